"""What depends on values: sizes, strengths, lattices, starts, durations.

Every check yields `Trouble`s with the path of the value in the spec, so that the reader can
point at it and `select` can name it.
"""
from __future__ import annotations

import math
from itertools import chain, islice
from dataclasses import replace
from typing import Iterator

import numpy as np

from ..methods import METHODS, others
from ..errors import UsageError
from ..language import limits
from ..language.evaluate import evaluate
from ..language.expr import Elem, Idx, Num, Op, Par, Spin, walk, with_index
from ..language.held import absent, still
from ..language.spec import Family, Graph, Lattice, Run, Spec, Term, families_of
from ..language import codes
from .bond_numbers import factor, number_of_bonds, one_for_each_bond
from .names import plural
from .trouble import Trouble
from .values import integer, number


BLOCK = 1 << 18         # sites looked at together
WORK = 2_000_000        # operations of a formula over sites: so far it is looked at here, the rest when a run starts
LEAST = 1000            # sites that are looked at, whatever the formula


def model(spec: Spec, values: dict) -> Iterator[Trouble]:
    """Counts, arrays, strengths, radii, Casimirs, terms, with these parameter values."""
    yield from staged(spec, values, sizes, space, terms)


def model_and_starts(spec: Spec, values: dict, names=None) -> Iterator[Trouble]:
    """The same, and the starts (of these names)."""
    yield from staged(spec, values, sizes, space, terms, lambda s, v: starts(s, v, names))


def staged(spec: Spec, values: dict, *stages) -> Iterator[Trouble]:
    """Each stage looks at what the troubles of those before leave to look at."""
    for stage in stages:
        found = list(stage(spec, values))
        yield from found
        spec = sound(spec, found)


def sound(spec: Spec, troubles) -> Spec:
    """The spec without what has troubles, and without what names that."""
    kinds = {f.name: f.kind for f in spec.families}
    lost = {t.path[1] for t in troubles if t.path[0] == "parameters" or t.path[2:] == (kinds.get(t.path[1]),)}
    leafless = lost | {t.path[1] for t in troubles if t.path[2:] in (("radius",), ("C",))}
    if not leafless:
        return spec
    return replace(spec, parameters=tuple(p for p in spec.parameters if p.name not in lost),
                   families=tuple(without(f, lost) for f in spec.families if f.name not in lost),
                   effects=tuple(e for e in spec.effects if not named(e) & lost),
                   observables=tuple(e for e in spec.observables if not named(e) & lost),
                   starts=tuple(replace(s, families=tuple(p for p in s.families if not used(p, spec) & leafless))
                                for s in spec.starts))


def without(family: Family, lost: set) -> Family:
    """The family with plain strengths and radii in place of those made of what is lost."""
    plain = {key: Num(1) for key in ("kappa", "radius") if elements(getattr(family, key)) & lost}
    return replace(family, **plain)


def elements(*formulas) -> set[str]:
    """The arrays and families that formulas name."""
    return {e.name if isinstance(e, Elem) else e.family for f in formulas if f is not None
            for e in walk(f) if isinstance(e, (Elem, Spin))}


def named(e) -> set[str]:
    """Of an effect or an observable."""
    return elements(*e.formulas.values()) | e.families


def used(part, spec: Spec) -> set[str]:
    """Of the start of a family: itself, and the arrays that it and the radius name."""
    family = next(f for f in spec.families if f.name == part.family)
    return {part.family} | elements(family.radius, *(part.value if part.kind == "formula" else ()))


def space(spec: Spec, values: dict) -> Iterator[Trouble]:
    """Strengths, radii and Casimirs."""
    for family in spec.families:
        yield from strength(family, values)
        yield from radius(family, values)
        yield from casimir(family, values)


def terms(spec: Spec, values: dict) -> Iterator[Trouble]:
    """Effects and observables."""
    for section, found in (("effects", spec.effects), ("observables", spec.observables)):
        for e in found:
            for key, formula in e.formulas.items():
                yield from formula_fits(spec, e, (section, e.name), key, formula, values)
    yield from nothing_left(spec, values)


