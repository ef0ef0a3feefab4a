"""Small specs beyond the shipped ones: corners of the space and of the energy."""
import smidgen

FIELD = """
[model]
name = "spin_in_field"
[space]
w = { sphere = 1 }
[parameters]
B = { default = 1.3 }
[effects.field]
energy = "B*dot(vec(0.36, 0.48, 0.8), w)"
[starts.first]
theta = 0.9
phi = 0.4
[runs.demo]
start = "first"
h = 0.4
time = 40
"""

MIXED = """
[model]
name = "mixed_spins"
orientation = -1
[space]
w = { sphere = 4, kappa = [1, 2, -1, 0.5], radius = 1.5 }
v = { r3 = 2, kappa = -3 }
[parameters]
J = { default = 0.7 }
[effects.exchange]
over = "pair(i, j) of w"
energy = "J*dot(w[i], w[j]) + 0.2*dot(w[i], w[j])^2"
[effects.drive]
over = "site(i) of w"
energy = "0.3*cos(2*t + i)*w[i].x + 0.1*w[i].z^3"
[effects.meeting]
over = "each(i of w, j of v)"
energy = "0.25*triple(w[i], v[j], vec(0, 1, 1)) + 0.1*sqrt(2 + dot(v[j], v[j]))"
[starts.first.w]
theta = "0.5 + 0.6*i"
phi = "1.1*i"
[starts.first.v]
vectors = [[0.3, -0.4, 0.9], [1.2, 0.1, -0.5]]
[runs.demo]
start = "first"
h = 0.05
time = 5
"""

GLASS = """
[model]
name = "spin_glass"
[space]
w = { sphere = 30 }
[graphs.g]
file = "edges.csv"
[effects.coupling]
over = "edge(i, j, K) of g"
energy = "K*dot(w[i], w[j])"
[effects.axis]
over = "site(i) of w"
energy = "-0.2*w[i].z^2"
[starts.random]
random = 3
[runs.demo]
start = "random"
h = 0.1
time = 10
"""

PULSE = """
[model]
name = "pulsed_spin"
[space]
w = { sphere = 1 }
[effects.spin]
energy = "0.5*w.z^2 + 0.3*w.x*w.y"
[effects.pulse]
energy = "2*exp(-(t - 1)^2)*w.x + sin(3*t)*w.y^2"
[starts.first]
theta = 1.0
phi = 0.2
[runs.demo]
start = "first"
h = 0.05
time = 2
"""

OPEN_CHAIN = """
[model]
name = "open_chain"
[space]
w = { sphere = "n", kappa = "1 + 0.5*mod(i, 2)" }
[parameters]
n = { default = 12 }
[effects.exchange]
over = "bond(i, j) of chain(n, open)"
energy = "-dot(w[i], w[j]) - 0.1*triple(w[i], w[j], vec(0, 0, 1))"
[effects.axis]
over = "site(i) of w"
energy = "-0.3*w[i].z^2 + 0.05*i*w[i].x"
[starts.random]
random = 5
[runs.demo]
start = "random"
h = 0.1
time = 10
"""

CORNERS = """
[model]
name = "corners"
[space]
w = { sphere = 2 }
u = { nambu = 1, C = "q*u.x^2 + u.y*u.z" }
[parameters]
q = { default = 0.7, fixed = true }
a = { default = 0.3 }
axis = { default = [0.6, 0.0, 0.8], vector = true }
[effects.pieces]
over = "site(i) of w"
energy = "if(w[i].x < a, a*w[i].z^2, w[i].y^3 - a) + max(w[i].x, 0.2*w[i].z)^2 + abs(w[i].y)^3"
[effects.functions]
energy = "exp(-dot(w[0], axis)) + atan2(w[1].y + 3, 2 + w[0].z) + mod(t, 2)*tanh(w[1].x)/cosh(a)"
[effects.powers]
energy = "(2 + w[0].x)^a + (3 + w[1].z)^-2.5 + sqrt(5 + dot(w[0], u)) - log(4 + norm(u))^3/7"
[observables.sum]
over = "site(i) of w"
value = "floor(3*w[i].x) + min(w[i].y, a) + i"
[starts.first.w]
theta = "0.4 + i"
phi = "0.3 + 2*i"
[starts.first.u]
vectors = [[0.8, 0.5, 0.4]]
[runs.demo]
start = "first"
h = 0.05
time = 5
"""

RING = [(i, (i + 1) % 30) for i in range(30)] + [(i, (7 * i + 3) % 30) for i in range(0, 30, 2)]
EDGES = "i,j,K\n" + "\n".join(f"{i},{j},{0.4 if (i * j) % 3 else -0.7}" for i, j in RING if i != j)


def read(text, folder=None):
    """A Spec from text; GLASS also needs a folder for its edges."""
    if folder is None:
        return smidgen.load_text(text)
    (folder / "edges.csv").write_text(EDGES)
    (folder / "model.toml").write_text(text)
    return smidgen.load(folder / "model.toml")
