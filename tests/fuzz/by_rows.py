"""Random lattices that must be stepped by rows: every method that has such a step, with everything that it supports (docs/lattices.md).

    text = row_text(random.Random(7))

The registry (`smidgen.methods`) says which methods these are, and what each of them supports. A comment of the text, `# goes: by rows`, says that its
steps must go by rows; if they go site by site, this is a fault (`fuzz.through`).
"""
from __future__ import annotations

from dataclasses import dataclass, field

from smidgen.compile.features import EVERYWHERE
from smidgen.effects.damping import FORMS
from smidgen.methods import METHODS

from .drawn import comments
from .invent import quoted

# over, as many sites as this, bonds of a site, sites of a bond; {0} and {1}: its boundaries
PLACES = {"chain": ("chain(n, {0})", "n", 2), "next on a chain": ("chain(n, {0}, 2)", "n", 2), "square": ("square(n, m, {0}, {1})", "n*m", 4), "short rows": ("square(m, n, {0}, {1})", "n*m", 4),
          "diagonals": ("square(n, m, {0}, {1}).second", "n*m", 4), "cubic": ("cubic(n, m, 2, {0}, {1}, open)", "2*n*m", 6), "cells": ("cells.b", "2*n*m", 4), "line": ("line.b", "n", 3),
          "shells": ("shells.b", "n*m", 12), "plaquettes": ("plaquettes.b", "n*m", 4), "reaching": ("reaching.b", "n*m", 3)}
DECLARED = {"cells": 'size = ["n", "m"]\nboundary = ["{0}", "{1}"]\nsites = 2\n'
                     "bonds.b = [{{ from = 0, to = 1, offset = [0, 0] }}, {{ from = 1, to = 1, offset = [1, 0] }}, {{ from = 1, to = 0, offset = [0, 1] }}]",
            "shells": 'size = ["n", "m"]\nboundary = ["{0}", "{1}"]\nbonds.b = [{{ offset = [1, 0] }}, {{ offset = [0, 1] }}, {{ offset = [1, 1] }}, {{ offset = [1, -1] }}, {{ offset = [2, 0] }}, {{ offset = [0, 2] }}]',
            "line": 'size = ["n"]\nboundary = "{0}"\nbonds.b = [{{ at = [[0, 0], [0, 1], [0, 2]] }}]',
            "plaquettes": 'size = ["n", "m"]\nboundary = ["{0}", "{1}"]\nbonds.b = [{{ at = [[0, 0, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1]] }}]',
            "reaching": 'size = ["n", "m"]\nboundary = ["{0}", "{1}"]\nbonds.b = [{{ at = [[0, -2, 0], [0, 0, 0], [0, 2, 0]] }}]',
            "above": 'size = {size}\nboundary = "periodic"\nsites = {sites}\nbonds.b = {bonds}'}
PAIRED = ("chain", "square", "short rows", "cubic")      # for pair rotations: rings of even length, and bonds that are alike
FARTHER = {"chain": "next on a chain", "square": "diagonals"}      # two shells of one lattice
OF_THREE = ("{k}*triple({0}, {1}, {2})", "{k}*dot({0}, {1})*{2}.{x}", "{k}*{0}.{x}*{1}.{y}*{2}.z", "{k}*dot({0}, {2})")
MANY = {"line": OF_THREE, "reaching": OF_THREE,
        "plaquettes": ("{k}*(dot({0}, {1})*dot({2}, {3}) + dot({1}, {2})*dot({0}, {3}))", "{k}*dot({0}, {1})*dot({2}, {3})", "{k}*dot({0}, {2})*{1}.{x}*{3}.{x}")}

