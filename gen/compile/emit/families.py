"""The sites of the phase space as the contract of runtime/core/smg_model.h asks for them: numbers, strengths, leaves."""
from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from ..derive.derivatives import scalar
from ..lower.kernels import function
from ..lower.loops import block
from .statics import WORD, Static
from .text import comment, per_site, plus, total

ALWAYS = ("smg_kind", "smg_kappa", "smg_radius", "smg_normal")     # what runtime/core asks of every model
KINDS = {"sphere": "SMG_SPHERE", "r3": "SMG_R3", "nambu": "SMG_NAMBU"}


@dataclass(frozen=True)
class FamilyText:
    """A family's pieces of C: sizes, its first site, its first row among the coupled ones (or among those that are alone),
    and its formulas of the local index i."""
    name: str
    kind: str
    text: str
    count: str
    first: str
    row: str
    kappa: object
    radius: object
    casimir: object
    rows: tuple
    h_over_kappa: str

    @property
    def unit(self) -> bool:
        """Spheres of radius 1?"""
        return self.kind == "sphere" and not self.radius.lines and self.radius.results[0] == "1.0"


def describe(f, spec) -> str:
    kinds = {"sphere": "spheres", "r3": "factors R^3 with the Lie-Poisson bracket", "nambu": "Nambu factors"}
    return kinds[f.kind] + (", tracers" if f.tracer else "")


