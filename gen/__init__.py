"""smidgen compiles Hamiltonians, written as formulas, to structure-preserving integrators."""
__version__ = "0.1.0"