# Formulas: of bonds that are linear in either end, of others, and of products alone, as pair rotations take them; of sites in the same way
BILINEAR = ("{k}*dot({0}, {1})", "{k}*{0}.{x}*{1}.{y}", "{k}*triple({0}, {1}, B)", "{k}*{0}.{x}*{1}.{x} + dot({0}, {1})/3")
CURVED = ("-0.4*dot({0}, {1})^2", "0.3*dot({0}, {1})^3 + {k}*dot({0}, {1})", "0.3*{0}.z^2*{1}.z^2", "exp(0.3*dot({0}, {1}))", "sin({0}.{x})*{1}.{y}", "0.2*dot({0}, {1})*dot({0}, B)*{1}.{x}")
OF_PRODUCTS = ("J*dot({0}, {1})", "{k}*dot({0}, {1})^2", "{k}*dot({0}, {1}) - 0.2*dot({0}, {1})^3")
LINEAR = ("{k}*{0}.{x}", "dot({0}, B)", "{k}*({0}.x - 0.3*{0}.z)")
QUADRATIC = ("{k}*{0}.{x}^2", "a*{0}.{x}*{0}.{y} + dot({0}, B)", "(dot({0}, B) - a)^2/4")
BENT = ("0.2*({0}.x^4 + {0}.y^4 + {0}.z^4)", "{k}*{0}.{x}^3", "exp(-{0}.z^2)/5", "0.2*sin({0}.x) + 0.3*{0}.{y}^4", "0.4*{0}.x^2*{0}.y^2*{0}.z^2")

# Factors: of the time, as long as a bound is known for all times; of the site, of the bond, of both and the time
CLOCK = ("cos(2.1*t)", "(1 + 0.4*sin(5*t))", "exp(-(t - 1)^2)", "min(max(t/3, 0), 1)", "mod(t, T)", "(1 + mod(floor(t/0.7), 3))", "if(mod(t, 1) < 0.5, 1, -1)", "if(t < 0.05, 0.3, 1)")
GROWING = ("t", "(0.3 + t)", "t^2/4")
OF_SITES = ("A[k]", "normal(4, k)", "(1 + 0.2*mod(k, 3))", "cos(0.7*mod(k, 16))", "(1 - 2*mod(k, 2))", "floor(k/4)/(1 + k)", "if(uniform(2, k) < 0.4, 1, 0.2)", "A[k]*cos(2*t)", "cos((1 + A[k])*t)", "(A[k] + k/n)")
PHASES = ("cos(2*t + A[k])", "sin(0.3*mod(k, 16) - 1.7*t)", "sin(A[k] - t)")         # two numbers of a site
OF_BONDS = ("(1 + 0.2*normal(6, i, j))", "A[i]*A[j]", "(1 + 0.1*mod(i + j, 3))", "normal(6, i, j)*cos(t)")
OF_NUMBERS = ("uniform(1, b)", "(1 + 0.2*mod(b, 3))", "normal(5, b)*cos(t)")
DAMPINGS = ("0.3", "q", "abs(a)")
DAMPINGS_BY_SITE = ("0.1*(1 + mod(k, 2))", "0.3*abs(A[k])", "0.2*uniform(4, k)")
HEATS = ("0.4", "abs(a)", "q*(1 + mod(k, 2))", "0*a")
CLOSED = ("0.2*cross({w}, cross({w}, vec(0.3, -0.2, 0.9)))", "q*cross({w}, vec(1, a, 0.5))", "0.1*vec(0, 0, 1)*dot({w}, {w}) - 0.1*{w}*{w}.z")
CLOSED_BY_SITE = ("(0.2 + 0.1*mod(k, 3))*cross({w}, cross({w}, vec(0.3, -0.2, 0.9)))", "A[k]*cross({w}, vec(1, a, 0.5))")
OPEN = ("0.2*{w}.z*cross({w}, vec(0, 1, 0))", "0.3*cos(t)*cross({w}, cross({w}, vec({w}.x, 0, 0)))", "-0.1*{w}.z*cross({w}, vec(0, 0.3, 1))", "0.2*(1 + mod(k, 3))*{w}.y*cross({w}, vec(1, 0, 0.5))")
BESIDE = "0.1*cross({w}[i], cross({w}[i], {w}[j]) - {w}[j])"
PINNED = ("k < 1", "uniform(3, k) < 0.4", "mod(k, 2) == 0 and normal(2, k) < 0.8")
ABSENT = ("k > 0 and uniform(5, k) < 0.3", "k == 1", "mod(k, 5) == 1")
RADII, KAPPAS = ('"1 + 0.2*mod(i, 2)"', '"1 + 0.3*uniform(8, i)"'), ('"1 + 0.5*mod(i, 2)"', '"(1 + mod(i, 2))*(1 - 2*mod(i, 3)/3)"', '"0.8 + abs(A[i])"')
ALIKE = ((), (), ("kappa = -1.5",), ('kappa = "kap"',), ("radius = 1.7",), ('radius = "abs(kap)"', "kappa = 0.7"))
WAVE = "-DSMG_WAVE_FROM=0 -DSMG_WAVE_BLOCK=8 -DSMG_BLOCKS_TO=0 -DSMG_LARGE_PLANE=100"


