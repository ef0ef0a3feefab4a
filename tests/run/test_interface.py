"""The C interface by itself: what init owes to nobody, and the place that a refusal names."""
import subprocess

import numpy as np
import pytest

from smidgen.compile.emit.emit import generate
from smidgen.read import load_text
from smidgen.resources import include_flags

pytestmark = pytest.mark.quick
HEAD = '[model]\nname = "m"\n[space]\n{space}\n[effects.one]\nover = "{over}"\nenergy = "{energy}"\n'
MODELS = {
    "one sphere": HEAD.format(space="w = { sphere = 1 }", over="site(i) of w", energy="w[i].z^2 + w[i].x*w[i].y"),
    "sites alone": HEAD.format(space="w = { sphere = 6, radius = 2 }", over="site(i) of w", energy="w[i].z^2 + w[i].x"),
    "all pairs": HEAD.format(space="w = { sphere = 6 }", over="pair(i, j) of w", energy="dot(w[i], w[j])"),
    "factors R^3": HEAD.format(space="w = { r3 = 6 }", over="pair(i, j) of w", energy="w[i].x*w[j].x + w[i].z*w[j].z"),
    "by rows": HEAD.format(space='w = { sphere = "n" }\n[parameters]\nn = 6', over="bond(i, j) of chain(n, periodic)", energy="-dot(w[i], w[j])"),
    "a tracer": HEAD.format(space="w = { sphere = 3 }\np = { sphere = 3, tracer = true }", over="each(i of w, j of p)",
                            energy="dot(w[i], p[j])"),
}
PROGRAM = """
#include "m.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static smg_real w[] = {{{w}}};

/* `count` steps in memory that held `garbage`. */
static smg_status run(int garbage, int count, m_state *s) {{
  static m_model model; /* states keep a pointer to it */
  m_params p;
  m_defaults(&p);
  if (m_model_init(&model, &p) != SMG_OK) return model.status;
  smg_real *mem = (smg_real *)malloc(m_memsize(&model));
  memset(mem, garbage, m_memsize(&model));
  memset(s, garbage, sizeof *s);
  const smg_status status = m_init(s, &model, mem, w, 0.5, 0.1);
  if (status != SMG_OK || count < 1) return status;
  const smg_status first = m_step(s);
  return first == SMG_OK ? m_steps(s, count - 1) : first;
}}

int main(void) {{
  m_state s;
  const int size = (int)(sizeof w / sizeof *w);
  for (int garbage = 0; garbage < 256; garbage += 127) {{
    printf("%d", (int)run(garbage, 20, &s));
    for (int k = 0; k < size; ++k) printf(" %.17g", s.w[k]);
    printf("\\n");
  }}
  for (int k = 0; k < size; ++k) {{
    const smg_real kept = w[k];
    w[k] = (smg_real)NAN;
    const smg_status nan = run(0, 0, &s);
    printf("%d %d", (int)nan, (int)s.report.site);
    w[k] = kept;
    for (int e = k / 3 * 3; e < k / 3 * 3 + 3; ++e) w[e] *= 1 + 1e-9;
    const smg_status off = run(0, 0, &s);
    printf(" %d %d\\n", (int)off, (int)s.report.site);
    for (int e = k / 3 * 3; e < k / 3 * 3 + 3; ++e) w[e] /= 1 + 1e-9;
  }}
  return 0;
}}
"""


@pytest.fixture(params=MODELS)
def said(request, tmp_path):
    """(name of the model, lines of the program, number of sites)."""
    text = MODELS[request.param]
    sites = 1 if request.param == "one sphere" else 6
    w = np.random.default_rng(2).normal(size=(sites, 3))
    w *= (2 if "radius" in text else 1) / np.linalg.norm(w, axis=1)[:, None]
    files = {**generate(load_text(text)), "main.c": PROGRAM.format(w=", ".join(repr(float(x)) for x in w.ravel()))}
    for name, content in files.items():
        (tmp_path / name).write_text(content)
    subprocess.run(["gcc", "-O1", "-std=c11", "-ffp-contract=off", *include_flags(), "-I.", "main.c", "m.c", "-lm",
                    "-o", "program"], cwd=tmp_path, check=True)
    lines = subprocess.run(["./program"], cwd=tmp_path, capture_output=True, text=True, check=True).stdout.splitlines()
    return request.param, lines, sites


