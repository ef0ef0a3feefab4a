"""Properties of a state on a lattice.

    grid = smidgen.lattice.of(spec)
    smidgen.lattice.charge(result.w["w"], grid)         # of every output
"""
from .run.fields.grid import Grid, of
from .run.fields.lattice import charge, correlation, magnetisation

__all__ = ["Grid", "charge", "correlation", "magnetisation", "of"]