def serves_rows(m) -> bool:
    """Has a method a step by rows?"""
    return m.takes_fields or m.splitting in ("sublattices", "pairs") or m.of_midpoints and not m.free_body


BY_ROWS = [m for m in METHODS.values() if serves_rows(m)]
KINDS = list(dict.fromkeys((m.header, m.stages > 1) for m in BY_ROWS))


def kind_of(m) -> tuple:
    return m.header, m.stages > 1


@dataclass
class Draft:
    """A lattice for which a text is being written. room: how many numbers may still differ from site to site, so that the C stays short; space: what is said of each family; warm: is there
    thermal noise? sided: does some spin feel a bond whose other ends are 0? landau: damping in the form of Landau and Lifshitz? curved: an energy that is not quadratic? grows: one without a bound at all times?"""
    dice: object
    method: object
    place: str
    edges: tuple
    names: tuple
    room: int = 24
    effects: list = field(default_factory=list)
    lattices: dict = field(default_factory=dict)
    space: dict = field(default_factory=dict)
    warm: bool = False
    sided: bool = False
    landau: bool = False
    curved: bool = False
    grows: bool = False

    def chance(self, one_of: int) -> bool:
        return self.dice.randrange(one_of) == 0

    def number(self) -> str:
        return f"{self.dice.choice((-1, 1))*(10*self.dice.randint(10, 139) + self.dice.choice((1, 3, 7, 9)))/1000:g}"

    def fill(self, form, *vectors) -> str:
        return form.format(*vectors, k=self.number(), x=self.dice.choice("xyz"), y=self.dice.choice("xyz"))

    def takes(self, numbers: int) -> bool:
        """Is there room for this many more numbers of a site? If so, it is reserved."""
        fits = numbers <= self.room
        self.room -= numbers * fits
        return fits

    def effect(self, over, **says):
        self.effects.append("\n".join([f"[effects.e{len(self.effects)}]", f'over = "{over}"', *(f'{key} = "{value}"' for key, value in says.items())]) + "\n")

    def over(self, place=None) -> str:
        """The bonds, with the lattice that they belong to."""
        place = place or self.place
        if place in DECLARED:
            self.lattices[place] = DECLARED[place].format(*self.edges)
        return PLACES[place][0].format(*self.edges)

    def on(self, name) -> str:
        return f" on {name}" if len(self.names) > 1 else ""


def row_text(dice) -> str:
    """A spec with its run."""
    draft, layout, (n, m) = begun(dice)
    for part in (bonds, one_sided, sites, more_bonds, strengths, held, damped, pushed):
        part(draft)
    return written(draft, layout, n, m)


def begun(dice) -> tuple:
    """(a draft, what its text is written for, its sizes). A sixth of the midpoints are long chains that are taken for large, in wavefronts."""
    header, composed = dice.choice(KINDS + [("smg_spherical_midpoint.h", False)] * 3)
    method = dice.choice([m for m in BY_ROWS if kind_of(m) == (header, composed)])
    wave = method.midpoint and dice.randrange(6) == 0
    place = "chain" if wave else dice.choice(PAIRED if method.splitting == "pairs" else list(PLACES))
    edges = dice.choice((("periodic", "periodic"), ("periodic", "open"), ("open", "periodic"), ("open", "open")))
    names = ("w", "v") if not wave and place not in MANY and method.splitting != "pairs" and dice.randrange(4) == 0 else ("w",)
    return Draft(dice, method, place, edges, names), "wavefronts" if wave else "rows", sizes(dice, method, place, wave, len(names), edges[0] == "periodic")


