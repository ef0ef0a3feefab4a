"""A model in C that several states share: on several threads, in ensembles, and with parameters that are changed between their steps."""
import subprocess

import pytest
import smidgen
from smidgen.compile.emit.emit import generate
from smidgen.resources import include_flags
from support.strict import WARNINGS

# Two threads step two states of one model and ask it; PLANTED: one of them changes the parameters meanwhile.
THREADS = """
#include "{M}.h"
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static {M}_params p;
static {M}_model model;
static {M}_state states[2];

static void *stepped(void *of) {{
  {M}_state *s = ({M}_state *)of;
  smg_real sum[3 * {families}], energy = 0;
  for (int k = 0; k < 20; ++k) {{
    if ({M}_steps(s, 5) != SMG_OK) exit(3);
    energy += {M}_energy(&model, (smg_real){M}_time(s), s->w);
    {M}_momentum(&model, s->w, sum);
#ifdef PLANTED
    if (s == states) (void){M}_set_parameters(&model, &p);
#endif
  }}
  return energy - energy == 0 ? NULL : s;
}}

int main(void) {{
  pthread_t threads[2];
  {M}_defaults(&p);
  if ({M}_model_init(&model, &p) != SMG_OK) return 1;
  const size_t n = 3 * (size_t){M}_sites(&model);
  unsigned char before[sizeof model];
  memcpy(before, &model, sizeof model);
  smg_real *w = malloc(n * sizeof *w);
  for (size_t k = 0; k < n; ++k) w[k] = k % 3 == 0 ? 0.6 : 0.8 * (k % 3 == 1 ? cos(1.5 * (double)(k / 3)) : sin(1.5 * (double)(k / 3)));
  for (int k = 0; k < 2; ++k)
    if ({M}_init(states + k, &model, malloc({M}_memsize(&model)), w, 0, 0.05) != SMG_OK) return 2;
  for (int k = 0; k < 2; ++k)
    if (pthread_create(threads + k, NULL, stepped, states + k)) return 4;
  for (int k = 0; k < 2; ++k) pthread_join(threads[k], NULL);
  if (memcmp(states[0].w, states[1].w, n * sizeof *w)) return 5;
  return memcmp(before, &model, sizeof model) ? 6 : 0;
}}
"""
SHARED = {"single sphere": ("forced_rigid_body", "spherical-midpoint"), "rows": ("heisenberg_chain", "spherical-midpoint"), "few in lanes": ("point_vortices", "spherical-midpoint"),
          "gauss": ("heisenberg_chain", "gauss-4"), "dop853": ("forced_rigid_body", "dop853")}


def races(tmp_path, key, *macros):
    name, method = SHARED[key]
    spec = smidgen.load(name)
    for file, text in {**generate(spec, method), "main.c": THREADS.format(M=name, families=len(spec.families))}.items():
        (tmp_path / file).write_text(text)
    words = ["gcc", "-std=gnu11", "-O1", "-g", "-w", "-ffp-contract=off", "-pthread", "-fsanitize=thread", *macros, *include_flags(), "-I."]
    subprocess.run([*words, "main.c", f"{name}.c", "-lm", "-o", "main"], cwd=tmp_path, check=True)
    return subprocess.run(["setarch", "-R", "./main"], cwd=tmp_path, capture_output=True, text=True)


@pytest.mark.parametrize("key", SHARED)
def test_threads_share_a_model(tmp_path, key):
    """Without a race, with equal bits, and the model has the bytes that it had."""
    said = races(tmp_path, key)
    assert said.returncode == 0 and "ThreadSanitizer" not in said.stderr, said.stderr[:2000]


def test_a_model_that_is_changed_meanwhile_is_seen(tmp_path):
    assert "data race" in races(tmp_path, "single sphere", "-DPLANTED").stderr


