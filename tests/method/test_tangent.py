"""The generated tangent map is the derivative of the emitted step.

Judged by two things that share nothing with it: seven-point differences of the step in extended precision, and the
symplectic form, M K(w) M^T = K(W). Either alone lets a fault through, and a test below shows which.
"""
import dataclasses

import numpy as np
import pytest
import sympy as sp
from support import texts
from support.features import ANYWHERE
from support.strict import FEW_COMPILERS, REALS, compile_all, run_sanitized
from support.systems import CLASSICAL, FREE_BODIES, SPECS, SPHERICAL, VESELOV, begin, tiers
from support.tangent import derivative, frame, leaves_of, polished

import smidgen
import smidgen.compile.assemble.same_bonds
from smidgen.build.binary import build_library
from smidgen.compile.derive.derivatives import derive, hessian_blocks
from smidgen.compile.derive.parts import Whole
from smidgen.compile.emit.emit import generate
from smidgen.errors import RunError, UsageError
from smidgen.language.c_names import in_c
from smidgen.run.step.integrator import Integrator
from smidgen.run.step.prepared import prepare, scene_of

TANGENT = ("tangent",)
AGREES, SYMPLECTIC = 1e-9, 1e-12
LOCAL = ("forced_rigid_body", "free_rigid_body", "irreversible_rigid_body", "lagrange", "nambu_a31", "nambu_a34",
         "nambu_a36", "nambu_a38", "nambu_a39", "test_particles")    # every site alone: the solver has no say
LATTICES = ("cubic_lattice", "honeycomb")       # no matrix
TRACERS = "vortex_tracers"
FEW = {("free_rigid_body", VESELOV, "auto"), ("nambu_a34", CLASSICAL, "auto"), ("heisenberg_chain", SPHERICAL, "auto"),
       ("heisenberg_chain", SPHERICAL, "rotation"), ("product", SPHERICAL, "newton"), ("two_bodies", SPHERICAL, "plain"),
       ("cubic_lattice", SPHERICAL, "auto"), (TRACERS, SPHERICAL, "rotation")}    # one a plan
SMALL_H = {("landau_lifshitz", "plain"): 0.02}  # part of its h at which plain sweeps contract
quick = pytest.mark.quick


def cases():
    """[(spec, method, solver)]: all that the compiler takes, each solver once."""
    found = []
    for name in SPECS:
        for method in (SPHERICAL, CLASSICAL, *([VESELOV] if name in FREE_BODIES else [])):
            for solver in ("auto",) if name in LOCAL else solvers(name, method):
                fast = name in ("forced_rigid_body", "nambu_a34") and method == SPHERICAL
                marks = quick if fast else () if (name, method, solver) in FEW else pytest.mark.long
                found.append(pytest.param(name, method, solver, marks=marks, id=f"{name}-{method}-{solver}"))
    return found


def solvers(name, method):
    found = ["auto"] if name in LATTICES or "chain" in name else ["newton"]
    return found + (["rotation"] if method == SPHERICAL and name not in LATTICES else []) + ["plain"]


class Step:
    """The step of the long-double build from time t0, with its tangent map, as functions of the state."""

    def __init__(self, model, h, t0=0.3):
        self.model, self.h, self.t0 = model, h, t0

    def __call__(self, w):
        return self.model.start(w.copy(), h=self.h, t0=self.t0).step().state()

    def tangent(self, w, v):
        self(w)
        return self.model.tangent(v.copy())


def long_step(case, method=SPHERICAL, solver="auto", h=None, features=TANGENT):
    model = smidgen.build(case.spec, method=method, parameters=case.values, solver=solver, real="long double",
                          features=features)
    return Step(model, case.h if h is None else h)


def generic_state(step, case, count=7):
    """Some steps on from the start, exactly on the spheres."""
    radius = leaves_of(case).radius
    w = polished(case.w.astype(np.longdouble), radius)
    return polished(step.model.start(w, h=step.h).steps(count).state(), radius)


