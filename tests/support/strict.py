"""The compilers that generated C must please, and a small driver that runs a model under sanitizers."""
import os
import shutil
import subprocess

import pytest
from smidgen.language.c_names import in_c
from smidgen.resources import include_flags

WARNINGS = ("-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Wconversion", "-Wdouble-promotion",
            "-Wvla", "-Werror")
COMPILERS = {name: words for name, words in {
    "gcc": ("-std=c11",), "clang": ("-std=c11",),
    "g++": ("-x", "c++", "-std=c++17"), "clang++": ("-x", "c++", "-std=c++17")}.items()
    if shutil.which(name)}
# Doubles become long double on purpose there, of which clang (not gcc) would warn.
REALS = {"double": (), "long double": ("-DSMG_LONG_DOUBLE", "-Wno-double-promotion")}

# Calls in place of inlined text: the same bits, and under the sanitizers half the time to compile.
CALLS = "-DSMG_INLINE=static inline"
READ, OPTIMISED = ("-fsyntax-only",), ("-O1", "-S", "-o", os.devnull)
# (compiler, how) of tests of warnings: in `make test` gcc with its optimiser, since some of its warnings need the flow of data, and the
# front end of clang, in C++; all of them, and all the optimisers, in the long tier.
FEW = {("gcc", OPTIMISED), ("clang++", READ)}
MODES = [pytest.param(compiler, how, marks=() if (compiler, how) in FEW else pytest.mark.long, id=compiler + "-O1" * (how == OPTIMISED))
         for compiler in COMPILERS for how in (READ, OPTIMISED) if compiler != "gcc" or how == OPTIMISED]
COMMANDS = [pytest.param(words, marks=() if words[0] in ("gcc", "clang") and len(words) == 2 else pytest.mark.long, id="-".join(words[::2]))
            for words in (["gcc", "-std=c11"], ["clang", "-std=c11"], ["g++", "-x", "c++", "-std=c++17"], ["gcc", "-std=c11", "-DSMG_LONG_DOUBLE"],
                          ["gcc", "-std=c11", "-DSMG_QUAD"])]
FEW_COMPILERS = [pytest.param(c, marks=() if c in dict(FEW) else pytest.mark.long) for c in COMPILERS]

DRIVER = """
#include <stdio.h>
#include <stdlib.h>
#include "{name}.h"

static int fail(const char *what, int status) {{
  printf("%s: %s\\n", what, smg_message((smg_status)status));
  return 1;
}}

int main(void) {{
  static const double start[] = {{ {start} }};
  {arrays}
  {name}_params p;
  {name}_model model;
  {name}_state s;
  {name}_defaults(&p);
  {assign}
  if ({name}_model_init(&model, &p) != SMG_OK) return fail("model", model.status);
  const int64_t sites = {name}_sites(&model);
  if (3 * sites != (int64_t)(sizeof start / sizeof *start)) return fail("size", SMG_BAD_PARAMETER);
  smg_real *mem = (smg_real *)malloc({name}_memsize(&model));
  smg_real *w = (smg_real *)malloc(sizeof(smg_real) * 3 * (size_t)sites);
  smg_real sum[3 * {families}], extra = 0;
  for (int64_t k = 0; k < 3 * sites; ++k) w[k] = start[k];
  smg_status status = {name}_init(&s, &model, mem, w, 0.25, {h});
  if (status != SMG_OK) return fail("init", status);
  status = {name}_steps(&s, {count});
  if (status != SMG_OK) return fail("steps", status);
  {name}_field(&model, 0.5, s.w, w);
  {name}_momentum(&model, s.w, sum);
  {name}_casimirs(&model, s.w, w);
  {observe}
  printf("%.17g %.17g\\n", (double)({name}_energy(&model, 0.5, s.w) + 0 * (sum[0] + extra)), (double)s.w[0]);
  free(mem);
  free(w);
  return 0;
}}
"""


def compile_all(where, sources, compiler, *more, real="double", how=READ):
    """Compile generated files to nothing; returns what the compiler said: '' when all is well."""
    if len(sources) > 1 and "-o" in how:
        return "".join(compile_all(where, [source], compiler, *more, real=real, how=how) for source in sources)
    said = subprocess.run([compiler, *COMPILERS[compiler], *WARNINGS, *REALS[real], *more, "-I.",
                           *include_flags(), *how, *sources],
                          cwd=where, capture_output=True, text=True)
    return said.stderr if said.returncode or said.stderr else ""


def driver(model, h, w, scalars, arrays, count=50):
    """C text of a program that steps a model from w and prints its energy and first component."""
    names = [o.name for o in model.scene.observables]
    return DRIVER.format(
        name=model.name, h=repr(float(h)), count=count, start=", ".join(repr(float(x)) for x in w.ravel()),
        families=len(model.scene.families),
        arrays="\n  ".join(f"static const double {n}[] = {{{', '.join(repr(float(x)) for x in values)}}};"
                           for n, values in arrays.items()),
        assign="\n  ".join([f"p.{in_c(n)} = {value!r};" for n, value in scalars.items()]
                           + [f"p.{in_c(n)} = {n};" for n in arrays]),
        observe="\n  ".join(f"extra += {model.name}_observe_{n}(&model, 0.5, s.w);" for n in names))


def run_sanitized(where, sources, compiler="gcc", real="double"):
    """(exit status, output) of the program made of `sources` under ASan and UBSan."""
    words = [compiler, "-std=c11", "-O0", *((CALLS,) if compiler == "gcc" else ()), "-ffp-contract=off", "-fsanitize=address,undefined",
             "-fno-sanitize-recover=all", *REALS[real], "-I.", *include_flags(), *sources,
             "-o", "program", "-lm"]
    subprocess.run(words, cwd=where, check=True, capture_output=True, text=True)
    said = subprocess.run(["./program"], cwd=where, capture_output=True, text=True, timeout=120)
    return said.returncode, said.stdout + said.stderr
