"""Random specs of every layout that the generator has: single sites of any kind, a single sphere, few spheres in lanes, rows of a lattice,
blocks, wavefronts; any of them as an ensemble too.

    text = spec_text(random.Random(7))

What a layout needs is all that its spec is held to: how a model goes in the end the program says (`fuzz.program`).
"""
from __future__ import annotations

import random
import re

from smidgen.effects.damping import FORMS
from smidgen.methods import DEFAULT, METHODS

from .by_rows import row_text
from .drawn import COMPOSED, FREE, SINGLE, SPLIT, comments
from .invent import Inventor, any_space, quoted

PARAMETERS = ("a = {{ default = 0.4{} }}", "J = {{ default = {{J}}{} }}", "kap = {{ default = 0.8{} }}", "q = {{ default = 0.7{} }}", "T = {{ default = 0.713{} }}",
              "B = {{ default = [0.3, -0.5, 0.8], vector = true{} }}")


DAMPINGS = ("0.3", "q", "abs(a)", "0.1*(1 + mod(k, 2))")
HEATS = ("0.4", "abs(a)", "q*(1 + mod(k, 2))", "0*a", "300")      # the last: vectors turn around several times in a step


def spec_text(dice) -> str:
    """The text of a random spec: a third are lattices that must go by rows (`fuzz.by_rows`), drawn by dice of their own; of the others nearly half
    are of any space, the rest of one layout; a fourth of those that can be are damped, half of these
    with thermal noise; a fourth are moved by torques; a fourth have random numbers, a fourth sites that are pinned or absent, and a third of the lattices two families."""
    text = dice.choice((any_space,) * 6 + (free_body, single_sphere, few_spheres, few_spheres, rows, rows, blocks, wavefront))(dice)
    own = random.Random(text + "a lattice")
    if own.randint(0, 2) == 0:
        return row_text(own)
    text = doubled(text)
    text = warmed(damped(dice, text)) if dice.randint(0, 3) == 0 else text
    return held(disordered(pushed(dice, text) if dice.randint(0, 3) == 0 else text))


def doubled(text) -> str:
    """A third of the lattices in rows and in blocks with a second family, with couplings of its own and bonds between both, by dice of their own."""
    dice, bond = random.Random(text + "families"), re.search(r'over = "bond\(i, j\) of ([^"]*)"\nenergy = """(.*?)"""', text, re.DOTALL)
    if not re.match("# layout: (rows|blocks)$", text, re.MULTILINE) or dice.randint(0, 2):
        return text
    own = f'[effects.own]\nover = "bond(i, j) of {bond[1]} on v"\nenergy = """{dice.choice((bond[2], "0.7*dot(w[i], w[j])")).replace("w[", "v[")}"""\n'
    between = f'[effects.between]\nover = "bond(i of w, j of v) of {bond[1]}"\nenergy = "0.2*dot(w[i], v[j])"\n'
    found = with_effects(re.sub(r'(over = "bond\(i, j\) of [^"]*)"', r'\1 on w"', text), dice.choice((own, between, own + between)), "between")
    found = re.sub(r"^w = (\{ sphere = .*)", lambda m: f"{m[0]}\nv = {dice.choice((m[1], re.sub(', (kappa|radius) = .*', ', kappa = 1.3 }', m[1])))}", found, flags=re.MULTILINE)
    return re.sub(r"^\[starts\.s\]\n(.*)", lambda m: f"[starts.s.w]\n{m[1]}\n[starts.s.v]\nrandom = {dice.randint(0, 99)}", found, flags=re.MULTILINE)


def warmed(text) -> str:
    """Half of the damped ones with thermal noise, by dice of their own; noise has no step backward, and no tangent map."""
    dice = random.Random(text)
    if "\ndamping = " not in text or dice.randint(0, 1):
        return text
    heated = re.sub(r"^damping = .*$", lambda m: f'{m[0]}\nkT = "{dice.choice(HEATS)}"', text, count=dice.randint(0, 1), flags=re.MULTILINE)
    return re.sub(r"^# features: .*", lambda m: m[0].replace(" tangent", ""), re.sub(r"^h = -", "h = ", heated, flags=re.MULTILINE), flags=re.MULTILINE)


