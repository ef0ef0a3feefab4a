"""Calls of a state that was declared and never begun, or whose beginning failed: a status, and no access to memory that it does not have."""
import subprocess

import pytest
import smidgen
from smidgen.build.binary import write_files
from smidgen.compile.emit.emit import generate
from smidgen.resources import include_flags
from support.strict import run_sanitized
from test_ranks import SMALL, mpirun, needs_mpi

# of every program: a model, and the numbers of its w
BEGIN = """  {name}_params p;
  {name}_model model;
  {name}_defaults(&p);
  if ({name}_model_init(&model, &p) != SMG_OK) return 1;
  const size_t n = 3 * (size_t){name}_sites(&model);
"""
MAIN = """
#include "{name}.h"
#include <stdlib.h>
static int refuses({name}_state *s, const smg_real *w, smg_real *room, smg_real *v) {{
  room[0] = 1;
  {name}_save(s, room);
  return {name}_step(s) == SMG_BAD_PARAMETER && {name}_steps(s, 3) == SMG_BAD_PARAMETER && s->count == 0 && room[0] == 0 &&
         {name}_set_state(s, w) == SMG_BAD_PARAMETER && {name}_restore(s, room) == SMG_BAD_PARAMETER &&
         {name}_tangent(s, v, 1, room) == SMG_BAD_PARAMETER && s->report.status == SMG_BAD_PARAMETER;
}}
int main(void) {{
  static const {name}_state zero;
  {name}_state s = zero;
""" + BEGIN + """  smg_real *w = (smg_real *)calloc(2 * n, sizeof *w), *v = w + n;
  smg_real *room = (smg_real *)malloc({name}_savesize(&model) * sizeof *room + {name}_tangent_memsize(&model));
  for (size_t k = 2; k < n; k += 3) w[k] = 1;
  if (!refuses(&s, w, room, v)) return 2;
  if ({name}_init(&s, &model, NULL, w, 0, 0.01) != SMG_BAD_PARAMETER || !refuses(&s, w, room, v)) return 3;
  if ({name}_init(&s, &model, room, w, (double)NAN, 0.01) != SMG_NOT_FINITE || !refuses(&s, w, room, v)) return 4;
  void *mem = malloc({name}_memsize(&model));
  w[2] = 2;
  if ({name}_init(&s, &model, mem, w, 0, 0.01) != SMG_OFF_MANIFOLD || {name}_step(&s) != SMG_OFF_MANIFOLD || s.count != 0) return 5;
  room[0] = 1;
  {name}_save(&s, room);
  w[2] = 1.5;
  if (room[0] != 0 || {name}_set_state(&s, w) != SMG_OFF_MANIFOLD || {name}_step(&s) != SMG_OFF_MANIFOLD) return 9;
  w[2] = 1;
  if ({name}_set_state(&s, w) != SMG_OK || {name}_step(&s) != SMG_OK || s.count != 1) return 6;
  const smg_status without = {name}_tangent(&s, v, 0, NULL);
  if (without != ({name}_tangent_memsize(&model) > 0 ? SMG_BAD_PARAMETER : SMG_OK) || {name}_tangent(&s, v, 1, room) != SMG_OK) return 7;
  static const {name}_model none;
  {name}_state other;
  if ({name}_init(&other, &none, mem, w, 0, 0.01) != SMG_BAD_PARAMETER || !refuses(&other, w, room, v)) return 8;
  if ({name}_init(&other, &model, room, NULL, 0, 0.01) != SMG_BAD_PARAMETER || !refuses(&other, w, room, v)) return 10;
  if ({name}_set_state(&s, NULL) != SMG_BAD_PARAMETER || {name}_restore(&s, NULL) != SMG_BAD_PARAMETER || {name}_step(&s) != SMG_OK || s.count != 2) return 11;
  if ({name}_set_parameters(&model, NULL) != SMG_BAD_PARAMETER || {name}_step(&s) != SMG_OK || s.count != 3) return 12;
  {name}_model unknown;
  if ({name}_model_init(&unknown, NULL) != SMG_BAD_PARAMETER || {name}_init(&other, &unknown, room, w, 0, 0.01) != SMG_BAD_PARAMETER || !refuses(&other, w, room, v)) return 13;
  free(mem);
  free(room);
  free(w);
  return 0;
}}
"""
ENSEMBLE = """
#include "{name}.h"
#include <stdlib.h>
int main(void) {{
  static const {name}_ensemble zero;
  {name}_ensemble e = zero;
""" + BEGIN + """  smg_real *w = (smg_real *)calloc(5 * n, sizeof *w);
  for (size_t k = 2; k < 5 * n; k += 3) w[k] = 1;
  if ({name}_ensemble_steps(&e, 0, 5, 1) != 5) return 2;
  if ({name}_ensemble_init(&e, &model, 0, 5, NULL, w, 0, 0.01) != 5 || {name}_ensemble_steps(&e, 0, 5, 1) != 5 || {name}_ensemble_steps(&e, 0, 0, 1) != 0) return 3;
  void *mem = malloc({name}_ensemble_memsize(&model, 0, 5));
  if ({name}_ensemble_init(&e, &model, 0, 5, mem, NULL, 0, 0.01) != 5 || {name}_ensemble_steps(&e, 0, 5, 1) != 5) return 8;
  if ({name}_ensemble_init(&e, &model, 0, 5, mem, w, 0, 0.01) != 0) return 4;
  if ({name}_ensemble_steps(&e, 3, 3, 1) != 3 || {name}_ensemble_steps(&e, -1, 2, 1) != 2 || {name}_ensemble_steps(&e, INT64_MAX, 1, 1) != 1) return 5;
  for (int k = 0; k < 5; ++k)
    if (e.member[k].count != 0) return 6;
  if ({name}_ensemble_steps(&e, 3, 2, 2) != 0 || e.member[4].count != 2 || e.member[2].count != 0) return 7;
  free(mem);
  free(w);
  return 0;
}}
"""
RANKS = """
#include <mpi.h>
#include "{name}.h"
#include <stdlib.h>
static int refuses({name}_state *s, const smg_real *w, smg_real *room) {{
  room[0] = 1;
  {name}_save(s, room);
  int good = room[0] == 0;
  room[0] = 1;
  {name}_save_part(s, 0, 0, room);
  return good && room[0] == 0 && {name}_step(s) == SMG_BAD_PARAMETER && {name}_set_state(s, w) == SMG_BAD_PARAMETER &&
         {name}_restore(s, room) == SMG_BAD_PARAMETER && s->report.status == SMG_BAD_PARAMETER && s->count == 0;
}}
int main(int argc, char **argv) {{
  static const {name}_state zero;
  int rank = 0, size = 0;
  MPI_Init(&argc, &argv);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  {name}_state s = zero;
""" + BEGIN + """  smg_real *w = (smg_real *)calloc(n, sizeof *w), *room = (smg_real *)calloc({name}_savesize(&model), sizeof *room);
  void *mem = calloc(1, {name}_memsize(&model));
  for (size_t k = 2; k < n; k += 3) w[k] = 1;
  if (!refuses(&s, w, room)) return 2;
  if ({name}_init(&s, &model, rank == size - 1 ? NULL : mem, w, 0, 0.01) != SMG_BAD_PARAMETER || !refuses(&s, w, room)) return 3;
  s = zero;
  if (!refuses(&s, w, room)) return 4;
  if ({name}_init(&s, &model, mem, w, 0, 0.01) != SMG_OK || {name}_step(&s) != SMG_OK || s.count != 1) return 5;
  MPI_Finalize();
  return 0;
}}
"""
BODY = """[model]
name = "one"
[space]
w = { sphere = 1 }
[effects.body]
over = "site(i) of w"
energy = "w[i].x^2 + 0.5*w[i].y*w[i].z"
"""


