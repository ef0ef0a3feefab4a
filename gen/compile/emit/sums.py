"""Sums over the index families: every term once (scatter), or the terms of one site (gather)."""
from __future__ import annotations

from ...language.spec import Lattice
from ..lower.kernels import function
from .families import names_of
from .statics import Static
from .text import plus

COORDINATES = ("sub", "s0", "s1", "s2", "s3")


class SumParts:
    """Loops over the terms; part of `Emitter`."""

    def site(self, slot) -> str:
        """The global number of the site at a slot."""
        f = self.by_name[slot[0]]
        return plus(f.first, str(slot[1]))

    def vector(self, array: str, slot) -> str:
        return f"{array} + 3*({self.site(slot)})"

    def sums(self, terms, body):
        lines = []
        for term in (t for t in terms if body(t)):      # a linear term has no blocks
            lines += self.loops.scatter(term.over, lambda _, t=term: body(t))
        return lines

    def coupled_effects(self):
        return [e for e in self.effects if not self.passive(e)
                and any(f in self.plan.coupled for f, _ in e.slots)]

    def passive(self, term):
        return [s for s in term.slots if s[0] in self.tracers]

    def gradient_body(self, vectors: str, out: str):
        def body(t):
            spare = [k for k, s in enumerate(t.slots) if self.passive(t) and s[0] not in self.tracers]
            outputs = [f"spare{k}" if k in spare else self.vector(out, s) for k, s in enumerate(t.slots)]
            call = t.call("gradient", [self.vector(vectors, s) for s in t.slots], *outputs) + ";"
            return [f"smg_real spare{k}[3] = {{0, 0, 0}};" for k in spare] + [call]
        return body

    def block_body(self, t):
        vectors = [self.vector("s->m", s) for s in t.slots]
        return [f"SMG_BLOCK({self.site(t.slots[k])}, {self.site(t.slots[l])}, {t.prefix}_hessian_{k}{l}, "
                f"{', '.join([*t.common(), *vectors])});" for k, l in t.derived.hessian]

    def product_body(self, t):
        """s->hessian_v += B s->v for the Hessian blocks that join two sites."""
        vectors = [self.vector("s->m", s) for s in t.slots]
        return [t.call(f"hessian_{k}{l}", vectors, self.vector("s->v", t.slots[l]), self.vector("s->hessian_v", t.slots[k])) + ";"
                for k, l in t.derived.hessian if k != l]

    def value_body(self, t):
        call = t.call("value", [self.vector("w", s) for s in t.slots])
        return [f"smg_add_compensated(&sum, &lost, {call});"]

    # -- the contract -------------------------------------------------------------------------
    def sum_functions(self):
        """Gradients, Hessian blocks and products over all sites."""
        every, some = self.sums(self.effects, self.gradient_body("w", "g")), self.sums(self.coupled_effects(), self.gradient_body("w", "g"))
        found = [self.gradient("smg_gradient", every)]
        if self.plan.coupled:
            found.append(self.gradient("smg_coupled_gradient", some if some != every else ["smg_gradient(c, w, g);"]))
            found.append(self.of_state("smg_hessian_blocks", self.sums(self.coupled_effects(), self.block_body)))
        if self.plan.coupled and not self.plan.matrix:
            found.append(self.of_state("smg_hessian_vector", self.sums(self.coupled_effects(), self.product_body)))
        return found

    def gradient(self, name: str, lines):
        return Static(name, function(f"void {name}", ["const smg_coefficients *c", "const smg_real *w", "smg_real *g"],
                                     lines, ["c", "w", "g"]), True)

    def of_state(self, name: str, lines):
        return Static(name, function(f"void {name}", ["const smg_state *s"], ["const smg_coefficients *c = &s->c;", "(void)c;", *lines], ["s"]), True)

    def site_sums(self):
        """Gradient, Hessian and the pull of the neighbours of one site."""
        tangent = "tangent" in self.features and (self.plan.local or self.lifts())
        newton = any(not self.closed_form(f) for f in self.chosen(self.plan.local))
        found = []
        lifted = tangent and self.lifts()
        if self.plan.local or self.plan.rotation:
            found.append(self.of_site("smg_gather", ["smg_real *g"], self.gather_lines, self.plan.rotation))
        if newton or tangent:
            found.append(self.of_site("smg_site_hessian_vector", ["const smg_real *v", "smg_real *y"], self.own_hessian_lines, lifted))
        if tangent:
            found.append(self.of_site("smg_bend", ["const smg_real *dm", "smg_real *y"], self.bend_lines, lifted))
        return found

    def of_site(self, name: str, more, lines_of, coupled: bool):
        """A function of sites that are solved alone, and of `coupled` ones where they too are asked one by one."""
        def lines(f):
            found = lines_of(f.name)
            used = [x for x in COORDINATES if self.lattice(f.name) is not None]
            return [*(f"const int64_t {x} = at.{x};" for x in used if x in names_of(found)), *found]
        arguments = ["const smg_coefficients *c", "smg_lattice_site at", "const smg_real *all", "const smg_real *own", *more]
        families = [f for f in self.families if f.name in self.plan.local or coupled]
        return Static(name, self.by_family(f"void {name}", arguments, lines, families, number="at.k", index="site"), True)

    def roles(self, family: str):
        """The effects and slots through which a site of `family` feels something."""
        for t in self.effects:
            passive = self.passive(t)
            for k, s in enumerate(t.slots):
                if s[0] == family and (not passive or s in passive):
                    yield t, k

    def lattice(self, family: str):
        """The lattice that a swept family lives on, when all its bonds agree on it."""
        if not self.plan.rotation or family not in self.plan.coupled:
            return None
        overs = [t.over for t, _ in self.roles(family) if isinstance(t.over, Lattice)]
        same = {(o.size, o.sites) for o in overs}
        return overs[0] if len(same) == 1 else None

    def gathered(self, family: str, calls_of):
        """Loops over the terms of one site, with the statements `calls_of(term, slot)` of each."""
        lines = []
        for t, k in self.roles(family):
            calls = calls_of(t, k)
            if calls:
                lines += self.loops.gather(t.over, t.slots[k], lambda _, calls=calls: calls, self.lattice(family) is not None)
        return lines

    def points(self, t, k):
        return ["own" if q == k else self.vector("all", s) for q, s in enumerate(t.slots)]

    def gather_lines(self, family: str):
        def calls(t, k):
            outputs = ["g" if q == k else f"o{q}" for q in range(len(t.slots))]
            spare = [f"smg_real {o}[3] = {{0, 0, 0}};" for o in outputs if o != "g"]
            return [*spare, t.call("gradient", self.points(t, k), *outputs) + ";"]
        return self.gathered(family, calls)

    def own_hessian_lines(self, family: str):
        def calls(t, k):
            return [t.call(f"hessian_{k}{k}", self.points(t, k), "v", "y") + ";"] if (k, k) in t.derived.hessian else []
        return self.gathered(family, calls)

    def bend_lines(self, family: str):
        def calls(t, k):
            return [t.call(f"hessian_{k}{l}", self.points(t, k), self.vector("dm", t.slots[l]), "y") + ";"
                    for l in range(len(t.slots)) if l != k and (k, l) in t.derived.hessian]
        return self.gathered(family, calls)

    def is_linear(self, family: str) -> bool:
        return not any((k, k) in t.derived.hessian for t, k in self.roles(family))

    def closed_form(self, f) -> bool:
        """A site alone in a field that does not depend on it: the step is an exact rotation."""
        return self.method.onto_leaf and f.kind != "nambu" and self.is_linear(f.name)

