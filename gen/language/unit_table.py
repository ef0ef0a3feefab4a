"""The names of units, each with its size in SI: a table of our own, and the only place that has a number of physics.

A size is (factor, energy, time, length, field): factor * J^energy * s^time * m^length * T^field. These four are enough: kg = J s^2/m^2,
A = J/(m^2 T). Temperatures are energies by k_B, so that 1 K is 1.380649e-23 J. An angle has no dimension: rad is 1.

Exact: h, e, k_B of the SI (2019) and what follows from them. Measured, with the edition in `CODATA`: Mohr, Newell, Taylor, Tiesinga, CODATA
recommended values of the fundamental physical constants: 2022, Rev. Mod. Phys. 97 (2025) 025002.
"""
from __future__ import annotations

from fractions import Fraction as F

CODATA = "2022"

PREFIXES = {name: F(10) ** power for name, power in (
    ("Q", 30), ("R", 27), ("Y", 24), ("Z", 21), ("E", 18), ("P", 15), ("T", 12), ("G", 9), ("M", 6), ("k", 3), ("h", 2), ("da", 1),
    ("d", -1), ("c", -2), ("m", -3), ("u", -6), ("n", -9), ("p", -12), ("f", -15),
    ("a", -18), ("z", -21), ("y", -24), ("r", -27), ("q", -30))}

PI = F("3.14159265358979323846264338327950288419716939937510582097494459")
E = F("1.602176634e-19")
K_B = F("1.380649e-23")
HBAR = F("6.62607015e-34") / (2 * PI)
MU_B = F("9.2740100657e-24")                # measured, relative error 3.1e-10

# those that take a prefix
PREFIXED = {
    "J": (F(1), 1, 0, 0, 0), "s": (F(1), 0, 1, 0, 0), "m": (F(1), 0, 0, 1, 0), "T": (F(1), 0, 0, 0, 1),
    "g": (F("1e-3"), 1, 2, -2, 0), "K": (K_B, 1, 0, 0, 0), "A": (F(1), 1, 0, -2, -1), "rad": (F(1), 0, 0, 0, 0),
    "Hz": (F(1), 0, -1, 0, 0), "N": (F(1), 1, 0, -1, 0), "Pa": (F(1), 1, 0, -3, 0), "W": (F(1), 1, -1, 0, 0),
    "C": (F(1), 1, 1, -2, -1), "V": (F(1), 0, -1, 2, 1), "Wb": (F(1), 0, 0, 2, 1), "H": (F(1), -1, 0, 4, 2), "ohm": (F(1), -1, -1, 4, 2),
    "eV": (E, 1, 0, 0, 0), "erg": (F("1e-7"), 1, 0, 0, 0), "dyn": (F("1e-5"), 1, 0, -1, 0), "bar": (F("1e5"), 1, 0, -3, 0),
    "G": (F("1e-4"), 0, 0, 0, 1), "Oe": (F("1e-4"), 0, 0, 0, 1),      # a field H in oersted stands for the induction mu_0 H
    "emu": (F("1e-3"), 1, 0, 0, -1),                                  # erg/G, of a moment
    "Ry": (F("2.1798723611030e-18"), 1, 0, 0, 0), "Ha": (F("4.3597447222060e-18"), 1, 0, 0, 0),
}

# those that do not
PLAIN = {
    "min": (F(60), 0, 1, 0, 0), "h": (F(3600), 0, 1, 0, 0), "d": (F(86400), 0, 1, 0, 0),
    "angstrom": (F("1e-10"), 0, 0, 1, 0), "a_0": (F("5.29177210544e-11"), 0, 0, 1, 0),
    "deg": (PI / 180, 0, 0, 0, 0), "arcmin": (PI / 10800, 0, 0, 0, 0), "arcsec": (PI / 648000, 0, 0, 0, 0),
    "turn": (2 * PI, 0, 0, 0, 0), "rpm": (PI / 30, 0, -1, 0, 0),
    "u": (F("1.66053906892e-27"), 1, 2, -2, 0), "m_e": (F("9.1093837139e-31"), 1, 2, -2, 0),
    "hbar": (HBAR, 1, 1, 0, 0), "k_B": (F(1), 0, 0, 0, 0),            # 1.380649e-23 J/K, and a kelvin is that energy
    "mu_B": (MU_B, 1, 0, 0, -1), "mu_N": (F("5.0507837393e-27"), 1, 0, 0, -1),
    "mu_0": (F("1.25663706127e-6"), -1, 0, 3, 2), "c": (F(299792458), 0, -1, 1, 0),
    "gamma": (2 * MU_B / HBAR, 0, -1, 0, -1),                         # of spins with g = 2
    "gamma_e": (F("1.76085962784e11"), 0, -1, 0, -1),                 # of the free electron, g = 2.00232
}


def size_of(name: str) -> tuple | None:
    """The size of a unit by its name, a prefix included; None where there is none of this name."""
    if name in PLAIN or name in PREFIXED:
        return PLAIN.get(name) or PREFIXED[name]
    for prefix, factor in PREFIXES.items():
        if name.startswith(prefix) and name[len(prefix):] in PREFIXED:
            size = PREFIXED[name[len(prefix):]]
            return (factor * size[0], *size[1:])
    return None