def gap(step, case, w, tries=4, width=1e-3):
    """Largest relative distance of the tangent map from differences, over directions of random sites.

    Along spheres; on R^3 and Nambu factors also across the leaf, which the step keeps for every w.
    """
    leaves, dice, worst = leaves_of(case), np.random.default_rng(1), 0
    for site in dice.integers(len(w), size=tries):
        e1, e2, _ = frame(leaves.normal(w)[site])
        angle = dice.uniform(0, 2 * np.pi)
        e = np.cos(angle) * e1 + np.sin(angle) * e2
        if np.isnan(leaves.radius[site]):
            e = e + dice.normal() * w[site]
        v = np.zeros_like(w)
        v[site] = e
        differences = derivative(step, w, leaves, site, e, width)
        worst = max(worst, np.abs(step.tangent(w, v).ravel() - differences).max() / np.abs(differences).max())
    return float(worst)


def poisson_gap(step, case, w):
    """max |M K(w) M^T - K(W)| / max |K(W)| with M applied to the columns of K."""
    leaves = leaves_of(case)
    columns = leaves.structure(w).reshape(-1, *w.shape)        # of K^T
    left = step.tangent(w, columns.astype(w.dtype)).reshape(len(columns), -1)     # K M^T
    pulled = step.tangent(w, left.T.reshape(-1, *w.shape)).reshape(len(columns), -1).T
    after = leaves.structure(step(w))
    return float(np.abs(pulled - after).max() / np.abs(after).max())


# -- every spec, every method, every solver -----------------------------------------------------

@pytest.mark.parametrize("name, method, solver", cases())
def test_equals_differences_of_the_step(name, method, solver):
    case = begin(name)
    step = long_step(case, method, solver, case.h * SMALL_H.get((name, solver), 1))
    found = gap(step, case, generic_state(step, case))
    print(f"{name} {method} {solver} ({step.model.notes['solver']}): {found:.1e}")
    assert found < AGREES


@pytest.mark.parametrize("text, solver", [
    pytest.param(text, solver, marks=() if (text, solver) in ((texts.MIXED, "rotation"), (texts.CORNERS, "newton")) else pytest.mark.long)
    for text in (texts.MIXED, texts.OPEN_CHAIN, texts.CORNERS) for solver in ("newton", "rotation", "plain")])
def test_equals_differences_beyond_the_shipped_specs(text, solver):
    """Strengths of both signs, radii, reversed bracket, time, open ends, R^3, powers and pieces."""
    case = begin(texts.read(text))
    step = long_step(case, solver=solver)
    assert gap(step, case, generic_state(step, case), width=1e-4) < AGREES


@pytest.mark.parametrize("text", [texts.FIELD, texts.PULSE])
def test_one_spin_alone(text):
    """FIELD has a step in closed form, PULSE a field that depends on time."""
    case = begin(texts.read(text))
    step = long_step(case)
    assert gap(step, case, generic_state(step, case)) < AGREES


@pytest.mark.parametrize("solver", tiers(["newton", "rotation", "plain"], (), ("newton",)))
def test_a_graph(solver, tmp_path):
    case = begin(texts.read(texts.GLASS, tmp_path))
    step = long_step(case, solver=solver)
    assert step.model.notes["solver"] == ("sparse" if solver == "newton" else solver)
    assert gap(step, case, generic_state(step, case)) < AGREES


ALONE = """
[model]
name = "sites_alone"
[space]
w = { sphere = 3, kappa = [1, -2, 0.5], radius = 0.7 }
v = { r3 = 2 }
p = { sphere = 2, tracer = true }
n = { nambu = 1, C = "n.x^2 + n.y^2 + 0.3*n.y*n.z + 0.5*n.z^2" }
[parameters]
a = { default = 0.4 }
[effects.field]
over = "site(i) of w"
energy = "cos(t)*w[i].x + w[i].y"
[effects.push]
over = "site(i) of v"
energy = "a*v[i].z + 0.3*v[i].x"
[effects.leaf]
energy = "n.y^2/2 + n.x"
[effects.carry]
over = "each(i of p, j of v)"
energy = "dot(p[i], v[j])^2"
[starts.first.w]
theta = "0.4 + i"
phi = "0.3 + 2*i"
[starts.first.v]
vectors = [[0.3, -0.4, 0.9], [1.2, 0.1, -0.5]]
[starts.first.p]
theta = "0.4 + i"
phi = "1.3 + 2*i"
[starts.first.n]
vectors = [[0.8, 0.5, 0.4]]
[runs.demo]
start = "first"
h = 0.2
time = 5
"""


