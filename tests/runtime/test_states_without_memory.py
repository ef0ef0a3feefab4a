"""Calls of a state that was declared and never begun, or whose beginning failed: a status, and no access to memory that it does not have."""
import pytest
import smidgen
from smidgen.build.binary import write_files
from smidgen.compile.emit.emit import generate
from support.strict import run_sanitized

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
  {name}_params p;
  {name}_model model;
  {name}_state s = zero;
  {name}_defaults(&p);
  if ({name}_model_init(&model, &p) != SMG_OK) return 1;
  const size_t n = 3 * (size_t){name}_sites(&model);
  smg_real *w = (smg_real *)calloc(2 * n, sizeof *w), *v = w + n;
  smg_real *room = (smg_real *)malloc({name}_savesize(&model) * sizeof *room + {name}_tangent_memsize(&model));
  for (size_t k = 2; k < n; k += 3) w[k] = 1;
  if (!refuses(&s, w, room, v)) return 2;
  if ({name}_init(&s, &model, NULL, w, 0, 0.01) != SMG_BAD_PARAMETER || !refuses(&s, w, room, v)) return 3;
  if ({name}_init(&s, &model, room, w, (double)NAN, 0.01) != SMG_NOT_FINITE || !refuses(&s, w, room, v)) return 4;
  void *mem = malloc({name}_memsize(&model));
  w[2] = 2;
  if ({name}_init(&s, &model, mem, w, 0, 0.01) != SMG_OFF_MANIFOLD || {name}_step(&s) != SMG_OFF_MANIFOLD || s.count != 0) return 5;
  w[2] = 1;
  if ({name}_set_state(&s, w) != SMG_OK || {name}_step(&s) != SMG_OK || s.count != 1) return 6;
  free(mem);
  free(room);
  free(w);
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
