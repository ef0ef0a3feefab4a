"""The plan: which sites are solved together, and by which solver (stage `plan`), from the coupling alone."""
import pytest
import smidgen
from smidgen.compile.assemble.model import Model
from smidgen.compile.plan.contributions import contributions_of, require
from smidgen.compile.plan.layout import FEW, LAYOUTS, MIDPOINT_ROWS, STAGE_ROWS, TURN_ROWS, with_layout
from smidgen.compile.plan.plan import choose, coupled_families
from smidgen.effects.motion import Contribution
from smidgen.errors import UsageError
from smidgen.methods import ENERGY, GRADIENT, HESSIAN, METHODS, MIDPOINTS, OFFERS, SITE_GRADIENT, WIDE_GRADIENT

pytestmark = pytest.mark.quick
SPHERICAL, CLASSICAL, _ = MIDPOINTS

# spec -> (solver, families solved together, families whose sites are solved alone)
PLANS = {
    "free_rigid_body": ("local", (), ("w",)),
    "two_bodies": ("dense", ("w",), ()),
    "point_vortices": ("dense", ("w",), ()),
    "vortex_tracers": ("dense", ("v",), ("p",)),
    "heisenberg_chain": ("band", ("w",), ()),
    "j1j2_chain": ("band", ("w",), ()),
    "cubic_lattice": ("rotation", ("w",), ()),
    "honeycomb": ("rotation", ("w",), ()),
}


def plan(name, method=SPHERICAL, solver="auto", **values):
    from smidgen.run.step.prepared import scene_of
    return choose(scene_of(smidgen.load(name), None, values), method, solver)


@pytest.mark.parametrize("name", PLANS)
def test_shipped_specs(name):
    found = plan(name)
    solver, coupled, local = PLANS[name]
    assert (found.solver, len(found.coupled), len(found.local)) == (solver, len(coupled), len(local))
    assert set(found.coupled) == set(coupled_families(smidgen.load(name))) and not set(found.coupled) & set(found.local)


@pytest.mark.parametrize("name, method, features, layout, said", [
    ("free_rigid_body", SPHERICAL, (), "single", "every site is solved separately, by Newton or in closed form"),
    ("free_rigid_body", SPHERICAL, ("ensemble",), "members", "every site is solved separately, by Newton or in closed form"),
    ("free_rigid_body", CLASSICAL, (), "sites", "every site is solved separately, by Newton or in closed form"),
    ("point_vortices", SPHERICAL, (), "few", FEW), ("point_vortices", SPHERICAL, ("extended",), "sites", "few sites: dense Newton"),
    ("heisenberg_chain", SPHERICAL, (), "rows", MIDPOINT_ROWS), ("heisenberg_chain", "gauss-4", (), "rows", STAGE_ROWS),
    ("heisenberg_chain", "sublattice-rotations", (), "rows", TURN_ROWS), ("heisenberg_chain", "cf4", (), "sites", "")])
def test_the_layout_is_taken_from_what_is_offered(name, method, features, layout, said):
    """And the reason says so."""
    before = plan(name, method)
    after = Model(smidgen.load(name), before, features).plan
    assert (before.layout, after.layout) == ("sites", layout) and after.layout in LAYOUTS
    assert after.reason in (before.reason, said, f"{before.reason}; {said}") and said in after.reason


def test_of_several_layouts_one_is_taken():
    one, method = plan("free_rigid_body"), METHODS[SPHERICAL]
    assert [with_layout(one, method, {*offered}).layout for offered in ((), ("single",), ("single", "members"), ("", "few"))] == ["sites", "single", "members", "few"]


@pytest.mark.parametrize("name, width, closed", [("heisenberg_chain", 1, True), ("j1j2_chain", 2, True)])
def test_the_band_of_a_chain(name, width, closed):
    found = plan(name)
    assert (found.band, found.wrap, found.rotation, found.matrix, found.swept) == (width, closed, True, True, True)
    assert not plan(name, solver="newton").swept


@pytest.mark.parametrize("n, solver", [(4, "dense"), (300, "dense"), (301, "rotation")])
def test_all_pairs_are_factored_while_the_matrix_is_small(n, solver):
    """600 unknowns, two a site; of the classical midpoint three."""
    spec = smidgen.load_text(f"""
[model]
name = "all"
[space]
w = {{ sphere = {n} }}
[effects.e]
over = "pair(i, j) of w"
energy = "dot(w[i], w[j])"
[starts.a]
random = 1
""")
    assert choose(spec, SPHERICAL, "auto").solver == solver
    assert choose(spec, CLASSICAL, "auto").solver == ("dense" if 3 * n <= 600 else "plain")


@pytest.mark.parametrize("method, unknowns", [(SPHERICAL, 2), (CLASSICAL, 3)])
def test_unknowns_of_a_site(method, unknowns):
    assert plan("point_vortices", method).block == unknowns == METHODS[method].unknowns


