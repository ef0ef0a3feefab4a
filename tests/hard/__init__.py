"""The hard suite: cases at the edge of what a step can do, each with what must happen there."""