@pytest.mark.parametrize("method", tiers([SPHERICAL, CLASSICAL], (), (SPHERICAL,)))
def test_closed_forms_and_tracers_of_other_families(method):
    """Linear fields on spheres and on R^3 (which turn in closed form), and tracers that bodies in R^3 move."""
    case = begin(texts.read(ALONE))
    step = long_step(case, method)
    assert gap(step, case, generic_state(step, case), tries=12) < AGREES


@pytest.mark.parametrize("name, h", [("heisenberg_chain", 0.4), *(pytest.param(name, h, marks=pytest.mark.long) for name, h in (
    ("irreversible_rigid_body", 1.5), ("nambu_a39", 0.8), ("point_vortices", 1.5), ("two_bodies", -0.5)))])
def test_at_any_step(name, h):
    case = begin(name)
    step = long_step(case, h=h)
    assert gap(step, case, generic_state(step, case, 3), width=1e-4) < AGREES


@pytest.mark.parametrize("name", tiers(["forced_rigid_body", "heisenberg_chain", "product", "cubic_lattice", TRACERS], (),
                                       ("forced_rigid_body",)))
def test_in_double_precision(name):
    """The build that users run: round-off of a double away from the long-double one."""
    case = begin(name)
    step = long_step(case)
    w = polished(generic_state(step, case).astype(float).astype(np.longdouble), leaves_of(case).radius)
    v = np.random.default_rng(3).standard_normal((2, *w.shape))
    expected = step.tangent(w, v.astype(np.longdouble))
    one = smidgen.build(case.spec, parameters=case.values, features=TANGENT)
    one.start(w.astype(float), h=case.h, t0=0.3).step()
    assert np.abs(one.tangent(v) - expected).max() < 1e-13 * np.abs(expected).max()


@pytest.mark.parametrize("feature", sorted(set(ANYWHERE) - {"tangent"}))
@pytest.mark.parametrize("name", tiers(["forced_rigid_body", "product"], (), ("forced_rigid_body",)))
def test_beside_other_features(name, feature):
    beside(name, feature)


def test_beside_other_features_of_a_lattice():
    beside("heisenberg_chain", "distributed")


def beside(name, feature):
    case = begin(name)
    one = smidgen.build(case.spec, parameters=case.values, features=("tangent", feature))
    alone = smidgen.build(case.spec, parameters=case.values, features=TANGENT)
    v = np.random.default_rng(0).standard_normal((2, *case.w.shape))
    expected, found = (m.start(case.w.copy(), h=case.h).push_forward(v.copy(), 3) for m in (alone, one))
    assert np.abs(found - expected).max() < 1e-13 * np.abs(expected).max()


# -- the symplectic form ------------------------------------------------------------------------

@pytest.mark.parametrize("name", tiers([n for n in SPECS if n not in (TRACERS, *LATTICES)], (),
                                       ("forced_rigid_body", "nambu_a34", "product", "heisenberg_chain")))
def test_the_tangent_map_is_symplectic(name):
    case = begin(name, **({"n": 12} if "chain" in name or "landau" in name else {}))
    step = long_step(case)
    assert poisson_gap(step, case, generic_state(step, case)) < 1e-15


@quick
@pytest.mark.parametrize("name", ["forced_rigid_body", pytest.param("irreversible_rigid_body", marks=pytest.mark.long), "nambu_a34"])
def test_that_of_the_classical_midpoint_is_not(name):
    case = begin(name)
    step = long_step(case, CLASSICAL)
    assert poisson_gap(step, case, generic_state(step, case)) > 1e-8


# -- faults -------------------------------------------------------------------------------------

def with_fault(case, name):
    """The long-double step that the compiler, at fault now, makes of a case, under a name of its own."""
    spec = dataclasses.replace(scene_of(case.spec, None, case.values), name=name)
    built = build_library(spec, real="long double", features=TANGENT, generate=lambda *a: generate(*a[:3], features=a[3]))
    return Step(Integrator(prepare(spec, SPHERICAL, None, case.values), built), case.h)


def other_hessian(term, *more):
    """derive with d2e/dx dx of all blocks scaled: symmetric still, and so the Hessian of another H."""
    d = derive(term, *more)
    first = sp.diag(sp.Float(1.001), 1, 1)
    return dataclasses.replace(d, hessian={pair: block.multiply_elementwise(sp.ones(3) + first - sp.eye(3))
                                           for pair, block in d.hessian.items()})


