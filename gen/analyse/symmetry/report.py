"""What is unchanged and what is conserved, from the spec alone."""
from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
import sympy as sp

from ...language.held import lacking, standing
from ...methods import METHODS
from ...compile.plan.splitting import splittings
from ...compile.plan.held import present
from ...compile.select import select
from ...public import few, html_of, public
from ...read.shipped import SpecLike, spec_or_name
from ...run.step.prepared import asked as asked_of, choose
from ...run.step.evaluated import casimir_matrices, kappas
from . import conserved, spaces
from .by_site import why_by_site
from .constants import real
from .integrals import WHY, Integral
from .jumps import jumps
from .joint import joint_quadratic, looked_for
from .kept_energy import energy_form, energy_integral, parity, time_dependent
from .look import unchanged
from .names import axis_text, form_text, number
from .questions import Asked, ask, attempt, holds, space


@dataclass(frozen=True)
class Report:
    """rotations: (family names, axes of shape (k, 3)): turning all sites of these families by one
    angle about any combination of the axes leaves H unchanged; mixed: such turns with an axis of
    its own for each family, {family: axis}; always: for each of `rotations`, does it hold for all
    values of the parameters; integrals: what is conserved; energy_changes: H depends on time;
    signs: sign patterns (sx, sy, sz) of all vectors under which H is unchanged; undecided: what
    could not be settled; splittings: explicit method -> what of H stands in its way, or None;
    searched: the classes of integrals that were looked for; damped: the families whose sites lose energy, of which no integrals but
    their lengths are looked for; heated: those that thermal noise turns; jumps: effect -> how far its energy jumps where sites cross an edge of a
    formula; pushed: those that torques move; standing: those with sites that are pinned, or fixed; absent: those that lack some;
    by_site: why the steps of a lattice go site by site, where they do."""
    spec: str
    method: str
    families: tuple
    sites: dict
    parameters: dict
    rotations: list
    always: list
    mixed: list
    integrals: list
    energy_changes: bool | None
    signs: list
    undecided: list = field(default_factory=list)
    tracers: tuple = ()
    algebras: dict = field(default_factory=dict)
    splittings: dict = field(default_factory=dict)
    searched: tuple = ()
    damped: tuple = ()
    heated: tuple = ()
    jumps: dict = field(default_factory=dict)
    pushed: tuple = ()
    standing: tuple = ()
    absent: tuple = ()
    by_site: str = ""

    def __repr__(self) -> str:
        return f"<Report {self.spec}: {self.method}; conserved: {few(i.name for i in self.integrals) or 'nothing'}>"

    def words(self) -> list[str]:
        """The report in plain sentences."""
        from .words import sentences
        return sentences(self)

    def _repr_html_(self) -> str:
        return html_of("\n".join(self.words()))

    def as_dict(self) -> dict:
        """For JSON."""
        turns = [{"families": list(names), "axes": axes.tolist(), "always": always}
                 for (names, axes), always in zip(self.rotations, self.always)]
        mixed = [{name: list(axis) for name, axis in one.items()} for one in self.mixed]
        return {"spec": self.spec, "method": self.method, "parameters": self.parameters, "rotations": turns,
                "mixed": mixed, "integrals": [i.as_dict() for i in self.integrals],
                "energy_changes": self.energy_changes, "signs": [list(s) for s in self.signs],
                "undecided": self.undecided, "splittings": self.splittings, "searched": list(self.searched), "damped": list(self.damped), "heated": list(self.heated), "jumps": self.jumps, "pushed": list(self.pushed), "standing": list(self.standing), "absent": list(self.absent), "by_site": self.by_site, "words": self.words()}


