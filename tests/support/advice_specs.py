"""Random specs of many kinds with a random start, for the step advice: the same seed, the same text."""
import random

HEAD = '[model]\nname = "case{seed}"\norientation = {orientation}\n'
TAIL = "[starts.first{family}]\nvectors = {rows}\n"


def vector(r, length=1.0):
    """Uniform on a sphere."""
    v = [r.gauss(0, 1) for _ in range(3)]
    size = sum(x * x for x in v) ** 0.5
    return [length * x / size for x in v]


def numbers(r, count, low=-1.0, high=1.0):
    return [round(r.uniform(low, high), 3) for _ in range(count)]


def start(rows, family="", normalise=True):
    """A [starts.first] section, for one family or the only one."""
    text = TAIL.format(family=f".{family}" if family else "", rows=rows)
    return text + ("normalise = true\n" if normalise else "")


def vortices(r):
    """Point vortices of both signs at random places."""
    n = r.randint(2, 5)
    kappa = [r.choice((-1, 1)) * round(r.uniform(0.3, 2), 3) for _ in range(n)]
    return (f"[space]\nw = {{ sphere = {n}, kappa = \"g[i]\" }}\n[parameters]\ng = {{ default = {kappa}, size = {n} }}\n"
            '[effects.interaction]\nover = "pair(i, j) of w"\n'
            'energy = "-g[i]*g[j]*log(2 - 2*dot(w[i], w[j]))/(4*pi)"\n' + start([vector(r) for _ in range(n)]))


def chain(r):
    """A chain with anisotropy and a field, periodic or open."""
    n, (j, k, x, z) = r.randint(3, 7), numbers(r, 4, -1.5, 1.5)
    return (f'[space]\nw = {{ sphere = {n} }}\n[effects.exchange]\nover = "bond(i, j) of chain({n}, '
            f'{r.choice(("periodic", "open"))})"\nenergy = "{j}*dot(w[i], w[j])"\n[effects.anisotropy]\n'
            f'over = "site(i) of w"\nenergy = "{k}*w[i].z^2 + {x}*w[i].x + {z}*w[i].z"\n'
            + start([vector(r) for _ in range(n)]))


def body(r):
    """One body with quadratic and quartic terms."""
    a, b, c, d, e = numbers(r, 5, -2, 2)
    return ('[space]\nw = { sphere = 1 }\n[effects.body]\n'
            f'energy = "{a}*w.x^2 + {b}*w.y^2*w.z + {c}*w.z^4 + {d}*w.x*w.y + {e}*w.y"\n' + start([vector(r)]))


def field(r):
    """One spin in a constant field, sometimes nearly perpendicular to it."""
    b = vector(r, r.uniform(0.2, 3))
    return ('[space]\nw = { sphere = 1 }\n[effects.field]\n'
            f'energy = "dot(vec({b[0]}, {b[1]}, {b[2]}), w)"\n' + start([vector(r)]))


def hyperboloid(r):
    """A Nambu factor with an indefinite C, and a field that bends."""
    a, b, c = (round(r.uniform(0.4, 2), 3) for _ in range(3))
    d, e, f = numbers(r, 3)
    w = [r.uniform(-1, 1), r.uniform(-1, 1), r.choice((-1, 1)) * r.uniform(1.5, 3)]
    return (f'[space]\nw = {{ nambu = 1, C = "({a}*w.x^2 + {b}*w.y^2 - {c}*w.z^2)/2" }}\n[effects.motion]\n'
            f'energy = "{d}*w.x^2 + {e}*w.y*w.z + {f}*w.x"\n' + start([w], normalise=False))


def product(r):
    """Bodies of different lengths in R^3, coupled."""
    n, (a, b, c, j) = r.randint(2, 3), numbers(r, 4, -1.5, 1.5)
    rows = [vector(r, r.uniform(0.3, 2)) for _ in range(n)]
    return (f'[space]\nw = {{ r3 = {n}, kappa = {round(r.uniform(0.5, 2), 3)} }}\n[effects.bodies]\n'
            f'over = "site(i) of w"\nenergy = "{a}*w[i].x^2 + {b}*w[i].y^2 + {c}*w[i].z"\n[effects.coupling]\n'
            f'over = "pair(i, j) of w"\nenergy = "{j}*dot(w[i], w[j]) + 0.2*triple(w[i], w[j], vec(0, 0, 1))"\n'
            + start(rows, normalise=False))


def driven(r):
    """Two spins in a field that turns."""
    j, b, q, k = numbers(r, 4, -2, 2)
    return ('[space]\nw = { sphere = 2, kappa = [1, 2] }\n[effects.pair]\n'
            f'energy = "{j}*dot(w[0], w[1]) + {k}*w[0].z^2"\n[effects.drive]\nover = "site(i) of w"\n'
            f'energy = "{b}*cos({q}*t)*w[i].x + {b}*sin({q}*t)*w[i].y"\n' + start([vector(r), vector(r)]))


def tracers(r):
    """A tracer among two vortices."""
    return ('[space]\nw = { sphere = 2, kappa = [1, -0.6] }\np = { sphere = 2, tracer = true }\n'
            '[effects.interaction]\nover = "pair(i, j) of w"\nenergy = "0.6*log(2 - 2*dot(w[i], w[j]))/(4*pi)"\n'
            '[effects.transport]\nover = "each(i of p, j of w)"\n'
            'energy = "-(1 - 1.6*j)*log(2 - 2*dot(p[i], w[j]))/(4*pi)"\n'
            + start([vector(r), vector(r)], "w") + start([vector(r), vector(r)], "p"))


def coupled(r):
    """A sphere coupled to a cylinder."""
    a, b, j = numbers(r, 3, -1.5, 1.5)
    return ('[space]\nw = { sphere = 1 }\nv = { nambu = 1, C = "v.x^2 + v.y^2" }\n[effects.motion]\n'
            f'energy = "{a}*w.x^2 + v.z^2/2 + {b}*v.x"\n[effects.coupling]\nenergy = "{j}*dot(w, v)"\n'
            + start([vector(r)], "w") + start([[0.6, 0.8, r.uniform(-1, 1)]], "v", normalise=False))


KINDS = (vortices, chain, body, field, hyperboloid, product, driven, tracers, coupled, vortices)


def text(seed: int) -> str:
    """The spec of that seed; kinds take turns."""
    r = random.Random(seed)
    body_ = KINDS[seed % len(KINDS)](r)
    return HEAD.format(seed=seed, orientation=r.choice((1, -1))) + body_
