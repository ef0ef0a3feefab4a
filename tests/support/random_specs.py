"""Whole random Hamiltonians as spec text: spaces, strengths, index families, functions, time.

    text, files = random_spec(random.Random(7))

Any object with the methods of random.Random will do, so hypothesis can shrink what it finds
(`st.randoms(use_true_random=False)`). Every formula is smooth and bounded near the states that
`random_state` gives, but for the edges of if, min, max, abs, mod and floor.
"""
from dataclasses import dataclass, field

SCALARS = ("a", "b", "c")
KAPPAS = ("", "kappa = -2", "kappa = 0.5", 'kappa = "1 + 0.5*mod(i, 2)"', 'kappa = "(1 + i)*(1 - 2*mod(i, 2))"')
RADII = ("", "", "radius = 2", 'radius = "1 + 0.25*i"')
CASIMIRS = ("dot({w}, {w})/2", "{w}.x^2 + {w}.y^2 + 0.5*{w}.z^2", "q*{w}.x^2 + {w}.y*{w}.z", "({w}.x^2 - {w}.y^2)/2",
            "{w}.y^2 + {w}.x*{w}.z")
EDGES = "i,j,K\n0,1,0.7\n1,2,-0.4\n0,2,1.1\n3,0,0.5\n"


@dataclass(frozen=True)
class Family:
    """name; kind; count as written in the spec and as a number; more keys; whether its radius is 1."""
    name: str
    kind: str
    count: str
    size: int
    more: str
    tracer: bool = False

    @property
    def is_unit(self):
        return self.kind == "sphere" and "radius" not in self.more

    def line(self):
        keys = [f'{self.kind} = {self.count}', self.more, "tracer = true" * self.tracer]
        return f'{self.name} = {{ {", ".join(k for k in keys if k)} }}'


@dataclass
class Writer:
    """The dice and what the formulas may use."""
    dice: object
    families: list = field(default_factory=list)
    formulas: dict = field(default_factory=dict)
    files: dict = field(default_factory=dict)
    lattices: list = field(default_factory=list)

    def coefficient(self):
        return f"{self.dice.choice((-1, 1))*self.dice.randint(1, 12)/10:g}"

    # Vectors and numbers of one term: `names` are its vectors, `indices` its index names.

    def vector(self, names, depth=1):
        pick = self.dice.randint(0, 9)
        if depth and pick == 0:
            return f"cross({self.vector(names, 0)}, {self.vector(names, 0)})"
        if depth and pick == 1:
            return f"({self.vector(names, 0)} - {self.coefficient()}*{self.vector(names, 0)})"
        if pick == 2:
            return self.dice.choice(("B", "vec(0.6, 0, 0.8)", "vec(a, 0.3, c)"))
        if depth and pick == 3:
            return f"if({self.leaf(names, ())} < {self.coefficient()}, {self.vector(names, 0)}, B)"
        return self.dice.choice(names)

    def leaf(self, names, indices):
        pick = self.dice.randint(0, 11)
        if pick <= 4:
            return f"{self.vector(names)}.{self.dice.choice('xyz')}"
        if pick <= 6:
            return f"dot({self.vector(names)}, {self.vector(names)})"
        if pick == 7 and indices:
            return self.dice.choice((f"{self.dice.choice(indices)}/5", f"mod({self.dice.choice(indices)}, 2)",
                                     f"gamma[{self.dice.choice(indices)}]", f"floor({self.dice.choice(indices)}/2)"))
        if pick == 8:
            return self.dice.choice(SCALARS)
        if pick == 9:
            return self.dice.choice(("cos(1.3*t)", "sin(omega*t + 0.2)", "exp(-(t - 1)^2)", "mod(t, 2)", "1/(1 + t^2)"))
        if pick == 10:
            return f"triple({self.vector(names)}, {self.vector(names)}, {self.vector(names)})"
        return self.coefficient()

    def number(self, names, indices, depth):
        if depth == 0:
            return self.leaf(names, indices)
        form = self.dice.choice(FORMS)
        return form.format(*(self.number(names, indices, self.dice.randint(0, depth - 1)) for _ in range(3)),
                           k=self.coefficient(), v=self.vector(names), u=self.vector(names))