def damped(dice, text) -> str:
    """With damped sites, where the method has a step for them and a family is on spheres."""
    names = re.findall(r'^(\w+) = \{ (sphere|r3) = (?!.*tracer)', text, re.MULTILINE)
    method = re.search(r'^method = "(.*)"', text, re.MULTILINE)
    wanted = re.search(r"^# features: .*extended", text, re.MULTILINE)
    if not names or wanted or not METHODS[method[1] if method else DEFAULT].responds:
        return text
    effects = (f'[effects.d{k}]\nover = "site(k) of {name}"\ndamping = "{dice.choice(DAMPINGS)}"\n' + f'form = "{dice.choice(FORMS)}"\n' * (kind == "sphere")
               for k, (name, kind) in enumerate(dice.sample(names, dice.randint(1, len(names)))))
    return with_effects(text, "".join(effects), "d0")


# tangent by their form; on the sphere alone, which no radius or R^3 has, they are not drawn
TORQUES = ("0.2*cross({w}, cross({w}, vec(0.3, -0.2, 0.9)))", "q*cross({w}, vec(1, a, 0.5))*cos(t)", "0.1*cross(vec(0, 0, 1), {w})*{w}.z*(1 + mod(k, 2))",
           "-0.2*cross({w}, cross({w}, vec(0.2*{w}.x, {w}.y, -{w}.z)))", "0.1*vec(0, 0, 1)*dot({w}, {w}) - 0.1*{w}*{w}.z", "if(t < 0.05, 0.1, -0.1)*cross({w}, vec(0, 1, 0))")


def pushed(dice, text) -> str:
    """With torques on sites, of their own vector alone or of others, where the method has a step for them."""
    names = re.findall(r'^(\w+) = \{ (?:sphere|r3) = (?!.*tracer)', text, re.MULTILINE)
    method = re.search(r'^method = "(.*)"', text, re.MULTILINE)
    wanted = re.search(r"^# features: .*extended", text, re.MULTILINE)
    if not names or wanted or not METHODS[method[1] if method else DEFAULT].responds:
        return text
    effects = []
    for k in range(dice.randint(1, 2)):
        name = dice.choice(names)
        over, torque = f"site(k) of {name}", dice.choice(TORQUES).replace("{w}", f"{name}[k]")
        if dice.randint(0, 3) == 0:
            over, torque = f"pair(k, l) of {name}", f"0.05*cross({name}[k], cross({name}[k], {name}[l]) - {name}[l])"
        effects.append(f'[effects.push{k}]\nover = "{over}"\ntorque = "{torque}"\n')
    return with_effects(text, "".join(effects), "push0")


HOLDS = ('pinned = "k < 1"', 'pinned = "uniform(3, k) < 0.4"', 'pinned = "mod(k, 2) == 0 and normal(2, k) < 0.8"', 'absent = "k > 0 and uniform(5, k) < 0.3"', 'absent = "k == 1"',
         'absent = "mod(k, 3) == 1"')
NOISES = ("0.2*normal(4, k)*{w}.x", "(1 + 0.3*uniform(7, k))*{w}.z^2", "if(uniform(2, k) < 0.3, a, 0)*{w}.y*{w}.z", "0.1*normal(9, 2*k + 1)*cos(t)*{w}.x")


def responding(text) -> list:
    """The families of spheres and R^3, no tracers, where the method has a step for sites that do more than precess."""
    method, wanted = re.search(r'^method = "(.*)"', text, re.MULTILINE), re.search(r"^# features: .*extended", text, re.MULTILINE)
    if wanted or not METHODS[method[1] if method else DEFAULT].responds:
        return []
    return re.findall(r'^(\w+) = \{ (?:sphere|r3) = (?!.*tracer)', text, re.MULTILINE)


def disordered(text) -> str:
    """A fourth with random numbers of sites, and of bonds where there are some, by dice of their own."""
    dice = random.Random(text + "disorder")
    names = responding(text)
    if not names or dice.randint(0, 3):
        return text
    name = dice.choice(names)
    text = with_effects(text, f'[effects.noise]\nover = "site(k) of {name}"\nenergy = "{dice.choice(NOISES).replace("{w}", f"{name}[k]")}"\n', "noise")
    bonds = re.compile(r'(over = "(?:bond|pair|edge)\((\w+), (\w+)[^"]*"\nenergy = """)(.*?)(""")', re.DOTALL)
    return bonds.sub(lambda m: f"{m[1]}(1 + 0.2*{dice.choice(('uniform', 'normal'))}(6, {m[2]}, {m[3]}))*({m[4]}){m[5]}", text, count=1)


