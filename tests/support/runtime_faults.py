"""Faults of the runtime, each in one layout or one place only, and the row of a certificate that must say no.

A fault is a line of a header of runtime/ and what stands there instead; `Faulty` compiles with a copy of the runtime that has it.
"""
import shutil
from dataclasses import dataclass, field

import smidgen
from smidgen import resources
from smidgen.build import binary
from smidgen.check.verify.case import Case
from smidgen.check.verify.subject import Emitted
from smidgen.run.step.integrator import build
from smidgen.run.settings import settle

BODY, CHAIN, CUBIC = ("free_rigid_body", {}), ("heisenberg_chain", {"n": 40}), ("cubic_lattice", {})
WARM = """
[model]
name = "warm"
[space]
w = { sphere = 2 }
[effects.pair]
energy = "dot(w[0], w[1]) + 0.4*w[0].z^2"
[effects.bath]
over = "site(i) of w"
damping = 0.3
kT = 0.5
[starts.a]
random = 3
[runs.a]
start = "a"
h = 0.05
steps = 20
"""
RING = ("heisenberg_chain", {"n": 640})      # long enough for wavefronts of the smallest blocks
LATTICE = """
[model]
name = "planted"
[space]
w = {{ sphere = "n*n"{sphere} }}
[parameters]
n = 8
[effects.exchange]
over = "bond(i, j) of square(n, n, periodic)"
energy = "-0.7*dot(w[i], w[j])"
{more}
[starts.a]
random = 3
[runs.a]
start = "a"
h = 0.08
steps = 30
"""


def planted(more="", sphere="") -> tuple:
    """A lattice by rows with further effects."""
    return LATTICE.format(more=more, sphere=sphere), {}


FIELD = '[effects.field]\nover = "site(i) of w"\nenergy = "-0.4*{}*w[i].z"\n'
DAMPED = '[effects.bath]\nover = "site(i) of w"\ndamping = "0.1*(1 + mod(i, 3))"\n'
PUSHED = '[effects.push]\nover = "site(i) of w"\ntorque = "0.2*cross(w[i], cross(w[i], vec(0, 1, 0)))"\n'
HOLES = '[effects.holes]\nover = "site(i) of w"\nabsent = "mod(i, 5) == 2"\n'


@dataclass(frozen=True)
class Fault:
    """row: the name of the one that says no; system: a shipped spec, or the text of one, and its values; settings: of the run."""
    row: str
    file: str
    right: str
    wrong: str
    system: tuple
    settings: dict = field(default_factory=dict)
    features: tuple = ()
    more: tuple = ()        # (file, right, wrong) of other lines


