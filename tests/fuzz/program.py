"""A C program that takes one model through its whole interface, in memory of exactly the sizes that it asks for.

It prints the numbers of the start, each state of COUNT steps, and whether the same bits come of a state saved halfway and restored into a
model that stood elsewhere, of COUNT steps in one call, and of each member of an ensemble beside the same state alone; then how the steps
went, by rows, in blocks, .. A word, if it is given one, is another h. One line for each: `name number number ..` in hexadecimal.
"""
from __future__ import annotations

import numpy as np
from smidgen.language.c_names import in_c

COUNT = 10

TEXT = """
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "{M}.c"     /* with what it keeps to itself: how its steps go */

static void put(const char *name, const smg_real *x, size_t n) {{
  printf("%s", name);
  for (size_t k = 0; k < n; ++k) printf(" %a", (double)x[k]);
  printf("\\n");
}}

static void one(const char *name, smg_real x) {{ put(name, &x, 1); }}

static smg_real *some(size_t bytes) {{
  smg_real *x = (smg_real *)malloc(bytes ? bytes : 1);
  if (!x) exit(9);
  memset(x, 0x7f, bytes);       /* what is read before it is written is seen in the numbers */
  return x;
}}

static smg_real *saved(const {M}_state *s, const {M}_model *model) {{
  smg_real *x = some({M}_savesize(model) * sizeof *x);
  {M}_save(s, x);
  return x;
}}

static int same(smg_real *a, smg_real *b, size_t n) {{
  const int equal = memcmp(a, b, n * sizeof *a) == 0;
  free(a);
  free(b);
  return equal;
}}

enum {{ SITES, SINGLE_SPHERE, FEW_IN_LANES, ROWS, BLOCKS, WAVEFRONTS }};

static int layout(const smg_state *s) {{
#if (defined(SMG_ROW_STAGES) || defined(SMG_ROW_FIELDS)) && SMG_LANES == 1
  (void)s;
  return SITES;
#elif defined(SMG_ROW_STAGES) || defined(SMG_ROW_FIELDS)
  (void)s;
  return ROWS;
#elif defined(SMG_BY_ROWS)
#if !SMG_ROW_TURNS
  smg_row_wave wave;
  smg_state first = *s;     /* between steps a composition has no stage */
#if SMG_COMPOSED
  first.stage = 0;
#endif
  if (s->rows && smg_wave_pays(&first, &wave)) return WAVEFRONTS;
#endif
  return !s->rows ? SITES : s->row_beside ? BLOCKS : ROWS;
#elif SMG_SINGLE_SPHERE
  (void)s;
  return SINGLE_SPHERE;
#elif SMG_FEW_IN_LANES
  (void)s;
  return FEW_IN_LANES;
#else
  (void)s;
  return SITES;
#endif
}}

{ensemble}
static const double start[] = {{ {start} }};
{tables}

int main(int given, char **word) {{
  const double t0 = {t0}, h = given > 1 ? strtod(word[1], NULL) : {h};
  {M}_params p;
  {M}_model model;
  {M}_state s, r;
  {M}_defaults(&p);
{assign}
  smg_status status = {M}_model_init(&model, &p);
  one("check", (smg_real)status);
  if (status != SMG_OK) return 0;
  const size_t n = 3 * (size_t){M}_sites(&model), size = {M}_savesize(&model);
  if (n != sizeof start / sizeof *start) return 8;
  smg_real *w = some(n * sizeof *w), *x = some(n * sizeof *x), *mem = some({M}_memsize(&model)), *other = some({M}_memsize(&model));
  for (size_t k = 0; k < n; ++k) w[k] = (smg_real)start[k];
  status = {M}_init(&s, &model, mem, w, t0, h);
  one("init", (smg_real)status);
  if (status != SMG_OK) return 0;
  one("energy", {M}_energy(&model, (smg_real)t0, s.w));
{values}
  {M}_field(&model, (smg_real)t0, s.w, x);
  put("field", x, n);
  {M}_casimirs(&model, s.w, x);
  put("casimirs", x, n / 3);
  smg_real sum[3 * {families}];
  {M}_momentum(&model, s.w, sum);
  put("momentum", sum, 3 * {families});
  smg_real *half = NULL;
  for (int k = 0; k < {count} && status == SMG_OK; ++k) {{
    smg_real *before = saved(&s, &model);
    if (k == {count} / 2) half = saved(&s, &model);
    status = {M}_step(&s);
    if (status == SMG_OK) put("w", s.w, n);
    else one("stays", same(saved(&s, &model), saved(&s, &model), size) && memcmp(before + 10, s.w, 0) == 0);
    free(before);
  }}
  one("status", (smg_real)status);
  one("layout", (smg_real)layout((const smg_state *)&s));
{tangent}
  if ({M}_init(&r, &model, other, w, t0, h) == SMG_OK) {{
    const smg_status all = {M}_steps(&r, {count});
    one("together", all == status && same(saved(&s, &model), saved(&r, &model), size));
  }}
{members}
  if (half) {{      /* in a model that has gone elsewhere */
    int equal = {M}_init(&r, &model, other, w, t0 + 1, 2 * h) == SMG_OK;
{seeded}    (void){M}_steps(&r, 2);
    equal = equal && {M}_restore(&r, half) == SMG_OK;
    const smg_status again = {M}_steps(&r, {count} - {count} / 2);
    equal = equal && again == status && r.count == s.count && same(saved(&s, &model), saved(&r, &model), size);
    one("restored", (smg_real)equal);
  }}
  free(half);
  free(w);
  free(x);
  free(mem);
  free(other);
{free}
  return 0;
}}
"""
TANGENT = """
  if (status == SMG_OK) {{
    smg_real *v = some(2 * n * sizeof *v), *scratch = some({M}_tangent_memsize(&model));
    for (size_t k = 0; k < 2 * n; ++k) v[k] = (smg_real)(k % 7) - 3;
    one("carried", (smg_real){M}_tangent(&s, v, 2, scratch));
    put("tangent", v, 2 * n);
    free(v);
    free(scratch);
  }}"""

