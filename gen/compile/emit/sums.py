"""Sums over the index families: every term once (scatter), or the terms of one site (gather)."""
from __future__ import annotations

from ...language.spec import Lattice
from ..lower.kernels import function
from ..lower.loops import indent
from .text import plus


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
        for term in (t for t in terms if body(t)):      # a term without curvature has no blocks
            lines += self.loops.scatter(term.over, lambda _, t=term: body(t))
        return "\n".join(indent(lines))

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
        lines = []
        vectors = [self.vector("s->m", s) for s in t.slots]
        for k, l in t.derived.hessian:
            rows = [plus(self.by_name[t.slots[q][0]].row, str(t.slots[q][1])) for q in (k, l)]
            where = [self.site(t.slots[q]) for q in (k, l)]
            lines.append(f"{self.M}_ADD({where[0]}, {where[1]}, {rows[0]}, {rows[1]}, {t.prefix}_hessian_{k}{l}, "
                         f"{', '.join([*t.common(), *vectors])});")
        return lines

    def product_body(self, t):
        """s->felt += B s->along for the Hessian blocks that join two sites."""
        vectors = [self.vector("s->m", s) for s in t.slots]
        return [t.call(f"hessian_{k}{l}", vectors, self.vector("s->along", t.slots[l]), self.vector("s->felt", t.slots[k])) + ";"
                for k, l in t.derived.hessian if k != l]

    def value_body(self, t):
        call = t.call("value", [self.vector("w", s) for s in t.slots])
        return [f"smg_add_carry(&sum, &lost, {call});"]

    def roles(self, family: str):
        """The effects and slots through which a site of `family` feels something."""
        for t in self.effects:
            passive = self.passive(t)
            for k, s in enumerate(t.slots):
                if s[0] == family and (not passive or s in passive):
                    yield t, k

    def gather(self, family: str, what: str, lines):
        out = ["const smg_real *v", "smg_real *y"] if what == "curvature" else ["smg_real *g"]
        place = self.place(family)
        return function(f"void {self.M}_{family}_{what}",
                        [f"const {self.M}_coefficients *c", *(f"int64_t {n}" for n in place),
                         "const smg_real *all", "const smg_real *own", *out], lines,
                        ["c", *place, "all", "own", *(o.split("*")[1] for o in out)]) + "\n"

    def place(self, family: str):
        """What a gather must know of a site: its number and, on a lattice, its cell and place."""
        lattice = self.lattice(family)
        return ["site"] if lattice is None else ["site", "sub", *(f"s{d}" for d in range(len(lattice.size)))]

    def lattice(self, family: str):
        """The lattice that a swept family lives on, when all its bonds agree on it."""
        if not self.plan.rotation or family not in self.plan.coupled:
            return None
        overs = [t.over for t, _ in self.roles(family) if isinstance(t.over, Lattice)]
        same = {(o.size, o.sites) for o in overs}
        return overs[0] if len(same) == 1 else None

    def gather_gradient(self, family: str):
        placed = self.lattice(family) is not None
        lines = []
        for t, k in self.roles(family):
            lines += self.loops.gather(t.over, t.slots[k], lambda _, t=t, k=k: self.gather_body(t, k), placed)
        return self.gather(family, "gather", lines)

    def seen(self, t, k):
        return ["own" if q == k else self.vector("all", s) for q, s in enumerate(t.slots)]

    def gather_body(self, t, k):
        outputs = ["g" if q == k else f"o{q}" for q in range(len(t.slots))]
        spare = [f"smg_real {o}[3] = {{0, 0, 0}};" for o in outputs if o != "g"]
        return [*spare, t.call("gradient", self.seen(t, k), *outputs) + ";"]

    def gather_curvature(self, family: str):
        lines = []
        for t, k in self.roles(family):
            if (k, k) in t.derived.hessian:
                call = t.call(f"hessian_{k}{k}", self.seen(t, k), "v", "y") + ";"
                lines += self.loops.gather(t.over, t.slots[k], lambda _, call=call: [call])
        return self.gather(family, "curvature", lines)

    def is_linear(self, family: str) -> bool:
        return not any((k, k) in t.derived.hessian for t, k in self.roles(family))

    def closed_form(self, f) -> bool:
        """A site alone in a field that does not depend on it: the step is an exact rotation."""
        return self.method == "spherical-midpoint" and f.kind != "nambu" and self.is_linear(f.name)

    def gathers(self):
        text = []
        local = self.plan.local
        for f in self.families:
            if f.name in local or self.plan.rotation:
                text.append(self.gather_gradient(f.name))
            if f.name in local and not self.closed_form(f):
                text.append(self.gather_curvature(f.name))
        return "\n".join(text)
