"""Sizes are values at run time: each is computed, checked, and no other size is another program."""
import re
import subprocess
from itertools import cycle

import pytest
from support.features import ANYWHERE, DIVIDED
from support.strict import WARNINGS, run_sanitized

from smidgen.build.binary import write_files
from smidgen.compile.emit.emit import generate
from smidgen.errors import UsageError
from smidgen.read import load_text
from smidgen.resources import include_flags
from smidgen.compile.select import select

SPEC = """
[model]
name = "sized"
[space]
w = {{ sphere = "n", kappa = "{kappa}" }}
v = {{ sphere = "m" }}
[parameters]
n = 4
m = 3
gamma = {{ default = 1.0, size = "{size}" }}
delta = {{ default = 0.5, size = "{other}" }}
[effects.field]
over = "site(i) of w"
energy = "{energy}"
[effects.chain]
over = "bond(i, j) of chain(m, open) on v"
energy = "dot(v[i], v[j])"
[observables.seen]
over = "site(i) of v"
value = "delta[i]*v[i].x"
"""
LATTICE = """
[model]
name = "sized"
[space]
w = { sphere = "2*n" }
[parameters]
n = 4
J = 1.0
B = 0.5
[effects.chain]
over = "bond(i, j) of chain(2*n, periodic)"
energy = "-J*dot(w[i], w[j])"
[effects.field]
over = "site(i) of w"
energy = "-B^2*w[i].z"
"""
USES = {"kappa": ("gamma[i] + 1", "w[i].z^2"), "energy": ("1", "gamma[i]*w[i].z^2"), "nothing": ("1", "w[i].z^2")}
LENGTHS = ("n", "2*n", "n + m", "n*m", "3*n - m", "m*m", "5")


def sized(size="2*n", use="kappa", other="n*m + 1"):
    kappa, energy = USES[use]
    return SPEC.format(size=size, kappa=kappa, energy=energy, other=other)


@pytest.mark.quick
@pytest.mark.parametrize("size, use, features", [*((size, use, ()) for size, use in zip(LENGTHS, cycle(USES))),
                                                 *(("2*n", use, ANYWHERE) for use in USES)])
def test_every_coefficient_that_is_read_is_computed(size, use, features):
    """Sizes n0, n1, .. in `_sizes`, values k0, k1, .. in `_prepare`, `_set_step` or `_set_time`; none is declared in vain."""
    all_are_computed(sized(size, use), features)


@pytest.mark.quick
def test_every_coefficient_of_a_divided_lattice_is_computed():
    all_are_computed(LATTICE, DIVIDED)


def all_are_computed(text, features):
    files = generate(load_text(text), features=features)
    read = set(re.findall(r"(?:c|wide|model)->([nk]\d+)(?! = )", files["sized.c"]))
    computed = set(re.findall(r"(?:c|wide|model)->([nk]\d+) = ", files["sized.c"]))
    declared = set(re.findall(r"(?:int64_t|smg_real|smg_wide) ([nk]\d+);", files["sized.h"]))
    assert read <= computed == declared


MAIN = """
#include "sized.h"
#include <stdlib.h>
/* A check in memory that was used before, with arrays of exactly their sizes; a bad entry, the last one, is seen. */
int main(void) {
  for (int64_t n = 3; n < 6; ++n) {
    sized_params p;
    sized_model model;
    sized_defaults(&p);
    p.n = n;
    double *gamma = (double *)malloc((size_t)(2 * n) * sizeof(double)), *delta = (double *)malloc((size_t)(3 * n + 1) * sizeof(double));
    for (int64_t k = 0; k < 2 * n; ++k) gamma[k] = 1;
    for (int64_t k = 0; k < 3 * n + 1; ++k) delta[k] = 1;
    p.gamma = gamma;
    p.delta = delta;
    if (sized_model_init(&model, &p) != SMG_OK) return 1;
    delta[3 * n] = (double)NAN;
    if (sized_model_init(&model, &p) != SMG_NOT_FINITE) return 2;
    free(gamma);
    free(delta);
  }
  return 0;
}
"""


def test_arrays_are_checked_over_their_own_sizes(tmp_path):
    files = generate(load_text(sized()))
    write_files({**files, "main.c": MAIN}, tmp_path)
    status, said = run_sanitized(tmp_path, ["sized.c", "main.c"])
    assert status == 0, said[:3000]


