"""Stage `emit`: kernels and plan as the C files of a model."""