@pytest.mark.parametrize("of", ["one", "heisenberg_chain"])
def test_a_state_without_memory_is_refused(tmp_path, of):
    spec = smidgen.load_text(BODY) if of == "one" else smidgen.load(of)
    write_files({**generate(spec, features=("tangent",)), "main.c": MAIN.format(name=spec.name)}, tmp_path)
    status, said = run_sanitized(tmp_path, [f"{spec.name}.c", "main.c"])
    assert status == 0, said[:3000]


REFUSED = """
#include "{name}.h"
#include <stdlib.h>
int main(void) {{
""" + BEGIN + """  smg_real *w = (smg_real *)calloc(n, sizeof *w), *room = (smg_real *)malloc({name}_savesize(&model) * sizeof *room);
  void *mem = malloc({name}_memsize(&model));
  {name}_state s, other;
  if ({name}_init(&other, &model, malloc({name}_memsize(&model)), w, 0, 0.01) != SMG_OK) return 2;
  w[4] = NAN;
  if ({name}_init(&s, &model, mem, w, 0, 0.01) != SMG_NOT_FINITE || s.report.site != 1) return 3;
  if ({name}_step(&s) != SMG_NOT_FINITE || {name}_steps(&s, 2) != SMG_NOT_FINITE || s.count != 0) return 4;
  {name}_save(&s, room);
  if ({name}_restore(&other, room) != SMG_BAD_PARAMETER || {name}_step(&other) != SMG_OK) return 5;
  if ({name}_set_parameters(&model, &p) != SMG_OK || {name}_step(&s) != SMG_NOT_FINITE) return 6;
  {name}_save(&other, room);
  if ({name}_restore(&s, room) != SMG_OK || {name}_step(&s) != SMG_OK || s.count != 2) return 7;
  free(other.w);
  free(mem);
  free(room);
  free(w);
  return 0;
}}
"""


