"""Vectors on the cells of a lattice: their grid, files of other programs, what a state on a lattice tells."""
