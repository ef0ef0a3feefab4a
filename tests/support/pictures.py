"""Results that tests of pictures draw: a top, a ring of spins, a film; and what a player's page carries."""
import json
import re

import numpy as np
import pytest

from smidgen.run.files.output import Result

INERTIA = np.array([1.0, 2.0, 4.0])
HOSTILE = "</script><script>alert('1')</script>&\"$x_{$\\frac\u202e\x00 <b>"


def midpoint(field, w, h, steps):
    """Spherical midpoint W - w = h m x b(m), m = r (w+W)/|w+W|, by fixed-point iteration."""
    w = np.array(w, float)
    radius, path = np.linalg.norm(w, axis=-1, keepdims=True), [w]
    for _ in range(steps):
        end = w
        for _ in range(100):
            m = w + end
            m = radius * m / np.linalg.norm(m, axis=-1, keepdims=True)
            new = w + h * np.cross(m, field(m))
            if np.array_equal(new, end):
                break
            end = new
        w = end
        path.append(w)
    return np.array(path)


def body(w):
    return w / INERTIA


def neighbours(w):
    return np.roll(w, 1, axis=0) + np.roll(w, -1, axis=0)


def energy_of(w):
    return 0.5 * np.sum(w * w / INERTIA, axis=-1)


@pytest.fixture(scope="module")
def top():
    w = midpoint(body, [[np.cos(1.1), 0, np.sin(1.1)]], 0.1, 200)
    return result({"w": w}, energy=energy_of(w[:, 0]), casimirs=np.sum(w * w, axis=2),
                  **{"momentum.w": w[:, 0]})


@pytest.fixture(scope="module")
def ring():
    i = 2 * np.pi * np.arange(30) / 30
    polar = 0.7 + 0.3 * np.sin(3 * i)
    w = np.stack([np.sin(polar) * np.cos(i), np.sin(polar) * np.sin(i), np.cos(polar)], axis=1)
    return result({"w": midpoint(neighbours, w, 0.1, 40)}, energy=np.zeros(41))


def result(states, title="A title", **values):
    """A Result as a run gives it, with only what pictures read."""
    count = len(next(iter(states.values())))
    meta = {"spec": "made", "title": title, "run": "demo", "method": "spherical-midpoint",
            "h": 0.1, "done": count - 1, "orientation": 1,
            "families": {n: w.shape[1] for n, w in states.items()}}
    return Result(meta, np.arange(count), 0.1 * np.arange(count), states, values)


FILM = """
[model]
name = "film"
[space]
w = { sphere = "nx*ny" }
[parameters]
nx = 6
ny = 5
[effects.exchange]
over = "bond(i, j) of square(nx, ny, open)"
energy = "-dot(w[i], w[j])"
[effects.field]
over = "site(i) of w"
energy = "-w[i].z"
"""
FILM_BONDS = {(i, i + 1) for i in range(30) if i % 6 < 5} | {(i, i + 6) for i in range(24)}


@pytest.fixture(scope="module")
def film():
    """A smooth film of 6 by 5 spins, with the spec that it comes from."""
    i = np.arange(30)
    polar, around = 0.4 + 0.2 * (i % 6), 0.5 + 0.25 * (i // 6)
    w = np.stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], axis=1)
    made = result({"w": np.stack([w] * 20)})
    made.meta.update(sources=[["film.toml", FILM]], effects=["exchange", "field"], parameters={"nx": 6, "ny": 5})
    return made


def pairs_of(bonds):
    return {tuple(sorted(map(int, pair))) for pair in bonds}


def data_of(page):
    return json.loads(re.search(r'id="data">(.*?)</script>', page, re.S).group(1))
