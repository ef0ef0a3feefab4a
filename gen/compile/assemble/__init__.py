"""Stage `assemble`: kernels, loops and the plan as all functions and tables of a model, still as data."""
