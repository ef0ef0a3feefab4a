"""Random Hamiltonians for `explain`: from small parts that share symmetries or break them."""
import random

HEAD = '[model]\nname = "case{seed}"\norientation = {orientation}\n[parameters]\nJ = {J}\nn = {n}\n'

SPACES = (
    'w = {{ sphere = "n" }}', 'w = {{ sphere = "n", kappa = "1 + 0.5*i" }}', 'w = {{ sphere = "n", radius = 1.5 }}',
    'w = {{ r3 = "n", kappa = -2 }}', 'w = {{ nambu = "n", C = "(w.x^2 + w.y^2 - w.z^2)/2" }}',
    'w = {{ nambu = "n", C = "w.x^2 + w.y^2 + 0.5*w.z^2 + w.x*w.y" }}')
SITE = ("w[i].z", "w[i].z^2", "w[i].x^2", "w[i].z^4", "w[i].x*w[i].y", "dot(vec(3, 0, 4), w[i])^2", "w[i].x^2 + w[i].y^2",
        "dot(w[i], w[i])", "exp(w[i].z)", "abs(w[i].z)", "if(w[i].z < 0.3, w[i].z, 1)", "i*w[i].z", "cos(2*t)*w[i].z",
        "sqrt(2 + w[i].x^2 + w[i].y^2)", "w[i].z^3/(2 + w[i].z)", "sin(t)*w[i].x", "dot(vec(1, 1, 0), w[i])")
PAIR = ("dot(w[i], w[j])", "w[i].z*w[j].z", "w[i].x*w[j].x", "w[i].y*w[j].y", "dot(w[i], w[j])^3", "log(9 + dot(w[i], w[j]))",
        "triple(w[i], w[j], vec(0, 0, 1))", "triple(w[i], w[j], vec(3, 0, 4))", "w[i].x*w[j].x + w[i].y*w[j].y",
        "sqrt(dot(w[i] - w[j], w[i] - w[j]) + 1)", "max(w[i].z, w[j].z)", "norm(w[i] + w[j] + vec(0, 0, 7))",
        "atan2(w[i].z + 9, 5 + w[j].z)", "(w[i].z - w[j].z)^2", "w[i].x - w[j].x", "exp(w[i].x)*w[j].y")
OVER_PAIR = ("pair(i, j) of w", "bond(i, j) of chain(n, periodic)", "bond(j, i) of chain(n, periodic)",
             "bond(i, j) of chain(n, open)", "bond(i, j) of chain(n, periodic, 2)")
CROSS = ("dot(w[i], v[j])", "w[i].z*v[j].z", "w[i].x*v[j].y", "exp(0.3*dot(w[i], v[j]))", "w[i].z*v[j].x")


def text(seed: int) -> str:
    """A spec with one to four effects, alike or not in what leaves them unchanged."""
    r = random.Random(seed)
    n, two = r.choice((1, 3, 4, 6)), r.random() < 0.3
    pool = r.choice(((SITE, PAIR), (SITE[:2] + SITE[8:12], PAIR[:2] + PAIR[5:7]), (SITE[1:3], PAIR[:4])))
    lines = [HEAD.format(seed=seed, orientation=r.choice((1, -1)), J=r.choice((0.0, 0.7, -1.3)), n=n), "[space]",
             r.choice(SPACES).format(), *(["v = { sphere = 2, kappa = [1, -3] }"] if two else [])]
    for k in range(r.randint(1, 4)):
        lines += effect(r, k, n, two, pool)
    return "\n".join(lines) + "\n"


def effect(r, k, n, two, pool):
    """A term of one site, of two of a family, or of two families."""
    kind = r.choice(["site", "pair"] if n > 1 else ["site"]) if not (two and r.random() < 0.5) else "cross"
    term = r.choice(pool[0] if kind == "site" else pool[1] if kind == "pair" else CROSS)
    over = {"site": "site(i) of w", "pair": r.choice(OVER_PAIR if n > 2 else OVER_PAIR[:1]),
            "cross": "each(i of w, j of v)"}[kind]
    over += " on w" if two and "chain" in over else ""
    factor = r.choice(("1", "-1", "J", "0.25"))
    return [f"[effects.part{k}]", f'over = "{over}"', f'energy = "{factor}*({term})"']


def planted(seed: int):
    """(spec text, axis): a Hamiltonian of what a rotation about the axis leaves alone, and of nothing more."""
    r = random.Random(seed)
    a = [r.randint(-4, 4) for _ in range(3)]
    a = a if any(a) else [1, 2, 2]
    axis = f"vec({a[0]}, {a[1]}, {a[2]})"
    along, between = f"dot({axis}, w[i])", "dot(w[i], w[j])"
    terms = r.sample((f"({along})^2", f"exp(0.1*{along})", f"{along}*dot({axis}, w[j])*{between}", f"{between}^2",
                      f"triple({axis}, w[i], w[j])", f"sqrt(9 + {between})*{along}", f"cos(t)*{along}^3/9"), 3)
    # without the first of these every rotation would do
    terms.append(f"0.3*({along} + dot({axis}, w[j]))^2")
    over = r.choice(("pair(i, j) of w", "bond(i, j) of chain(4, periodic)"))
    parts = [f'[effects.part{k}]\nover = "{over}"\nenergy = "{r.choice((1, -2, 0.3))}*({t})"' for k, t in enumerate(terms)]
    return '[model]\nname = "planted"\n[space]\nw = { sphere = 4, kappa = [1, 2, -1, 3] }\n' + "\n".join(parts) + "\n", a