def other_sign(term, *more):
    """derive with one component of the gradient of the wrong sign, and the Hessian that belongs to it: that of no H."""
    d = derive(term, *more)
    first = d.gradient[0]
    gradient = ((first[0], -first[1], first[2]), *d.gradient[1:])
    return dataclasses.replace(d, gradient=gradient, hessian=hessian_blocks(gradient, d.vectors, Whole()))


@quick
def test_a_wrong_hessian_is_found_by_differences_and_by_nothing_else(monkeypatch):
    """The step still converges to the right solution, and the tangent map is that of the step of another H."""
    monkeypatch.setattr(smidgen.compile.assemble.same_bonds, "derive", other_hessian)
    case = begin("two_bodies")
    step = with_fault(case, "wrong_hessian")
    w = generic_state(step, case)
    assert poisson_gap(step, case, w) < 1e-15
    assert gap(step, case, w) > 100 * AGREES


@quick
def test_a_wrong_gradient_is_found_by_the_symplectic_form(monkeypatch):
    """Its Hessian blocks are its own derivatives, so that differences see nothing."""
    monkeypatch.setattr(smidgen.compile.assemble.same_bonds, "derive", other_sign)
    case = begin("two_bodies")
    step = with_fault(case, "wrong_gradient")
    w = generic_state(step, case)
    assert gap(step, case, w) < AGREES
    assert poisson_gap(step, case, w) > 1e-6


# -- the interface ------------------------------------------------------------------------------

def spins(solver="auto", **more):
    case = begin("heisenberg_chain", n=12)
    return smidgen.build(case.spec, parameters=case.values, solver=solver, features=TANGENT, **more), case


@pytest.mark.parametrize("name, solver", [("forced_rigid_body", "auto"), *(
    pytest.param(name, solver, marks=pytest.mark.long) for name, solver in (
        ("heisenberg_chain", "newton"), ("heisenberg_chain", "auto"), ("cubic_lattice", "auto"), ("point_vortices", "newton"), ("two_bodies", "plain"), (TRACERS, "auto")))])
def test_the_steps_keep_their_bits(name, solver):
    """With or without the feature, with or without calls between the steps."""
    case = begin(name)
    plain = smidgen.build(case.spec, parameters=case.values, solver=solver).start(case.w.copy(), h=case.h)
    one = smidgen.build(case.spec, parameters=case.values, solver=solver, features=TANGENT).start(case.w.copy(), h=case.h)
    v = np.random.default_rng(0).standard_normal((2, *case.w.shape))
    for _ in range(30):
        plain.step()
        one.step().tangent(v)
        assert np.array_equal(one.w, plain.w) and one.report() == plain.report()


@pytest.mark.parametrize("solver", tiers(["newton", "rotation"], (), ("newton",)))
def test_columns_are_carried_one_by_one(solver):
    model, case = spins(solver)
    model.start(case.w.copy(), h=case.h).steps(3)
    v = np.random.default_rng(0).standard_normal((3, *case.w.shape))
    together = model.tangent(v.copy())
    assert np.array_equal(together, [model.tangent(one.copy()) for one in v])
    sums = model.tangent(v[0] - 2 * v[1])
    assert np.abs(sums - (together[0] - 2 * together[1])).max() < 1e-14 * np.abs(together).max()
    assert model.tangent(v[:0].copy()).shape == (0, *case.w.shape)


@pytest.mark.parametrize("scale", [1e-290, 1e290])
@pytest.mark.parametrize("solver", ["newton", "rotation"])
def test_the_size_of_a_vector_does_not_matter(solver, scale):
    model, case = spins(solver)
    model.start(case.w.copy(), h=case.h).step()
    v = np.random.default_rng(0).standard_normal(case.w.shape)
    assert np.abs(model.tangent(v * scale) / scale - model.tangent(v.copy())).max() < 1e-13


def test_carry_is_step_and_tangent_in_turn():
    model, case = spins()
    v = np.random.default_rng(0).standard_normal((2, *case.w.shape))
    expected, w = v.copy(), model.start(case.w.copy(), h=case.h)
    for _ in range(5):
        w.step().tangent(expected)
    after = w.w.copy()
    found = model.start(case.w.copy(), h=case.h).push_forward(v, 5)
    assert found is v and model.count == 5
    assert np.array_equal(v, expected) and np.array_equal(model.w, after)