@public
@spec_or_name
def explain(spec: SpecLike, run: str | None = None, *, method: str | None = None, effects: Iterable[str] | None = None,
            parameters: Mapping[str, object] | None = None) -> Report:
    """Find the rotations that leave H unchanged, what is conserved, and what the method preserves.

    :param run: the name of a run in the spec; by default the first. `method`, `effects` and `parameters` override what it says.
    :returns: a report; `print` shows it in sentences.
    :raises UsageError: for an unknown name.

    docs/explain.md describes what is searched for and how it is proved.
    """
    one = asked_of(spec, run, method, None, effects, parameters)
    method = choose("method", one.method, METHODS)
    scene = select(spec, one.effects, dict(one.parameters))
    asked = ask(present(scene), {}, on_sphere=METHODS[method].onto_leaf)
    undecided: list = []
    seen = attempt(lambda: unchanged(asked.spec, asked.values))
    turns = space(asked, "all", lambda t: conserved.linear_rows(t, asked.families, "all"), 3 * len(asked.families), seen)
    rotations, always, mixed = _rotations(asked, turns, seen, undecided)
    changes = time_dependent(asked)
    given_up = not scene.conservative
    held = bool(standing(scene))
    integrals = [] if given_up else [*energy_integral(asked, method, changes)] if held else [*_linear(asked, method, turns, undecided), *_quadratic(asked, method, undecided),
                                   *joint_quadratic(asked, method, undecided), *energy_integral(asked, method, changes)]
    integrals += _casimirs(asked, METHODS[method].keeps_leaf)
    if changes is None:
        undecided.append("whether H depends on time")
    return Report(scene.name, method, tuple(asked.families), {n: c for n, (_, c) in asked.places.items()},
                  _parameters(asked), rotations, always,
                  mixed, _unique(integrals), changes, [] if given_up or held else parity(asked), undecided,
                  tuple(f.name for f in scene.families if f.tracer), _algebras(asked), {} if given_up or held or lacking(scene) else attempt(lambda: splittings(scene)) or {},
                  () if given_up or held else tuple(looked_for(asked)), scene.damped, scene.heated, jumps(scene), scene.pushed, standing(scene), lacking(scene), why_by_site(scene, method))


def _parameters(asked: Asked) -> dict:
    """Numbers, lists of a few of them, and of longer lists what they are like."""
    found = {p.name: asked.values[p.name] for p in asked.spec.parameters}
    return {k: _listed(v) if isinstance(v, np.ndarray) else v for k, v in found.items()}


def _listed(v: np.ndarray):
    if v.size <= 4:
        return v.tolist()
    return f"{v[0]:g} for all {v.size} entries" if np.all(v == v[0]) else f"a list of {v.size} entries"


def _unique(integrals) -> list:
    """Each formula once."""
    return list({(i.kind, i.formula): i for i in integrals}.values())


# Rotations

def _rotations(asked: Asked, turns, seen, undecided):
    if turns is None:
        undecided.append("which rotations leave H unchanged")
        return [], [], []
    if seen is not None and seen > len(turns):
        undecided.append(f"{seen} independent rotations seem to leave H unchanged in floating point, {len(turns)} "
                         "could be proved")
    grouped, mixed = grouped_axes(turns, len(asked.families))
    always = [all(holds(asked.always, lambda t: conserved.linear_rows(t, asked.families, "all"),
                        _pattern(a, chosen, len(asked.families))) for a in axes) for chosen, axes in grouped]
    names = asked.families
    return ([(tuple(names[f] for f in chosen), directions(axes)) for chosen, axes in grouped], always,
            [{names[f]: directions([v[3 * f:3 * f + 3]])[0] for f in spaces.support(v)} for v in mixed])


def grouped_axes(turns, families: int):
    """([(families that turn together, axes)], what is left): single families first, then all that remain."""
    found, covered = [], []
    chosen = [(f,) for f in range(families)] + sorted(
        {spaces.support(v) for v in turns} | {tuple(range(families))}, key=len)
    for subset in dict.fromkeys(chosen):
        axes = spaces.common_axes(turns, families, subset)
        fresh = [a for a in axes if not spaces.within(_pattern(a, subset, families), covered)]
        if fresh:
            axes = spaces.neat(axes if len(fresh) == len(axes) else fresh)
            covered += spaces.beyond([_pattern(a, subset, families) for a in axes], covered)
            found.append((subset, axes))
    return found, spaces.beyond(turns, covered)


def _pattern(axis, chosen, families: int) -> list:
    return [axis[c] if f in chosen else sp.Integer(0) for f in range(families) for c in range(3)]


def directions(axes) -> np.ndarray:
    """Unit vectors, shape (k, 3)."""
    rows = np.array([[real(x) for x in a] for a in axes])
    return rows / np.linalg.norm(rows, axis=1)[:, None]


# Linear integrals: sum_f a_f . sum kappa w

