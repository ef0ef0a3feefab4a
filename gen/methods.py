"""The registry of methods: the one place that knows their names. Readers, plans, emission, checks and pictures ask it.

A method is one entry here and one header of runtime/ over the contract of runtime/core/smg_model.h.
"""
from __future__ import annotations

from dataclasses import dataclass, replace

SOLVERS = ("auto", "newton", "rotation", "plain")

# What a contribution to the motion may offer, and a method, a solver or a feature ask of each.
ENERGY, GRADIENT, SITE_GRADIENT, HESSIAN, WIDE_GRADIENT = (
    "energy", "gradient", "gradient of a single site", "Hessian", "gradient in extended precision")
OFFERS = frozenset((ENERGY, GRADIENT, SITE_GRADIENT, HESSIAN, WIDE_GRADIENT))


@dataclass(frozen=True)
class Method:
    """What the stages must know of a method.

    name: as specs and the command give it; title: with its article, in sentences; label: in legends and tables;
    summary: one line of the C header's comment; order: of its error in h; header: its file in runtime/;
    onto_leaf: is the field taken at a point of the leaf (m = P(mbar)), or at the midpoint as it is; symplectic: on
    spheres and leaves; divided: is h X divided by a function q of the field; unknowns: of Newton a site;
    solvers: those it may be asked for; free_body: it is for one free rigid body alone, whose energy and momentum it
    keeps; keeps_quadratic: it keeps quadratic integrals of single sites (on the leaf), or all (at the midpoint as
    it is); keeps_leaf: it stays on spheres and leaves; spaces: factors of the phase space that it is for; features: of
    `compile.features` that it has; controlled: it takes steps of its own within h, to a tolerance; needs: functions of
    a site in the contract that its header calls, beside those of every model; by_field: it asks for the right-hand side alone, which a unit
    sphere alone has in one formula; asks: what every contribution to the motion must offer it (`OFFERS`), whatever the solver.
    A method that is no midpoint brings a step of its own: midpoint False, `how` it is found, the steps that its
    `history` reaches back, `arrays` of its state as (name, numbers a site or the macro of its header that has them for so many
    sites, and how many more, meaning), and `defines` for its header; lanes: the most states whose gradient it takes at once; stage_rows: on
    lattices it goes by rows, sites in lanes.
    A composition takes `stages` steps of its base method, with the coefficients of the header `scheme`; the rest it has from that.
    lane_header: the file that takes several members of an ensemble at once, those of a single unit sphere.
    variant: sweeps over all methods leave it out, since another one of its kind and order does better.
    symmetric: a step of -h undoes a step of h.
    splitting: what an explicit splitting of H takes apart (`compile.plan.splitting`, which looks at Hessians); keeps_linear: it keeps momentum and the
    linear integrals of sites; keeps_energy: the energy, whatever else it keeps; responds: it has a step for sites that do more than precess in
    their field (`compile.plan.contributions.Response`); equivariant: it commutes with the rotations
    that leave H unchanged; across: it takes fields off the spheres, or turns sites about R itself, of which a torque w x R tells only what is across w:
    so it takes torques as fields across w; points: how often a step that is no midpoint, or a sweep of it, takes the field;
    noise_within: thermal noise is in its step, not around it.
    """
    name: str
    title: str
    label: str
    summary: str
    order: int
    header: str
    onto_leaf: bool = False
    symplectic: bool = False
    divided: bool = False
    unknowns: int = 3
    solvers: tuple = ("auto", "newton", "plain")
    free_body: bool = False
    keeps_quadratic: bool = True
    keeps_leaf: bool = True
    spaces: tuple = ("sphere", "r3", "nambu")
    features: tuple = ("tangent", "extended", "plain-sums")
    needs: tuple = ("smg_h_over_kappa",)
    by_field: bool = False
    asks: tuple = (GRADIENT, HESSIAN)
    midpoint: bool = True
    controlled: bool = False
    how: tuple = ()
    history: int = 0
    stage_rows: bool = False
    arrays: tuple = ()
    defines: tuple = ()
    lanes: int = 1
    stages: int = 1
    scheme: str = ""
    lane_header: str = ""
    variant: bool = False
    splitting: str = ""
    symmetric: bool = True
    keeps_linear: bool = True
    keeps_energy: bool = False
    responds: bool = True
    equivariant: bool = True
    across: bool = False
    points: int = 1
    noise_within: bool = False

    @property
    def responds_by_rows(self) -> bool:
        """Has it a step by rows for sites that do more than precess? The classical midpoint has none: such sites need |m|, which is not known."""
        return self.onto_leaf or bool(self.splitting) or self.takes_fields

    @property
    def takes_fields(self) -> bool:
        """By rows of a lattice it takes the field where it is asked for, whatever h is: no bound is needed."""
        return self.stage_rows or self.by_field

    @property
    def pushed_by_rows(self) -> bool:
        """Has it a step by rows with torques that are fields?"""
        return self.of_midpoints and self.onto_leaf or self.takes_fields

    @property
    def of_midpoints(self) -> bool:
        """Its step is one or several of a midpoint."""
        return self.midpoint or self.stages > 1 and not self.how