def sizes(dice, method, place, wave, families, ring) -> tuple:
    """n and m; ring: does the first direction close? Then it may be shorter than bonds are long. Rings of even length for pair rotations; of chains more sites than a small dense matrix has; of compositions as many as
    the witness's matrix has."""
    if method.splitting == "pairs":
        return dice.choice((8, 12, 34)), dice.choice((4, 8))
    if place == "shells":
        return (dice.choice((7, 8, 12)), dice.choice((5, 6))) if not method.of_midpoints or method.midpoint else (7, 5) if families == 1 else (5, 5)
    m = dice.choice((4, 5, 8) if "diagonals" in (place, FARTHER.get(place)) else (3, 4, 8))
    if wave or PLACES[place][1] == "n":
        few = families > 1 and method.of_midpoints and not method.midpoint
        return dice.choice((256, 271) if wave else (13, 14, 17) if few else (13, 14, 17, 33, 48)), m
    if place == "reaching":
        return (3, 8) if dice.randrange(2) and ring else (dice.choice((5, 7)), 4)
    if method.of_midpoints and not method.midpoint:
        if families > 1:
            return (5, 3) if PLACES[place][1] == "2*n*m" else (7, min(m, 4))
        return dice.choice((5, 6, 7)) if PLACES[place][1] == "2*n*m" else dice.choice((7, 8, 12)), min(m, 4)
    return dice.choice((5, 6, 7, 8, 12, 17)), m


# The energy

def bond_forms(d) -> tuple:
    """Those that a method takes."""
    if d.method.splitting:
        return OF_PRODUCTS if d.method.splitting == "pairs" else BILINEAR
    return one_of(d, BILINEAR, CURVED)


def one_of(d, quadratic, curved) -> tuple:
    """A third of the energies are not quadratic."""
    found = d.chance(3)
    d.curved = d.curved or found
    return curved if found else quadratic


def bonds(d):
    """Of each family; one or two effects on the same bonds, and those of a farther shell."""
    for name in d.names:
        for _ in range(d.dice.choice((1, 1, 2))):
            one_bond(d, name, d.place)
        if d.place in FARTHER and not pair(d) and d.chance(4):
            one_bond(d, name, FARTHER[d.place])


def one_bond(d, name, place):
    if place in MANY:
        form = d.dice.choice(many_forms(d, place))
        energy, d.sided = d.fill(form, *(f"{name}[{i}]" for i in "ijkl")), d.sided or "{1}" not in form
        if "{1}" in form and not pair(d) and d.chance(3) and d.takes(4):
            energy = f"{d.dice.choice(OF_BONDS)}*({energy})"
        return d.effect(f"bond(i, j, k{', l' * (place == 'plaquettes')}) of {d.over(place)}{d.on(name)}", energy=energy if place == "plaquettes" else clocked(d, energy))
    energy, index = d.fill(d.dice.choice(bond_forms(d)), f"{name}[i]", f"{name}[j]"), "i, j"
    if not pair(d) and d.chance(3) and not several_terms(energy) and d.takes(PLACES[place][2]):
        index, factors = d.dice.choice((("i, j", OF_BONDS), ("i, j, b", OF_NUMBERS)))
        energy = f"{d.dice.choice(factors)}*({energy})"
        if index == "i, j" and d.chance(3) and d.takes(PLACES[place][2] + 1):       # 1: kappa
            energy = f"{energy} - 0.7*(1 + uniform(2, i))*{name}[j].z"
    d.effect(f"bond({index}) of {d.over(place)}{d.on(name)}", energy=clocked(d, energy))


def one_sided(d):
    """An effect over bonds that names one of their ends, and is not felt where an open end cuts them."""
    if pair(d) or d.place in MANY or not d.chance(5):
        return
    name, d.sided = d.dice.choice(d.names), True
    energy = d.fill(d.dice.choice(LINEAR if d.method.splitting else QUADRATIC), f"{name}[{d.dice.choice('ij')}]")
    d.effect(f"bond(i, j) of {d.over()}{d.on(name)}", energy=clocked(d, energy))


def many_forms(d, place) -> tuple:
    """All of them are linear in each site, as splittings ask for."""
    d.curved = True
    return MANY[place]


def several_terms(energy) -> bool:
    """A number of a bond times a sum, or times a vector, is several."""
    return any(word in energy for word in (" + ", " - ", "exp(", "sin(", "B)"))


def clocked(d, energy) -> str:
    """A fourth of them depend on time. Factors that grow without limit are for methods that need no bound, and for the midpoint method, which takes one at each step."""
    if not d.chance(4):
        return energy
    may_grow = d.method.takes_fields or d.method.midpoint and d.method.onto_leaf
    factor = d.dice.choice(CLOCK + GROWING * may_grow)
    d.grows = d.grows or factor in GROWING
    return f"{factor}*({energy})"