def nothing_left(spec: Spec, values: dict) -> Iterator[Trouble]:
    """Some site must be there."""
    gone = [e for e in spec.effects if e.gone]
    if gone and not any(np.any(is_there(spec, f, values)) for f in spec.families):
        yield Trouble(("effects", gone[0].name), codes.VALUE, "every site is absent: no site is left to move", "keep at least one site")


def is_there(spec: Spec, family: Family, values: dict):
    """Is every site of a family there? True where all are."""
    condition = absent(spec, family.name)
    return True if condition is None else ~np.asarray(evaluate(condition, {**values, "i": np.arange(integer(family.count, values))}), bool)


def formula_fits(spec: Spec, e, path: tuple, key: str, formula, values: dict) -> Iterator[Trouble]:
    """Sites, entries of arrays; and where its kind says so, no negative value at any site."""
    found = list(term_fits(spec, Term(e.name, e.over, formula), path, key, values))
    yield from found
    if not found and key in getattr(e, "not_negative", ()):
        yield from negative(spec, e, path, key, formula, values)


def negative(spec: Spec, e, path: tuple, key: str, formula, values: dict) -> Iterator[Trouble]:
    """The first site that moves where a formula of the sites of a family is negative or no number."""
    family, condition = next(f for f in spec.families if f.name == e.over.family), still(spec, e.over.family)
    formula = with_index(formula, e.over.index, Idx("i"))
    bad = first_bad(formula if condition is None else Op("if", (condition, Num(0), formula)), family, values, lambda a: ~(np.isfinite(a) & (a >= 0)))
    if bad:
        yield Trouble(path + (key,), codes.VALUE, f"the {key} of `{family.name}[{bad[0]}]` is {bad[1]:g}", e.not_negative[key])


# Sizes

def sizes(spec: Spec, values: dict) -> Iterator[Trouble]:
    """Counts of families and lengths of arrays."""
    total = 0
    for family in spec.families:
        count = integer(family.count, values)
        total += count
        path = ("space", family.name, family.kind)
        if count < 1:
            yield Trouble(path, codes.COUNT, f"`{family.name}` would have {plural(count, 'site')}",
                          "a family must have at least one site")
        elif total > limits.SITES:
            yield Trouble(path, codes.LIMIT, f"the model would have {total} sites; at most "
                          f"{limits.SITES} are allowed", "choose smaller counts")
    entries = 0
    for p in spec.parameters:
        if p.kind == "array":
            entries += max(0, integer(p.size, values))
            yield from array(p, values, entries)


def array(p, values: dict, entries: int) -> Iterator[Trouble]:
    """entries: of this array and of those before it."""
    size, have = integer(p.size, values), len(values[p.name])
    path = ("parameters", p.name, "default")
    if size < 1:
        yield Trouble(("parameters", p.name, "size"), codes.COUNT,
                      f"`{p.name}` would have {size} entries", "an array must not be empty")
    elif entries > limits.ARRAY:
        before = f", with the arrays before it {entries}" if entries > size else ""
        yield Trouble(("parameters", p.name, "size"), codes.LIMIT, f"`{p.name}` would have {size} "
                      f"entries{before}; at most {limits.ARRAY} are allowed", "choose a smaller size")
    elif have != size:
        yield Trouble(path, codes.COUNT, f"`{p.name}` has {have} entries, but its size is {size}",
                      f"give {size} numbers, or one number for all entries")


# Strengths, radii, Casimirs

