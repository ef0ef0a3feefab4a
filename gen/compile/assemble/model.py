"""A model as data: its kernels, its plan, and what the functions over its sites ask of them."""
from __future__ import annotations

from ...errors import UsageError
from ...language.spec import Lattice, Spec
from ...language.sublattice import within
from ...language.tracers import moves_tracers
from ...methods import METHODS
from ..by_bond import by_bond, split
from ..derive.derivatives import switched
from ..features import ASKS, EVERYWHERE, chosen_features
from ..lower.code import At, Name
from ..lower.indices import one_site, safe_indices
from ..lower.integers import Index, Int, total
from ..lower.kernels import field_kernels, term_kernels
from ..lower.loops import Loops
from ..lower.lowering import Lowering
from ..plan.contributions import contributions_of, fields_of, require, responses_of
from ..plan.held import present
from ..plan.layout import HISTORY, with_layout
from ..plan.plan import Plan, require_free_body
from .families import FamilyCode, family_codes
from .norms import edge_norms, reach
from .parts import FIRST, PARTS
from .rows import one_lattice
from .same_bonds import energy_kernels


class Model:
    """One spec with one plan. All kernels are made here, so that what is hoisted is known: `coefficients`.

    families: sizes, strengths and leaves; energies, observables: kernels of one term; values: of effects that share bonds (`same_bonds.py`), which `energies` have as one; torques: of those that are fields beside the gradients; responses: laws of families whose sites do more than precess;
    effects: of the spec, by name, what each is made of (`by_bond`); reach, edge_norms: bounds of the rows of the Hessian, or None, and of each edge of a graph; parts: those of `parts.py` that it has, each also an
    attribute by its name, what it is made of or None; whole: the spec with absent sites in its terms; why_by_site: why a lattice goes site by site.
    """

    def __init__(self, spec: Spec, plan: Plan, features=(), contributions=None):
        self.effects = split(spec)
        spec = by_bond(spec)
        self.whole, self.spec, self.plan, self.method = safe_indices(one_site(spec)), safe_indices(one_site(present(spec))), plan, METHODS[plan.method]
        self.features = chosen_features(features)
        self.contributions = contributions_of(spec, self.method) if contributions is None else contributions
        self.responses = responses_of(self.contributions)
        self.refuse_what_the_method_has_not()
        low = Lowering(self.spec)
        self.families = family_codes(low, self.spec, plan.coupled)
        self.by_name = {f.name: f for f in self.families}
        self.energies, self.values = energy_kernels(low, self.spec.energies, "effect", self.method)
        self.torques = tuple(field_kernels(low, t, t.slots, field) for t, field in fields_of(self.spec, self.contributions, self.method))
        self.observables = tuple(term_kernels(low, o, "observe", False) for o in self.spec.observables)
        self.parts = ()
        self.add(FIRST, low)
        self.loops = Loops(low, lambda family: self.by_name[family].count)
        self.reach = reach(self, low) if plan.rotation else None
        self.edge_norms = edge_norms(self, low) if self.reach is not None else {}
        self.add(PARTS[len(FIRST):], low)
        self.plan = with_layout(plan, self.method, {part.layout for part in self.parts})
        self.low, self.coefficients = low, low.finished()

    def add(self, parts, low):
        """Each under its name; those that the model has are its `parts`."""
        for part in parts:
            found = part.made(self, low)
            setattr(self, part.name, found)
            if found is not None:
                part.fits(self)
                self.parts += (part,)

    @property
    def history(self) -> int:
        """Steps that are remembered."""
        own = max((part.history(self) for part in self.parts), default=0)
        return own or (HISTORY if self.method.midpoint else self.method.history)

    def refuse_what_the_method_has_not(self):
        missing = [name for name in self.features if name not in (*EVERYWHERE, *self.method.features)]
        if missing:
            raise UsageError(f"method {self.plan.method} has no feature '{missing[0]}'")
        for feature in self.features:
            require(self.contributions, ASKS.get(feature, ()), f"feature {feature}")
        if self.method.free_body:
            require_free_body(self.spec, self.plan.method)

    @property
    def sums(self) -> dict:
        """Name of each energy of the spec -> the terms that it is made of."""
        terms = {t.derived.term.name: t for t in (*self.energies, *self.values)}
        return {name: [terms[part.name] for part in parts] for name, parts in self.effects.items() if all(part.name in terms for part in parts)}

    @property
    def fields(self) -> tuple:
        """All terms that move sites by a gradient, or by a field in the place of one."""
        return (*self.energies, *self.torques)

    # -- families -----------------------------------------------------------------------------
    @property
    def coupled(self) -> list:
        return [f for f in self.families if f.name in self.plan.coupled]

    @property
    def alone(self) -> list:
        return [f for f in self.families if f.name in self.plan.local]

    @property
    def total(self) -> Int:
        """The number of sites."""
        return total(*(f.count for f in self.families))

    @property
    def rows(self) -> Int:
        """The number of coupled sites."""
        return total(*(f.count for f in self.coupled))

    @property
    def alone_rows(self) -> Int:
        return total(*(f.count for f in self.alone))

    def is_tracer(self, slot) -> bool:
        return self.by_name[slot[0]].tracer

    # -- sites and terms ----------------------------------------------------------------------
    def site(self, slot) -> Int:
        """The global number of the site at a slot; a name is its number within the family."""
        number = Index(slot[1]) if isinstance(slot[1], str) else slot[1]
        return self.by_name[slot[0]].first + number

    def vector(self, array, slot, written: bool = False, size: int = 3) -> At:
        """The vector of a slot in an array of all sites: a name, or a member of the state."""
        return At(Name(array) if isinstance(array, str) else array, size * self.site(slot), written)

    def passive(self, term) -> bool:
        """Does a term hold tracers? It moves them alone."""
        return moves_tracers(term.over, term.slots, {f.name for f in self.families if f.tracer})

    def unfelt(self, term) -> list:
        """Numbers of the slots whose gradient is dropped: tracers act on none, and a torque moves one site."""
        if term.derived.pushed is not None:
            return [k for k in range(len(term.slots)) if k != term.derived.pushed]
        return [k for k, s in enumerate(term.slots) if self.passive(term) and not self.is_tracer(s)]

    def coupled_effects(self) -> list:
        return [e for e in self.fields if not self.passive(e) and any(f in self.plan.coupled for f, _ in e.slots)]

    def roles(self, family: str):
        """The effects and slots through which a site of `family` feels something."""
        for t in self.fields:
            for k, s in enumerate(t.slots):
                if s[0] == family and k not in self.unfelt(t):
                    yield t, k

    def lattices(self, family: str) -> list:
        return [within(t.over, family) for t, _ in self.roles(family) if isinstance(t.over, Lattice)]

    def lattice(self, family: str):
        """The lattice that a swept family lives on, when all its bonds agree on it."""
        if not self.plan.rotation or family not in self.plan.coupled:
            return None
        return one_lattice(self.lattices(family))

    # -- what follows -------------------------------------------------------------------------
    def is_linear(self, family: str) -> bool:
        """Does the field of a site not depend on the site itself, nor jump where it goes?"""
        return not any((k, k) in t.derived.hessian or switched(t.derived) & set(t.derived.vectors[k]) for t, k in self.roles(family))

    def closed_form(self, f: FamilyCode) -> bool:
        """A site alone in a field that does not depend on it: the step is an exact rotation."""
        return self.method.onto_leaf and f.kind != "nambu" and self.is_linear(f.name)

    @property
    def by_site(self) -> str:
        """Why the steps of its lattice go site by site, where they do."""
        return self.why_by_site if self.plan.layout == "sites" else ""

    def lifts(self) -> bool:
        """Does the leaf of a coupled site move with w?"""
        return self.method.onto_leaf and any(f.kind != "sphere" for f in self.coupled)

    def unit_radius(self) -> bool:
        """Are all spheres of radius 1?"""
        return all(f.unit for f in self.families if f.kind == "sphere")