def held(text) -> str:
    """A fourth with sites that are pinned or absent, likewise."""
    dice = random.Random(text + "held")
    names = responding(text)
    if not names or dice.randint(0, 3):
        return text
    effects = [f'[effects.held{k}]\nover = "site(k) of {dice.choice(names)}"\n{dice.choice(HOLDS)}\n' for k in range(dice.randint(1, 2))]
    return with_effects(text, "".join(effects), "held0")


def with_effects(text, effects, first) -> str:
    """Before the starts; a run that names its effects names the first of them too."""
    found = re.sub(r"^(?=\[starts)", lambda _: effects, text, count=1, flags=re.MULTILINE)
    return re.sub(r"^effects = \[", f'effects = ["{first}", ', found, flags=re.MULTILINE)


def assembled(dice, first, space, parameters, more, effects, start, method, solver, h=0.01, given="") -> str:
    """One family, its effects and its run. parameters: lines; given: what the run sets."""
    fixed = lambda: ", fixed = true" * (dice.randint(0, 2) == 0)
    common = [p.format(fixed()).replace("{J}", f"{float(Inventor(dice).coefficient())!r}") for p in PARAMETERS]
    sections = [text for k, (over, energy) in enumerate(effects) for text in (f"[effects.e{k}]", *[f'over = "{over}"'] * bool(over), f'energy = """{energy}"""')]
    run = ["[runs.fuzz]", 'start = "s"', f'method = "{method}"', f'solver = "{solver}"', f"h = {dice.choice((h, -h))}", "steps = 10",
           *[f"set = {{ {given} }}"] * bool(given)]
    return first + "\n".join(["[model]", 'name = "random_model"', f"orientation = {dice.choice((1, -1))}", "[space]", space, "[parameters]",
                              *common, *parameters, *more, *sections, "[starts.s]", start, *run]) + "\n"


def random_or_angles(dice) -> str:
    return dice.choice((f"random = {dice.randint(0, 99)}", f'theta = "0.4 + 0.37*i"\nphi = "{dice.randint(1, 6)} + 2.4*i"'))


# One site

BODIES = ("(w.x^2/I[0] + w.y^2/I[1] + w.z^2/I[2])/2", "(w.x^2 + 0.5*w.y^2/I[1])/2 + 0.2*w.x*w.y", "-kap*dot(w, vec(1, 0.5, 0.3))^2")
DRIVEN = ("a*cos(2.1*t)*w.x", "J*mod(t, T)*w.z", "if(mod(t/T, 1) < q, a, J)*w.y", "dot(w, B)", "floor(t/T)*w.x*w.z", "J*w.x^2*w.y", "0.3*max(w.x, J*w.y)*w.z",
          "exp(0.3*w.x*w.z)", "sqrt(2 + w.y)", "J*atan(w.x)*cos(t)", "w.z^3/(2 + w.x)", "if(w.z + 0.013 < a*w.x, w.x, 0.5*w.z)^2", "abs(w.x + 0.3*w.z)^3")


def free_body(dice):
    """One free rigid body, for the discrete Moser-Veselov method and its compositions too."""
    kappa = dice.choice(("", ", kappa = -1.5", ', kappa = "kap"'))
    method = dice.choice((FREE[0], FREE[0], dice.choice(FREE), "spherical-midpoint"))
    return assembled(dice, comments(dice, "single sphere"), f"w = {{ {dice.choice(('sphere', 'r3'))} = 1{kappa} }}",
                     [f"I = {{ default = [1.0, 2.1, {Inventor(dice).coefficient()}], size = 3{', fixed = true' * dice.randint(0, 1)} }}"], [],
                     [("", dice.choice(BODIES))], dice.choice(("theta = 0.7\nphi = 0.4", f"random = {dice.randint(0, 99)}")), method,
                     dice.choice(("auto", *METHODS[method].solvers)))


def single_sphere(dice):
    """A unit sphere in fields that depend on time and on itself; most of them an ensemble, whose members go in lanes."""
    method = dice.choice(("spherical-midpoint",) * 3 + ("extrapolation-12", "dop853", "dop853-projected", dice.choice(SINGLE + COMPOSED).name, dice.choice(SPLIT["axes"])))
    separate = METHODS[method].splitting
    effects = [("", BODIES[0] if separate else dice.choice(BODIES))]
    effects += [("", dice.choice(DRIVEN[:4] if separate else DRIVEN)) for _ in range(dice.choice((0, 1, 1, 2)))]
    wanted = [f for f in ("tangent", "extended", "plain-sums") if dice.randint(0, 5) == 0] + ["ensemble"] * (dice.randint(0, 3) > 0)
    return assembled(dice, comments(dice, "single sphere", features=wanted), "w = { sphere = 1 }",
                     [f"I = {{ default = [1.0, 2.1, {Inventor(dice).coefficient()}], size = 3{', fixed = true' * dice.randint(0, 1)} }}"], [], effects,
                     dice.choice(("theta = 0.7\nphi = 0.4", f"random = {dice.randint(0, 99)}")), method, dice.choice(("auto", *METHODS[method].solvers)))