def blocks(family: Family, values: dict, *formulas) -> Iterator[np.ndarray]:
    """The indices of the sites where these formulas are looked at, in pieces: reading takes bounded time and memory
    however many sites there are. The first site with a fault is mostly among the first ones; `start.py` sees all."""
    operations = sum(sum(1 for _ in walk(e)) for e in formulas)
    count = min(integer(family.count, values), max(LEAST, WORK // operations))
    return (np.arange(k, min(k + BLOCK, count)) for k in range(0, count, BLOCK))


def per_site(e, i: np.ndarray, values: dict):
    """The values of a formula in i at these sites; None when an array is too short for it."""
    try:
        return np.broadcast_to(np.asarray(evaluate(e, {**values, "i": i}), float), i.shape)
    except UsageError:
        return None


def with_arrays(values: dict, *formulas) -> dict:
    """The values, with numpy arrays for the lists that the formulas name."""
    names = {n.name for e in formulas for n in walk(e) if isinstance(n, Elem)}
    return {**values, **{name: np.asarray(values[name], float) for name in names}}


def first_bad(e, family: Family, values: dict, bad):
    """(site, value) of the first site where bad(value) holds; () when there is none; None when an array is too short."""
    values = with_arrays(values, e)
    for i in blocks(family, values, e):
        x = per_site(e, i, values)
        if x is None:
            return None
        with np.errstate(all="ignore"):
            found = np.flatnonzero(bad(x))
        if found.size:
            return i[found[0]], x[found[0]]
        if not any(isinstance(n, Idx) for n in walk(e)):
            break
    return ()


def too_short(family: Family, path: tuple, e, values: dict) -> Trouble:
    names = {n.name: len(values[n.name]) for n in walk(e) if isinstance(n, Elem)}
    have = ", ".join(f"{'the list' if n == family.name + '_kappa' else f'`{n}`'} has {k} entries"
                     for n, k in names.items())
    return Trouble(path, codes.COUNT, f"{have}, but `{family.name}` has "
                   f"{integer(family.count, values)} sites", "give one entry for each site")


def strength(family: Family, values: dict) -> Iterator[Trouble]:
    path, e = ("space", family.name, "kappa"), family.kappa
    bad = first_bad(e, family, values, lambda k: ~np.isfinite(k) | (np.abs(k) > limits.LARGEST)
                    | (np.abs(k) < limits.SMALLEST))
    if bad is None or listed(e) and len(values[e.name]) != integer(family.count, values):
        yield too_short(family, path, e, values)
    elif bad:
        yield Trouble(path, codes.KAPPA, f"the strength of `{family.name}[{bad[0]}]` is "
                      f"{bad[1]:g}", "a strength must be finite and not zero")


def listed(e) -> bool:
    """Is a strength a plain list, so that its length must be the count."""
    return isinstance(e, Elem) and e.index == Idx("i")


def radius(family: Family, values: dict) -> Iterator[Trouble]:
    if family.radius is None:
        return
    path = ("space", family.name, "radius")
    bad = first_bad(family.radius, family, values, lambda r: ~(np.isfinite(r) & (r > 0)))
    if bad is None:
        yield too_short(family, path, family.radius, values)
    elif bad:
        yield Trouble(path, codes.RADIUS, f"the radius of `{family.name}[{bad[0]}]` is "
                      f"{bad[1]:g}", "a radius must be positive")


def casimir(family: Family, values: dict) -> Iterator[Trouble]:
    if family.casimir is None:
        return
    a = np.array([[number(e, values) for e in row] for row in family.casimir])
    if not np.isfinite(a).all() or not a.any():
        yield Trouble(("space", family.name, "C"), codes.CASIMIR,
                      "C is zero or not finite with these values of the parameters",
                      "choose other values")


# Terms

def term_fits(spec: Spec, term: Term, path: tuple, key: str, values) -> Iterator[Trouble]:
    """Sites of lattices and graphs, literal sites, entries of arrays."""
    counts = {f.name: integer(f.count, values) for f in spec.families}
    over = term.over
    if isinstance(over, Lattice):
        found = [lattice(over, family, counts[family], path + ("over",), values) for family in dict.fromkeys(families_of(over).values())]
        yield from islice(chain.from_iterable(found), 1)
    if isinstance(over, Graph):
        far = over.highest
        if far >= counts[over.family]:
            yield Trouble(path + ("over",), codes.LATTICE, f"an edge names site {far}, but "
                          f"`{over.family}` has {plural(counts[over.family], 'site')} (0 to "
                          f"{counts[over.family] - 1})", "sites are counted from 0")
    ranges = {i: (0, counts[f] - 1) for i, f in families_of(over).items()}
    if isinstance(over, Lattice) and over.number:
        ranges[over.number] = (0, number_of_bonds(over, values) - 1)
        yield from one_for_each_bond(term, over, path + (key,), values)
    yield from accesses(term, counts, ranges, path + (key,), values)


def all_sites(over: Lattice) -> str:
    """The number of a lattice's sites as a formula."""
    return "*".join(([str(over.sites)] if over.sites > 1 else []) + [factor(s) for s in over.size])


def lattice(over: Lattice, family: str, count: int, path: tuple, values: dict) -> Iterator[Trouble]:
    size = [integer(s, values) for s in over.size]
    sites = math.prod(size) * over.sites
    if min(size) < 1:
        yield Trouble(path, codes.COUNT, f"a lattice of {' x '.join(map(str, size))} cells",
                      "every direction must have at least one cell")
    elif sites != count:
        cells = " x ".join(map(str, size)) + (f" x {over.sites}" if over.sites > 1 else "")
        yield Trouble(path, codes.LATTICE, f"the lattice has {cells} = {sites} sites, but "
                      f"`{family}` has {count}", f"make the counts equal, for example `sphere = \"{all_sites(over)}\"`")
    else:
        yield from loops(over, size, path)


def loops(over: Lattice, size: list[int], path: tuple) -> Iterator[Trouble]:
    """A bond whose ends are one site because a periodic direction is too short."""
    for bond in over.bonds:
        ends = {(home, sub, tuple(o % n if p else o for o, n, p in zip(off, size, over.periodic)))
                for home, (sub, off) in zip(families_of(over).values(), bond)}
        if len(ends) < len(bond):
            yield Trouble(path, codes.BOND, f"with {' x '.join(map(str, size))} periodic cells a bond would join a site to itself", "make the lattice larger, or its boundary open")
            return


def accesses(term: Term, counts: dict, ranges: dict, path: tuple, values) -> Iterator[Trouble]:
    for e in walk(term.value):
        if isinstance(e, Spin) and isinstance(e.slot, int) and e.slot >= counts[e.family]:
            yield Trouble(path, codes.INDEX, f"`{e.family}[{e.slot}]` does not exist: `{e.family}` has "
                          f"{plural(counts[e.family], 'site')} (0 to {counts[e.family] - 1})",
                          "sites are counted from 0", part=e)
        if isinstance(e, Elem):
            low, high = interval(e.index, ranges, values)
            if low < 0 or high >= len(values[e.name]):
                span = f"{low}" if low == high else f"{low} to {high}"
                yield Trouble(path, codes.INDEX, f"the index of `{e.name}` takes the values "
                              f"{span}, but `{e.name}` has {len(values[e.name])} entries "
                              f"(0 to {len(values[e.name]) - 1})",
                              "give the array a larger `size`",
                              part=e)


def interval(e, ranges: dict, values: dict) -> tuple[int, int]:
    """The least and largest value of an integer formula (each index on its own)."""
    if isinstance(e, Num):
        return e.value, e.value
    if isinstance(e, Par):
        return values[e.name], values[e.name]
    if isinstance(e, Idx):
        return ranges[e.name]
    parts = [interval(a, ranges, values) for a in e.args]
    return combine(e.op, parts)


def combine(op: str, parts: list) -> tuple[int, int]:
    (a, b), (c, d) = parts[0], parts[-1]
    if op == "neg":
        return -b, -a
    if op == "+":
        return a + c, b + d
    if op == "-":
        return a - d, b - c
    products = (a * c, a * d, b * c, b * d)
    return min(products), max(products)


# Starts

def starts(spec: Spec, values: dict, names=None) -> Iterator[Trouble]:
    """Every start has the right number of vectors, on their spheres."""
    for start in spec.starts:
        if names is not None and start.name not in names:
            continue
        for part in start.families:
            family = next(f for f in spec.families if f.name == part.family)
            yield from start_fits(part, family, ("starts", start.name, family.name), values)


def start_fits(part, family: Family, path: tuple, values: dict) -> Iterator[Trouble]:
    count = integer(family.count, values)
    if part.kind == "vectors" and len(part.value) != count:
        yield Trouble(path + ("vectors",), codes.START, f"{plural(len(part.value), 'vector')} for "
                      f"the {plural(count, 'site')} of `{family.name}`",
                      "give one vector for each site")
        return
    if part.kind == "random":
        return
    if part.kind == "vectors":
        yield from on_leaf(np.array(part.value, dtype=float), np.arange(count), part, family, path, values)
        return
    values = with_arrays(values, *part.value, *[family.radius] * (family.radius is not None))
    for i in blocks(family, values, *part.value):
        troubles = list(block_fits(i, part, family, path, values))
        yield from troubles
        if troubles:
            return


def block_fits(i, part, family: Family, path: tuple, values: dict) -> Iterator[Trouble]:
    """A start by formulas at the sites i."""
    columns = [per_site(e, i, values) for e in part.value]
    if any(c is None for c in columns):
        yield Trouble(path, codes.START, "an array is too short for this formula",
                      "give the array one entry for each site")
        return
    yield from on_leaf(np.stack(columns, axis=1), i, part, family, path, values)


def on_leaf(w, i, part, family: Family, path: tuple, values: dict) -> Iterator[Trouble]:
    """w at the sites i: finite; on the sphere within `limits.SPHERE`; C not zero."""
    bad = np.flatnonzero(~np.isfinite(w).all(axis=1))
    if bad.size:
        k = i[bad[0]]
        yield Trouble(at(path, part, k), codes.START,
                      f"the start of `{family.name}[{k}]` is not finite",
                      "correct the formula for this site; `i` counts from 0")
    elif family.kind == "sphere":
        yield from on_sphere(w, i, part, family, path, values)
    elif family.kind == "nambu":
        a = np.array([[number(e, values) for e in row] for row in family.casimir])
        zero = np.flatnonzero(np.einsum("ni,ij,nj->n", w, a, w) == 0)
        if zero.size:
            k = i[zero[0]]
            yield Trouble(at(path, part, k), codes.OFF,
                          f"C is zero at the start of `{family.name}[{k}]`",
                          "choose a start where C is not zero, as the method requires")
    elif not w.any(axis=1).all():
        zero = i[int(np.argmin(w.any(axis=1)))]
        yield Trouble(at(path, part, zero), codes.OFF, f"`{family.name}[{zero}]` starts at zero",
                      "choose a start other than zero, because the bracket vanishes there")


def on_sphere(w, i, part, family: Family, path: tuple, values: dict) -> Iterator[Trouble]:
    length = np.sqrt((w * w).sum(axis=1))
    if part.normalise:
        yield from directions(length, i, part, family, path)
        return
    r = per_site(family.radius, i, values)
    off = np.abs(length / r - 1)
    k = int(np.argmax(off))
    if not off[k] <= limits.SPHERE:
        yield Trouble(at(path, part, i[k]), codes.OFF,
                      f"`{family.name}[{i[k]}]` has length {length[k]:.15g}, its sphere has "
                      f"radius {r[k]:.15g}",
                      "write `normalise = true` to project it onto the sphere, give more digits, or use `r3` if the length matters")


def at(path: tuple, part, site: int) -> tuple:
    """The path of a site's vector where it is written."""
    return path + ("vectors", int(site)) if part.kind == "vectors" else path


def directions(length, i, part, family: Family, path: tuple) -> Iterator[Trouble]:
    zero = i[np.flatnonzero(length == 0)]
    if zero.size:
        yield Trouble(at(path, part, zero[0]), codes.OFF, f"`{family.name}[{zero[0]}]` starts "
                      "at zero, which has no direction", "give a vector other than zero")


# Runs

def run(spec: Spec, r: Run, values: dict) -> Iterator[Trouble]:
    """Step, duration, period of outputs and method of one run."""
    h, path = number(r.h, values), ("runs", r.name)
    if not math.isfinite(h) or h == 0:
        yield Trouble(path + ("h",), codes.STEP, f"the step is {h:g}",
                      "a step must be finite and not zero; a negative step runs backward")
        return
    yield from duration(r, h, path, values)
    if r.period is not None:
        yield from period(r, h, path + ("output", "period"), values)
    yield from method(spec, r, path + ("method",))
    yield from effects(spec, r, h, path)


def duration(r: Run, h: float, path: tuple, values: dict) -> Iterator[Trouble]:
    if r.steps is not None:
        steps = integer(r.steps, values)
        if not 1 <= steps <= limits.STEPS:
            yield Trouble(path + ("steps",), codes.STEP, f"a run cannot have {steps} steps: from 1 to {limits.STEPS} "
                          "are allowed", "choose another number of steps, or `time`")
        return
    time = number(r.time, values)
    if h < 0 < time:
        time = -time                        # `time = 10` with a negative step: 10 backward
    yield from multiple(time, h, path + ("time",), codes.DURATION, "duration")


def multiple(time: float, h: float, path, code: str, what: str) -> Iterator[Trouble]:
    """`time` must be a positive whole number of steps."""
    ratio = time / h
    if not math.isfinite(ratio) or ratio <= 0 or ratio > limits.STEPS:
        yield Trouble(path, codes.STEP, f"a {what} of {time:g} is impossible with a step of {h:g}",
                      "it must have the sign of the step and not be zero")
    elif abs(ratio - round(ratio)) > limits.MULTIPLE * ratio or round(ratio) < 1:
        low = math.floor(ratio)
        near = " and ".join(f"{k * h:.15g} ({k} step{'s' * (k != 1)})"
                            for k in (low, low + 1) if k > 0)
        yield Trouble(path, code, f"the {what} {time:.15g} is not a multiple of the step "
                      f"{h:.15g}", f"the nearest: {near}")


def period(r: Run, h: float, path: tuple, values: dict) -> Iterator[Trouble]:
    between = abs(number(r.period, values)) * (1 if h > 0 else -1)
    yield from multiple(between, h, path, codes.STEP, "period")


def effects(spec: Spec, r: Run, h: float, path: tuple) -> Iterator[Trouble]:
    """Effects that the step or the method of a run does not go with."""
    called = [e for e in spec.effects if r.effects is None or e.name in r.effects]
    noise = next((e.name for e in called if e.heats), None)
    if noise and h < 0:
        yield Trouble(path + ("h",), codes.STEP, f"the step is {h:g}, but with the noise of `{noise}` steps cannot be negative", f"give a positive step, or `without = [\"{noise}\"]`")
    kind = next((e for e in called if e.pushes or e.damps), None)
    if kind and not METHODS[r.method].responds:
        more = kind.name
        yield Trouble(path + ("method",), codes.METHOD, f"method {r.method} does not support {'damping' if kind.damps else 'torques'} (effect `{more}`)",
                      f"use {others(r.method)}, or `without = [\"{more}\"]`")


def method(spec: Spec, r: Run, path: tuple) -> Iterator[Trouble]:
    free = len(spec.families) == 1 and spec.families[0].count == Num(1) \
        and spec.families[0].kind != "nambu"
    chosen = METHODS[r.method]
    for f in spec.families:
        if f.kind not in chosen.spaces:
            yield Trouble(path, codes.METHOD, f"method {chosen.name} does not support the factor `{f.name}`",
                          f"use {others(chosen.name)}")
    if chosen.free_body and not free:
        yield Trouble(path, codes.METHOD, f"the {chosen.title.removeprefix('the ')} method requires a single free rigid body: `{{ sphere = 1 }}` or `{{ r3 = 1 }}`",
                      f"use {others(chosen.name)}")