FORMS = ("{0} + {1}", "{0} - {1}", "{0}*({1})", "{k}*({0})", "-({0})", "({0})/(3 + ({1})^2)", "({0})^2", "({0})^3",
         "({0})^2*({1})", "sin({0})", "cos({0})", "exp(-({0})^2)", "exp(0.3*sin({0}))", "log(2 + ({0})^2)",
         "sqrt(1.5 + ({0})^2)", "(2 + ({0})^2)^0.7", "(2 + ({0})^2)^-1.5", "(1.5 + sin({0}))^a", "2^sin({0})", "tanh({0})",
         "sinh(sin({0}))", "cosh(cos({0}))", "atan({0})", "atan2({0}, 2 + ({1})^2)", "asin(0.8*sin({0}))",
         "acos(0.5*cos({0}))", "tan(0.9*sin({0}))", "abs({0})^3", "max({0}, {1})^2", "min({0}, {k})^3",
         "if({0} < {k}, {1}, {2})", "if({0} > {k} and not {1} <= 0.1 or {2} == 2, {1}, {k})", "norm({v} + 3*vec(0.3, 0.5, 1))",
         "square({0})", "mixed({v}, {u})", "shift*({0})")


def random_spec(dice):
    """(text, files): a spec, and the files that it names by name."""
    w = Writer(dice)
    w.families = [random_family(dice, name) for name in "uvw"[:dice.randint(1, 3)]]
    if dice.randint(0, 3) == 0:
        w.families.append(Family("p", "sphere", str(dice.randint(1, 3)), 3, "", True))
    effects = [random_effect(w, k) for k in range(dice.randint(1, 3))]
    values = [random_term(w, "observables", f"o{k}", "value", w.families) for k in range(dice.randint(0, 1))]
    return "\n".join([head(w), *w.lattices, *effects, *values]) + "\n", w.files


def random_family(dice, name):
    kind = dice.choice(("sphere", "sphere", "sphere", "r3", "nambu"))
    size = dice.choice((1, 1, 2, 3, 4, 6)) if kind != "nambu" else dice.choice((1, 1, 2))
    count = dice.choice((str(size), str(size), f'"{ {6: "n", 4: "n - 2", 3: "n - 3"}[size] }"')) if size in (3, 4, 6) else str(size)
    keys = [dice.choice(KAPPAS + (f"kappa = {[(-1)**k * (1 + k) / 2 for k in range(size)]}", 'kappa = "gamma[i] + 0.1"'))]
    if kind == "sphere":
        keys.append(dice.choice(RADII))
    if kind == "nambu":
        keys.append(f'C = "{dice.choice(CASIMIRS).format(w=name)}"')
    return Family(name, kind, count, size, ", ".join(k for k in keys if k))


def head(w):
    dice = w.dice
    fixed = ", fixed = true" * dice.randint(0, 1)
    lines = ["[model]", 'name = "random_model"', f"orientation = {dice.choice((1, 1, -1))}", "[space]",
             *(f.line() for f in w.families), "[parameters]", "n = 6", f"a = {{ default = {w.coefficient()}{fixed} }}",
             *(f"{name} = {float(w.coefficient())!r}" for name in "bc"), "q = { default = 0.7, fixed = true }", "omega = 2.5",
             "gamma = { default = [0.6, -0.8, 1.1, 0.5, -1.3, 0.9, 0.7], size = 7 }",
             "B = { default = [0.3, -0.5, 0.8], vector = true }", "[formulas]", '"square(s)" = "s*s"',
             '"mixed(s, r)" = "dot(s, r) + 0.2*triple(s, r, B)"', 'shift = "a + 0.5*cos(omega*t)"']
    return "\n".join(lines)


