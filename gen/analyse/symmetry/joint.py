"""Quadratic forms of several sites together, such as Manakov's integral of two coupled vectors.

F = v.(Q v), v all components of all sites. With w_k' = tau_k/kappa_k its derivative is sum_q Q_q P_q over the entries
(i, a) <= (j, b) of Q, with

    P_q = v_ia tau_jb/kappa_j + v_jb tau_ia/kappa_i          (once, where both are the same),

linear in Q: so all conserved forms are a null space, as in `conserved`. That needs the sum written out site by site, and some
9 n^2/2 unknowns: `bounds.JOINT` sites at most. What other integrals imply is taken off: products of linear ones, forms of single
sites, sums of them, Casimirs, the energy where it is a quadratic form.
"""
from __future__ import annotations

import functools
import itertools

import numpy as np
import sympy as sp

from ...language.expr import Par, walk
from ...language.spec import Lattice
from ...methods import METHODS
from ...run.step.evaluated import casimir_matrices, kappas
from . import bounds, conserved, modular, spaces, polynomial as poly
from .constants import real
from .integrals import WHY, Integral
from .names import AXES, number
from .orbits import written_out
from .polynomial import Budget
from .questions import Asked, attempt, holds, space
from .torque import Torques, torques

SHOWN = 12          # terms of a form that its text has


class Joint:
    """The question for one spec. places: (family, site) of each site that is no tracer; entries: the unknowns, pairs of
    components (site, axis), made for few sites alone."""

    def __init__(self, asked: Asked):
        self.asked = asked
        tracers = {f.name for f in asked.spec.families if f.tracer}
        self.places = [(name, k) for name, (_, count) in asked.places.items() if name not in tracers for k in range(count)]
        self.first = {name: first for name, (first, _) in asked.places.items()}
        self.components = [(k, c) for k in range(len(self.places)) for c in range(3)]
        strength = kappas(asked.spec, asked.values)
        self.rates = [1 / number(strength[self.first[name] + k]) for name, k in self.places]

    @functools.cached_property
    def entries(self) -> list:
        return list(itertools.combinations_with_replacement(range(len(self.components)), 2))

    @functools.cached_property
    def at(self) -> dict:
        """The place of each pair among the entries."""
        return {pair: q for q, pair in enumerate(self.entries)}

    @property
    def small(self) -> bool:
        """Are there several sites, and few enough?"""
        return 1 < len(self.places) <= bounds.JOINT and self.asked.written is not None

    def null_space(self, rows, size: int):
        """Of the sum written out, which alone has the numbers of sites; None: not decided."""
        found = self.asked.written
        found.algebra.budget = Budget()
        return attempt(lambda: conserved.null_space(found.algebra, rows(found), size))

    def linear_rows(self, found: Torques) -> list:
        """P_q of the components themselves: w_k' for every site."""
        return [self.velocities(o) for o in found.orbits]

    def velocities(self, orbit) -> list:
        """w_k' of every site, component by component."""
        felt = orbit.all if orbit.watched else orbit.own
        out = []
        for place, rate in zip(self.places, self.rates):
            out += [poly.scaled(p, poly.Fraction(int(rate.p), int(rate.q))) for p in felt.get(place, ({}, {}, {}))]
        return out

    def rows(self, found: Torques) -> list:
        """P_q of the entries."""
        vectors = [c for place in self.places for c in found.algebra.vector(*place)]
        return [self._products(found.algebra, vectors, self.velocities(o)) for o in found.orbits]

    def _products(self, algebra, v, slopes) -> list:
        out = []
        for i, j in self.entries:
            p = algebra.times(v[i], slopes[j])
            out.append(p if i == j else poly.add(p, algebra.times(v[j], slopes[i])))
        return out

    def rows_by_site(self, found: Torques) -> list:
        """What of P_q has v of one site as its first factor, for each site."""
        out = []
        for o in found.orbits:
            slopes = self.velocities(o)
            for k, place in enumerate(self.places):
                own = dict(zip(range(3 * k, 3 * k + 3), found.algebra.vector(*place)))
                out.append([self._of_site(found.algebra, own, slopes, i, j) for i, j in self.entries])
        return out

    def _of_site(self, algebra, own, slopes, i: int, j: int) -> dict:
        p = algebra.times(own[i], slopes[j]) if i in own else {}
        return poly.add(p, algebra.times(own[j], slopes[i])) if j in own and i != j else p

    def block(self, site: int, q) -> list:
        """The form of one site, from its six entries."""
        out = [sp.Integer(0)] * len(self.entries)
        for (a, b), x in zip(conserved.PAIRS, q):
            out[self.at[3 * site + a, 3 * site + b]] = sp.sympify(x)
        return out

    def product(self, a, b) -> list:
        """(a.v)(b.v) of two linear forms."""
        return [a[i] * b[i] if i == j else (a[i] * b[j] + a[j] * b[i]) / 2 for i, j in self.entries]


