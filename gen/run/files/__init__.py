"""Results on disk and in memory: written as a run goes, checked when read, with checkpoints in between."""
