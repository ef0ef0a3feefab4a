"""One method with one step: its error against a reference, and its time."""