@quick
def test_arrays_of_other_shapes_and_types():
    case = begin("forced_rigid_body")
    model = smidgen.build(case.spec, features=TANGENT)
    with pytest.raises(UsageError, match="no trajectory"):
        model.tangent(np.eye(3)[:1])
    model.start(case.w.copy(), h=case.h)
    with pytest.raises(UsageError, match="no step has been taken"):
        model.tangent(np.eye(3)[:1])
    model.step()
    expected = model.tangent(np.eye(3)[:, None])
    assert np.array_equal(model.tangent([[1, 0, 0]]), expected[0])
    fixed = np.eye(3)[1:2]
    fixed.flags.writeable = False
    assert np.array_equal(model.tangent(fixed), expected[1])
    for wrong in (np.eye(3), np.zeros(3), np.zeros((1, 1, 1, 3)), "no numbers"):
        with pytest.raises(UsageError):
            model.tangent(wrong)
    with pytest.raises(UsageError, match="must not be negative"):
        model.push_forward(expected, -1)
    with pytest.raises(UsageError, match="features"):
        smidgen.build(case.spec).start(case.w.copy(), h=case.h).step().tangent(np.eye(3)[:1])


@pytest.mark.parametrize("solver", ["newton", "rotation"])
def test_what_is_not_finite_is_said_and_leaves_v(solver):
    model, case = spins(solver)
    model.start(case.w.copy(), h=case.h).step()
    for bad in (np.nan, np.inf):
        v = np.ones((2, *case.w.shape))
        v[1, 4, 1] = bad
        before = v.copy()
        with pytest.raises(RunError, match="tangent map of step 1"):
            model.tangent(v)
        assert np.array_equal(v, before, equal_nan=True)
    assert np.isfinite(model.step().tangent(np.ones(case.w.shape))).all()


REST = """
[model]
name = "bodies_at_rest"
[space]
w = { r3 = 2 }
[effects.rotation]
over = "site(i)"
energy = "w[i].x/2 + w[i].y/3"
[starts.first]
vectors = [[0.3, -0.4, 0.9], [1, 0, 0]]
[runs.demo]
start = "first"
h = 0.2
time = 5
"""


def test_a_body_at_rest_has_no_derivative():
    """At w = 0 the midpoint |w| mbar/|mbar| of the method on R^3 depends on the direction of w; mbar does not."""
    case = begin(texts.read(REST))
    w = case.w * [[1], [0]]
    model = smidgen.build(case.spec, features=TANGENT).start(w.copy(), h=case.h).step()
    with pytest.raises(RunError, match="singular: site 1 is the zero vector of R.3.*classical-midpoint") as caught:
        model.tangent(np.ones((2, 3)))
    assert caught.value.status == 7 and caught.value.site == 1
    classical = smidgen.build(case.spec, method=CLASSICAL, features=TANGENT).start(w, h=case.h).step()
    turned = classical.tangent(np.ones((2, 3)))[1]      # about the field, by a rotation
    assert np.linalg.norm(turned) == pytest.approx(np.sqrt(3), rel=1e-14) and turned[0] != 1


# -- the C --------------------------------------------------------------------------------------

DRIVER = """
#include <stdio.h>
#include <stdlib.h>
#include "{name}.h"

int main(void) {{
  static const double start[] = {{ {start} }};
  const int64_t size = (int64_t)(sizeof start / sizeof *start);
  {name}_params p;
  {name}_model model;
  {name}_state s;
  {name}_defaults(&p);
  {assign}
  if ({name}_model_init(&model, &p) != SMG_OK) return 1;
  void *mem = malloc({name}_memsize(&model)), *more = malloc({name}_tangent_memsize(&model));
  smg_real *w = (smg_real *)malloc(sizeof(smg_real) * (size_t)size), *v = (smg_real *)malloc(sizeof(smg_real) * 2 * (size_t)size);
  for (int64_t k = 0; k < size; ++k) w[k] = start[k];
  for (int64_t k = 0; k < 2 * size; ++k) v[k] = 1;
  smg_status status = {name}_init(&s, &model, mem, w, 0.25, {h});
  if (status != SMG_OK) return 1;
  if ({name}_tangent(&s, v, 2, more) != SMG_BAD_PARAMETER) return 2;
  for (int k = 0; k < 5 && status == SMG_OK; ++k) {{
    status = {name}_step(&s);
    if (status == SMG_OK) status = {name}_tangent(&s, v, 2, more);
  }}
  if (status != SMG_OK) return 3;
  s.h *= {stretch};
  status = {name}_tangent(&s, v, 2, more);
  printf("%s\\n", smg_message(status));
  free(mem);
  free(more);
  free(w);
  free(v);
  return 0;
}}
"""


