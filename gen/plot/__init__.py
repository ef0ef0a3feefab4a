"""Pictures: `plot` draws a result; `figures` holds those of the paper and the demo.

    smidgen.plot.plot("chain.h5", kind="chain", out="chain.pdf")
"""
from .draw import plot
from .pictures import kinds

__all__ = ["kinds", "plot"]