# Members that start where w does, its components exchanged and their signs changed, so that lengths and leaves through the axes stay.
ENSEMBLE = """
enum {{ MEMBERS = 11 }};

static int members(const {M}_model *model, const smg_real *w, size_t n, double t0, double h) {{
  {M}_ensemble e;
  {M}_state alone;
  smg_real *all = some(MEMBERS * n * sizeof *all), *own = some({M}_memsize(model));
  char *mem = (char *)some({M}_ensemble_memsize(model, 0, MEMBERS));
  int equal = 1;
  for (size_t k = 0; k < MEMBERS * n; ++k) all[k] = (k / n % 2 ? -1 : 1) * w[k % n / 3 * 3 + (k % 3 + k / n % 3) % 3];
  (void){M}_ensemble_init(&e, model, 0, MEMBERS, mem, all, t0, h);
  (void){M}_ensemble_steps(&e, 0, MEMBERS, {count} / 2);
  (void){M}_ensemble_steps(&e, 0, 3, {count} / 2);
  (void){M}_ensemble_steps(&e, 3, MEMBERS - 3, {count} / 2);
  for (size_t k = 0; k < MEMBERS; ++k) {{
    smg_status status = {M}_init(&alone, model, own, all + n * k, t0, h);
    const int begun = status == SMG_OK;
{seeded}    if (begun) status = {M}_steps(&alone, {count} / 2);
    if (status == SMG_OK) status = {M}_steps(&alone, {count} / 2);
    equal = equal && e.member[k].report.status == status
            && (!begun || (e.member[k].count == alone.count && memcmp(e.member[k].w, alone.w, n * sizeof *all) == 0));
  }}
  free(all);
  free(own);
  free(mem);
  return equal;
}}
"""
MEMBERS = """
  one("members", (smg_real)members(&model, w, n, t0, h));
  one("lanes", (smg_real){M}_ensemble_lanes());"""


def program(scene, values, w, t0, h, features) -> str:
    """The text of main.c. values: of all parameters; w: the start, shape (sites, 3)."""
    free = [p for p in scene.parameters if not p.fixed]
    arrays = {p.name: values[p.name] for p in free if p.kind == "array"}
    numbers = {p.name: values[p.name] for p in free if p.kind != "array"}
    name = scene.name
    calls = [(f"energy.{e.name}", f"{name}_energy_{e.name}") for e in scene.energies]
    calls += [(o.name, f"{name}_observe_{o.name}") for o in scene.observables]
    return TEXT.format(
        M=name, start=listed(w.ravel()), t0=literal(t0), h=literal(h), count=COUNT, families=len(scene.families),
        tables="\n".join(f"static const double given_{a}[] = {{ {listed(x)} }};" for a, x in arrays.items()),
        assign="\n".join([f"  p.{in_c(k)} = {literal(x)};" for k, x in numbers.items()] + [heap(a) for a in arrays]),
        values="\n".join(f'  one("{shown}", {call}(&model, (smg_real)t0, s.w));' for shown, call in calls),
        ensemble=ENSEMBLE.format(M=name, count=COUNT, seeded=f"    {name}_set_seed(&alone, 0, (uint32_t)k);\n" * bool(scene.heated)) if "ensemble" in features else "", members=MEMBERS.format(M=name) if "ensemble" in features else "",
        tangent=TANGENT.format(M=name) if "tangent" in features else "",
        seeded=f"    {name}_set_seed(&r, 5, 1);\n" * bool(scene.heated), free="\n".join(f"  free(own_{a});" for a in arrays))


def heap(a):
    """An array in memory of its own size: what lies behind its end is no memory of the program."""
    return (f"  double *own_{a} = (double *)malloc(sizeof given_{a});\n  if (!own_{a}) return 9;\n"
            f"  memcpy(own_{a}, given_{a}, sizeof given_{a});\n  p.{in_c(a)} = own_{a};")


def literal(x) -> str:
    return str(x) if isinstance(x, int) else float(x).hex()


def listed(x) -> str:
    return ", ".join(literal(float(v)) for v in x)


def numbers_of(said: str) -> dict:
    """name -> numbers of what the program printed; `w` has one row for each step."""
    found = {}
    for line in said.splitlines():
        name, *words = line.split()
        found.setdefault(name, []).append([float.fromhex(x) for x in words])
    return {name: np.array(rows) if name == "w" else np.array(rows[-1]) for name, rows in found.items()}