def random_effect(w, k):
    """An effect; the first one of a space of tracers moves what is no tracer."""
    own = [f for f in w.families if not f.tracer]
    chosen = w.families if k and w.dice.randint(0, 1) else own
    return random_term(w, "effects", f"e{k}", "energy", chosen)


def random_term(w, section, name, key, families):
    over, names, indices = random_over(w, families)
    weight = "K*" if over.startswith("edge") else ""
    body = " + ".join(f"{weight}{w.coefficient()}*({w.number(names, indices, w.dice.randint(0, 3))})"
                      for _ in range(w.dice.randint(1, 3)))
    vectors = [v for v in names if v not in body]
    body += "".join(f" + {w.coefficient()}*{v}.{w.dice.choice('xyz')}*{names[0]}.{w.dice.choice('xyz')}" for v in vectors)
    return "\n".join([f"[{section}.{name}]", *([f'over = "{over}"'] if over else []), f'{key} = """{body}"""'])


def random_over(w, families):
    """(over, vectors of the term, indices); a term holds one tracer at most."""
    dice, f = w.dice, w.dice.choice(families)
    place = f" on {f.name}" if len(w.families) > 1 else ""
    several = f.size > 1 and not f.tracer
    kinds = ["once"] * (f.size == 1) + ["fixed"] * several + ["site"]
    kinds += ["pair", "chain"] * several + ["square"] * (f.size in (4, 6)) + ["graph"] * (f.size == 4)
    kinds += ["lattice"] * (f.size == 6) + ["each", "each"] * (len(families) > 1)
    kind = dice.choice(kinds)
    i, j = f"{f.name}[i]", f"{f.name}[j]"
    if kind == "once":
        return "", [f.name if f.count == "1" else f"{f.name}[0]"], ()
    if kind == "fixed":
        return "", [f"{f.name}[0]", f"{f.name}[{f.size - 1}]"], ()
    if kind == "site":
        return f"site(i) of {f.name}", [i], ("i",)
    if kind == "pair":
        return f"pair(i, j) of {f.name}", [i, j], ("i", "j")
    if kind == "chain":
        edge = dice.choice(("periodic", "open")) if f.size > 2 else "open"
        return f"bond(i, j) of chain({count_of(f)}, {edge}){place}", [i, j], ("i", "j")
    if kind == "square":
        return f"bond(i, j) of square({f.size // 2}, 2, open){place}", [i, j], ("i", "j")
    if kind == "graph":
        return random_graph(w, f, place)
    if kind == "lattice":
        return random_lattice(w, f, place)
    g = dice.choice([g for g in families if g is not f])
    return f"each(i of {f.name}, j of {g.name})", [i, f"{g.name}[j]"], ("i", "j")


def count_of(f):
    return f.count.strip('"')


def random_graph(w, f, place):
    w.files["edges.csv"] = EDGES
    if not any("[graphs.g]" in text for text in w.lattices):
        w.lattices.append('[graphs.g]\nfile = "edges.csv"')
    return f"edge(i, j, K) of g{place}", [f"{f.name}[i]", f"{f.name}[j]"], ("i", "j")


def random_lattice(w, f, place):
    """Cells of two sites in a ring of three, bonds of two or three sites."""
    if not w.lattices or not any("[lattices.l]" in text for text in w.lattices):
        w.lattices.append('[lattices.l]\nsize = [3]\nboundary = "periodic"\nsites = 2\n'
                          "bonds.two = [{ from = 0, to = 1, offset = [0] }, { from = 1, to = 0, offset = [1] }]\n"
                          "bonds.three = [{ at = [[0, 0], [1, 0], [0, 1]] }]")
    if w.dice.randint(0, 1):
        return f"bond(i, j) of l.two{place}", [f"{f.name}[i]", f"{f.name}[j]"], ("i", "j")
    return f"bond(i, j, k) of l.three{place}", [f"{f.name}[{s}]" for s in "ijk"], ("i", "j", "k")
