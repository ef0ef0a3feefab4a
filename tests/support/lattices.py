"""Small lattices, and spins on them."""
import numpy as np

FILM = """[model]
name = "film"
[space]
w = { sphere = "nx*ny" }
[parameters]
nx = 5
ny = 3
[effects.exchange]
over = "bond(i, j) of square(nx, ny, periodic, open)"
energy = "-dot(w[i], w[j])"
[starts.random]
random = 2
[runs.demo]
start = "random"
h = 0.05
time = 1
output = { every = 4, what = ["states"] }
"""
HONEY = FILM.replace('"nx*ny"', '"2*nx*ny"').replace("square(nx, ny, periodic, open)", "honey.a") + """[lattices.honey]
size = ["nx", "ny"]
boundary = "periodic"
sites = 2
bonds.a = [{ from = 0, to = 1, offset = [0, 0] }]
"""


MEASURED = """[model]
name = "crystal"
[units]
energy = "meV"
time = "fs"
{length}
[lattices.net]
size = [6, 6]
boundary = "periodic"
{constant}
{cell}
[space]
w = {{ sphere = "net", moment = "1 mu_B" }}
[effects.exchange]
over = "bond(i, j) of net.first"
energy = "-1 meV*dot(w[i], w[j])"
[starts.random]
random = 1
"""


def random_spins(count, seed=3):
    """Unit vectors (count, 3)."""
    w = np.random.default_rng(seed).standard_normal((count, 3))
    return w / np.linalg.norm(w, axis=1)[:, None]