def test_a_state_whose_start_was_refused_takes_no_step(tmp_path):
    """0 is a vector of R^3, but no one's start: there is none until a w or a saved state is given."""
    spec = smidgen.load_text(BODY.replace("sphere = 1", "r3 = 2"))
    write_files({**generate(spec), "main.c": REFUSED.format(name=spec.name)}, tmp_path)
    status, said = run_sanitized(tmp_path, [f"{spec.name}.c", "main.c"])
    assert status == 0, (status, said[:3000])


@pytest.mark.parametrize("of", ["one", "heisenberg_chain"])
def test_an_ensemble_without_memory_and_members_that_it_has_not_are_refused(tmp_path, of):
    spec = smidgen.load_text(BODY) if of == "one" else smidgen.load(of)
    write_files({**generate(spec, features=("ensemble",)), "main.c": ENSEMBLE.format(name=spec.name)}, tmp_path)
    status, said = run_sanitized(tmp_path, [f"{spec.name}.c", "main.c"])
    assert status == 0, (status, said[:3000])


@needs_mpi
@pytest.mark.parametrize("of, grid", [("heisenberg_chain", ()), ("cubic_lattice", ("-DSMG_MPI_GRID=1,1,2",))])
def test_ranks_refuse_states_that_never_began_and_wait_for_no_one(tmp_path, of, grid):
    """Also where a single rank has no memory: all are told."""
    spec = smidgen.load(of)
    write_files({**generate(spec, features=("distributed",)), "main.c": RANKS.format(name=spec.name)}, tmp_path)
    subprocess.run(["mpicc", "-DSMG_MPI", "-D_DEFAULT_SOURCE", "-std=c11", "-O0", "-g", "-Wno-psabi", *SMALL, *grid, *include_flags(), "-I.", f"{spec.name}.c", "main.c",
                    "-o", "shared", "-lm"], cwd=tmp_path, check=True)
    for ranks in (1, 2) if not grid else (2,):
        said = mpirun(ranks, "./shared", cwd=tmp_path, limit=60)
        assert said.returncode == 0, (ranks, said.stderr)