# Few spheres

BETWEEN = ("J*gamma[i]*gamma[j]*dot({0}, {1})", "-gamma[i]*gamma[j]*log(4.3 - dot({0}, {1}))/2", "{k}*dot({0}, {1})^2", "{k}*({0}.x*{1}.x - {0}.y*{1}.y)",
           "{k}/(5 + dot({0}, {1}))", "gamma[i]*gamma[j]*sqrt(4.3 - dot({0}, {1}))", "J*exp(0.3*dot({0}, {1}))", "{k}*cos(t)*dot({0}, {1})")
OWN = ("{k}*{0}.z", "gamma[i]*dot({0}, B)", "{k}*{0}.x^2", "{k}*{0}.x*{0}.y", "cos(2.1*t)*{0}.z", "mod(t, T)*{0}.x", "gamma[i]*{0}.z^2", "floor(i/n)*{0}.x + {0}.z/5",
       "if(i/n < 0.403, J, 0.3)*{0}.y", "mod(i, n)*{0}.z/n")


def few_spheres(dice):
    """All pairs of a family of spheres, both sites of a pair alike."""
    w = Inventor(dice)
    n = dice.choice((2, 3, 4, 5, 7, 8, 9, 12, 15, 16, 17))
    later = dice.choice((n, n, 2, 6, 10))
    method = dice.choice(("spherical-midpoint",) * 6 + (dice.choice(SINGLE).name, dice.choice(SPLIT["sublattices"] + SPLIT["pairs"])))
    between, own = (BETWEEN[1:3] + BETWEEN[4:], ()) if METHODS[method].splitting == "pairs" else (BETWEEN[:1], OWN[:2]) if METHODS[method].splitting else (BETWEEN, OWN)
    effects = [("pair(i, j) of w", dice.choice(between)) for _ in range(dice.choice((1, 1, 2)))]
    effects += [("site(i) of w", dice.choice(own)) for _ in range(dice.choice((0, 1, 1, 2)) if own else 0)]
    alike = [*dice.choice(((), ("kappa = -1.5",), ('kappa = "gamma[i]"',), ('kappa = "1 + 0.5*mod(i, 2)"',))), *dice.choice(((), (), ("radius = 1.7",), ('radius = "1 + i/n"',)))]
    listed = lambda count: f"[{', '.join(w.coefficient() for _ in range(count))}]"
    wanted = [f for f in ("plain-sums", "ensemble") if dice.randint(0, 4) == 0]
    return assembled(dice, comments(dice, "few in lanes", features=wanted), f"w = {{ {', '.join(['sphere = ' + quoted('n'), *alike])} }}",
                     [f"n = {{ default = {n}{', fixed = true' * (later == n and dice.randint(0, 1))} }}", f'gamma = {{ default = {listed(n)}, size = "n" }}'], [],
                     [(over, e.format("w[i]", "w[j]", k=w.coefficient())) for over, e in effects], random_or_angles(dice), method,
                     "auto" if dice.randint(0, 4) else dice.choice(METHODS[method].solvers), given=f"n = {later}, gamma = {listed(later)}" if later != n else "")


# Lattices of equal spheres

