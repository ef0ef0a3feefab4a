"""Another w between steps, by m_set_state and by what is written into `w`: the state as if it had begun there, whatever the layout."""
import subprocess

import numpy as np
import pytest
import smidgen
from smidgen.compile.emit.emit import generate
from smidgen.errors import ReadOnlyError, RunError, UsageError
from smidgen.methods import METHODS
from smidgen.resources import include_flags
from smidgen.run.step.saved import COUNT_HIGH, COUNT_LOW, HEAD, HISTORY, PAST
from smidgen.run.step.start import initial_state
from support.exact import rotation
from support.strict import WARNINGS
from support.systems import begin, tiers
from test_methods import MIX
from test_row_blocks import SPECS as BLOCKS
from test_pair_rows import SPECS as PAIRS
from test_rows import EXCHANGE, SPECS as ROWS, lattice
from test_rows_any_formula import SPECS as ANY
from test_rows_by_site import BLOCKS as SITED_BLOCKS, SOME as SITED
from test_rows_far import SPECS as FAR
from test_rows_growing import SPECS as GROWING
from test_rows_held import SOME as HELD
from test_rows_in_time import SPECS as IN_TIME
from test_rows_laws import SOME as LAWS
from test_rows_radii import SPECS as RADII
from test_rows_torques import spec_of as pushed
from test_sublattice_rows import SPECS as TURNS

FREE = """[model]
name = "apart"
[space]
w = { r3 = 2 }
[effects.field]
over = "site(i) of w"
energy = "-w[i].z"
[starts.a]
vectors = [[1, 0, 0.5], [0, 1, 0.5]]
"""
# name -> (spec, method, h): one a layout
LAYOUTS = {
    "single sphere": ("forced_rigid_body", "spherical-midpoint", 0.3), "single sphere composed": ("forced_rigid_body", "spherical-midpoint-6", 0.3),
    "divided": ("free_rigid_body", "moser-veselov", 0.3), "nambu": ("nambu_a34", "spherical-midpoint", 0.05), "composed": ("two_bodies", "spherical-midpoint-4", 0.2),
    "dense": ("two_bodies", "spherical-midpoint", 0.3), "few in lanes": ("point_vortices", "spherical-midpoint", 0.1),
    "tracers": ("vortex_tracers", "spherical-midpoint", 0.05), "band": ("heisenberg_chain", "classical-midpoint", 0.3),
    "rows": (ROWS["odd cubic"], "spherical-midpoint", 0.05), "ring by rows": (ROWS["ring of 33"], "spherical-midpoint", 0.05),
    "sweeps, then Newton": (ROWS["ring of 17"], "spherical-midpoint", 1.0), "blocks": (BLOCKS["ring"][0], "spherical-midpoint", 0.1),
    "three colours": (ROWS["three colours"], "spherical-midpoint", 0.05),
    "rows by site, in time": (SITED, "spherical-midpoint", 0.05), "blocks by site, in time": (SITED_BLOCKS, "spherical-midpoint", 0.05), "gauss by site": (SITED, "gauss-4", 0.05),
    "sublattices by rows": (TURNS["square"], "sublattice-rotations", 0.1), "sublattices composed": (TURNS["square"], "sublattice-rotations-4", 0.1),
    "pairs by rows": (PAIRS["square"], "pair-rotations", 0.1), "pairs": (lattice("pentagon", "chain(n, periodic)", 5, "n", EXCHANGE), "pair-rotations", 0.1),
    "axes": ("free_rigid_body", "axis-splitting", 0.2), "gauss": (MIX, "gauss-6", 0.1), "gauss by rows": (TURNS["square"], "gauss-6", 0.1),
    "dop853": (MIX, "dop853", 0.3), "dop853 alone": ("free_rigid_body", "dop853-projected", 1.0), "extrapolation": (MIX, "extrapolation-12", 0.1),
    "composed by rows": (IN_TIME["damped"], "spherical-midpoint-4", 0.1), "classical by rows": (IN_TIME["open square"], "classical-midpoint", 0.05),
    "dop853 by rows": (SITED, "dop853", 0.3), "dop853-projected by rows": (IN_TIME["damped"], "dop853-projected", 0.3), "fixed steps by rows": (SITED, "dormand-prince-8", 0.02),
    "extrapolation by rows": (IN_TIME["damped"], "extrapolation-12", 0.1), "responses by site": (LAWS, "spherical-midpoint", 0.05),
    "torques by rows": (pushed("three colours", "all"), "spherical-midpoint", 0.05), "radii by site": (RADII["open"], "spherical-midpoint", 0.05),
    "held sites": (HELD, "spherical-midpoint", 0.05), "held sites of stages": (HELD, "gauss-4", 0.05), "other formulas": (ANY["cubic"], "spherical-midpoint", 0.05),
    "growing": (GROWING["growing"], "spherical-midpoint", 0.1), "several shells": (FAR["third"], "spherical-midpoint", 0.05), "heun": (ROWS["ring of 17"], "heun", 0.05),
    "one stage": (MIX, "isospectral-midpoint", 0.1), "two points": (MIX, "rattle", 0.1), "explicit": (MIX, "cf4", 0.1),
}
LATE = ("rows", "three colours", "composed", "nambu", "sublattices composed", "divided", "explicit",
        "composed by rows", "classical by rows", "dop853-projected by rows", "fixed steps by rows", "extrapolation by rows", "responses by site", "torques by rows",
        "radii by site", "held sites", "held sites of stages", "other formulas", "growing", "several shells", "heun")