def more_bonds(d):
    """Between both families."""
    if len(d.names) < 2 or d.chance(3):
        return
    size = PLACES[d.place][1]
    cells = {"n": '["n"]', "n*m": '["n", "m"]', "2*n*m": '["n", "m"]'}[size]
    if d.place in ("cubic", "cells", "short rows", "diagonals"):
        over = d.over()
    else:
        flat = size == "n"
        d.lattices["above"] = DECLARED["above"].format(size=cells, sites=1, bonds="[{ offset = [0] }, { offset = [1] }]" if flat else "[{ offset = [0, 0] }, { offset = [1, 0] }]")
        over = "above.b"
    d.effect(f"bond(i of w, j of v) of {over}", energy=clocked(d, d.fill(d.dice.choice(bond_forms(d)), "w[i]", "v[j]")))


def sites(d):
    """Fields and anisotropies."""
    if pair(d):
        return
    for _ in range(d.dice.choice((0, 1, 1, 2))):
        name = d.dice.choice(d.names)
        forms = LINEAR if d.method.splitting else d.dice.choice((LINEAR, QUADRATIC, one_of(d, QUADRATIC, BENT)))
        energy = d.fill(d.dice.choice(forms), f"{name}[k]")
        numbers, factors = d.dice.choice(((1, OF_SITES), (1, OF_SITES), (2, PHASES)))
        whole = d.chance(2) and not several_terms(energy) and d.takes(numbers)
        d.effect(f"site(k) of {name}", energy=f"{d.dice.choice(factors)}*({energy})" if whole else clocked(d, energy))


# What is said of sites

def strengths(d):
    """kappa and radius: of all sites alike, of each family, or of each site."""
    for name in d.names:
        d.space[name] = list(d.dice.choice(ALIKE)) if name == "w" or d.chance(2) and not pair(d) else list(d.space["w"])
    if not pair(d) and d.takes(1) and d.chance(3):
        d.space["w"] = [k for k in d.space["w"] if not k.startswith("kappa")] + [f"kappa = {d.dice.choice(KAPPAS)}"]
    radii = {tuple(k for k in d.space[name] if k.startswith("radius")) for name in d.names}
    one = d.method.of_midpoints or d.method.by_field
    if len(radii) > 1 and not (one and d.takes(1)):
        d.space["v"] = [k for k in d.space["v"] if not k.startswith("radius")] + [k for k in d.space["w"] if k.startswith("radius")]
    if one and (d.method.by_field or not d.curved) and d.chance(4) and d.takes(1):
        d.space["w"] = [k for k in d.space["w"] if not k.startswith("radius")] + [f"radius = {d.dice.choice(RADII)}"]


def pair(d) -> bool:
    return d.method.splitting == "pairs"


def responds(d) -> bool:
    """Does its step by rows support more than precession?"""
    return d.method.responds and d.method.responds_by_rows


def held(d):
    """Pinned and absent sites; a number of each site says whether it moves."""
    if not (responds(d) and d.chance(3) and d.takes(1)):
        return
    for _ in range(d.dice.randint(1, 2)):
        absent = d.chance(2) and not d.sided and not any("if(" in e for e in d.effects)       # conditions beside absent sites are no factors of the time alone
        d.effect(f"site(k) of {d.dice.choice(d.names)}", **{"absent" if absent else "pinned": d.dice.choice(ABSENT if absent else PINNED)})


def damped(d):
    if not (responds(d) and d.chance(3)):
        return
    warm = d.chance(2)
    for name in d.names[:d.dice.randint(1, len(d.names))]:
        alike = len(d.names) == 1 and not d.takes(2)
        if len(d.names) > 1 and not d.takes(2):
            return
        says = {"damping": d.dice.choice(DAMPINGS if alike else DAMPINGS + DAMPINGS_BY_SITE), "form": d.dice.choice(FORMS)}
        d.effect(f"site(k) of {name}", **says, **{"kT": d.dice.choice(HEATS)} if warm else {})
        d.warm, d.landau = d.warm or warm, d.landau or says["form"] == "ll"