def written(case, where, method=SPHERICAL, solver="auto"):
    """The generated files with the feature, written; returns their names that end in .c."""
    files = generate(scene_of(case.spec, None, case.values), method, solver, features=TANGENT)
    for name, text in files.items():
        (where / name).write_text(text)
    return [name for name in files if name.endswith(".c")]


PLANS = [("free_rigid_body", SPHERICAL, "auto"), ("free_rigid_body", VESELOV, "auto"), ("nambu_a34", CLASSICAL, "auto"),
         ("heisenberg_chain", SPHERICAL, "auto"), ("j1j2_chain", CLASSICAL, "newton"), ("product", SPHERICAL, "newton"),
         ("product", SPHERICAL, "rotation"), ("honeycomb", SPHERICAL, "auto"), ("cubic_lattice", CLASSICAL, "auto"),
         ("two_bodies", SPHERICAL, "plain"), (TRACERS, SPHERICAL, "auto"), (TRACERS, CLASSICAL, "plain")]
CLEAN = [PLANS[k] for k in (0, 3, 5, 8)]     # compiled in `make test`


@pytest.mark.parametrize("compiler", FEW_COMPILERS)
@pytest.mark.parametrize("name, method, solver", [pytest.param(*plan, marks=() if plan in CLEAN else pytest.mark.long) for plan in PLANS])
def test_compiles_without_a_warning(name, method, solver, compiler, tmp_path):
    sources = written(begin(name), tmp_path, method, solver)
    for real in REALS:
        assert compile_all(tmp_path, sources, compiler, real=real) == ""


@pytest.mark.parametrize("compiler", FEW_COMPILERS)
def test_a_graph_compiles_without_a_warning(compiler, tmp_path):
    case = begin(texts.read(texts.GLASS, tmp_path))
    for solver in ("newton", "rotation", "plain"):
        assert compile_all(tmp_path, written(case, tmp_path, solver=solver), compiler) == ""


@pytest.mark.parametrize("name, solver, values", [("heisenberg_chain", "newton", {"n": 8}), pytest.param("two_bodies", "newton", {}, marks=pytest.mark.long),
                                                  pytest.param("product", "rotation", {}, marks=pytest.mark.long),
                                                  (TRACERS, "auto", {"m": 4}), ("forced_rigid_body", "auto", {})])
def test_runs_clean_under_the_sanitizers(name, solver, values, tmp_path):
    assert sanitized(begin(name, **values), tmp_path, solver, 1, values) == "ok"


@pytest.mark.parametrize("name, solver, stretch, values", [("product", "plain", 100, {}),
                                                           pytest.param(TRACERS, "rotation", 300, {"m": 2}, marks=pytest.mark.long)])
def test_where_sweeps_do_not_settle_columns_are_carried(name, solver, stretch, values, tmp_path):
    """A step many times as large, whose matrix the sweeps do not contract for: GMRES needs no contraction."""
    assert sanitized(begin(name, **values), tmp_path, solver, stretch, values) == "ok"


def sanitized(case, where, solver, stretch, values):
    """What the driver says, h replaced by stretch*h before its last call."""
    sources = [s for s in written(case, where, solver=solver) if not s.endswith("_abi.c")]
    (where / "driver.c").write_text(DRIVER.format(
        name=case.spec.name, start=", ".join(repr(float(x)) for x in case.w.ravel()), h=repr(case.h), stretch=stretch,
        assign="\n  ".join(f"p.{in_c(n)} = {v};" for n, v in values.items())))
    status, said = run_sanitized(where, [*sources, "driver.c"])
    assert status == 0, said
    return said.strip()


@quick
@pytest.mark.parametrize("name", ["free_rigid_body", "product", "heisenberg_chain"])
def test_nothing_of_it_is_there_unasked(name):
    spec = begin(name).spec
    without, asked = generate(spec), generate(spec, features=TANGENT)
    for file, text in without.items():
        assert "tangent(" not in text and "variation" not in text
        kept = iter(asked[file].splitlines())
        assert all(line in kept for line in text.splitlines()), file     # the same lines, in order
