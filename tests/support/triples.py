"""Test programs whose numbers travel as three doubles each (tests/runtime/triples.h), and vectors of mpmath's numbers."""
import subprocess

import numpy as np
from mpmath import mp, mpf, sqrt

mp.dps = 40


def parts(x):
    """x as three doubles."""
    found = []
    for _ in range(3):
        found.append(float(x))
        x = x - mpf(found[-1])
    return found


def ask(command, w):
    """The numbers that a program answers to the vectors w."""
    sent = np.array([parts(mpf(x)) for v in w for x in v])
    done = subprocess.run([*map(str, command)], input=sent.tobytes(), stdout=subprocess.PIPE, check=True)
    return [mpf(a) + mpf(b) + mpf(c) for a, b, c in np.frombuffer(done.stdout).reshape(-1, 3)]


def vectors(numbers):
    return [numbers[k:k + 3] for k in range(0, len(numbers), 3)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def norm(a):
    return sqrt(dot(a, a))


def on_sphere(v, radius=1):
    return [mpf(radius) * mpf(x) / norm([mpf(x) for x in v]) for x in v]


def apart(a, b):
    """The largest distance of two states, site by site."""
    return max(norm([x - y for x, y in zip(*both)]) for both in zip(a, b))


FOUR = ((1, 0.2, 0.3), (-0.5, 1, 0.1), (-0.4, -1, 0.5), (0.1, 0.3, -1))      # places of four vortices