SOME = ("single sphere", "few in lanes", "ring by rows", "pairs by rows", "gauss by rows", "dop853", "one stage")


def bits(x) -> bytes:
    return np.asarray(x).tobytes()


def spec_of(one):
    return smidgen.load(one) if isinstance(one, str) else one


def start_of(spec):
    return begin(spec).w if spec.runs else initial_state(spec, spec.starts[0].name)


def kicked(w, angle=0.7):
    """Every vector turned about the axis (1, 2, 2)/3."""
    axis = np.array([1.0, 2.0, 2.0]) / 3
    along = np.outer(w @ axis, axis)
    return np.cos(angle) * (w - along) + np.sin(angle) * np.cross(axis, w) + along


def fresh(model, w, h, count):
    """A trajectory that begins at w, told that it has taken `count` steps."""
    saved = model.start(w.copy(), h=h).save()
    saved[COUNT_HIGH], saved[COUNT_LOW] = divmod(count, 2 ** 32)
    return model.restore(saved)


def remembered(model) -> bytes:
    """What a saved state has before the increments of the steps before, of which only so many count as it says."""
    saved = model.save()
    return bits(saved[:int(saved[PAST])])


@pytest.mark.parametrize("name", tiers(LAYOUTS, SOME, [n for n in LAYOUTS if n not in LATE]))
def test_a_written_state_is_a_beginning(name):
    """Bit for bit: neither history nor compensation of the steps before is left, at any place in the history."""
    one, method, h = LAYOUTS[name]
    model, other = (smidgen.build(spec_of(one), method=method) for _ in range(2))
    w, taken = start_of(spec_of(one)), 0
    model.start(w.copy(), h=h)
    for before, after in ((5, 20), (1, 3), (17, 12)):
        model.steps(before)
        model.w[:] = kicked(model.w)
        given, taken = model.w.copy(), taken + before
        fresh(other, given, h, taken)
        assert remembered(model) == remembered(other)
        for steps in (1, after):
            assert remembered(model.steps(steps)) == remembered(other.steps(steps))
            assert bits(model.w) == bits(other.w) and model.t == other.t
        taken += 1 + after


def test_every_function_sees_what_was_written():
    model = smidgen.build(smidgen.load("free_rigid_body")).start(h=0.1).steps(3)
    w = kicked(model.w)
    wanted = smidgen.build(smidgen.load("free_rigid_body")).start(w.copy(), h=0.1)
    for look in ("energy", "values", "casimirs", "field", "state"):
        model.w[:] = w
        assert bits(getattr(model, look)()) == bits(getattr(wanted, look)())
        model.w[:] = kicked(w)
        model.w[:] = w
    assert model.save()[HISTORY] == 0 and bits(model.save()[HEAD:HEAD + 3]) == bits(w)


