"""A random spec of any kind that the language has, in one text: with its run, its files and the features to build with.

    text = any_space(random.Random(7))      # layouts.spec_text: of any layout

The text is TOML. Its comments hold what TOML does not: `# features: tangent` before the first section, and a block
`# file: edges.csv` for each file that the spec names (`files_of`). Counts, arrays and lattices fit at the defaults and
at the values that the run sets. Formulas are smooth and bounded near the states of the run, but for the edges of if,
min, max, abs, mod and floor; constants are odd thousandths, so that none lies on such an edge.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from itertools import product

import numpy as np
from support.random_specs import FORMS, Writer

from .drawn import any_method, comments

COUNTS = {"1": lambda n, m: 1, "one": lambda n, m: 1, "2": lambda n, m: 2, "3": lambda n, m: 3, "4": lambda n, m: 4,
          "6": lambda n, m: 6, "n": lambda n, m: n, "m": lambda n, m: m, "2*n": lambda n, m: 2*n, "n + 1": lambda n, m: n + 1,
          "n*m": lambda n, m: n*m, "2*m": lambda n, m: 2*m, "n - 1": lambda n, m: n - 1, "2*n + m": lambda n, m: 2*n + m}
SHAPES = {"n*m": [("n", "m")], "4": [("2", "2"), ("4", "1")], "6": [("3", "2"), ("1", "6")], "2*n": [("n", "2"), ("2", "n")],
          "2*m": [("m", "2")]}       # of square lattices
CELLS = {"n": [(("n",), 1)], "m": [(("m",), 1)], "2*n": [(("n",), 2), (("n", "2"), 1), (("1", "n"), 2)], "n*m": [(("n", "m"), 1), (("m",), "n")],
         "2*m": [(("m",), 2)], "6": [(("3",), 2), (("2",), 3), (("2", "3"), 1)], "4": [(("2", "1"), 2), (("4",), 1)], "3": [(("3",), 1)]}
CASIMIRS = {"dot({w}, {w})/2": (1, 1, 1), "({w}.x^2 + q*{w}.y^2 - {w}.z^2)/2": (1, .7, -1), "{w}.x^2 + 0.5*{w}.z^2": (2, 0, 1),
            "({w}.x^2 - {w}.y^2)/2": (1, -1, 0), "r*{w}.y^2": (0, 1.3, 0), "-({w}.x^2 + 2*{w}.y^2 + r*{w}.z^2)/2": (-1, -2, -.65)}
KAPPAS = ("-2", "0.5", '"kap"', '"1 + 0.5*mod(i, 2)"', '"(1 + i)*(1 - 2*mod(i, 2))"', '"if(i == 0, 1.5, -0.7)"', '"kap + floor(i/2)"',
          '"min(i + 1, 2)/kap"', '"abs(i - 1.5)"', '"max(0.6, i)"', '"-kap*(1 + i)^2/3"')
RADII = ("2", '"1 + 0.25*i"', '"abs(kap)"', '"if(mod(i, 2) == 0, 1, 1.7)"', '"sqrt(1 + i)"', '"max(0.8, kap/(1 + i))"')
NAMES = (("u", "v", "w"),) * 4 + (("S", "I", "E"), ("g", "s", "d"), ("x", "y", "z"))
MORE = (*FORMS, "1/(2 + (3 + {0})^2)", "1/(2 + (3 + ({0})^2)^2)", "mod({0}, 1.301)", "floor(2.303*({0}))*({1})", "abs({0})", "max({0}, {1})", "min({0}, {1})",
        "min({0} + 0.1*({2}), {1} - 0.3*({2}))", "max(min({0}, {1}), {2})", "if({0} >= {1}, {2}, {k})", "if({0} != {k}, {1}, {2})",
        "if({0} < {k}, {1}, {2})", "({0})*({1})*({2})", "sqrt(2 + {0}*tanh({0}))", "scaled({0}, {1})")
# what jumps where a quotient of integers is whole, and where sites take one side each
DIVIDED = ("floor({i}/n)", "floor({i}*m/n)", "mod({i}, m)", "mod({i}/m, one)", "if({i}/m == floor({i}/m), 0.9, -0.4)", "if({i}/n >= 1/n, 1.1, 0.3)",
           "if(2*{i} < n and {i} != m or {i} == n - 1, -0.8, 0.6)", "floor({i}/(2*m))", "abs({i} - n/2)")
WHOLE = "whole.toml"      # the file of a scene that says the same as one spec
DEPTHS = (0, 0, 0, 1, 1, 1, 1, 2, 2, 3)
SITES = 26


@dataclass(frozen=True)
class Family:
    """name, kind, count as written, its values at the defaults and in the run, further keys."""
    name: str
    kind: str
    count: str
    sizes: tuple
    more: tuple
    tracer: bool = False

    def line(self):
        count = self.count if self.count.isdigit() else f'"{self.count}"'
        return f"{self.name} = {{ {', '.join([f'{self.kind} = {count}', *self.more, *['tracer = true'] * self.tracer])} }}"


@dataclass
class Inventor(Writer):
    """The dice, the numbers n and m at the defaults and in the run, arrays (name -> size as written, sizes)."""
    pairs: tuple = ()
    arrays: dict = field(default_factory=dict)
    extra: str = "beta"

    # Numbers

    def coefficient(self):
        return f"{self.dice.choice((-1, 1))*(10*self.dice.randint(10, 139) + self.dice.choice((1, 3, 7, 9)))/1000:g}"

    def sizes(self, count):
        return tuple(COUNTS[count](*p) for p in self.pairs)

    def at(self, text):
        """A size of a lattice, a number or a count, at the defaults and in the run."""
        return (int(text),) * 2 if str(text).isdigit() else self.sizes(text)

    def elements(self, indices, sizes):
        """Entries of arrays that exist for all values of the indices, whose families have these sizes."""
        found = [f"{a}[0]" for a in self.arrays]
        for (name, (_, have)), i, s in product(self.arrays.items(), indices, sizes):
            forms = {"{i}": s, "{i} + 1": [k + 1 for k in s], "2*{i}": [2*k - 1 for k in s], "2*{i} + 1": [2*k for k in s],
                     "n - 1 - {i}": [max(p[0], 10**6 * (k > p[0])) for p, k in zip(self.pairs, s)],
                     "m*{i}": [p[1]*(k - 1) + 1 for p, k in zip(self.pairs, s)]}
            found += [f"{name}[{form.format(i=i)}]" for form, need in forms.items()
                      if all(a <= b for a, b in zip(need, have)) and s is sizes[indices.index(i)]]
        if len(indices) > 1:
            found += 3 * [f"{a}[{indices[0]} + {indices[1]}]" for a, (_, have) in self.arrays.items()
                      if all(x + y - 1 <= h for x, y, h in zip(*sizes[:2], have))]
        return found

    # Formulas

    def leaf(self, names, indices):
        pick = self.dice.randint(0, 13)
        if pick <= 4:
            return f"{self.vector(names)}.{self.dice.choice('xyz')}"
        if pick <= 6:
            return f"dot({self.vector(names)}, {self.vector(names)})"
        if pick <= 8 and self.entries:
            return self.dice.choice(self.entries)
        if pick == 9 and indices:
            i = self.dice.choice(indices)
            return self.dice.choice((f"{i}/5", f"mod({i}, 2)", f"floor({i}/2)", f"(1 - 2*mod({i}, 2))", f"if({i} < 1, 1.2, 0.7)",
                                     f"mod({i}, n)", f"min({i}, m)", f"({i} - n/2)/7", *(form.format(i=i) for form in DIVIDED)))
        if pick == 10:
            return self.dice.choice(("a", "b", "c", "q", "r", self.extra, "n/7", "1/m"))
        if pick == 11:
            return self.dice.choice(("cos(1.3*t)", "sin(omega*t + 0.2)", "exp(-(t - 1)^2)", "mod(t, 2.003)", "1/(1 + t^2)", "shift",
                                     "if(mod(t, 0.371) < 0.171, 1, -0.5)", "floor(1.7*t + 0.013)",
                                     "mod(t, q)", "floor(t/T)", "mod(t/T, one)", "if(t/T > floor(t/T) + 0.503, 0.4, -1)"))
        if pick == 12:
            return f"triple({self.vector(names)}, {self.vector(names)}, {self.vector(names)})"
        return self.coefficient()

    def vector(self, names, depth=1):
        if self.dice.randint(0, 9) == 0:
            return self.dice.choice(("D", "(w_ + B)", "(0.3*w_ - D)")).replace("w_", self.dice.choice(names))
        return super().vector(names, depth)

    def number(self, names, indices, depth):
        if depth == 0:
            return self.leaf(names, indices)
        return self.dice.choice(MORE).format(*(self.number(names, indices, self.dice.randint(0, depth - 1)) for _ in range(3)),
                                             k=self.coefficient(), v=self.vector(names), u=self.vector(names))

    def body(self, names, indices, weights):
        """A sum of some terms in which every vector occurs."""
        depth = self.dice.choice(DEPTHS) if len(names) < 3 else self.dice.choice((0, 0, 1))
        factors = [f"{self.coefficient()}*" + "".join(f"{w}*" for w in weights)]
        text = " + ".join(f"{self.dice.choice(factors)}({self.number(names, indices, depth)})"
                          for _ in range(self.dice.choice((1, 1, 2, 3) if depth < 2 else (1, 1, 2))))
        return text + "".join(f" + {self.coefficient()}*{v}.{self.dice.choice('xyz')}*{names[0]}.{self.dice.choice('xyz')}"
                              for v in names if v not in text)


def any_space(dice) -> str:
    """A spec of families of any kind, with any effects."""
    before = dice.choice((2, 2, 3, 3, 4, 5)), dice.choice((1, 2, 2, 3))
    after = (dice.choice((2, 3, 4, 5)), dice.choice((1, 2, 3))) if dice.randint(0, 2) == 0 else before
    w = Inventor(dice, pairs=(before, after), extra=dice.choice(("h", "x1", "k0", "I2", "S2", "N", "beta", "E1", "J")))
    for name in dice.sample(("gamma", "delta", "rho"), dice.choice((0, 1, 1, 2, 3))):
        count = dice.choice([c for c in COUNTS if c != "one"])
        w.arrays[name] = count, w.sizes(count)
    w.families = random_families(w)
    effects = [term(w, "effects", f"e{k}", "energy", own_or_all(w, k)) for k in range(dice.choice((1, 1, 2, 2, 3)))]
    values = [term(w, "observables", f"o{k}", "value", w.families) for k in range(dice.choice((0, 0, 1, 2)))]
    start, run = random_start(w), random_run(w, len(effects))
    parts = [comments(dice, "sites"), *(files(w)), head(w), *w.lattices, *effects, *values, start, run]
    return "\n".join(p for p in parts if p) + "\n"


# The space

def random_families(w):
    dice, names = w.dice, w.dice.choice(NAMES)
    found, room = [], SITES
    for name in names[:dice.choice((1, 1, 2, 2, 3))]:
        found.append(random_family(w, name, dice.choice(("sphere",) * 4 + ("r3", "nambu")), room))
        room -= max(found[-1].sizes)
    if dice.randint(0, 4) == 0 and room > 2:
        found.append(random_family(w, "p", dice.choice(("sphere", "sphere", "r3")), room, True))
    return found


def random_family(w, name, kind, room, tracer=False):
    dice = w.dice
    least = 1
    fits = [c for c in COUNTS if max(w.sizes(c)) <= max(1, room // 2) and min(w.sizes(c)) >= least]
    count = dice.choice([c for c in fits if c in ("1", "one", "2", "n", "m")] if kind == "nambu" else fits + ["1", "one"])
    sizes, more = w.sizes(count), []
    plain = [f"{a}[i]" for a, (_, have) in w.arrays.items() if have != sizes]       # a list of strengths has one for each site
    entries = [e for e in w.elements(("i",), (sizes,)) if e not in plain and dice.randint(0, 1)]
    if dice.randint(0, 1):
        listed = [f"[{', '.join(w.coefficient() for _ in range(sizes[0]))}]"] * (sizes[0] == sizes[1])
        more.append(f"kappa = {dice.choice([*KAPPAS, *listed, *(quoted(e) for e in entries), *(quoted(e) for e in entries)])}")
    if kind == "sphere" and dice.randint(0, 2) == 0:
        more.append(f"radius = {dice.choice([*RADII, *(quoted(f'abs({e}) + 0.1') for e in entries)])}")
    if kind == "nambu":
        more.append(f'C = "{dice.choice(list(CASIMIRS)).format(w=name)}"')
    return Family(name, kind, count, sizes, tuple(more), tracer)


def quoted(text):
    return f'"{text}"'


def own_or_all(w, k):
    """The first effect moves what is no tracer."""
    own = [f for f in w.families if not f.tracer]
    return w.families if k and w.dice.randint(0, 2) else own


# Parameters

def head(w):
    dice = w.dice
    fixed = lambda: ", fixed = true" * (dice.randint(0, 2) == 0)
    (n, m), lists = w.pairs[0], []
    for name, (size, (s, _)) in w.arrays.items():
        value = f"[{', '.join(w.coefficient() for _ in range(s))}]" if dice.randint(0, 1) else w.coefficient()
        given = size if size.isdigit() else quoted(size)
        lists.append(f"{name} = {{ default = {value}, size = {given}{fixed()} }}")
    kap = dice.choice((0.9, 1.6, -1.2))
    lines = ["[model]", 'name = "random_model"', f"orientation = {dice.choice((1, 1, -1))}", "[space]", *(f.line() for f in w.families),
             "[parameters]", f"n = {{ default = {n}{fixed() if w.pairs[0] == w.pairs[1] else ''} }}",
             f"m = {{ default = {m}{fixed() if w.pairs[0] == w.pairs[1] else ''} }}", f"one = {{ default = 1{fixed()} }}",
             *(f"{name} = {{ default = {float(w.coefficient())!r}{fixed()} }}" for name in ("a", "b", "c", w.extra)),
             f"kap = {{ default = {kap}{fixed()} }}", f"q = {{ default = 0.7{fixed()} }}", f"r = {{ default = 1.3{fixed()} }}", "omega = 2.5", f"T = {{ default = 0.713{fixed()} }}", *lists,
             f"B = {{ default = [0.3, -0.5, 0.8], vector = true{fixed()} }}", f"D = {{ default = [0.2, 0.7, -0.4], vector = true{fixed()} }}",
             "[formulas]", '"square(s_1)" = "s_1*s_1"', '"mixed(s1, r1)" = "dot(s1, r1) + 0.2*triple(s1, r1, B)"',
             'shift = "a + 0.5*cos(omega*t)"', '"scaled(p1, p2)" = "square(p1) + q*p2"']
    several = w.families[0]
    lines.append(f'"pull(i1)" = "norm({several.name}[i1] + 3*vec(0.3, 0.5, 1))"')
    return "\n".join(lines)


def files(w):
    return ["\n".join(f"# {line}" for line in [f"file: {name}", *text.split("\n")]) + "\n" for name, text in w.files.items()]


# Terms

def term(w, section, name, key, families):
    over, names, indices, weights = random_over(w, families)
    sizes = [next(f.sizes for f in w.families if v.startswith(f.name + "[")) for v in names if "[" in v][:len(indices)]
    w.entries = w.elements(indices, sizes) if len(sizes) == len(indices) else w.elements((), ())
    first = w.families[0].name
    if over and names[0].startswith(f"{first}[") and w.dice.randint(0, 5) == 0:
        w.entries = [*w.entries, f"pull({indices[0]})"]
    return "\n".join([f"[{section}.{name}]", *([f'over = "{over}"'] if over else []),
                      f'{key} = """{w.body(names, indices, weights)}"""'])


def random_over(w, families):
    """(over, vectors of the term, indices, weights); a term holds one tracer at most."""
    dice, f = w.dice, w.dice.choice(families)
    index = dice.choice((("i", "j", "k", "l"),) * 3 + (("k", "i", "c2", "j"), ("s2", "h2", "m2", "x2")))
    kinds = [once, site, site] if f.tracer or max(f.sizes) == 1 else [once, site, pair, chain, chain, square, cubic, declared, declared, graph]
    if len(families) > 1:
        kinds += [each] * 3
    return dice.choice(kinds)(w, f, index, families) or site(w, f, index, families)


def on(w, f):
    return f" on {f.name}" if len(w.families) > 1 else w.dice.choice(("", f" on {f.name}"))


def vectors(f, index, count):
    return [f"{f.name}[{i}]" for i in index[:count]]


def once(w, f, index, families):
    others = [g for g in families if g is not f and not (f.tracer and g.tracer)]
    found = [f] + ([w.dice.choice(others)] if others and w.dice.randint(0, 1) else [])
    names = [g.name if g.count == "1" and w.dice.randint(0, 1) else f"{g.name}[{w.dice.randrange(min(g.sizes))}]" for g in found]
    if not f.tracer and min(f.sizes) > 1 and w.dice.randint(0, 1):
        names = [f"{f.name}[0]", f"{f.name}[{min(f.sizes) - 1}]"]
    return "", names, (), ()


def site(w, f, index, families):
    names = vectors(f, index, 1)
    single = [g for g in families if g is not f and g.count == "1" and not (f.tracer and g.tracer)]
    if single and w.dice.randint(0, 1):
        names = names + [w.dice.choice(single).name]
    return f"site({index[0]}) of {f.name}", names, index[:1], ()


def pair(w, f, index, families):
    return f"pair({index[0]}, {index[1]}) of {f.name}", vectors(f, index, 2), index[:2], ()


def edge_of(w, sizes, least=2):
    return w.dice.choice(("periodic", "open")) if min(sizes) >= least else "open"


def chain(w, f, index, families):
    far = w.dice.randint(0, 3) == 0
    edge = edge_of(w, f.sizes, 3 if far else 2)
    text = f"bond({index[0]}, {index[1]}) of chain({f.count}, {edge}{', 2' * far}){on(w, f)}"
    return text, vectors(f, index, 2), index[:2], ()


def square(w, f, index, families):
    if f.count not in SHAPES:
        return None
    shape = w.dice.choice(SHAPES[f.count])
    edges = [edge_of(w, w.at(s)) for s in shape]
    return f"bond({index[0]}, {index[1]}) of square({', '.join([*shape, *edges])}){on(w, f)}", vectors(f, index, 2), index[:2], ()


def cubic(w, f, index, families):
    if f.count not in SHAPES:
        return None
    shape = list(w.dice.choice(SHAPES[f.count]))
    shape.insert(w.dice.randint(0, 2), "1")
    edges = [edge_of(w, w.at(s)) for s in shape]
    return f"bond({index[0]}, {index[1]}) of cubic({', '.join([*shape, *edges])}){on(w, f)}", vectors(f, index, 2), index[:2], ()


def declared(w, f, index, families):
    """A lattice of its own: cells, one to three bonds of two to four sites each."""
    cells = [c for c in CELLS.get(f.count, []) if str(c[1]).isdigit()]
    if not cells:
        return None
    size, inside = w.dice.choice(cells)
    periodic = [w.dice.randint(0, 1) for _ in size]
    count = w.dice.choice((2, 2, 2, 3, 3, 4))
    bonds = [b for b in (random_bond(w, size, inside, periodic, count) for _ in range(w.dice.randint(1, 3))) if b]
    if not bonds:
        return None
    name = f"l{len(w.lattices)}"
    lists = ", ".join(written_bond(b) for b in bonds)
    edges = [quoted(("open", "periodic")[p]) for p in periodic]
    w.lattices.append("\n".join([
        f"[lattices.{name}]", f"size = [{', '.join(s if s.isdigit() else quoted(s) for s in size)}]",
        f"boundary = {edges[0] if len(set(edges)) == 1 else '[' + ', '.join(edges) + ']'}", *[f"sites = {inside}"] * (inside > 1),
        f"bonds.b = [{lists}]"]))
    return f"bond({', '.join(index[:count])}) of {name}{w.dice.choice(('', '.b'))}{on(w, f)}", vectors(f, index, count), index[:count], ()


def random_bond(w, size, inside, periodic, count):
    """[(site of the cell, offsets)]; None when chance joins a site to itself."""
    for _ in range(20):
        bond = [(w.dice.randrange(inside), tuple(w.dice.choice((0, 0, 1, 1, -1, 2)) * bool(k) for _ in size)) for k in range(count)]
        if all(len({(s, tuple(o % w.at(n)[k] if p else o for o, n, p in zip(off, size, periodic))) for s, off in bond}) == count
               for k in (0, 1)):
            return bond
    return None


def written_bond(bond):
    if len(bond) == 2:
        (a, _), (b, offset) = bond
        return f"{{ from = {a}, to = {b}, offset = {list(offset)} }}"
    return f"{{ at = {[[s, *offset] for s, offset in bond]} }}"


def graph(w, f, index, families):
    least, dice = min(f.sizes), w.dice
    if least < 2:
        return None
    name, columns = f"g{len(w.files)}", dice.randint(0, 2)
    edges = [dice.sample(range(least), 2) for _ in range(dice.randint(1, 2*least))]
    rows = [", ".join(map(str, [*e, *(w.coefficient() for _ in range(columns))])) for e in edges]
    title = [",".join(["i", "j", "K", "L"][:2 + columns])] * dice.randint(0, 1)
    w.files[f"{name}.csv"] = "\n".join([*title, *rows])
    w.lattices.append(f'[graphs.{name}]\nfile = "{name}.csv"')
    weights = ("K", "L")[:dice.randint(0, columns)]
    return f"edge({', '.join([*index[:2], *weights])}) of {name}{on(w, f)}", vectors(f, index, 2), index[:2], weights


def each(w, f, index, families):
    others = [g for g in families if g is not f and not (f.tracer and g.tracer)]
    if not others:
        return None
    found = [f, *w.dice.sample(others, min(len(others), w.dice.choice((1, 1, 1, 2))))]
    text = ", ".join(f"{i} of {g.name}" for i, g in zip(index, found))
    return f"each({text})", [f"{g.name}[{i}]" for i, g in zip(index, found)], index[:len(found)], ()


# Starts and the run

def random_start(w):
    single = len(w.families) == 1
    return "\n".join(line for f in w.families for line in [f"[starts.s{'' if single else '.' + f.name}]", *start_lines(w, f)])


def start_lines(w, f):
    """How one family starts: a kind that its count and its leaf allow."""
    dice, same = w.dice, f.sizes[0] == f.sizes[1]
    if f.kind == "nambu":
        diagonal = next(d for c, d in CASIMIRS.items() if c.format(w=f.name) in f.more[-1])
        kinds = [lambda: formula_start(dice, tiled(dice, diagonal))] + [lambda: listed_start(f, lambda: tiled(dice, diagonal))] * same
        return dice.choice(kinds)()
    on_sphere = f.kind == "sphere"
    kinds = [lambda: [f"random = {dice.randint(0, 99)}"], lambda: formula_start(dice, (0.6, 0.7, -0.4)) + ["normalise = true"] * on_sphere,
             lambda: ['theta = "0.4 + 0.37*i"', f'phi = "{dice.randint(1, 6)} + 2.4*i"']]
    if same:
        kinds += [lambda: listed_start(f, lambda: [dice.choice((-1, 1)) * dice.uniform(0.4, 1) for _ in "xyz"]) + ["normalise = true"] * on_sphere,
                  *[lambda: [f"{k} = [{', '.join(f'{dice.uniform(0.3, 2.8):.3f}' for _ in range(f.sizes[0]))}]" for k in ("theta", "phi")]
                    ] * ('radius = "' not in f.line()),
                  lambda: file_start(w, f) + ["normalise = true"] * on_sphere]
    return dice.choice(kinds)()


def tiled(dice, diagonal):
    """A vector where C is well away from 0."""
    while True:
        v = [dice.choice((-1, 1)) * dice.uniform(0.4, 1.2) for _ in "xyz"]
        if abs(sum(d * x * x for d, x in zip(diagonal, v))) > 0.3:
            return v


def formula_start(dice, v):
    return [f'{axis} = "{x:.3f} {"+" if x > 0 else "-"} 0.01*i"' for axis, x in zip("xyz", v)]


def listed_start(f, draw):
    return ["vectors = [" + ", ".join(f"[{', '.join(f'{x:.3f}' for x in draw())}]" for _ in range(f.sizes[0])) + "]"]


def file_start(w, f):
    name = f"start_{f.name}.csv"
    w.files[name] = "\n".join(", ".join(f"{w.dice.choice((-1, 1)) * w.dice.uniform(0.4, 1):.3f}" for _ in "xyz") for _ in range(f.sizes[0]))
    return [f'file = "{name}"']


def random_run(w, effects):
    dice = w.dice
    method, solver = any_method(dice, {f.kind for f in w.families})
    lines = ["[runs.fuzz]", 'start = "s"', f'method = "{method}"', f'solver = "{solver}"', f"h = {dice.choice((0.01, -0.01))}", "steps = 10"]
    kept = sorted(dice.sample(range(effects), dice.randint(1, effects)))
    if len(kept) < effects:
        lines.append(f"effects = {[f'e{k}' for k in kept]}".replace("'", '"'))
    values = set_values(w)
    if values:
        lines.append(f"set = {{ {', '.join(values)} }}")
    return "\n".join(lines)


def set_values(w):
    """New sizes, with lists of the new lengths; new numbers and vectors."""
    dice, found = w.dice, []
    (before, after) = w.pairs
    if before != after:
        found += [f"n = {after[0]}", f"m = {after[1]}"]
    for name, (_, (_, size)) in w.arrays.items():
        if before != after or dice.randint(0, 2) == 0:
            found.append(f"{name} = [{', '.join(w.coefficient() for _ in range(size))}]" if dice.randint(0, 2) else f"{name} = {w.coefficient()}")
    found += [f"{name} = {float(w.coefficient())!r}" for name in ("a", "b", w.extra) if dice.randint(0, 3) == 0]
    return found + ["B = [-0.2, 0.4, 0.9]"] * (dice.randint(0, 3) == 0)


def put_files(where, files):
    """Files in a folder and below it; of a `.npy` file the text has its numbers, as a table."""
    for name, content in files.items():
        path = where / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if name.endswith(".npy"):
            np.save(path, np.loadtxt(content.splitlines(), ndmin=1))
        else:
            path.write_text(content)


def files_of(text) -> dict:
    """The files that the comments of a text hold: name -> content."""
    found, name = {}, None
    for line in text.split("\n"):
        if line.startswith("# file: "):
            name = line[8:].strip()
            found[name] = ""
        elif name and line.startswith("# "):
            found[name] += line[2:] + "\n"
        else:
            name = None
    return found
