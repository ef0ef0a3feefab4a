"""Dampings, with the key `damping`, and `kT` where sites are in a heat bath: sites lose energy on their spheres."""
from __future__ import annotations

from dataclasses import dataclass, replace

from ..language import codes
from ..language.expr import Expr, Idx, Num, Op, with_index
from ..language.spec import Effect, Sites, Spec
from ..language.sublattice import sites_of, there
from ..language.units import ENERGY, NONE, power
from .motion import Contribution, Response, family_of

FORMS = ("gilbert", "ll")     # Gilbert's damping, and that of Landau and Lifshitz
KEYS = ("over", "damping", "kT", "form", "meaning")


class DampingReader:
    """Reads one effect; `terms` reads its name and its index family."""

    def __init__(self, terms):
        self.terms, self.problems, self.damped = terms, terms.problems, {}

    def read(self, node) -> Damping:
        if node.has("energy"):
            node.get(next(key for key in ("damping", "kT") if node.has(key))).wrong(
                codes.CONFLICT, f"`{node.label}` has both an energy and a damping", "write two separate effects")
        if not node.has("damping"):
            node.get("kT").wrong(codes.MISSING, f"`{node.label}` has `kT` but no `damping`",
                                 "noise without damping heats the system without limit: add `damping = 0.1`")
        node.table(*KEYS)
        name, (over, alpha, form, kT), said = self.problems.together(
            lambda: self.terms.name(node, "effect", ()), lambda: self.law(node), lambda: self.terms.text(node, "meaning"))
        return Damping(name, over, alpha, form, said, kT)

    def law(self, node):
        """(the sites, alpha, the form, kT or None)."""
        over, condition = self.sites(node)
        return (over, *self.problems.together(lambda: there(condition, self.terms.formulas.free(node.get("damping"), "a damping", over.index, self.dimension(over), over.family)),
                                              lambda: self.form(node, self.terms.declared.families[over.family].kind),
                                              lambda: self.temperature(node, over)))

    def dimension(self, over: Sites) -> tuple:
        """Of a damping: none on a sphere, 1/|w| in R^3."""
        declared = self.terms.declared
        return power(declared.dimensions.get(over.family, NONE), -1) if declared.families[over.family].kind == "r3" else NONE

    def temperature(self, node, over: Sites):
        return self.terms.formulas.free(node.get("kT"), "a temperature", over.index, ENERGY, over.family) if node.has("kT") else None

    def sites(self, node) -> tuple:
        """Those of one family on spheres or in R^3, that no other effect damps, and of which sublattice."""
        over, condition = sites_of(self.terms.over(node, "damping"))
        at = node.get("over") if node.has("over") else node
        if not isinstance(over, Sites):
            at.wrong(codes.OVER, "a damping must act on the sites of a family", 'write `over = "site(i) of w"`')
        self.terms.known({over.family})
        family = self.terms.declared.families[over.family]
        if family.kind == "nambu" or family.tracer:
            what = "are tracers, which only follow other sites" if family.tracer else "are on Nambu leaves"
            at.wrong(codes.NOT_HERE, f"the sites of `{family.name}` {what}", "damping requires sites on spheres or in R^3")
        if over.family in self.damped:
            node.problems.fail(codes.CONFLICT, node.key, f"`{self.damped[over.family]}` already damps the sites of `{over.family}`", "combine them into one damping")
        self.damped[over.family] = node.name
        return over, condition

    def form(self, node, kind: str) -> str:
        """Gilbert's unless another is given; in R^3 that of Landau and Lifshitz alone, where alpha is in units of 1/|w|."""
        if not node.has("form"):
            return FORMS[kind == "r3"]
        form = node.get("form").string()
        if kind == "r3" and form == FORMS[0]:
            node.get("form").wrong(codes.CHOICE, "Gilbert damping requires spheres", 'in R^3, where |w| depends on the start, write `form = "ll"`')
        if form not in FORMS:
            node.get("form").wrong(codes.CHOICE, f"`{form}` is not a form of damping", " or ".join(f'`"{x}"`' for x in FORMS))
        return form