def test_init_owes_nothing_to_what_was_in_memory(said):
    """Zeros, halves or NaN in the caller's memory and in the state: the same bits after twenty steps."""
    lines = said[1][:3]
    assert lines[0].startswith("0 ") and "nan" not in lines[0]
    assert lines[0] == lines[1] == lines[2]


def test_a_refused_start_names_its_site(said):
    """NOT_FINITE and OFF_MANIFOLD, at the site that is wrong; an R^3 factor may have any length."""
    name, lines, sites = said
    assert len(lines) == 3 + 3 * sites
    for k, line in enumerate(lines[3:]):
        nan, nan_site, off, off_site = map(int, line.split())
        assert (nan, nan_site) == (4, k // 3)
        assert (off, off_site) == ((0, -1) if name == "factors R^3" else (6, k // 3))


REFUSED = """
[model]
name = "m"
[space]
w = { sphere = "n", kappa = "k*(i + 1)", radius = "r*(i + 1)" }
[parameters]
n = 3
k = 1.0
r = 1.0
[effects.exchange]
over = "bond(i, j) of chain(n, periodic)"
energy = "dot(w[i], w[j])"
"""
ASKED = """
#include "m.h"
#include <stdio.h>
#include <stdlib.h>

int main(void) {
  static smg_real mem[10000];
  static const smg_real w[] = {0, 0, 1, 0, 0, 2, 0, 3, 0};
  double n, k, r, t0, h, tolerance;
  while (scanf("%lf %lf %lf %lf %lf %lf", &n, &k, &r, &t0, &h, &tolerance) == 6) {
    m_params p;
    m_model model;
    m_state s;
    m_defaults(&p);
    p.n = (int64_t)n;
    p.k = k;
    p.r = r;
    (void)m_model_init(&model, &p); /* a start of a bad model is refused */
    if (n == 3 && m_memsize(&model) > sizeof mem) return 1;
    const int begun = (int)m_init(&s, &model, mem, w, t0, h);
    printf("%d %d\\n", begun, begun == 0 ? (int)m_set_tolerance(&s, tolerance) : -1);
  }
  return 0;
}
"""
OK, NOT_FINITE, BAD = 0, 4, 5
GOOD = {"n": 3, "k": 1, "r": 1, "t0": 0, "h": 0.1, "tolerance": 0.5}
CASES = [({}, OK, OK), ({"tolerance": 0}, OK, OK), ({"tolerance": -1e-9}, OK, BAD), ({"tolerance": 1}, OK, BAD), ({"tolerance": "nan"}, OK, BAD),
         ({"n": 2}, BAD, -1), ({"n": -1}, BAD, -1), ({"k": 0}, BAD, -1), ({"k": -1}, OK, OK), ({"k": 1e308}, BAD, -1), ({"k": "nan"}, NOT_FINITE, -1),
         ({"r": 0}, BAD, -1), ({"r": -1}, BAD, -1), ({"r": 1e308}, BAD, -1), ({"r": "inf"}, NOT_FINITE, -1), ({"t0": "inf"}, NOT_FINITE, -1),
         ({"h": "inf"}, NOT_FINITE, -1), ({"h": 1e-310}, BAD, -1), ({"h": -1e-310}, BAD, -1), ({"h": 0}, OK, OK), ({"h": -0.1}, OK, OK)]


def test_init_refuses_what_no_step_could_use(tmp_path):
    """By itself: nobody has looked at the status of m_model_init. Strengths and radii that overflow on the way are no better than infinite ones."""
    for name, content in {**generate(load_text(REFUSED)), "main.c": ASKED}.items():
        (tmp_path / name).write_text(content)
    subprocess.run(["gcc", "-O1", "-std=c11", "-ffp-contract=off", *include_flags(), "-I.", "main.c", "m.c", "-lm", "-o", "program"], cwd=tmp_path, check=True)
    asked = "\n".join(" ".join(str({**GOOD, **changed}[key]) for key in GOOD) for changed, _, _ in CASES)
    said = subprocess.run(["./program"], cwd=tmp_path, input=asked, capture_output=True, text=True, check=True).stdout.splitlines()
    assert [tuple(map(int, line.split())) for line in said] == [(begun, set_) for _, begun, set_ in CASES]