LATTICES = {"square(m, n, {0}, {1})": "n*m", "chain(n, {0})": "n", "chain(n, {0}, 2)": "n", "square(n, m, {0}, {1})": "n*m", "cubic(m, n, 2, {0}, {1}, open)": "2*n*m", "cells.b": "2*n*m"}
CELL = """[lattices.cells]
size = ["n", "m"]
boundary = ["{0}", "{1}"]
sites = 2
bonds.b = [{{ from = 0, to = 1, offset = [0, 0] }}, {{ from = {2}, to = {2}, offset = [1, 0] }}, {{ from = 1, to = 0, offset = [0, 1] }}]"""
ON_BONDS = ("J*dot({0}, {1})", "{k}*{0}.{x}*{1}.{y}", "{k}*triple({0}, {1}, B)", "{k}*{0}.{x}*{1}.{x} + dot({0}, {1})/3")
ON_SITES = ("{k}*{0}.{x}^2", "{k}*{0}.{x}", "a*{0}.{x}*{0}.{y} + dot({0}, B)", "(dot({0}, B) - a)^2/4")
# What a splitting allows of bonds and of sites
ALLOWED = {"": (ON_BONDS, ON_SITES), "sublattices": (ON_BONDS, ON_SITES[1:2]), "pairs": (ON_BONDS[:1] + ("{k}*dot({0}, {1})^2", "{k}*sqrt(4.3 + dot({0}, {1}))"), ()),
           "axes": (("J*dot({0}, {1})", "{k}*{0}.{x}*{1}.{x}"), ON_SITES[:2])}
GAUSS = [m.name for m in METHODS.values() if m.stage_rows]


def lattice_method(dice, midpoints: int):
    """Midpoints so many times of ten, else Gauss collocation and the splittings, by rows too."""
    if dice.randint(0, 9) < midpoints:
        return "spherical-midpoint", dice.choice(("auto", "auto", "rotation"))
    return dice.choice((dice.choice(GAUSS), *map(dice.choice, SPLIT.values()))), "auto"


def lattice(dice, layout, over, n, m, edges, midpoints, define="") -> str:
    """A lattice of equal spheres with the same quadratic energy in every cell."""
    w, (method, solver) = Inventor(dice), lattice_method(dice, midpoints)
    bonds, sites = ALLOWED[METHODS[method].splitting]
    fill = lambda form: form.format("w[i]", "w[j]", k=w.coefficient(), x=dice.choice("xyz"), y=dice.choice("xyz"))
    effects = [(f"bond(i, j) of {over.format(*edges)}", fill(dice.choice(bonds))) for _ in range(dice.choice((1, 1, 2)))]
    effects += [("site(i) of w", fill(dice.choice(sites))) for _ in range(dice.choice((0, 1, 2)) if sites else 0)]
    dice.shuffle(effects)
    alike = [*dice.choice(((), ("kappa = -1.5",), ('kappa = "kap"',))), *dice.choice(((), ("radius = 1.7",), ('radius = "abs(kap)"',)))]
    fixed = lambda: ", fixed = true" * dice.randint(0, 1)
    wanted = [f for f in ("plain-sums", "ensemble") if dice.randint(0, 5) == 0]
    return assembled(dice, comments(dice, layout, define, wanted), f"w = {{ {', '.join([f'sphere = {quoted(LATTICES[over])}', *alike])} }}",
                     [f"n = {{ default = {n}{fixed()} }}", f"m = {{ default = {m}{fixed()} }}"],
                     [CELL.format(*edges, dice.randint(0, 1))] * (over == "cells.b"), effects, f"random = {dice.randint(0, 99)}", method, solver)


def rows(dice):
    """Of any size and boundary."""
    edges = [dice.choice(("periodic", "open")) for _ in "nm"]
    return lattice(dice, "rows", dice.choice(list(LATTICES)), dice.choice((5, 6, 7, 12, 35)), dice.choice((3, 4)), edges, 6)


def blocks(dice):
    """Closed all around, of sizes that can be cut."""
    over, n, m = dice.choice((("chain(n, {0})", 48, 3), ("chain(n, {0})", 32, 3), ("square(n, m, {0}, {1})", 10, 8), ("square(n, m, {0}, {1})", 8, 4), ("cells.b", 8, 8)))
    return lattice(dice, "blocks", over, n, m, ("periodic", "periodic"), 6)


WAVE = "-DSMG_WAVE_FROM=0 -DSMG_WAVE_BLOCK=8 -DSMG_BLOCKS_TO=0 -DSMG_LARGE_PLANE=100"


def wavefront(dice):
    """Long ones, taken for large: arrays of any size are worth a wavefront, and its blocks are of eight slots."""
    over, n, m = dice.choice((("chain(n, {0})", 256, 3), ("chain(n, {0})", 271, 3), ("square(m, n, {0}, {1})", 72, 4), ("chain(n, {0}, 2)", 282, 3)))
    define = WAVE + " -fopenmp -DSMG_SHARE=8" * (dice.randint(0, 3) == 0)
    return lattice(dice, "wavefronts", over, n, m, [dice.choice(("periodic", "open")) for _ in "nm"], 10, define)