@dataclass(frozen=True)
class Damping(Effect):
    """The sites of `over` lose energy on their spheres.

    alpha: dimensionless, a formula of parameters and of the site's number Idx(over.index). With b = (1/kappa) dH/dw,
    r the radius, o the orientation and s the sign of kappa, form 'll' moves a site by

        w' = o w x b + s (alpha/r) w x (w x b),

    and 'gilbert', w' = o w x b + o s (alpha/r) w x w', by the same divided by 1 + alpha^2. In R^3, where r is the state's, the form is
    'll' and r is 1: alpha has the unit of 1/|w|.

    kT: of a heat bath in the unit of the energy, a formula of the same kind, or None: noise then turns the sites, and the distribution
    exp(-H/kT) is stationary.
    """
    name: str
    over: Sites
    alpha: Expr
    form: str = "gilbert"
    meaning: str = ""
    kT: Expr | None = None

    told_by = ("damping", "kT")
    keys = ("damping", "form", "kT")
    reader = DampingReader
    moves = False
    gives_up = {"by": "damped sites", "as": "sites are damped", "symplectic": "damped sites lose area", "energy": "damped sites lose energy",
                "momentum": "damped sites turn towards their field"}
    work = 18, 24       # F = f g and Q = q g, then F + m x Q; the vector that it adds
    not_negative = {"damping": "a damping constant must be finite and not negative, so that the energy decreases", "kT": "a temperature must be finite and not negative"}

    @property
    def formulas(self) -> dict[str, Expr]:
        return {"damping": self.alpha} if self.kT is None else {"damping": self.alpha, "kT": self.kT}

    @property
    def families(self) -> set[str]:
        return {self.over.family}

    def mapped(self, over, formula) -> Damping:
        return replace(self, over=over(self.over), alpha=formula(self.alpha), kT=self.kT and formula(self.kT))

    @property
    def untitled(self) -> Damping:
        return replace(self, meaning="")

    @property
    def damps(self) -> tuple[str, ...]:
        return (self.over.family,)

    @property
    def heats(self) -> tuple[str, ...]:
        return () if self.kT is None else (self.over.family,)

    @property
    def lost(self) -> dict[str, str]:
        found = {"energy": "falls", "momentum": "is damped", "symplectic": "areas shrink"}
        return found if self.kT is None else {**dict.fromkeys(found, "noise"), "reversible": "noise cannot be undone by another step"}

    @property
    def calm(self) -> Damping:
        return replace(self, kT=None)

    @property
    def note(self) -> str:
        return f", damped by {self.name} ({self.form}{', with thermal noise' * (self.kT is not None)})"

    def contribution(self, spec: Spec, method) -> Contribution:
        return Contribution(self.name, ((self.over.family, self.over.index),), self.over, conservative=False, response=self.response(spec),
                            diffusion=None if self.kT is None else self.diffusion(spec))

    def response(self, spec: Spec) -> Response:
        """Landau and Lifshitz: f = 1, q = o s alpha/r, s the sign of kappa, r = 1 in R^3; Gilbert: both divided by 1 + alpha^2."""
        family, alpha = family_of(spec, self.over.family), self.of_site(self.alpha)
        side = Op("if", (Op(">", (family.kappa, Num(0))), Num(spec.orientation), Num(-spec.orientation)))
        f = Num(1) if self.form == "ll" else Op("/", (Num(1), Op("+", (Num(1), Op("*", (alpha, alpha))))))
        q = Op("*", (f, Op("*", (side, Op("/", (alpha, family.radius or Num(1)))))))
        return Response(f, q, lag=Num(0) if self.form == "ll" else Op("*", (side, alpha)))

    def diffusion(self, spec: Spec) -> Expr:
        """D = alpha kT/(|kappa| r), for Gilbert's form divided by 1 + alpha^2; r = 1 in R^3. The components of a unit vector then forget where they
        were as exp(-2 D t), and exp(-H/kT) is stationary."""
        family, alpha, kT = family_of(spec, self.over.family), self.of_site(self.alpha), self.of_site(self.kT)
        size = Op("*", (Op("abs", (family.kappa,)), family.radius or Num(1)))
        rate = Op("/", (Op("*", (alpha, kT)), size))
        return rate if self.form == "ll" else Op("/", (rate, Op("+", (Num(1), Op("*", (alpha, alpha))))))

    def of_site(self, e: Expr) -> Expr:
        """A formula of its index in the number Idx('i') of the site."""
        return with_index(e, self.over.index, Idx("i"))