# Members of an ensemble whose parameters are changed between calls: all at once, or those of one member.
MEMBERS = """
#include "{M}.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {{ N = 11 }};
#define T2 0.25
#define CHECK(what) if (!(what)) return printf("%s\\n", #what), 1

int main(void) {{
  static {M}_model models[N], alone;
  {M}_params p;
  {M}_ensemble e;
  {M}_state s;
  smg_real w[3 * N], v[3];
  {M}_defaults(&p);
  for (int k = 0; k < N; ++k) w[3 * k] = 0.6, w[3 * k + 1] = 0.8 * cos(k), w[3 * k + 2] = 0.8 * sin(k);
  for (int own = 0; own < 2; ++own) {{
    for (int k = 0; k < N; ++k) CHECK({M}_model_init(models + k, &p) == SMG_OK);
    CHECK({M}_model_init(&alone, &p) == SMG_OK);
    void *mem = malloc({M}_ensemble_memsize(models, own, N)), *its = malloc({M}_memsize(&alone));
    CHECK({M}_ensemble_init(&e, models, own, N, mem, w, 0, 0.3) == 0);
    CHECK({M}_init(e.member + 2, own ? models + 2 : models, e.member[2].w, w + 6, T2, 0.3) == SMG_OK); /* another time */
    CHECK({M}_ensemble_steps(&e, 0, N, 17) == 0 && {M}_steps(e.member + 5, 3) == SMG_OK);
    {M}_params other = p;
    other.{p} *= 1.25;
    CHECK({M}_set_parameters(models, &other) == SMG_OK); /* of the first member, or of all */
    CHECK({M}_ensemble_steps(&e, 0, 4, 9) == 0 && {M}_ensemble_steps(&e, 4, N - 4, 9) == 0);
    for (int k = 0; k < N; ++k) {{
      CHECK({M}_set_parameters(&alone, &p) == SMG_OK && {M}_init(&s, &alone, its, w + 3 * k, k == 2 ? T2 : 0, 0.3) == SMG_OK && {M}_steps(&s, k == 5 ? 20 : 17) == SMG_OK);
      if (!own || k == 0) CHECK({M}_set_parameters(&alone, &other) == SMG_OK);
      CHECK({M}_steps(&s, 9) == SMG_OK && e.member[k].count == s.count);
      memcpy(v, s.w, sizeof v);
      CHECK(memcmp(v, e.member[k].w, sizeof v) == 0);
    }}
    free(mem), free(its);
  }}
  return 0;
}}
"""
LANES = ["-Wno-psabi", "-ffp-contract=off", "-fno-math-errno", "-DSMG_LANES=4"]


@pytest.mark.quick
@pytest.mark.parametrize("name, method, parameter", [("irreversible_rigid_body", "spherical-midpoint", "I1"), ("irreversible_rigid_body", "dop853", "I1"),
                                                     ("irreversible_rigid_body", "extrapolation-12", "I1"), ("forced_rigid_body", "spherical-midpoint", "I1")])
def test_members_share_a_model_or_have_their_own(tmp_path, name, method, parameter):
    """Also where one began at another time, or has taken steps by itself."""
    runs(tmp_path, name, MEMBERS.format(M=name, p=parameter), method)


# Members of other sizes, and of a model that is none.
UNLIKE = """
#include "heisenberg_chain.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHECK(what) if (!(what)) return printf("%s\\n", #what), 1

int main(void) {
  static heisenberg_chain_model models[3];
  heisenberg_chain_params p;
  heisenberg_chain_ensemble e;
  heisenberg_chain_state s;
  smg_real w[3 * 3 * 6];
  heisenberg_chain_defaults(&p);
  for (int k = 0; k < 18; ++k) w[3 * k] = 0.6, w[3 * k + 1] = 0.8 * cos(k), w[3 * k + 2] = 0.8 * sin(k);
  for (int k = 0; k < 3; ++k) {
    p.n = k == 0 ? 6 : k == 1 ? 4 : -1;
    CHECK((heisenberg_chain_model_init(models + k, &p) == SMG_OK) == (k < 2));
  }
  void *mem = malloc(heisenberg_chain_ensemble_memsize(models, 1, 3)), *its = malloc(heisenberg_chain_memsize(models));
  CHECK(heisenberg_chain_ensemble_init(&e, models, 1, 3, mem, w, 0, 0.3) == 2);
  CHECK(e.member[0].report.status == SMG_OK && e.member[1].report.status == SMG_BAD_PARAMETER && e.member[2].report.status == SMG_BAD_PARAMETER);
  CHECK(heisenberg_chain_ensemble_steps(&e, 0, 3, 7) == 2 && e.member[0].count == 7 && e.member[1].count == 0 && e.member[2].count == 0);
  CHECK(heisenberg_chain_init(&s, models, its, w, 0, 0.3) == SMG_OK && heisenberg_chain_steps(&s, 7) == SMG_OK);
  CHECK(memcmp(s.w, e.member[0].w, 18 * sizeof *w) == 0);
  free(mem), free(its);
  return 0;
}
"""


def runs(place, spec, main, method="spherical-midpoint"):
    for file, text in generate(smidgen.load(spec), method, features=("ensemble",)).items():
        (place / file).write_text(text)
    (place / "main.c").write_text(main)
    subprocess.run(["gcc", "-std=c11", "-O1", *LANES, "-fsanitize=undefined,address", "-fno-sanitize-recover=all", *include_flags(), "-I.", "main.c", f"{spec}.c", "-lm", "-o", "main"],
                   cwd=place, check=True)
    said = subprocess.run(["./main"], cwd=place, capture_output=True, text=True)
    assert said.returncode == 0, said.stdout + said.stderr