def test_what_cannot_be_a_state_is_refused_and_the_state_stays():
    model = smidgen.build(smidgen.load_text(FIELD)).start(h=0.1).steps(5)
    kept = model.w.copy()
    saved = model.save()
    for wrong, said in ((1.1, "site 1"), (np.nan, "not finite"), (0.0, "off manifold")):
        model.w[1] = kept[1] * wrong
        for act in (model.step, model.energy, model.save, model.values, lambda: model.advance(2)):
            with pytest.raises(UsageError, match=said):
                act()
        model.w[:] = kept
        assert bits(model.save()) == bits(saved)      # the same w: nothing was written
    with pytest.raises(ReadOnlyError, match="write to w"):
        model.w = kept
    model.w[1] *= 1 + 1e-13
    assert abs(np.linalg.norm(model.step().w[1]) - 1) < 5e-16


def test_the_tangent_map_of_a_step_ends_where_w_is_written():
    model = smidgen.build(smidgen.load("two_bodies"), features=("tangent",)).start(h=0.1).steps(5)
    v = np.ones_like(model.w)
    model.tangent(v.copy())
    model.w[:] = kicked(model.w)
    with pytest.raises(RunError, match="no step has been taken"):
        model.tangent(v.copy())
    model.push_forward(v, 2)


@pytest.mark.quick
def test_a_step_goes_to_the_same_array():
    w = start_of(smidgen.load("free_rigid_body"))
    model = smidgen.build(smidgen.load("free_rigid_body")).start(w, h=0.1)
    for take in (model.steps, model.advance):
        before = w.copy()
        take(2)
        assert model.w is w and bits(w) == bits(model.state()) != bits(before)


FIELD = """
[model]
name = "top_in_field"
[space]
w = { sphere = 2 }
[effects.rotation]
over = "site(i) of w"
energy = "(w[i].x^2 + w[i].y^2/2 + w[i].z^2/4)/2"
[effects.coupling]
energy = "0.3*dot(w[0], w[1])"
[effects.field]
over = "site(i) of w"
energy = "0.8*w[i].z"
[starts.a]
theta = "0.5 + i"
phi = 0.2
"""