@pytest.mark.parametrize("name, method, solver, said", [
    ("heisenberg_chain", CLASSICAL, "rotation", "no solver 'rotation'"),
    ("cubic_lattice", SPHERICAL, "newton", "use solver rotation or plain here"),
    ("cubic_lattice", CLASSICAL, "newton", "use solver plain here"),
    ("nambu_a31", "gauss-4", "auto", "does not support Nambu factors")])
def test_what_does_not_go_together_is_refused(name, method, solver, said):
    with pytest.raises(UsageError, match=said):
        plan(name, method, solver)


@pytest.mark.parametrize("method", [m for m in METHODS if not METHODS[m].of_midpoints])
def test_methods_with_a_step_of_their_own_need_no_solver(method):
    found = plan("heisenberg_chain", method)
    assert found.coupled == found.local == () and found.solver == METHODS[method].how[0]


# Contributions that offer less than a local energy term does

SUM_BY_FFT = Contribution("far", (("w", "i"), ("w", "j")), offers=frozenset((ENERGY, GRADIENT, HESSIAN)))
DAMPING = Contribution("damping", (("w", "i"),), offers=frozenset((GRADIENT,)), conservative=False)


def with_more(name, more, method=SPHERICAL, solver="auto"):
    spec = smidgen.load(name)
    return choose(spec, method, solver, (*contributions_of(spec), more))


def test_an_effect_is_an_energy_and_offers_all():
    found = contributions_of(smidgen.load("vortex_tracers"))
    assert [c.name for c in found] == [e.name for e in smidgen.load("vortex_tracers").effects]
    assert all(c.offers == OFFERS and c.conservative and not c.lacks(OFFERS) for c in found)


def test_a_contribution_that_offers_all_is_planned_like_an_effect():
    chain = smidgen.load("heisenberg_chain")
    again = Contribution("again", *[(c.slots, c.over) for c in contributions_of(chain)][0])
    assert with_more("heisenberg_chain", again) == choose(chain, SPHERICAL, "auto")


@pytest.mark.parametrize("name, solver", [("heisenberg_chain", "plain"), ("cubic_lattice", "plain"), ("two_bodies", "dense")])
def test_no_gradient_of_a_single_site_no_rotation_sweeps(name, solver):
    """A sum over all sites: no band either, and a small matrix as before."""
    found = with_more(name, SUM_BY_FFT)
    assert (found.solver, found.rotation) == (solver, False)
    with pytest.raises(UsageError, match="solver rotation needs the gradient of a single site of every effect, but 'far' does not provide it"):
        with_more(name, SUM_BY_FFT, solver="rotation")


def test_a_chain_whose_terms_have_no_gradient_of_a_single_site_is_solved_by_newton_alone():
    spec = smidgen.load("heisenberg_chain")
    bonds = [Contribution(c.name, c.slots, c.over, OFFERS - {SITE_GRADIENT}) for c in contributions_of(spec)]
    found = choose(spec, SPHERICAL, "auto", bonds)
    assert (found.solver, found.rotation, found.swept) == ("band", False, False)


def test_a_site_that_is_solved_alone_needs_its_own_gradient():
    """Only where the contribution meets such a site: spins of a chain are not alone."""
    field = Contribution("field", (("w", "i"),), offers=OFFERS - {SITE_GRADIENT})
    with pytest.raises(UsageError, match="solved separately needs the gradient of a single site"):
        with_more("free_rigid_body", field)
    assert with_more("two_bodies", field).solver == "dense"


@pytest.mark.parametrize("method", METHODS)
def test_a_method_is_refused_where_a_contribution_lacks_what_it_asks(method):
    """Without a Hessian there is no Newton; methods of gradients alone take any, and the refusal names them."""
    if HESSIAN in METHODS[method].asks:
        with pytest.raises(UsageError, match=f"method {method} needs the .* of every effect, but 'damping' does not provide it; use gauss-2 or "):
            with_more("free_rigid_body", DAMPING, method)
    else:
        assert with_more("free_rigid_body", DAMPING, method).solver == METHODS[method].how[0]


def test_a_method_of_energies_refuses_what_is_none():
    """Moser and Veselov discretise a Lagrangian; the offers alone would let this pass."""
    method = next(m for m in METHODS if METHODS[m].free_body)
    twist = Contribution("twist", (("w", "i"),), conservative=False)
    with pytest.raises(UsageError, match="'twist' does not derive from an energy"):
        with_more("free_rigid_body", twist, method)
    assert with_more("free_rigid_body", twist).solver == "local"


def test_what_is_asked_has_a_name():
    """A word that nothing offers would refuse every effect."""
    from smidgen.compile.features import ASKS as OF_FEATURES, FEATURES
    from smidgen.compile.plan.plan import ASKS as OF_SOLVERS
    asked = [*(m.asks for m in METHODS.values()), *OF_FEATURES.values(), *OF_SOLVERS.values()]
    assert all(set(asks) <= OFFERS and GRADIENT in (*asks, *asked[0]) for asks in asked) and set(OF_FEATURES) <= set(FEATURES)
    with pytest.raises(UsageError, match="feature extended needs the gradient in extended precision"):
        require([SUM_BY_FFT], (WIDE_GRADIENT,), "feature extended")
