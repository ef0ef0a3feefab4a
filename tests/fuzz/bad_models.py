"""The models that bad steps are thrown at: every solver, every kind of space.

`kappa` and `radius` are C expressions in the parameters p, the site k and its number i in its
family; `casimir` is the matrix A of C(w) = w.(A w)/2. They are written here once more, so that
the residual does not take them from the generated code.
"""
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Model:
    """A spec, the method, and what the step equation needs to know about each family.

    families: (count, kind, kappa, radius) in order, as C expressions; share: of all the steps; closed: a linear field of each
    site by itself, whose one branch is known in closed form (runtime/core/smg_spin.h).
    """
    spec: str
    families: tuple
    method: str = "spherical-midpoint"
    solver: str = "auto"
    orientation: int = 1
    casimir: tuple = (1, 0, 0, 0, 1, 0, 0, 0, 1)
    share: float = 1.0
    closed: bool = False
    files: dict = field(default_factory=dict)


def spec(name, rest):
    return f'[model]\nname = "{name}"\n{rest}'


BODY = """
[space]
w = { sphere = 1 }
[parameters]
I1 = 1.0
I2 = 2.0
I3 = 4.0
[effects.rotation]
energy = "(w.x^2/I1 + w.y^2/I2 + w.z^2/I3)/2"
"""
FORCED = """
[space]
w = { sphere = 1, kappa = "k" }
[parameters]
k = 1.0
eps = 0.5
[effects.rotation]
energy = "(w.x^2 + 0.75*w.y^2 + 0.5*w.z^2)/2 + 0.1*w.x*w.y*w.z"
[effects.loading]
energy = "eps*sin(t)*w.z"
"""
FIELD = """
[space]
w = { sphere = 1, kappa = "k" }
[parameters]
k = 1.0
bx = 0.0
by = 0.0
bz = 1.0
[effects.field]
energy = "bx*w.x + by*w.y + bz*w.z"
"""
VORTICES = """
[space]
w = { sphere = 4, kappa = "gamma[i]" }
[parameters]
gamma = { default = [1.0, -0.6, 0.8, 1.3], size = 4 }
[effects.interaction]
over = "pair(i, j) of w"
energy = "-gamma[i]*gamma[j]*log(2 - 2*dot(w[i], w[j]))/(4*pi)"
"""
CHAIN = """
[space]
w = {{ sphere = "n" }}
[parameters]
n = {n}
J = 1.0
K = 0.2
[effects.exchange]
over = "bond(i, j) of chain(n, periodic)"
energy = "-J*dot(w[i], w[j])"
[effects.axis]
over = "site(i) of w"
energy = "-K*w[i].z^2"
"""
TOP = """
[space]
w = { r3 = 1, kappa = "k" }
[parameters]
k = 1.0
a = 0.7
[effects.rotation]
energy = "(w.x^2 + w.y^2/2 + w.z^2/4)/2 + a*w.x*w.z"
[effects.weight]
energy = "0.3*w.z*w.y^2"
"""
R3_FIELD = """
[space]
w = { r3 = 3 }
[parameters]
b = 1.0
[effects.field]
over = "site(i) of w"
energy = "b*w[i].z + 0.3*w[i].x"
"""
R3_PAIR = """
[space]
w = { r3 = 2, kappa = "gamma[i]" }
[parameters]
gamma = { default = [1.0, -2.0], size = 2 }
J = 1.0
[effects.exchange]
energy = "J*dot(w[0], w[1]) + 0.2*w[0].x^2*w[1].z"
"""
NAMBU = """
[space]
w = { nambu = 1, C = "w.y^2 + w.x*w.z" }
[parameters]
a = 0.5
[effects.motion]
energy = "(w.x^2 + w.y^2 + w.z^2)/2 + a*w.y^4/4 + 0.2*w.x"
"""
TRACERS = """
[space]
w = { sphere = 3, kappa = "gamma[i]" }
p = { sphere = "m", tracer = true }
[parameters]
m = 3
gamma = { default = [1.0, -0.6, 0.8], size = 3 }
[effects.interaction]
over = "pair(i, j) of w"
energy = "-gamma[i]*gamma[j]*log(2 - 2*dot(w[i], w[j]))/(4*pi)"
[effects.transport]
over = "each(i of p, j of w)"
energy = "-gamma[j]*log(2 - 2*dot(p[i], w[j]))/(4*pi)"
"""
CUBIC = """
orientation = -1
[space]
w = { sphere = "3*l*l" }
[parameters]
l = 3
J = 1.0
B = 0.3
[effects.exchange]
over = "bond(i, j) of cubic(3, l, l, periodic)"
energy = "-J*dot(w[i], w[j])"
[effects.field]
over = "site(i) of w"
energy = "-B*(1 + 0.2*cos(t))*w[i].x"
"""
GLASS = """
[space]
w = { sphere = 16, radius = "r" }
[parameters]
r = 1.5
J = 1.0
[graphs.g]
file = "edges.csv"
[effects.coupling]
over = "edge(i, j, K) of g"
energy = "J*K*dot(w[i], w[j])"
[effects.axis]
over = "site(i) of w"
energy = "-0.2*w[i].z^2"
"""
EDGES = "i,j,K\n" + "".join(f"{i},{j},{0.4 if (i + j) % 3 else -0.7}\n"
                            for i, j in [(k, (k + 1) % 16) for k in range(16)] + [(k, k + 8) for k in range(8)])