# suffix -> order, stages, header, source: the plain orders are the schemes that did best of their order
SCHEMES = {"4": (4, 5, "smg_suzuki5.h", "Suzuki"), "6": (6, 11, "smg_ss11.h", "Sofroniou and Spaletta"),
           "8": (8, 21, "smg_ss21.h", "Sofroniou and Spaletta"), "10": (10, 35, "smg_ss35.h", "Sofroniou and Spaletta"),
           "ss13": (6, 13, "smg_ss13.h", "Sofroniou and Spaletta"), "kl9a": (6, 9, "smg_kl9a.h", "Kahan and Li"),
           "kl17a": (8, 17, "smg_kl17a.h", "Kahan and Li")}


def composed(base: Method, scheme: str) -> Method:
    """The symmetric composition of a symmetric method of order 2."""
    order, stages, header, source = SCHEMES[scheme]
    kind = "symplectic, " if base.symplectic else ""
    return replace(
        base, name=f"{base.name}-{scheme}", title=f"{base.title} composed to order {order}", label=f"{base.label} {scheme}",
        summary=f"{base.name} composed of {stages} stages ({kind}order {order}, {source})", order=order, midpoint=False,
        features=("tangent", "plain-sums") if base.midpoint else (), history=8 if base.midpoint else base.history, stages=stages, scheme=header,
        lane_header=base.lane_header and "smg_lane_composition.h", variant=base.midpoint and not base.onto_leaf or not scheme.isdigit())


MIDPOINT_METHODS = (
    Method("spherical-midpoint", "the spherical midpoint", "spherical midpoint", "spherical midpoint (symplectic, order 2)", 2,
           "smg_spherical_midpoint.h", onto_leaf=True, symplectic=True, unknowns=2, solvers=SOLVERS, lane_header="smg_lane_sphere.h"),
    Method("classical-midpoint", "the classical midpoint", "classical midpoint", "classical midpoint (comparator: not symplectic on spheres)", 2,
           "smg_classical_midpoint.h", across=True),
    Method("moser-veselov", "discrete Moser-Veselov", "Moser\u2013Veselov", "discrete Moser-Veselov (free body)", 2,
           "smg_moser_veselov.h", symplectic=True, divided=True, free_body=True, responds=False, solvers=SOLVERS, asks=(ENERGY, GRADIENT, HESSIAN)))
