"""The plan: which sites are solved together, and by which solver (stage `plan`), from the coupling alone."""
import pytest
import smidgen
from smidgen.compile.plan.plan import choose, coupled_families
from smidgen.errors import UsageError
from smidgen.methods import METHODS, MIDPOINTS

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
    from smidgen.run.integrator import scene_of
    return choose(scene_of(smidgen.load(name), None, values), method, solver)


@pytest.mark.parametrize("name", PLANS)
def test_shipped_specs(name):
    found = plan(name)
    solver, coupled, local = PLANS[name]
    assert (found.solver, len(found.coupled), len(found.local)) == (solver, len(coupled), len(local))
    assert set(found.coupled) == set(coupled_families(smidgen.load(name))) and not set(found.coupled) & set(found.local)


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
    ("cubic_lattice", SPHERICAL, "newton", "here use solver rotation or plain"),
    ("cubic_lattice", CLASSICAL, "newton", "here use solver plain"),
    ("nambu_a31", "gauss-4", "auto", "not for Nambu factors")])
def test_what_does_not_go_together_is_refused(name, method, solver, said):
    with pytest.raises(UsageError, match=said):
        plan(name, method, solver)


@pytest.mark.parametrize("method", [m for m in METHODS if not METHODS[m].midpoint])
def test_methods_with_a_step_of_their_own_need_no_solver(method):
    found = plan("heisenberg_chain", method)
    assert found.coupled == found.local == () and found.solver == METHODS[method].how[0]