SPHERE = (("1", "sphere", "1", "1"),)
MODELS = {
    "body": Model(spec("body", BODY), SPHERE, share=4),
    "forced": Model(spec("forced", FORCED), (("1", "sphere", "p->k", "1"),), share=4),
    "field": Model(spec("field", FIELD), (("1", "sphere", "p->k", "1"),), share=4, closed=True),
    "vortices": Model(spec("vortices", VORTICES), (("4", "sphere", "p->gamma[i]", "1"),), share=2),
    "chain6": Model(spec("chain6", CHAIN.format(n="{ default = 6, fixed = true }")), (("6", "sphere", "1", "1"),), share=1),
    "chain20": Model(spec("chain20", CHAIN.format(n="20")), (("p->n", "sphere", "1", "1"),), share=0.5),
    "top": Model(spec("top", TOP), (("1", "r3", "p->k", "0"),), share=4),
    "r3_field": Model(spec("r3_field", R3_FIELD), (("3", "r3", "1", "0"),), share=2, closed=True),
    "r3_pair": Model(spec("r3_pair", R3_PAIR), (("2", "r3", "p->gamma[i]", "0"),), share=2),
    "nambu": Model(spec("nambu", NAMBU), (("1", "nambu", "1", "0"),), share=3,
                   casimir=(0, 0, 1, 0, 2, 0, 1, 0, 0)),
    "tracers": Model(spec("tracers", TRACERS), (("3", "sphere", "p->gamma[i]", "1"), ("p->m", "sphere", "1", "1"))),
    "cubic": Model(spec("cubic", CUBIC), (("3*p->l*p->l", "sphere", "1", "1"),), orientation=-1, share=0.1),
    "glass": Model(spec("glass", GLASS), (("16", "sphere", "1", "p->r"),), files={"edges.csv": EDGES}, share=0.5),
    "body_classical": Model(spec("body_classical", BODY), SPHERE, method="classical-midpoint", share=2),
    "vortices_classical": Model(spec("vortices_classical", VORTICES), (("4", "sphere", "p->gamma[i]", "1"),),
                                method="classical-midpoint"),
    "nambu_classical": Model(spec("nambu_classical", NAMBU), (("1", "nambu", "1", "0"),), share=1,
                             method="classical-midpoint", casimir=(0, 0, 1, 0, 2, 0, 1, 0, 0)),
    "veselov": Model(spec("veselov", BODY), SPHERE, method="moser-veselov", share=1),
}