SPLITTINGS = (
    Method("axis-splitting", "the axis splitting", "axis splitting", "rotations about the axes in turn (symplectic, explicit, order 2)", 2,
           "smg_axis_splitting.h", symplectic=True, keeps_quadratic=False, solvers=("auto",), spaces=("sphere", "r3"), features=(),
           asks=(GRADIENT, HESSIAN), midpoint=False, responds=False, splitting="axes", keeps_linear=False, equivariant=False,
           how=("explicit", "rotations about x, y, z, y, x"), history=1,
           arrays=(("points", 3, 0, "w during the step"), ("slopes", 1, 0, "dH/dw along one axis"),
                   ("inverse", 1, 0, "1/|w|^2 at the start of the step"))),
    Method("sublattice-rotations", "the method of sublattice rotations", "sublattice rotations",
           "each sublattice rotated in the field of the others (energy exact, not symplectic; explicit, order 2)", 2,
           "smg_sublattice_rotations.h", keeps_quadratic=False, solvers=("auto",), spaces=("sphere", "r3"), features=(),
           asks=(SITE_GRADIENT, HESSIAN), midpoint=False, responds=False, splitting="sublattices", keeps_linear=False, keeps_energy=True,
           how=("explicit", "one sublattice after the other, then in reverse order"), history=1,
           arrays=(("points", 3, 0, "w during the step"), ("inverse", 1, 0, "1/|w|^2 at the start of the step"))),
    Method("pair-rotations", "the method of pair rotations", "pair rotations",
           "both spins of a bond rotated about their total momentum, one bond after the other (symplectic, momentum exact; explicit, order 2)", 2,
           "smg_pair_rotations.h", symplectic=True, keeps_quadratic=False, solvers=("auto",), spaces=("sphere", "r3"), features=(),
           asks=(GRADIENT, HESSIAN), midpoint=False, responds=False, splitting="pairs", needs=(), how=("explicit", "one bond after the other, then in reverse order"), history=1,
           arrays=(("points", 3, 0, "w during the step"), ("inverse", 1, 0, "1/|w|^2 at the start of the step"))))
ONE_STAGE = {"solvers": ("auto",), "spaces": ("sphere", "r3"), "features": (), "asks": (GRADIENT,), "midpoint": False, "history": 3,
             "how": ("fixed-point", "the points of all sites together, by fixed-point iteration"),
             "arrays": (("points", 3, 0, "where the field is taken"), ("slopes", 3, 0, "what the iteration is for"),
                        ("past_slopes", 9, 0, "the same for the last steps"), ("inverse", 1, 0, "1/|w|^2 at the start of the step"))}
TWO_POINTS = {"solvers": ("auto",), "spaces": ("sphere", "r3"), "features": (), "asks": (GRADIENT,), "midpoint": False, "symmetric": False, "keeps_linear": False,
               "keeps_quadratic": False, "onto_leaf": True, "across": True, "points": 2, "history": 1, "noise_within": True, "defines": (("SMG_NOISE_WITHIN", 1),),
               "arrays": (("points", 3, 0, "w during the step"), ("turns", 6, 0, "h b at both ends of the step"), ("inverse", 1, 0, "1/|w|^2 at the start of the step"))}
COMPARATORS = (
    Method("cf4", "the commutator-free Lie-group method of order 4", "CF4",
           "commutator-free Lie-group method (comparator: explicit, order 4, not symplectic)", 4, "smg_cf4.h", onto_leaf=True, across=True, points=4,
           keeps_quadratic=False, solvers=("auto",), spaces=("sphere", "r3"), features=(), asks=(GRADIENT,), midpoint=False, symmetric=False, keeps_linear=False,
           how=("explicit", "four stages of rotations"), history=1,
           arrays=(("points", 3, 0, "w during the step"), ("turns", 12, 0, "h b of the four stages"),
                   ("inverse", 1, 0, "1/|w|^2 at the start of the step"))),
    Method("heun", "Heun's method", "Heun", "Heun's method with projection (comparator: explicit, order 2, not symplectic)", 2, "smg_heun.h",
           how=("explicit", "a predicted point, then the mean of both slopes"), **TWO_POINTS),
    Method("depondt-mertens", "the method of Depondt and Mertens", "Depondt\u2013Mertens",
           "predictor and corrector by rotations (comparator: explicit, order 2, not symplectic)", 2, "smg_depondt_mertens.h",
           how=("explicit", "a predicted point, then a rotation by the mean of both fields"), **TWO_POINTS),
    Method("isospectral-midpoint", "the isospectral midpoint", "isospectral midpoint", "isospectral midpoint of so(3) (comparator: symplectic, order 2)", 2,
           "smg_isospectral_midpoint.h", symplectic=True, keeps_quadratic=False, across=True, **ONE_STAGE),
    Method("geodesic-midpoint", "the geodesic midpoint", "geodesic midpoint", "geodesic midpoint (comparator: not symplectic, order 2)", 2,
           "smg_geodesic_midpoint.h", onto_leaf=True, keeps_linear=False, **ONE_STAGE),
    Method("exponential-midpoint", "the Lie-group method with the exponential map", "exponential midpoint",
           "Lie-group method with the exponential map on T*SU(2), reduced (comparator: symplectic, order 2)", 2,
           "smg_exponential_midpoint.h", symplectic=True, keeps_quadratic=False, responds=False, **ONE_STAGE),
    Method("rattle", "RATTLE on T*S^3", "RATTLE", "RATTLE on T*S^3, reduced (comparator: symplectic, order 2)", 2,
           "smg_rattle.h", symplectic=True, keeps_quadratic=False, responds=False, points=2, **ONE_STAGE | {
               "how": ("fixed-point", "both points of all sites together, by fixed-point iteration"),
               "arrays": (("points", 7, 0, "where the field is taken, twice, and e (s - sigma)"), ("slopes", 8, 0, "h b/2 at both, e s and e sigma"),
                          ("past_slopes", 24, 0, "the same for the last steps"), ("inverse", 1, 0, "1/|w|^2 at the start of the step"))}))
