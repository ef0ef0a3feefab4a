"""Which features models can have: ranks with memory of their own need a lattice by rows, and extended precision goes site by site."""
from smidgen.compile.features import FEATURES

ANYWHERE = tuple(f for f in FEATURES if f != "distributed")     # of every layout, alone and together
DIVIDED = tuple(f for f in FEATURES if f != "extended")         # of a lattice by rows, alone and together
