"""Stage `lower`: derivatives as kernels of C statements, sums as loops."""