def _linear(asked: Asked, method, turns, undecided):
    names = asked.families
    rows = lambda t: conserved.linear_rows(t, names, "own")     # noqa: E731
    if not any(f.tracer for f in asked.spec.families):
        asked.answers["own"] = turns        # every rotation has its integral
    basis = space(asked, "own", rows, 3 * len(names))
    if basis is None:
        undecided.append("which linear integrals there are")
        return
    alone = {}
    for f, name in enumerate(names):
        mine = lambda t: conserved.own_rows(t, name)            # noqa: E731
        alone[f] = space(asked, ("own", name), mine, 3, len(_of_family(basis, f))) or []
        for axis in spaces.neat(alone[f]) if alone[f] and asked.places[name][1] > 1 else ():
            yield _own_linear(asked, method, name, axis, mine)
    grouped, mixed = grouped_axes(basis, len(names))
    for chosen, axes in grouped:
        for a in axes:
            yield _sum_linear(asked, method, _pattern(a, chosen, len(names)), rows)
    for v in mixed:
        yield _sum_linear(asked, method, v, rows)


def _of_family(basis, f) -> list:
    """What of a space belongs to one family: an integral of each site is one of their sum."""
    return spaces.common_axes(basis, len(basis[0]) // 3, (f,)) if basis else []


def _sum_linear(asked, method, vector, rows):
    parts = {f: directions([vector[3 * f:3 * f + 3]])[0] if len(spaces.support(vector)) == 1 else
             np.array([real(x) for x in vector[3 * f:3 * f + 3]]) for f in spaces.support(vector)}
    strength = kappas(asked.spec, asked.values)
    text = " + ".join(_sum_text(asked, f, a) for f, a in parts.items())
    names = [asked.families[f] for f in parts]

    def numbers(w):
        return sum(_sites(asked, strength[:, None] * w, n).sum(axis=0) @ a for n, a in zip(names, parts.values()))
    return _linear_integral(asked, method, "total " + text, text, vector, rows, numbers, 1)


def _sum_text(asked, f, a) -> str:
    """`w.z`, `sum kappa w.z`: the sum over a family of one component."""
    family, name = asked.spec.families[f], asked.families[f]
    weight = "" if family.kappa.__class__.__name__ == "Num" and family.kappa.value == 1 else "kappa "
    return f"{'sum ' if asked.places[name][1] > 1 else ''}{weight}{axis_text(name, a)}"


def _own_linear(asked, method, name, axis, rows):
    a = directions([axis])[0]
    text = axis_text(f"{name}[i]", a)
    return _linear_integral(asked, method, f"{text} of every site", text, axis, rows,
                            lambda w: _sites(asked, w, name) @ a, asked.places[name][1])


def _linear_integral(asked, method, name, text, vector, rows, numbers, count):
    one = METHODS[method]
    kept = one.keeps_linear and (one.onto_leaf or holds(asked.off, rows, vector))
    return Integral(name, "linear", text, kept, WHY["linear" if kept else "off" if one.keeps_linear else "parts" if one.splitting else "none"],
                    holds(asked.always, rows, vector), count, numbers)


def _sites(asked, w, name):
    """Absent ones are 0, as in all output."""
    first, count = asked.places[name]
    return np.where(asked.present[first:first + count, None], w[first:first + count], 0)


# Quadratic integrals: w.(Q w) of every site, or summed over families

def _quadratic(asked: Asked, method, undecided):
    for name in asked.families:
        rows = lambda t: conserved.own_quadratic_rows(t, name)      # noqa: E731
        basis = space(asked, ("quadratic", name), rows, 6)
        if basis is None:
            undecided.append(f"which quadratic integrals a single {name} has")
            continue
        linear = space(asked, ("own", name), lambda t: conserved.own_rows(t, name), 3) or []
        for q in spaces.beyond(basis, [*_known(asked, name, linear), *energy_form(asked)]):
            yield _own_quadratic(asked, method, name, q, rows)
    yield from _summed_quadratic(asked, method)


def _own_quadratic(asked, method, name, q, rows):
    text, matrix = form_text(name if asked.places[name][1] == 1 else f"{name}[i]", q), _matrix(q)
    kept = METHODS[method].keeps_quadratic and (METHODS[method].onto_leaf or holds(asked.off, rows, q))
    many = "" if asked.places[name][1] == 1 else " of every site"
    return Integral(text + many, "quadratic", text, kept, WHY["own" if kept else "off" if METHODS[method].keeps_quadratic else "other"],
                    holds(asked.always, rows, q), asked.places[name][1],
                    lambda w: np.einsum("si,ij,sj->s", s := _sites(asked, w, name), matrix, s))


def _summed_quadratic(asked: Asked, method):
    """Sums over several sites of kappa w.(Q w) that are conserved though the single terms are not."""
    names = asked.families
    rows = lambda t: conserved.quadratic_rows(t, names)         # noqa: E731
    if all(count == 1 for _, count in asked.places.values()) and len(names) == 1:
        return
    basis = space(asked, "quadratic", rows, 6 * len(names)) or []
    known = [q for f, name in enumerate(names) for q in _padded(asked, f, name)]
    strength = kappas(asked.spec, asked.values)
    for q in spaces.beyond(basis, known):
        parts = {n: _matrix(q[6 * f:6 * f + 6]) for f, n in enumerate(names) if any(q[6 * f:6 * f + 6])}
        text = " + ".join(f"sum kappa ({form_text(n, q[6 * names.index(n):6 * names.index(n) + 6])})" for n in parts)
        kept = METHODS[method].keeps_quadratic and not METHODS[method].onto_leaf and holds(asked.off, rows, q)
        yield Integral(text, "quadratic", text, kept, WHY["every" if kept else "other" if not METHODS[method].keeps_quadratic else "sum" if METHODS[method].onto_leaf else "off"],
                       holds(asked.always, rows, q), 1, _summed_form(asked, parts, strength))


def _summed_form(asked, parts, strength):
    return lambda w: sum(np.einsum("s,si,ij,sj->", _sites(asked, strength, n), s := _sites(asked, w, n), m, s)
                         for n, m in parts.items())


def _padded(asked, f, name):
    """Quadratic forms of family f that each site has by itself, as vectors over all families."""
    own = space(asked, ("quadratic", name), lambda t: conserved.own_quadratic_rows(t, name), 6) or []
    for q in [*own, *_known(asked, name, [])]:
        yield [sp.Integer(0)] * (6 * f) + list(q) + [sp.Integer(0)] * (6 * (len(asked.families) - f - 1))


def _known(asked: Asked, name, linear):
    """The Casimir's form and the squares and products of linear integrals a.w of a single site."""
    first, count = asked.places[name]
    matrices = casimir_matrices(asked.spec, asked.values)[first:first + count]
    known = [[number(matrices[0][a, b]) for a, b in conserved.PAIRS]] if np.all(matrices == matrices[0]) else []
    for k, a in enumerate(linear):
        known += [[(a[i] * b[j] + a[j] * b[i]) / 2 for i, j in conserved.PAIRS] for b in linear[k:]]
    return known


def _matrix(q) -> np.ndarray:
    out = np.zeros((3, 3))
    for (a, b), x in zip(conserved.PAIRS, q):
        out[a, b] = out[b, a] = real(x)
    return out


# Casimirs

def _casimirs(asked: Asked, kept: bool):
    matrices = casimir_matrices(asked.spec, asked.values)
    for family in asked.spec.families:
        first, count = asked.places[family.name]
        one = family.name if count == 1 else f"{family.name}[i]"
        factor = 0.5 if family.kind == "nambu" else 1.0
        text = f"C({one})" if family.kind == "nambu" else f"|{one}|^2"
        forms = factor * matrices[first:first + count]
        yield Integral(text if count == 1 else f"{text} of every site", "casimir", text, kept, WHY["casimir" if kept else "leaf"], True, count,
                       lambda w, n=family.name, m=forms: np.einsum("si,sij,sj->s", s := _sites(asked, w, n), m, s))


def _algebras(asked: Asked) -> dict:
    """family -> the group of its Casimir, from the signs of its eigenvalues."""
    matrices, found = casimir_matrices(asked.spec, asked.values), {}
    for family in asked.spec.families:
        if family.kind == "nambu":
            e = np.linalg.eigvalsh(matrices[asked.places[family.name][0]])
            tiny = 1e-12 * np.max(np.abs(e))
            signs = tuple(sorted((int(np.sum(e > tiny)), int(np.sum(e < -tiny))), reverse=True))
            found[family.name] = {(3, 0): "SO(3)", (2, 1): "SO(2,1)", (2, 0): "SE(2)", (1, 1): "SE(1,1)",
                                  (1, 0): "the Heisenberg group"}[signs]
    return found
