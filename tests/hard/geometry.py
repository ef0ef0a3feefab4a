"""Angles of spins and places of rings, measured and exact."""
from pathlib import Path

import mpmath
import numpy as np

import smidgen

mpmath.mp.dps = 30      # of every exact law here
SPECS = Path(__file__).parent / "specs"


def load(name: str):
    """The spec of that name beside this file."""
    return smidgen.load(SPECS / f"{name}.toml")


def build(name: str, **values):
    """Compiled, with these values of its parameters."""
    return smidgen.build(load(name), parameters=values)


def polar(theta, phi):
    """Unit vectors (k, 3) at angles theta from z and phi around it."""
    theta, phi = np.broadcast_arrays(np.asarray(theta, float), np.asarray(phi, float))
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)


def turns(w, after, axis=(0, 0, 1)):
    """The angle of every row about `axis` from w to after, in (-pi, pi]."""
    e = np.asarray(axis, np.longdouble) / np.sqrt(np.sum(np.square(np.asarray(axis, np.longdouble))))
    u, v = (np.asarray(x, np.longdouble) for x in (w, after))
    u, v = (x - np.outer(x @ e, e) for x in (u, v))
    return np.arctan2(np.cross(u, v) @ e, np.sum(u * v, axis=1)).astype(float)


def largest(a) -> float:
    """Largest absolute entry; NaN if there is one."""
    return float(np.abs(np.asarray(a)).max())
