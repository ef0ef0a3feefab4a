"""What one state on a lattice tells, computed where it is called for and nowhere else.

    grid = smidgen.lattice.of(spec)
    smidgen.lattice.charge(result.w["w"], grid)         # of every output
"""
from .run.fields.grid import Grid, of
from .run.fields.lattice import charge, correlation, magnetisation

__all__ = ["Grid", "charge", "correlation", "magnetisation", "of"]