LAST = "smg_lane_set({0}, SMG_LANES - 1, (smg_real)1.01 * smg_lane_get({0}, SMG_LANES - 1));"
END = "slot + SMG_LANES >= go.pitch - SMG_BEFORE - SMG_AFTER ? (smg_real)1.01 : (smg_real)1"
ENSEMBLE, CONTROLLED, EXTRAPOLATED = ("ensemble",), {"method": "dop853"}, {"method": "extrapolation-12"}
LONG = {"h": 0.2}       # near the longest step that goes by rows, where sweeps shrink changes least
COMPOSED, DRIVEN = {"method": "spherical-midpoint-4"}, FIELD.format("cos(2*t)")
ALL_SCALED = "for (int b = 0; b < 3; ++b) smg_lane_set({0} + b, SMG_LANES - 1, (smg_real)1.01 * smg_lane_get({0} + b, SMG_LANES - 1));"
SCALED = "smg_lane_set(&{0}, SMG_LANES - 1, (smg_real)1.01 * smg_lane_get(&{0}, SMG_LANES - 1));"
COMMIT, ROWS, SAVED, STATE, HALO = ("smg_row_commit.h", "smg_rows.h", "smg_saved.h", "smg_row_state.h", "smg_row_halo.h")
FAULTS = {
    "increments in the last lane": Fault("ensemble", "smg_lane_sphere.h", "  else smg_lanes_commit(g, &f);", f"  else {{\n    smg_lane_found wrong = f;\n    {LAST.format('&wrong.W.x')}\n    smg_lanes_commit(g, &wrong);\n  }}", BODY, {}, ENSEMBLE),
    "a vector that is not full": Fault("ensemble", "smg_lane_batch.h", "g->live = smg_lane_below(n);", "g->live = smg_lane_below(n > 1 && n < SMG_LANES ? n - 1 : n);", BODY, {}, ENSEMBLE),
    "the last lane of step control": Fault("ensemble", "smg_lane_dop853.h", "  smg_lane_extract(f->w, l, s->w, 3);", "  smg_lane_extract(f->w, l, s->w, 3);\n  s->w[0] *= l == SMG_LANES - 1 ? 1 + 4 * SMG_EPS : 1;", BODY, CONTROLLED, ENSEMBLE),
    "the last lane of extrapolation": Fault("ensemble", "smg_lane_batch.h", "  s->count = g->began[l] + g->taken;\n}", "  s->count = g->began[l] + g->taken - (l == SMG_LANES - 1);\n}", BODY, EXTRAPOLATED, ENSEMBLE),
    "members with parameters of their own": Fault("ensemble", "smg_lane_batch.h", "smg_lane_fill(to, l, smg_lane_at(b->group + k, l, part));", "smg_lane_fill(to, l, smg_lane_at(b->group + k, l == SMG_LANES - 1 ? 0 : l, part));", BODY, {}, ENSEMBLE),
    "a second member, one by one": Fault("ensemble", "smg_ensemble.h", "e->member[k].report.status = smg_steps(e->member + k, count);", "e->member[k].report.status = smg_steps(e->member + k, k == 1 && count > 5 ? count - 1 : count);", CHAIN, {}, ENSEMBLE),
    "the last row": Fault("run", COMMIT, "smg_lane_add_step(3, sum, go.lost_from + slot, go.lost + slot, go.pitch, u);", f"smg_lanes wrong[3];\n  smg_lane_multiple(wrong, smg_lane_of({END}), u, 3);\n  smg_lane_add_step(3, sum, go.lost_from + slot, go.lost + slot, go.pitch, wrong);", CUBIC),
    "the seam of a ring": Fault("run", ROWS, "along < 0 ? x + n : x - n, s) - at->start;", "along < 0 ? x + n : x - n + SMG_ROW_STEP, s) - at->start;", CHAIN),
    "the bound of rows": Fault("by rows", STATE, "#define SMG_ROW_BOUND (smg_real)0.9", "#define SMG_ROW_BOUND (smg_real)45", CUBIC),
    "the tolerance of rows": Fault("tolerance", "smg_row_sweep.h", "* sweep->whole.rate * sweep->whole.now))", "* sweep->whole.rate * sweep->whole.now / 100))", CUBIC, LONG,
                                   more=(("smg_row_step.h", "return smg_tolerated(s, s->report.residual);", "return smg_tolerated(s, s->report.residual / 100);"),)),
    "the end of passes": Fault("settled", "smg_row_sweep.h", "return smg_rest_settled(&sweep->whole, SMG_EPS * scale)", "return smg_rest_settled(&sweep->whole, 1000 * SMG_EPS * scale)", CUBIC, LONG),
    "a weight of degree 3": Fault("predictor", "smg_polynomial.h", "{4, -6, 4, -1}", "{4, -6, 4.1, -1}", CUBIC),
    "a weight of degree 3 of a single sphere": Fault("predictor", "smg_single_sphere.h", "{4, 4, 4, 4, -6, -6, -6, -6, 4, 4, 4, 4, -1, -1, -1, -1}", "{4, 4, 4, 4, -6, -6, -6, -6, 4.1, 4.1, 4.1, 4, -1, -1, -1, -1}", BODY),
    "the order of the history": Fault("iterations", "smg_row_step.h", "  smg_remember(s, SMG_ROW_HISTORY, &s->row_late);", "  smg_remember(s, SMG_ROW_HISTORY, &s->row_late);\n  if (s->history > 2) { smg_real *one = s->past[1]; s->past[1] = s->past[2]; s->past[2] = one; }", CUBIC),
    "a sign after a restore": Fault("restore", SAVED, "  smg_copy(s->w + from, in + SMG_SAVED_HEAD + from, 3 * smg_own_to(&s->c) - from);", "  smg_copy(s->w + from, in + SMG_SAVED_HEAD + from, 3 * smg_own_to(&s->c) - from);\n  s->w[0] = -s->w[0];", BODY),
    "a save without compensation": Fault("restore", SAVED, "  smg_copy(lost, s->compensation, 3 * smg_sites(&s->c));", "  for (int64_t k = 0; k < 3 * smg_sites(&s->c); ++k) lost[k] = 0;", BODY),
    "a restore of rows without compensation": Fault("restore", STATE, "  smg_to_slots(s, lost, s->row_compensation);", "  (void)lost;", CHAIN),
    "a restore without the tolerance": Fault("restore", SAVED, "  (void)smg_set_tolerance(s, (double)in[SMG_SAVED_TOLERANCE]); /* 0: that of the method */", "  s->tolerance = 0;", CUBIC),
    "after t = 9.9": Fault("whole space", "smg_single_sphere.h", "  smg_sphere_commit(s, &f);\n  s->report.iterations = 1;", "  smg_found wrong = f;\n  if (smg_time_at(s, 0) > (smg_real)9.9) wrong.W = smg_vec_add(f.W, smg_vec_scale((smg_real)1e-6, f.v));\n  smg_sphere_commit(s, &wrong);\n  s->report.iterations = 1;", BODY),
    "the second thread": Fault("threads", "smg_row_team.h", "SMG_INLINE smg_share smg_share_of_thread(smg_share all) { return smg_part_of(all, smg_thread(), smg_threads()); }",
                               "SMG_INLINE smg_share smg_share_of_thread(smg_share all) {\n  smg_share part = smg_part_of(all, smg_thread(), smg_threads());\n  if (smg_thread() == 1 && part.to > part.from) part.to -= SMG_WIDEST;\n  return part;\n}", CHAIN),
    "the lag of wavefronts": Fault("wavefronts", "smg_row_wave.h", "wave->lag = (s->row_reach + block - 1) / block + (s->row_team > 1);", "wave->lag = 1;", ("cubic_lattice", {"nx": 6, "ny": 6, "nz": 60})),
    "the ring of wavefronts": Fault("wavefronts", "smg_row_wave.h", "wave->later = SMG_RINGS > 0 || SMG_RANKS > 1 ? wave->lag : 0;", "wave->later = 0;", RING),
    "a bound on the turn of a site": Fault("refusals", "smg_single_sphere.h", "if (!smg_clear_of_branches(n.det) || !(most <= SMG_CONTRACTS)) return SMG_WRONG_BRANCH;", "if (!smg_clear_of_branches(n.det) || !(most <= SMG_CONTRACTS)) return SMG_WRONG_BRANCH;\n      if (most > (smg_real)0.3) return SMG_NO_CONVERGENCE;", BODY,
                                           more=(("smg_single_sphere.h", "    status = smg_site_solve(s, s->c.h, 0);", "    status = SMG_NO_CONVERGENCE;"),)),
    "a solver that gives up": Fault("refusals", "smg_step.h", "  smg_status status = SMG_OK;\n#if SMG_MATRIX_FREE", "  smg_status status = SMG_OK;\n  if (smg_abs(h) > (smg_real)0.5) return SMG_NO_CONVERGENCE;\n#if SMG_MATRIX_FREE", ("two_bodies", {})),
    "the variance of noise": Fault("noise", "smg_thermal.h", "sqrt(2 * (part - part * part / 6))", "sqrt(2 * part)", (WARM, {})),
    "the seed of a save": Fault("noise restored", SAVED, "  s->seed = ", "  s->seed = 1 + ", (WARM, {})),
    "dampings in the last lane": Fault("run", "smg_lane_respond.h", "told.r[k] = smg_lane_take(values + n++ * pitch);",
                                       "{\n      told.r[k] = smg_lane_take(values + n++ * pitch);\n      " + SCALED.format("told.r[k]") + "\n    }", planted(DAMPED)),
    "the torque of the last lane": Fault("run", "smg_row_sweep.h", "  smg_lane_multiple(g, smg_lane_of(turn.half), F, 3);\n", f"  {SCALED.format('Q[1]')}\n  smg_lane_multiple(g, smg_lane_of(turn.half), F, 3);\n", planted(PUSHED)),
    "the radius of the last site": Fault("run", "smg_row_slots.h", "smg_site_value(&s->c, n, site);", "smg_site_value(&s->c, n, site) * (n == SMG_RADIUS_AT && site == smg_sites(&s->c) - 1 ? (smg_real)1.01 : 1);",
                                         planted(sphere=', radius = "1 + mod(i, 2)/2"')),
    "a hole that is felt": Fault("run", "smg_row_arrays.h", "    smg_put_absent(s, 1);\n", "", planted(HOLES)),
    "a stage of rows at the time of the step": Fault("step", "smg_composition.h", "status = smg_solve_composed_stage(s, done + 0.5 * gamma, rows);", "status = smg_solve_composed_stage(s, rows ? 0.5 : done + 0.5 * gamma, rows);",
                                                     planted(DRIVEN), COMPOSED),
    "the last lane of a right side": Fault("step", "smg_field_rows.h", "  smg_first_lanes(in, k);\n", f"  {ALL_SCALED.format('k')}\n  smg_first_lanes(in, k);\n", planted(DRIVEN), CONTROLLED),
    "the last lane of an extrapolated right side": Fault("step", "smg_field_rows.h", "  smg_first_lanes(in, k);\n", f"  {ALL_SCALED.format('k')}\n  smg_first_lanes(in, k);\n", planted(DAMPED), EXTRAPOLATED),
    "the classical midpoint in the last lane": Fault("run", "smg_row_spin.h", "  for (int k = 0; k < 3; ++k) m[k] *= scale;\n", f"  for (int k = 0; k < 3; ++k) m[k] *= scale;\n  {SCALED.format('m[0]')}\n", planted(DRIVEN), {"method": "classical-midpoint"}),
    "Gauss in the last lane": Fault("step", "smg_gauss_sweep.h", "    smg_slot_slopes(a, i, slot, g, z,", f"    {ALL_SCALED.format('g')}\n    smg_slot_slopes(a, i, slot, g, z,", planted(DRIVEN), {"method": "gauss-4"}),
    "a turn in the last lane": Fault("step", "smg_sublattice_rows.h", "  const smg_lanes g[3] = {half * gradient[0], half * gradient[1], half * gradient[2]};\n",
                                     f"  smg_lanes g[3] = {{half * gradient[0], half * gradient[1], half * gradient[2]}};\n  {SCALED.format('g[0]')}\n", planted(), {"method": "sublattice-rotations"}),
    "pairs around a ring": Fault("step", "smg_pair_rows.h", "  if (around) smg_put_some_spins(turn, slot + b->around, sites & smg_lane_not(within), &w);\n", "", planted(), {"method": "pair-rotations"}),
    "few sites in the last lane": Fault("run", "smg_few.h", "(smg_real)a[i + l < sites ? i + l : sites - 1]", "(smg_real)a[i + l < sites - 1 ? i + l : 0]", ("point_vortices", {"gamma": [1.0, 0.7, -0.4, 0.9]})),
    "sweeps beyond the bound of rows": Fault("run", "smg_row_beyond.h", "                                      : s->row_late[k * SMG_LATE_PITCH(&s->c) + slot - first];\n",
                                             "                                      : s->row_late[k * SMG_LATE_PITCH(&s->c) + slot - first] * (site > 1 ? 1 : (smg_real)1.01);\n", planted(), {"h": 0.52}),
    "noise of the last site of a lattice": Fault("noise", "smg_thermal.h", "end = from + all * (thread + 1) / threads;", "end = from + all * (thread + 1) / threads - SMG_BY_ROWS;",
                                                 planted(DAMPED + "kT = 0.2\n")),
    "ghost cells": Fault("ranks", HALO, "  for (int64_t colour = 1; colour < SMG_COLOURS; ++colour) smg_send_colour(colour);", "  for (int64_t colour = 1; colour + 1 < SMG_COLOURS; ++colour) smg_send_colour(colour);", RING),
    "ranks that crash": Fault("ranks", HALO, "  for (int64_t colour = 1; colour < SMG_COLOURS; ++colour) smg_send_colour(colour);", "  __builtin_trap();", RING),
}