def pushed(d):
    """Torques: in closed form, at all sites alike or not; of other forms, and of neighbours, where these are part of the field, which has no bound beside that damping.

    The bounds of those contain the radius, which then is not of each site. Those of neighbours are divided by kappa, and what pinned sites feel is
    another response: where one of the two is of each site, they differ from bond to bond. Beside absent sites
    neither these nor such that are no product with the vector: conditions stand in them."""
    if not (responds(d) and d.chance(3)):
        return
    name, gone, still = d.dice.choice(d.names), any("absent" in effect for effect in d.effects), any("pinned" in effect for effect in d.effects)
    free = d.method.takes_fields and len(d.names) == 1 or d.method.of_midpoints and not d.landau and not of_each(d, name, "radius", RADII)
    if free and d.chance(2):
        d.effect(f"site(k) of {name}", torque=d.dice.choice(OPEN[:3:1 + gone]).replace("{w}", f"{name}[k]"))
        if d.place not in MANY and not (gone or still or of_each(d, name, "kappa", KAPPAS) or of_each(d, name, "radius", RADII)) and d.chance(3):
            d.effect(f"bond(i, j) of {d.over()}{d.on(name)}", torque=BESIDE.replace("{w}", name))
    elif d.takes(6):
        timed = d.method.pushed_by_rows and not of_each(d, name, "radius", RADII) and d.chance(2)
        torque = f"{d.dice.choice(CLOCK)}*{d.dice.choice(CLOSED[:2] + CLOSED_BY_SITE)}" if timed else d.dice.choice(CLOSED + CLOSED_BY_SITE)
        d.effect(f"site(k) of {name}", torque=torque.replace("{w}", f"{name}[k]"))


def of_each(d, name, what, formulas) -> bool:
    """Does what the space says of a family differ from site to site?"""
    return any(f"{what} = {x}" in d.space[name] for x in formulas)


# The text

def wanted(d) -> list:
    """Features that its method has by rows: not extended precision, and of splittings none; ranks divide one family, whose bounds hold at all times."""
    without = {"extended", *["tangent"] * d.warm, *["distributed"] * (not d.method.midpoint or len(d.names) > 1 or d.grows)}
    return [] if d.method.splitting else [f for f in (*d.method.features, *EVERYWHERE) if f not in without and d.chance(4)]


def written(d, layout, n, m) -> str:
    dice, count = d.dice, PLACES[d.place][1]
    fixed = lambda: ", fixed = true" * d.chance(3)
    sites = {"n": n, "n*m": n*m, "2*n*m": 2*n*m}[count]
    listed = ", ".join(d.number() for _ in range(sites)) if sites < 300 else ""
    head = comments(dice, layout, (WAVE + " -fopenmp -DSMG_SHARE=8" * d.chance(4)) * (layout == "wavefronts"), wanted(d)) + "# goes: by rows\n"
    space = [f"{name} = {{ {', '.join([f'sphere = {quoted(count)}', *d.space[name]])} }}" for name in d.names]
    numbers = [f"n = {{ default = {n}{fixed()} }}", f"m = {{ default = {m}{fixed()} }}", *(f"{name} = {{ default = {value}{fixed()} }}" for name, value in
               (("a", 0.4), ("J", float(d.number())), ("kap", 0.8), ("q", 0.7), ("T", 0.713))), f"B = {{ default = [0.3, -0.5, 0.8], vector = true{fixed()} }}",
               f"A = {{ default = {f'[{listed}]' if listed else d.number()}, size = \"{count}\" }}"]
    dice.shuffle(d.effects)
    starts = [line for k, name in enumerate(d.names) for line in (f"[starts.s{'.' + name if len(d.names) > 1 else ''}]", f"random = {dice.randint(0, 99)}")]
    solver = dice.choice(("auto", "auto", "rotation")) if "rotation" in d.method.solvers else "auto"
    run = ["[runs.fuzz]", 'start = "s"', f'method = "{d.method.name}"', f'solver = "{solver}"', f"h = {0.01 if d.warm else dice.choice((0.01, -0.01))}", "steps = 10"]
    return head + "\n".join(["[model]", 'name = "random_model"', f"orientation = {dice.choice((1, -1))}", "[space]", *space, "[parameters]", *numbers,
                             *(f"[lattices.{name}]\n{text}" for name, text in d.lattices.items()), *d.effects, *starts, *run]) + "\n"