def joint_quadratic(asked: Asked, method: str, undecided: list):
    """The integrals beyond those that others imply."""
    one = Joint(asked)
    if not one.small:
        return
    known = attempt(lambda: implied(one)) or []
    if nothing_more(one, known):
        return
    basis = None if symbolic(known) else one.null_space(one.rows, len(one.entries))
    if basis is None or symbolic(basis):
        undecided.append("which quadratic forms of several sites together are conserved")
        return
    always = attempt(lambda: _symbols(asked))
    for q in _beyond(basis, known):
        lead = next(pair for pair, x in zip(one.entries, q) if x)
        yield _integral(one, method, q if lead[0] == lead[1] else [x / 2 for x in q], always)       # its text begins with 1


def symbolic(forms) -> bool:
    """Are there constants in them that are symbols? Elimination with so many takes too long."""
    return any(sp.sympify(x).free_symbols for q in forms for x in q)


def nothing_more(one: Joint, known) -> bool:
    """Are there as many that are known as there can be?"""
    if not all(x.is_Rational for q in known for x in q):
        return False
    most = modular.most(one.asked.written, one.velocities, one.places, one.entries)
    return most == modular.rank(np.array([[modular.residue(x) for x in q] for q in known], dtype=np.int64))


def _symbols(asked: Asked) -> Torques:
    """The sum written out, with parameters as symbols. kappa and the numbers of sites stay what they are in the run, so no parameter may be in them."""
    families, lattices = asked.spec.families, [e.over for e in asked.spec.energies if isinstance(e.over, Lattice)]
    sizes = [f.count for f in families] + [size for over in lattices for size in over.size]
    if any(f.kappa.__class__.__name__ != "Num" for f in families) or any(isinstance(node, Par) for size in sizes for node in walk(size)):
        return None
    tables = {name: asked.values[name] for name, _ in asked.spec.tables}
    return torques(asked.spec, written_out(asked.spec.energies, asked.values, asked.places), None, tables, Budget(), True)


def implied(one: Joint) -> list:
    """Forms that are conserved for a simpler reason."""
    asked, found = one.asked, []
    casimirs = casimir_matrices(asked.spec, asked.values)
    for k, (name, i) in enumerate(one.places):
        matrix = casimirs[one.first[name] + i]
        found.append(one.block(k, [number(matrix[a, b]) for a, b in conserved.PAIRS]))
        own = space(asked, ("quadratic", name), lambda t, name=name: conserved.own_quadratic_rows(t, name), 6) or []
        found += [one.block(k, q) for q in own]
    linear = spaces.beyond([*_total(one), *(one.null_space(one.linear_rows, len(one.components)) or [])], [])
    found += [one.product(a, b) for k, a in enumerate(linear) for b in linear[k:]]
    return found + _summed(one) + _energy(one)


def _total(one: Joint) -> list:
    """Linear integrals of whole families, sum kappa a.w."""
    names = one.asked.families
    basis = space(one.asked, "own", lambda t: conserved.linear_rows(t, names, "own"), 3 * len(names)) or []
    return [[a[3 * names.index(name) + c] / rate for (name, _), rate in zip(one.places, one.rates) for c in range(3)] for a in basis]


def _summed(one: Joint) -> list:
    """Sums of one form over the sites of each family, kappa w.(Q w), that are reported by themselves."""
    asked, names, found = one.asked, one.asked.families, []
    basis = space(asked, "quadratic", lambda t: conserved.quadratic_rows(t, names), 6 * len(names)) or []
    for q in basis:
        parts = [one.block(k, [x / rate for x in q[6 * names.index(name):6 * names.index(name) + 6]])
                 for k, ((name, _), rate) in enumerate(zip(one.places, one.rates))]
        found.append([sum(column) for column in zip(*parts)])
    return found