@pytest.mark.quick
def test_members_that_cannot_begin_leave_the_others_alone(tmp_path):
    runs(tmp_path, "heisenberg_chain", UNLIKE)


# Valid C++, too: a change, refusals, an array that is written to.
CHANGES = """
#include "{M}.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHECK(what) if (!(what)) return printf("%s\\n", #what), 1

int main(void) {{
  static {M}_model model, before, none;
  {M}_params p;
  {M}_state s;
  {M}_defaults(&p);
  double gamma[4] = {{p.gamma[0], p.gamma[1], p.gamma[2], p.gamma[3]}};
  p.gamma = gamma;
  CHECK({M}_model_init(&model, &p) == SMG_OK && model.status == SMG_OK);
  memcpy(&before, &model, sizeof model);
  const size_t n = 3 * (size_t){M}_sites(&model), size = {M}_savesize(&model);
  smg_real *w = (smg_real *)malloc(n * sizeof *w), *one = (smg_real *)calloc(size, sizeof *one), *two = (smg_real *)calloc(size, sizeof *two);
  void *mem = malloc({M}_memsize(&model));
  for (size_t k = 0; k < n; ++k) w[k] = k % 3 == 0 ? 0.6 : 0.8 * (k % 3 == 1 ? cos(1.5 * (double)(k / 3)) : sin(1.5 * (double)(k / 3)));
  CHECK({M}_init(&s, &model, mem, w, 0, 0.05) == SMG_OK && {M}_steps(&s, 7) == SMG_OK);
  CHECK(memcmp(&before, &model, sizeof model) == 0);

  {M}_params other = p;
  other.n = 5;
  CHECK({M}_set_parameters(&model, &other) == SMG_BAD_PARAMETER);
  gamma[2] = 0; /* no strength of a vortex */
  CHECK({M}_set_parameters(&model, &p) == SMG_BAD_PARAMETER);
  gamma[2] = (double)NAN;
  CHECK({M}_set_parameters(&model, &p) == SMG_NOT_FINITE);
  CHECK(memcmp(&before, &model, sizeof model) == 0);
  CHECK({M}_model_init(&none, &p) == SMG_NOT_FINITE && none.status == SMG_NOT_FINITE && {M}_init(&s, &none, mem, w, 0, 0.05) == SMG_NOT_FINITE);
  gamma[2] = p.gamma[1];
  CHECK({M}_set_parameters(&none, &p) == SMG_BAD_PARAMETER); /* there is no model yet */

  CHECK({M}_set_parameters(&model, &p) == SMG_OK && model.version == before.version + 1);
  CHECK({M}_init(&s, &model, mem, w, 0, 0.05) == SMG_OK && {M}_steps(&s, 7) == SMG_OK);
  gamma[2] = p.gamma[0] * 1.5; /* written into the array */
  CHECK({M}_set_parameters(&model, &p) == SMG_OK);
  memcpy(w, s.w, n * sizeof *w);
  CHECK({M}_steps(&s, 7) == SMG_OK);
  {M}_save(&s, one);
  CHECK({M}_model_init(&none, &p) == SMG_OK && {M}_init(&s, &none, mem, w, 0, 0.05) == SMG_OK && {M}_steps(&s, 7) == SMG_OK);
  {M}_save(&s, two);
  CHECK(memcmp(one + 11, two + 11, (size - 11) * sizeof *one) == 0); /* all but the head */
  free(w), free(one), free(two), free(mem);
  return 0;
}}
"""


@pytest.mark.quick
@pytest.mark.parametrize("words", [["gcc", "-std=c11"], ["clang", "-std=c11"], ["g++", "-x", "c++", "-std=c++17"]])
def test_changes_and_refusals(tmp_path, words):
    for file, text in generate(smidgen.load("point_vortices")).items():
        (tmp_path / file).write_text(text)
    (tmp_path / "main.c").write_text(CHANGES.format(M="point_vortices"))
    flags = [*WARNINGS, "-Wno-psabi", "-O1", "-ffp-contract=off", "-fsanitize=undefined,address", "-fno-sanitize-recover=all"]
    subprocess.run([*words, *flags, *include_flags(), "-I.", "main.c", "point_vortices.c", "-o", "main", "-lm"], cwd=tmp_path, check=True)
    said = subprocess.run(["./main"], cwd=tmp_path, capture_output=True, text=True)
    assert said.returncode == 0, said.stdout + said.stderr