# -- the C refuses the sizes that the reader refuses -----------------------------------------------

ACCESS = """
[model]
name = "access{number}"
[space]
w = {{ sphere = "n", kappa = "{kappa}" }}
v = {{ sphere = "m" }}
[parameters]
n = 3
m = 2
k = 1
gamma = {{ default = 1.0, size = "n" }}
A = {{ default = 1.0, size = "n*m" }}
F = {{ default = [1.0, 2.0, 1.5, 0.5], size = 4, fixed = true }}
[effects.all]
over = "each(i of w, j of v)"
energy = "({energy})*dot(w[i], v[j]) + gamma[0] + A[0] + k*F[0]"
"""
ACCESSES = [("gamma[i] + 1", "1"), ("1 + F[i]", "1"), ("1 + gamma[2*i - i]", "1"), ("2 + A[i*i - k*i]", "1"), ("1 + gamma[k]", "1"),
            ("1", "gamma[j]"), ("1", "F[i + j]"), ("1", "A[i + n*j + 0*j*k*i]"), ("1", "A[(k - 1)*i + (j - 1)*(k - 2) + 1]"),
            ("1", "gamma[n - 1 - i]")]
BOX = [(n, m, k) for n in range(6) for m in range(5) for k in range(-1, 5)]


def one_try(sizes: str, arrays: tuple = (), fill: str = "") -> str:
    """C that gives the parameters of {name} these sizes, and the arrays that `fill` declares, and prints the status of its model."""
    given = "".join(f"  p.{x} = {x};\n" for x in (*sizes, *arrays))
    return (f"\nstatic void try_{{name}}({', '.join(f'int64_t {x}' for x in sizes)}) {{{{\n{fill}  {{name}}_params p;\n  {{name}}_model model;\n  {{name}}_defaults(&p);\n"
            f'{given}  printf("%d ", (int){{name}}_model_init(&model, &p));\n}}}}\n')


TRY = one_try("nmk", ("gamma", "A"), """  double gamma[8], A[32];
  for (int e = 0; e < 8; ++e) gamma[e] = e < n ? 1 : (double)NAN; /* what is not its own reads as not finite */
  for (int e = 0; e < 32; ++e) A[e] = e < n * m ? 1 : (double)NAN;
""")


def accepted(spec, place):
    try:
        return bool(select(spec, None, dict(zip("nmk", place))))
    except UsageError:
        return False


def said_by_c(folder, specs, program, box, method="spherical-midpoint"):
    """The status of each size of the box, as the C of each spec has it."""
    files = {name: text for spec in specs for name, text in generate(spec, method).items() if not name.endswith("_abi.c")}
    heads = "".join(f'#include "{spec.name}.h"\n' for spec in specs)
    tries = "".join(program.format(name=spec.name) for spec in specs)
    arguments = ", ".join(f"box[b][{k}]" for k in range(len(box[0])))
    calls = "".join(f'  for (int b = 0; b < {len(box)}; ++b) try_{spec.name}({arguments});\n  puts("");\n' for spec in specs)
    sizes = ", ".join(f"{{{', '.join(map(str, place))}}}" for place in box)
    main = f"{heads}#include <stdio.h>\n{tries}\nint main(void) {{\n  static const int box[][{len(box[0])}] = {{{sizes}}};\n{calls}  return 0;\n}}\n"
    write_files({**files, "main.c": main}, folder)
    subprocess.run(["gcc", "-std=c11", *WARNINGS, "-O0", *include_flags(), "-I.", *sorted(f for f in files if f.endswith(".c")),
                    "main.c", "-lm", "-o", "program"], cwd=folder, check=True)
    said = subprocess.run(["./program"], cwd=folder, capture_output=True, text=True, check=True).stdout.splitlines()
    assert len(said) == len(specs)
    return [line.split() for line in said]


def refuses_what_the_reader_refuses(folder, specs, program, box, method="spherical-midpoint"):
    for spec, said in zip(specs, said_by_c(folder, specs, program, box, method)):
        assert set(said) <= {"0", "5"}, spec.name
        assert [place for place, found in zip(box, said) if found == "5"] == [place for place in box if not accepted(spec, place)], spec.name