class FamilyParts:
    """Functions of one site, by family; part of `Emitter`."""

    def family_texts(self):
        texts, first, rows = [], [], {True: [], False: []}
        for f in self.spec.families:
            count, coupled = self.low.size(f.count), f.name in self.plan.coupled
            texts.append(self.family_text(f, count, total(first), total(rows[coupled])))
            first.append(count)
            rows[coupled].append(count)
        self.total, self.rows, self.alone_rows = total(first), total(rows[True]), total(rows[False])
        return texts

    def family_text(self, f, count, first, row):
        low = self.low
        kappa = low.formula(f.kappa)
        radius = low.formula(f.radius) if f.kind == "sphere" else None
        casimir, rows = self.casimir(f) if f.kind == "nambu" else (None, ())
        return FamilyText(f.name, f.kind, comment(describe(f, self.spec)), count, first, row, kappa, radius, casimir, rows,
                          self.h_over(f, kappa))

    def casimir(self, f):
        """C v, the gradient of C(v) = v.C v/2, in the model's own precision."""
        rows, leaves = self.casimir_rows(f)
        kernel = self.low.kernel(rows, leaves)
        fix = [t.replace("v0[", "v[") for t in kernel.results]
        kernel.lines = [line.replace("v0[", "v[") for line in kernel.lines]
        return kernel, tuple(fix)

    def casimir_rows(self, f):
        """Three sums over the non-zero entries of C, in the symbols v0x, v0y, v0z."""
        entries = [low_entry for row in f.casimir for low_entry in row]
        values, leaves = [], {}
        for e in entries:
            value, more = scalar(e)
            values.append(value)
            leaves.update(more)
        v = sp.symbols("v0x v0y v0z", real=True)
        return [sum(values[3 * r + k] * v[k] for k in range(3)) for r in range(3)], leaves

    def h_over(self, f, kappa):
        """h/kappa, as a product with a hoisted inverse where kappa is the same for all sites."""
        value, leaves = scalar(f.kappa)
        inverse = self.low.kernel([1 / value], leaves)
        if inverse.results[0] in ("1.0", "1"):
            return "h"
        if inverse.lines or per_site(f.kappa):
            return "h / smg_kappa(c, k)"
        return f"h * ({inverse.results[0]})"

    # -- the contract -------------------------------------------------------------------------
    def by_family(self, head: str, arguments, lines_of, families=None, number: str = "k", first: str = "first", index: str = "i"):
        """A function of a site `number` that does what `lines_of(family)` says, in the local index of that name; a single text
        for all families alike."""
        families = self.families if families is None else families
        texts = {f.name: list(lines_of(f)) for f in families}
        alike = len({tuple(lines) for lines in texts.values()}) == 1 and index not in names_of(texts[families[0].name])
        body = []
        for f in families[:0 if alike else -1]:
            inside = [*local_index(texts[f.name], index, number, getattr(f, first)), *texts[f.name], *(["return;"] if head.startswith("void") else [])]
            body += block(f"if ({number} < {end_of(f, first)})", inside)
        last = families[-1]
        body += [*local_index(texts[last.name], index, number, getattr(last, first)), *texts[last.name]]
        return function(head, arguments, body, [a.split()[-1].lstrip("*") for a in arguments])

    def site_functions(self):
        """Kind, strength, radius, normal of every site."""
        site = ["const smg_coefficients *c", "int64_t k"]
        functions = [("smg_kind", "int", site, lambda f: [f"return {KINDS[f.kind]};"]),
                     ("smg_kappa", "smg_real", site, lambda f: [*f.kappa.lines, f"return {f.kappa.results[0]};"]),
                     ("smg_h_over_kappa", "smg_real", [*site, "smg_real h"], lambda f: [f"return {f.h_over_kappa};"]),
                     ("smg_radius", "smg_real", site, radius_lines),
                     ("smg_normal", "void", [*site, "const smg_real *v", "smg_real *n"], normal_lines)]
        return [Static(name, self.by_family(f"{kind} {name}", arguments, lines), name in ALWAYS or name in self.method.needs)
                for name, kind, arguments, lines in functions]

    def number_functions(self):
        """How sites are numbered: in all, among those that are solved together, among those alone, by family."""
        size, row = ["const smg_coefficients *c"], ["const smg_coefficients *c", "int64_t row"]
        site = ["const smg_coefficients *c", "int64_t k"]
        coupled, alone = self.chosen(self.plan.coupled), self.chosen(self.plan.local)
        found = [("smg_sites", function("int64_t smg_sites", size, [f"return {self.total};"], ["c"])),
                 ("smg_family_end", self.family_end())]
        if coupled:
            found += [("smg_coupled", function("int64_t smg_coupled", size, [f"return {self.rows};"], ["c"])),
                      ("smg_site", self.by_family("int64_t smg_site", row, moved("row", "row", "first"), coupled, "row", "row")),
                      ("smg_row", self.by_family("int64_t smg_row", site, moved("k", "first", "row"), coupled, "k", "first"))]
        if alone and (not self.solo or "tangent" in self.features):
            n = ["const smg_coefficients *c", "int64_t n"]
            found += [("smg_alone", function("int64_t smg_alone", size, [f"return {self.alone_rows};"], ["c"])),
                      ("smg_alone_site", self.by_family("int64_t smg_alone_site", n, moved("n", "row", "first"), alone, "n", "row"))]
        if alone and not self.solo:
            found.append(("smg_tracer", self.by_family("int smg_tracer", site, lambda f: [f"return {int(f.name in self.tracers)};"], alone)))
        if self.mixed_alone():
            found.append(("smg_is_linear", self.by_family("int smg_is_linear", site, lambda f: [f"return {int(self.closed_form(f))};"], alone)))
        return [Static(name, text, True) for name, text in found]

    def mixed_alone(self) -> bool:
        """Are there sites alone of both kinds, with a closed form and without?"""
        return len({self.closed_form(f) for f in self.chosen(self.plan.local)}) == 2

    def family_end(self) -> str:
        ends, seen = [], []
        for f in self.families:
            seen.append(f.count)
            ends.append(total(seen))
        lines = [f"if (f == {k}) return {end};" for k, end in enumerate(ends[:-1])]
        return function("int64_t smg_family_end", ["const smg_coefficients *c", "int f"], [*lines, f"return {ends[-1]};"], ["c", "f"])


def names_of(lines) -> set:
    return set(WORD.findall("\n".join(lines)))


def end_of(f, first: str) -> str:
    """The number after the last site of a family."""
    start = getattr(f, first)
    return f.count if start == "0" else total([start, f.count])


def local_index(lines, index: str, number: str, first: str):
    """`const int64_t i = number - first;`, where the lines need it."""
    if index not in names_of(lines):
        return []
    return [f"const int64_t {index} = {number};" if first == "0" else f"const int64_t {index} = {number} - ({first});"]


def moved(name: str, start: str, to: str):
    """The number counted from another beginning."""
    def lines(f):
        a, b = getattr(f, start), getattr(f, to)
        return [f"return {name};" if a == b else f"return {plus(b, name)};" if a == "0" else f"return {plus(b, name)} - ({a});"]
    return lines


def radius_lines(f):
    return [*f.radius.lines, f"return {f.radius.results[0]};"] if f.kind == "sphere" else ["return 0;"]


def normal_lines(f):
    rows = f.rows if f.kind == "nambu" else ("v[0]", "v[1]", "v[2]")
    lines = f.casimir.lines if f.kind == "nambu" else []
    return [*lines, *(f"n[{r}] = {text};" for r, text in enumerate(rows))]