@pytest.mark.quick
@pytest.mark.parametrize("method", ["spherical-midpoint", "gauss-4", "dop853", "extrapolation-12", "cf4"])
def test_a_splitting_with_a_map_of_the_user(method):
    """Strang: half a turn in the field, a step of the rest, half a turn. Halving h divides the error by 4, against the whole by an integrator of order 12."""
    spec, T = smidgen.load_text(FIELD), 2.0
    exact = smidgen.build(spec, method="extrapolation-12").start("a", h=T / 200).steps(200).w
    model, errors = smidgen.build(spec, method=method, effects=["rotation", "coupling"]), []
    for steps in (20, 40, 80):
        h = T / steps
        model.start("a", h=h)
        half = rotation([0, 0, 1], -0.8 * h / 2)
        for _ in range(steps):
            model.w[:] = model.w @ half.T
            model.step()
            model.w[:] = model.w @ half.T
        errors.append(np.abs(model.state() - exact).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.abs(orders - 2).max() < 0.1, (errors, orders)
    assert np.abs(np.linalg.norm(model.w, axis=1) - 1).max() < 1e-14 * (1 if METHODS[method].keeps_leaf else 1e3)


def test_what_steps_moved_off_its_sphere_may_be_written():
    """|w| of an explicit method drifts; what is as far off is put back."""
    model = smidgen.build(MIX, method="extrapolation-12").start("a", h=0.5).steps(20)
    off = np.abs(np.linalg.norm(model.w[:3], axis=1) - 2)
    assert off.max() > 1e-10
    model.w[:] = kicked(model.w)
    assert np.abs(np.linalg.norm(model.state()[:3], axis=1) - 2).max() < 5e-16 * 2
    model.w[0] *= 1 + 1e-11
    with pytest.raises(UsageError, match="site 0"):
        model.step()


EDGES = """
#include "{M}.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHECK(what) if (!(what)) return printf("%s\\n", #what), 1

int main(void) {{
  {M}_params p;
  {M}_model model;
  {M}_state s;
  {M}_defaults(&p);
  CHECK({M}_model_init(&model, &p) == SMG_OK);
  const size_t n = 3 * (size_t){M}_sites(&model), size = {M}_savesize(&model);
  smg_real *w = malloc(n * sizeof *w), *one = malloc(size * sizeof *one), *other = malloc(size * sizeof *other);
  void *mem = malloc({M}_memsize(&model));
  for (size_t k = 0; k < n; ++k) w[k] = k % 3 == 0 ? 0.6 : k % 3 == 1 ? 0 : k % 2 ? 0.8 : -0.8;
  CHECK({M}_init(&s, &model, mem, w, 0, 1e-310) == SMG_BAD_PARAMETER);
  CHECK({M}_init(&s, &model, mem, w, 0, 0) == SMG_OK); /* no motion, and its saved state is one */
  {M}_save(&s, one);
  CHECK({M}_restore(&s, one) == SMG_OK);
  CHECK({M}_init(&s, &model, mem, w, 0, 0.1) == SMG_OK && {M}_steps(&s, 5) == SMG_OK);
  {M}_save(&s, one);
  const int64_t none[] = {{INT64_MIN, -1, 0}};
  for (int k = 0; k < 3; ++k) CHECK({M}_steps(&s, none[k]) == SMG_OK && s.count == 5);
  {M}_save(&s, other);
  CHECK(memcmp(one, other, size * sizeof *one) == 0);

  memcpy(w, s.w, n * sizeof *w);
  const smg_real wrong[] = {{0, 2, (smg_real)NAN, (smg_real)INFINITY}};
  for (int k = 0; k < 4; ++k) {{
    for (size_t b = n - 3; b < n; ++b) w[b] = wrong[k] * s.w[b];
    CHECK({M}_set_state(&s, w) == (k < 2 ? SMG_OFF_MANIFOLD : SMG_NOT_FINITE) && s.report.site == (int64_t)n / 3 - 1);
    {M}_save(&s, other);
    CHECK(memcmp(one, other, size * sizeof *one) == 0);
  }}
  const double never[] = {{-1e-12, 1, NAN}};
  for (int k = 0; k < 3; ++k) CHECK({M}_set_tolerance(&s, never[k]) == SMG_BAD_PARAMETER);
  {M}_save(&s, other);
  CHECK(memcmp(one, other, size * sizeof *one) == 0);
  memcpy(w, s.w, n * sizeof *w);
  CHECK({M}_set_state(&s, w) == SMG_OK && s.count == 5 && {M}_step(&s) == SMG_OK && s.count == 6);
  s.w[0] = -s.w[0];
  CHECK({M}_set_state(&s, s.w) == SMG_OK && {M}_step(&s) == SMG_OK);

  {M}_model bad;
  p.{p} = {value};
  CHECK({M}_model_init(&bad, &p) != SMG_OK);
  CHECK({M}_init(&s, &bad, mem, w, 0, 0.1) != SMG_OK && {M}_set_state(&s, w) == SMG_BAD_PARAMETER && {M}_restore(&s, one) == SMG_BAD_PARAMETER);
  free(w), free(one), free(other), free(mem);
  return 0;
}}
"""
IN_C = {"free_rigid_body": ("spherical-midpoint", "I1", "NAN"), "heisenberg_chain": ("spherical-midpoint", "n", "1"), "free_rigid_body projected": ("dop853-projected", "I1", "NAN"), "heisenberg_chain turned": ("sublattice-rotations", "n", "1"), "heisenberg_chain in stages": ("gauss-6", "n", "1")}


@pytest.mark.parametrize("name", tiers(IN_C, (), ("free_rigid_body", "heisenberg_chain")))
def test_edges_in_c(tmp_path, name):
    """What init refuses, set_state, restore and check refuse; numbers of steps below 1; under sanitizers."""
    spec, (method, parameter, value) = smidgen.load(name.split()[0]), IN_C[name]
    for file, text in generate(spec, method=method).items():
        (tmp_path / file).write_text(text)
    (tmp_path / "main.c").write_text(EDGES.format(M=spec.name, p=parameter, value=value))
    flags = [*WARNINGS, "-Wno-psabi", "-std=c11", "-O0", "-g", "-ffp-contract=off", "-fsanitize=undefined,address", "-fno-sanitize-recover=all"]
    subprocess.run(["gcc", *flags, *include_flags(), "-I.", "main.c", f"{spec.name}.c", "-o", "main", "-lm"], cwd=tmp_path, check=True)
    said = subprocess.run(["./main"], cwd=tmp_path, capture_output=True, text=True)
    assert said.returncode == 0, said.stdout + said.stderr


MEMBERS = """
#include "{M}.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {{ N = 11 }};

static void kick(smg_real *w) {{
  const smg_real x = w[0];
  w[0] = w[1], w[1] = w[2], w[2] = x;
}}

/* Members in lanes, some of them kicked, two refused, which then take no more steps until one is restored and the other set again: the bits of
 * states alone. */
int main(void) {{
  {M}_params p;
  {M}_model model;
  {M}_ensemble e;
  {M}_state s;
  smg_real w[3 * N], none[3] = {{0, 0, 0}}, v[3];
  {M}_defaults(&p);
  if ({M}_model_init(&model, &p)) return 1;
  for (int k = 0; k < N; ++k) w[3 * k] = 0.6, w[3 * k + 1] = 0.8 * cos(k), w[3 * k + 2] = 0.8 * sin(k);
  void *mem = malloc({M}_ensemble_memsize(&model, 0, N)), *own = malloc({M}_memsize(&model));
  smg_real *saved = malloc({M}_savesize(&model) * sizeof *saved);
  if ({M}_ensemble_init(&e, &model, 0, N, mem, w, 0, 0.3) || {M}_ensemble_steps(&e, 0, N, INT64_MIN) || {M}_ensemble_steps(&e, 0, N, 17)) return 1;
  for (int k = 0; k < N; k += 2) {{
    memcpy(v, e.member[k].w, sizeof v);
    kick(v);
    if ({M}_set_state(&e.member[k], v)) return 2;
  }}
  {M}_save(&e.member[3], saved);
  if ({M}_set_state(&e.member[3], none) != SMG_OFF_MANIFOLD || {M}_restore(&e.member[3], saved) || e.member[3].report.site != -1) return 7;
  if ({M}_set_state(&e.member[1], none) != SMG_OFF_MANIFOLD || {M}_ensemble_steps(&e, 0, N, 21) != 1 || e.member[1].count != 17) return 3;
  memcpy(v, e.member[1].w, sizeof v);
  if ({M}_set_state(&e.member[1], v) || {M}_ensemble_steps(&e, 0, N, 5) != 0 || e.member[1].count != 22) return 4;
  for (int k = 0; k < N; ++k) {{
    if ({M}_init(&s, &model, own, w + 3 * k, 0, 0.3) || {M}_steps(&s, 17)) return 5;
    memcpy(v, s.w, sizeof v);
    if (k % 2 == 0) kick(v);
    if ((k % 2 == 0 || k == 1) && {M}_set_state(&s, v)) return 6;
    if ({M}_steps(&s, k == 1 ? 5 : 26) || s.count != e.member[k].count || memcmp(s.w, e.member[k].w, sizeof v)) return 10 + k;
  }}
  free(mem), free(own), free(saved);
  return 0;
}}
"""


@pytest.mark.parametrize("method", ["spherical-midpoint", "dop853", "extrapolation-12"])
def test_members_of_an_ensemble(tmp_path, method):
    for file, text in generate(smidgen.load("irreversible_rigid_body"), method=method, features=("ensemble",)).items():
        (tmp_path / file).write_text(text)
    (tmp_path / "main.c").write_text(MEMBERS.format(M="irreversible_rigid_body"))
    flags = ["-Wno-psabi", "-std=c11", "-O1", "-ffp-contract=off", "-fno-math-errno", "-fsanitize=undefined", "-fno-sanitize-recover=all", "-DSMG_LANES=4"]
    subprocess.run(["gcc", *flags, *include_flags(), "-I.", "main.c", "irreversible_rigid_body.c", "-o", "main", "-lm"], cwd=tmp_path, check=True)
    said = subprocess.run(["./main"], cwd=tmp_path, capture_output=True, text=True)
    assert said.returncode == 0, (said.returncode, said.stderr)


@pytest.mark.parametrize("method, h", [("spherical-midpoint", 0.1), ("spherical-midpoint", 50), ("spherical-midpoint-4", 0.1), ("classical-midpoint", 0.1)])
def test_a_site_of_r3_that_is_set_to_0_stays_there(method, h):
    """Whatever its increments were before."""
    one = smidgen.build(smidgen.load_text(FREE), method=method).start("a", h=h).steps(20)
    one.w[0] = 0
    assert not one.steps(1).w[0].any() and not one.steps(20).w[0].any() and one.w[1].any()