def _energy(one: Joint) -> list:
    """H, where it is a quadratic form of the vectors; |w|^2 = r^2 may have been used, which only adds Casimirs."""
    found = one.asked.written
    energies = [o.energy for o in found.orbits if not o.watched]
    generators = [next(iter(c))[0][0] for place in one.places for c in found.algebra.vector(*place)]
    total: dict = {}
    for p in energies:
        total = poly.add(total, p)
    total = {m: c for m, c in total.items() if m != poly.ONE}
    if any(sum(e for g, e in m) != 2 or any(g not in generators for g, _ in m) for m in total):
        return []
    second = [poly.number_of(poly.derivative(poly.derivative(total, generators[i]), generators[j])) for i, j in one.entries]
    return [[sp.Rational(x.numerator, x.denominator) for x in second]]


def _beyond(basis, known) -> list:
    """Representatives of basis modulo known: entries that the known forms can take are taken off, so that few are left."""
    if not basis:
        return []
    reduced, pivots = sp.Matrix(known).rref()
    rows = []
    for q in basis:
        row = sp.Matrix([q])
        for k, column in enumerate(pivots):
            row -= row[column] * reduced.row(k)
        rows.append(row)
    left, pivots = sp.Matrix.vstack(*rows).rref()
    return [list(left.row(k)) for k in range(len(pivots))]


def _integral(one: Joint, method: str, q, always) -> Integral:
    text, kept, why = _text(one, q), *_kept(one, method, q)
    matrix = np.zeros((len(one.components),) * 2)
    for (i, j), x in zip(one.entries, q):
        matrix[i, j] = matrix[j, i] = real(x)
    sites = [one.first[name] + k for name, k in one.places]

    def numbers(w):
        v = np.where(one.asked.present[sites, None], w[sites], 0).ravel()
        return np.array([v @ matrix @ v])
    return Integral(text, "quadratic", text, kept, why, holds(always, one.rows, q), 1, numbers)


def _kept(one: Joint, method: str, q):
    """(does the method keep it, why). The spherical midpoint has W.QW - w.Qw = 2h sum_k mbar_k.(Q X(m))_k, where mbar_k is m_k times a
    number of its own: each term must vanish by itself, as it does where a single site is in the form, and in an XYZ pair."""
    m = METHODS[method]
    if not m.keeps_quadratic:
        return False, WHY["other"]
    if m.onto_leaf:
        kept = holds(one.asked.written, one.rows_by_site, q)
        return kept, WHY["own" if kept else "sum"]
    kept = holds(one.asked.off, one.rows, q)
    return kept, WHY["every" if kept else "off"]


def _text(one: Joint, q) -> str:
    """`w[0].x w[1].x + 2 w[0].y^2 ..`"""
    named = [_site(one, k) + "." + AXES[c] for k, c in one.components]
    parts = []
    for (i, j), x in zip(one.entries, q):
        c = real(x) * (1 if i == j else 2)
        if c:
            parts.append(f"{'-' if c < 0 else '+'} {'' if abs(c) == 1 else f'{abs(c):.6g} '}{named[i]}{'^2' if i == j else ' ' + named[j]}")
    text = " ".join(parts[:SHOWN]) + (f" + .. ({len(parts)} terms)" if len(parts) > SHOWN else "")
    return text[2:] if text.startswith("+ ") else text


def _site(one: Joint, k: int) -> str:
    name, i = one.places[k]
    return name if one.asked.places[name][1] == 1 else f"{name}[{i}]"


def looked_for(asked: Asked) -> list[str]:
    """Which classes of integrals were searched, and which were not."""
    one = Joint(asked)
    said = ["linear ones", "quadratic forms of single sites"]
    if len(asked.families) > 1 or any(count > 1 for _, count in asked.places.values()):
        said.append("sums of one such form over the sites of each family")
    if one.small:
        said.append("quadratic forms of all sites together")
    elif len(one.places) > 1:
        why = f"{len(one.places)} sites; the limit is {bounds.JOINT}" if len(one.places) > bounds.JOINT else f"more than {bounds.TERMS} terms, or too much work"
        return [*said, f"not searched: quadratic forms that couple sites ({why})"]
    return said
