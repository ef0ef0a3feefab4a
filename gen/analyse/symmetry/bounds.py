"""How much work one question may cost; past it the answer is "not decided", never a claim.

Operations are counted, not seconds: the answer is the same on every machine.
"""
from __future__ import annotations

PRODUCTS = 100_000      # products of terms
TERMS = 60              # terms of the energy that are written out one by one
EQUATIONS = 20_000      # linear equations
ROOTS = 2000            # entries of such equations, where they hold square roots
LONG = 64               # digits of a constant whose function or root is simplified
EVALUATIONS = 20_000_000    # numbers that the look at the energy itself may touch
JOINT = 6               # sites whose joint quadratic forms are looked for: 9 n^2/2 unknowns