METHODS = {m.name: m for m in (
    *MIDPOINT_METHODS,
    *(Method(f"gauss-{2 * s}", f"Gauss collocation of order {2 * s}", f"Gauss {2 * s}",
             f"Gauss collocation in collective variables, {s} stage{'s' * (s > 1)} (symplectic, order {2 * s})", 2 * s, "smg_gauss.h",
             symplectic=True, keeps_quadratic=False, solvers=("auto",), spaces=("sphere", "r3"), features=(), asks=(GRADIENT,), midpoint=False,
             how=("fixed-point", "the stages of all sites together, by fixed-point iteration"), history=1,
             arrays=(("stages", "SMG_STAGES_SIZE", 0, "points, stages and slopes of every site"),), defines=(("SMG_STAGES", s),),
             lanes=1 << (s - 1).bit_length(), stage_rows=True)
      for s in range(1, 9)),
    *(Method(f"dop853{kind}", f"Dormand-Prince 8(5,3){said}", f"DOP853{said}",
             f"Dormand-Prince 8(5,3){said}, explicit, with step control (not symplectic)", 8, "smg_dop853.h",
             keeps_quadratic=False, keeps_leaf=bool(kind), controlled=True, by_field=True, symmetric=False, solvers=("auto",), features=(), asks=(GRADIENT,), midpoint=False,
             how=("explicit", "twelve stages; steps within h to a tolerance of 1e-12"),
             arrays=(("stages", 42, 1, "stages, and the size of the last step within h"),), defines=(("SMG_PROJECT", int(bool(kind))),),
             lane_header="smg_lane_dop853.h")
      for kind, said in (("", ""), ("-projected", " with projection onto the leaves"))),
    *SPLITTINGS,
    *(composed(base, scheme) for base in (*MIDPOINT_METHODS, *SPLITTINGS) for scheme in SCHEMES),
    *COMPARATORS,
    Method("dormand-prince-8", "Dormand-Prince of order 8", "Dormand\u2013Prince 8", "Dormand-Prince of order 8, explicit (not symplectic)", 8, "smg_dormand_prince.h",
           keeps_quadratic=False, keeps_leaf=False, by_field=True, symmetric=False, solvers=("auto",), features=(), asks=(GRADIENT,), midpoint=False,
           how=("explicit", "twelve stages"), points=12, arrays=(("stages", 36, 0, "slopes of the stages"),)),
    Method("extrapolation-12", "extrapolation of order 12", "extrapolation 12",
           "Gragg-Bulirsch-Stoer extrapolation, explicit, order 12 (not symplectic)", 12, "smg_extrapolation.h",
           keeps_quadratic=False, keeps_leaf=False, by_field=True, symmetric=False, solvers=("auto",), features=(), asks=(GRADIENT,), midpoint=False,
           how=("explicit", "six rows of the explicit midpoint rule"), points=37, arrays=(("tableau", 15, 0, "slopes, points and increments of a row of the tableau"),),
           lane_header="smg_lane_extrapolation.h"),
)}
NAMES = tuple(METHODS)
DEFAULT = NAMES[0]
ACCURATE = "gauss-12"       # where errors of the method are not to count
MIDPOINTS = tuple(m.name for m in MIDPOINT_METHODS)


def others(name: str) -> str:
    """The methods that serve any model, for a hint: `a or b`."""
    return " or ".join(m.name for m in METHODS.values() if m.name != name and m.midpoint and not m.free_body)