def examined(fault: Fault, layouts: bool):
    """(case, subject) of the run that shows a fault; the subject has no library in extended precision."""
    values = fault.system[1]
    spec = spec_of(fault).calm
    s = settle(spec, None, parameters=values, **fault.settings)
    subject = Emitted(build(spec, method=s.method, effects=s.effects, parameters=s.parameters, solver=s.solver, features=fault.features), None)
    subject.generated = True
    return Case(spec, s, 2, tier="quick", features=fault.features, layouts=layouts), subject


def spec_of(fault: Fault):
    """With its noise, where it has any."""
    name = fault.system[0]
    return smidgen.load_text(name) if "\n" in name else smidgen.load(name)


def plant(monkeypatch, place, fault: Fault | None) -> None:
    """From now on libraries are compiled with a runtime that has this fault."""
    monkeypatch.setenv("SMIDGEN_CACHE", str(place / "cache"))
    monkeypatch.setattr(binary, "FLAGS", tuple("-O1" if flag == "-O3" else flag for flag in binary.FLAGS))
    if fault is None:
        return
    shutil.copytree(resources.folder("runtime"), place / "runtime")
    for file, right, wrong in ((fault.file, fault.right, fault.wrong), *fault.more):
        path = next((place / "runtime").rglob(file))
        text = path.read_text()
        assert text.count(right) == 1, f"{file} has no such line"
        path.write_text(text.replace(right, wrong))
    folder = resources.folder
    monkeypatch.setattr(resources, "folder", lambda name: place / name if name == "runtime" else folder(name))