@pytest.mark.parametrize("accesses", [ACCESSES[3::3], pytest.param(ACCESSES, marks=pytest.mark.long)], ids=len)
def test_the_c_refuses_the_sizes_that_the_reader_refuses(accesses, tmp_path):
    """Of every index formula, over a box of sizes; a size that is accepted reads no entry but the array's own."""
    specs = [load_text(ACCESS.format(number=k, kappa=kappa, energy=energy)) for k, (kappa, energy) in enumerate(accesses)]
    refuses_what_the_reader_refuses(tmp_path, specs, TRY, BOX)


LOOPED = """
[model]
name = "looped{number}"
[space]
a = {{ sphere = "n*m" }}
b = {{ sphere = "n*m" }}
[parameters]
n = 5
m = 5
[lattices.film]
size = ["n", "m"]
boundary = ["periodic", "{boundary}"]
bonds.far = [{{ at = {ends} }}]
bonds.near = [{{ offset = [0, 0] }}]
[effects.far]
over = "bond({over}) of film.far"
energy = "{energy}"
[effects.near]
over = "bond(i of a, j of b) of film.near"
energy = "-dot(a[i], b[j])"
"""
THREE, FOUR = ("i of a, j of b, k of a", "0.4*a[i].x*b[j].y*a[k].z"), ("i of a, j of b, k of b, l of a", "a[i].x*b[j].y*b[k].z*a[l].x")
LOOPS = [("[[0, -1, 0], [0, 0, 0], [0, 1, 0]]", *THREE, "open"), ("[[0, 0, -1], [0, 0, 0], [0, 1, 1]]", *THREE, "periodic"), ("[[0, 0, -1], [0, 0, 0], [0, 0, 1]]", *THREE, "open"),
         ("[[0, 0, 0], [0, 1, 0], [0, 1, 1], [0, -1, 0]]", *FOUR, "periodic"), ("[[0, 0, 1], [0, 2, 0], [0, 2, 2], [0, 2, 1]]", *FOUR, "periodic")]
AROUND = [(n, m) for n in range(1, 6) for m in range(1, 6)]

@pytest.mark.parametrize("method", ["sublattice-rotations", pytest.param("spherical-midpoint", marks=pytest.mark.long)])
def test_no_bond_of_several_families_joins_a_site_to_itself(method, tmp_path):
    """Of three and four ends, two of them of one family: rings that are so short are refused by the reader and by the C."""
    specs = [load_text(LOOPED.format(number=k, ends=ends, over=over, energy=energy, boundary=boundary)) for k, (ends, over, energy, boundary) in enumerate(LOOPS)]
    short = [lambda n, m: n < 3, lambda n, m: n == 1 and m < 3, lambda n, m: False, lambda n, m: n == 1 or m == 1, lambda n, m: n < 3 or m < 3]
    assert [[place for place in AROUND if not accepted(spec, place)] for spec in specs] == [[place for place in AROUND if is_short(*place)] for is_short in short]
    refuses_what_the_reader_refuses(tmp_path, specs, one_try("nm"), AROUND, method)


COUNTED = """
[model]
name = "counted{number}"
[space]
a = {{ sphere = "n" }}
b = {{ sphere = "m" }}
[parameters]
n = 4
m = 4
k = 4
J = {{ default = 1.0, size = "m" }}
[lattices.ring]
size = ["k"]
boundary = "periodic"
bonds.near = [{{ offset = [1] }}]
[graphs.path]
edges = [[0, 1], [1, 2], [2, 3]]
[effects.near]
over = "{over}"
energy = "{energy}"
[effects.field]
over = "site(i) of {other}"
energy = "{other}[i].z"
"""
UNNAMED = [("bond(i of a, j of b) of ring.near", "J[j]*a[i].x", "b"), ("edge(i, j) of path on b", "J[j]", "a"), ("bond(i, j) of ring.near on b", "J[j]", "a")]
FILLED = one_try("nmk", ("J",), """  double J[8];
  for (int e = 0; e < 8; ++e) J[e] = 1;
""")


def test_families_that_no_formula_names_have_the_sites_of_their_bonds(tmp_path):
    """Their numbers are places in an array."""
    specs = [load_text(COUNTED.format(number=k, over=over, energy=energy, other=other)) for k, (over, energy, other) in enumerate(UNNAMED)]
    refuses_what_the_reader_refuses(tmp_path, specs, FILLED, [(n, m, k) for n in (3, 4, 5) for m in (2, 3, 4, 5) for k in (3, 4)])
