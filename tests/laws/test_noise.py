"""Thermal noise: N(h/2) step N(h/2), the numbers of Philox by step, site and half; exp(-H/kT) is stationary up to h^2.

The bias of the mean needs no sampling: for one spin in a field along z the height u = w.z is a Markov chain, whose kernel acts on Legendre
polynomials of u. Noise multiplies P_l by the mean of P_l over its turn, with the variance that the C has; the step between is that of the C.
"""
import ctypes
import shutil
import subprocess

import numpy as np
import pytest
from support.strict import COMPILERS, OPTIMISED, READ, REALS, compile_all
from support.thermal import heat, nodes, stationary, transition

import smidgen
from smidgen.build.binary import write_files
from smidgen.check.witness import Witness
from smidgen.check.witness.thermal import philox
from smidgen.compile.emit.emit import generate
from smidgen.compile.select import select
from smidgen.errors import RunError, UsageError
from smidgen.methods import METHODS
from smidgen.resources import include_flags
from smidgen.run.step.integrator import build
from smidgen.run.step.saved import COUNT_HIGH

quick = pytest.mark.quick
SPIN = """[effects.field]
over = "site(i) of w"
energy = "-w[i].z"
"""
PAIRS = SPIN + """[effects.pairs]
over = "pair(i, j) of w"
energy = "0.7*dot(w[i], w[j])"
"""
AXIS = SPIN + """[effects.axis]
over = "site(i) of w"
energy = "-0.4*w[i].x^2"
"""
CUBE = """[effects.exchange]
over = "bond(i, j) of cubic(n, n, n, periodic)"
energy = "-dot(w[i], w[j])"
"""


def spec_of(effects, sites=1, form="gilbert", kT="kT", alpha="alpha", space='sphere = "{sites}"', values="n = 6\nkT = 0.5\nalpha = 0.5", more="", orientation=1):
    return smidgen.load_text(f"""[model]
name = "warm"
orientation = {orientation}
[space]
w = {{ {space.format(sites=sites)} }}
[parameters]
{values}
{effects}[effects.bath]
over = "site(k) of w"
damping = "{alpha}"
kT = "{kT}"
form = "{form}"
[starts.a]
random = 5
{more}""")


# --- random numbers

PROGRAM = """#include <stdio.h>
#include <string.h>
#include "smg_random.h"
int main(void) {
  const smg_philox counters[3] = {{{0, 0, 0, 0}}, {{~0u, ~0u, ~0u, ~0u}}, {{0x243f6a88u, 0x85a308d3u, 0x13198a2eu, 0x03707344u}}};
  const uint64_t keys[3] = {0, ~0ull, 0x299f31d0a4093822ull};
  for (int k = 0; k < 3; ++k) {
    const smg_philox r = smg_philox_of(counters[k], keys[k]);
    printf("%08x %08x %08x %08x\\n", r.word[0], r.word[1], r.word[2], r.word[3]);
  }
  const smg_philox c = smg_counter((1ll << 48) - 1, (1ll << 40) - 2, 0xab, 0x12345678u);
  printf("%08x %08x %08x %08x\\n", c.word[0], c.word[1], c.word[2], c.word[3]);
  uint64_t sum = 0;
  for (int64_t k = 0; k < 200000; ++k) {
    double x[3];
    smg_three_normals(smg_philox_of(smg_counter(k, 7, 1, 2), 99), x);
    for (int b = 0; b < 3; ++b) {
      uint64_t bits;
      memcpy(&bits, x + b, 8);
      sum = sum * 6364136223846793005ull + bits;
    }
    if (k < 1000) printf("%.17g %.17g %.17g\\n", x[0], x[1], x[2]);
  }
  printf("%016llx\\n", (unsigned long long)sum);
  return 0;
}
"""
KNOWN = ["6627e8d5 e169c58d bc57ac4c 9b00dbd8", "408f276d 41c83b0e a20bc7c6 6d5451fd", "d16cfe09 94fdcceb 5001e420 24126ea1",
         "ffffffff fffeffff abffffff 12345678"]


def output_of(place, compiler, *flags) -> list[str]:
    (place / "numbers.c").write_text(PROGRAM)
    subprocess.run([compiler, "-std=c11", "-ffp-contract=off", *flags, *include_flags(), str(place / "numbers.c"), "-o", str(place / "numbers"), "-lm"], check=True)
    return subprocess.run([str(place / "numbers")], check=True, capture_output=True, text=True).stdout.splitlines()


@quick
def test_philox_has_its_known_answers_and_every_compiler_the_same_bits(tmp_path):
    """C and witness; gcc and clang, with and without optimisation; the normals beside those of numpy's functions."""
    lines = output_of(tmp_path, "gcc", "-O2")
    assert lines[:4] == KNOWN
    witness = philox([[0] * 4, [2**32 - 1] * 4, [0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344]], 0)[:1], philox([[2**32 - 1] * 4], 2**64 - 1), \
        philox([[0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344]], 0x299f31d0a4093822)
    assert [" ".join(f"{int(x):08x}" for x in found[0]) for found in witness] == KNOWN[:3]
    others = [("gcc", "-O0"), ("gcc", "-O3", "-march=native", "-fno-tree-slp-vectorize"), ("clang", "-O0"), ("clang", "-O2", "-march=native")]
    for compiler, *flags in others:
        if shutil.which(compiler):
            assert output_of(tmp_path, compiler, *flags) == lines
    from smidgen.check.witness.thermal import normals
    mine = np.array([line.split() for line in lines[4:1004]], float)
    theirs = np.array([normals(99, k, 8, 1, 2)[7] for k in range(1000)])
    assert np.abs(mine - theirs).max() < 3e-15


@quick
def test_normals_have_the_moments_of_normals():
    """Of three million, within five standard errors: mean, variance, third and fourth moment, and no correlation of the three."""
    from smidgen.check.witness.thermal import normals
    x = np.concatenate([normals(11, k, 20000, 0) for k in range(5)])
    n = len(x)
    for power, moment, variance in ((1, 0, 1), (2, 1, 2), (3, 0, 15), (4, 3, 96), (6, 15, 10170)):
        assert np.abs((x**power).mean(0) - moment).max() < 5 * np.sqrt(variance / n)
    assert np.abs(np.corrcoef(x.T) - np.eye(3)).max() < 5 / np.sqrt(n)


# --- steps beside the witness

@pytest.mark.parametrize("method", [pytest.param(m, marks=quick if m in ("cf4", "gauss-4", "dop853", "spherical-midpoint", "spherical-midpoint-4") else pytest.mark.long)
                                    for m in METHODS if METHODS[m].responds and not METHODS[m].variant])
def test_steps_are_those_of_the_witness(method):
    spec = spec_of(PAIRS + AXIS[len(SPIN):], 4)
    one = build(spec, method=method).start("a", h=0.1, seed=2**63 + 7)
    theirs = Witness(spec, seed=2**63 + 7).steps(one.w.copy(), 0, 0.1, 10, method)[-1]
    assert np.abs(one.steps(10).w - theirs).max() < (1e-11 if METHODS[method].controlled else 2e-14)


@pytest.mark.parametrize("method", ["spherical-midpoint", "heun", "depondt-mertens"])
def test_steps_with_the_other_orientation_are_those_of_the_witness(method):
    """Noise has no orientation: its strength is that of |h|."""
    spec = spec_of(PAIRS, 3, space='sphere = "{sites}", kappa = -2.0, radius = 0.5', orientation=-1)
    one = build(spec, method=method).start("a", h=0.1, seed=5)
    theirs = Witness(spec, seed=5).steps(one.w.copy(), 0, 0.1, 10, method)[-1]
    assert np.abs(one.steps(10).w - theirs).max() < 2e-14


@pytest.mark.parametrize("effects, sites, space", [
    pytest.param(AXIS, 1, "sphere = 1", marks=quick), (AXIS, 3, 'sphere = "3", kappa = -2.0, radius = 0.5'), (SPIN, 2, "sphere = 2"), (CUBE, 216, 'sphere = "n*n*n"'),
    (AXIS, 2, "r3 = 2")])
@pytest.mark.parametrize("kT, h", [("0.5*(1 + k)", 0.05), ("200", 0.05)])
def test_every_layout_has_the_same_noise(effects, sites, space, kT, h):
    """A single sphere, sites alone, a lattice by rows, R^3; noise by site, and so strong that there are several turns."""
    spec = spec_of(effects, sites, "ll", kT, "0.3", space)
    one = build(spec).start("a", h=h, seed=3, member=4)
    theirs = Witness(spec, seed=3, member=4).steps(one.w.copy(), 0, h, 5)[-1]
    length = np.linalg.norm(one.w, axis=1)
    assert np.abs(one.steps(5).w - theirs).max() < 2e-14
    assert np.abs(np.linalg.norm(one.w, axis=1) / length - 1).max() < 2e-14


@quick
def test_lengths_walk_at_random():
    """|w| of 20 spins after 10^4 steps: round-off of 2 * 10^4 turns, of no one sign."""
    one = build(spec_of(SPIN, 20, "ll", alpha="0.3")).start("a", h=0.1)
    drift = np.linalg.norm(one.steps(10000).w, axis=1) - 1
    assert np.abs(drift).max() < 8 * 1.1e-16 * np.sqrt(20000)
    assert abs(drift.mean()) < 3 * 1.1e-16 * np.sqrt(20000)


# --- the stationary mean, without sampling

def mean_height(one, h, diffusion):
    """Of the stationary distribution; every node is a spin of its own."""
    u, factors = nodes()[0], heat(diffusion, h)
    ends = one.start(np.stack([np.sqrt(1 - u**2), 0 * u, u], 1), h=h).step().state()[:, 2]
    return stationary(factors[:, None] * transition(ends) * factors)[1]


@quick
@pytest.mark.parametrize("form, biases", [("ll", (-5.5748e-3, -1.39528e-3, -3.48942e-4)), ("gilbert", (-3.56964e-3, -8.93125e-4, -2.23332e-4))])
def test_the_bias_of_the_mean_of_a_spin_in_a_field(form, biases):
    """B = 1, kT = 0.5, alpha = 0.5, exactly coth 2 - 1/2; the deterministic step by the C, in the scene without noise."""
    spec = spec_of(SPIN, 120, form)
    one, exact = build(spec.calm), 1 / np.tanh(2) - 0.5
    assert abs(exact - .537314720727548) < 1e-14
    diffusion = Witness(spec).diffusion[0]
    assert np.isclose(diffusion, 0.25 if form == "ll" else 0.2, rtol=1e-15)
    for h, bias in zip((0.4, 0.2, 0.1), biases):
        assert abs(mean_height(one, h, diffusion) - exact - bias) < 6e-9 + 6e-6 * abs(bias)


def test_the_mean_that_is_sampled():
    """1000 spins of one seed: the mean over spins and times within four standard errors, found from the spins, which are independent, of coth 2 - 1/2."""
    one = build(spec_of(SPIN, 1000)).start("a", h=0.1, seed=1)
    one.steps(100)
    heights = np.mean([one.steps(20).w[:, 2].copy() for _ in range(30)], axis=0)
    exact = 1 / np.tanh(2) - 0.5 - 2.23332e-4
    assert abs(heights.mean() - exact) < 4 * heights.std(ddof=1) / np.sqrt(len(heights))
    assert heights.std(ddof=1) / np.sqrt(len(heights)) < 4e-3


# --- bits

@quick
@pytest.mark.parametrize("effects, sites, space", [(AXIS, 1, "sphere = 1"), (PAIRS, 4, "sphere = 4"), (CUBE, 216, 'sphere = "n*n*n"')])
def test_a_restart_has_the_bits_of_the_unbroken_run(effects, sites, space):
    spec = spec_of(effects, sites, space=space)
    one, other = build(spec).start("a", h=0.1, seed=2**64 - 1, member=3), build(spec)
    saved = one.steps(7).save()
    other.start("a", h=0.2).restore(saved)
    assert np.array_equal(one.steps(20).w, other.steps(20).w)
    assert np.array_equal(one.start("a", h=0.1, seed=8).steps(20).w, other.start("a", h=0.1, seed=8).steps(9).steps(11).w)
    assert not np.array_equal(one.w, other.start("a", h=0.1, seed=9).steps(20).w)


def test_a_run_with_checkpoints_goes_on(tmp_path):
    spec = spec_of(PAIRS, 4, more='[runs.demo]\nstart = "a"\nh = 0.05\nsteps = 60\n')
    whole = smidgen.run(spec, seed=5)
    calls = []

    def stop(done):
        calls.append(done)
        raise RuntimeError

    with pytest.raises(RuntimeError):
        smidgen.run(spec, seed=5, out=tmp_path / "a.h5", checkpoint=20, progress=stop)
    assert np.array_equal(smidgen.resume(tmp_path / "a.h5").final, whole.final)
    first = build(spec).start("a", h=0.05).w
    assert not np.array_equal(smidgen.run(spec, seed=6, start=first).final, smidgen.run(spec, seed=7, start=first).final)


@pytest.mark.parametrize("effects, sites, space", [(AXIS, 1, "sphere = 1"), (PAIRS, 4, "sphere = 4")])
@pytest.mark.parametrize("method", ["spherical-midpoint", "dop853", "extrapolation-12"])
def test_members_of_an_ensemble_have_the_noise_that_they_have_alone(effects, sites, space, method):
    spec = spec_of(effects, sites, space=space)
    alphas = np.array([0.0, 0.1, 0.4, 1.0, 0.2])
    found = smidgen.ensemble(spec, start="a", method=method, h=0.1, steps=12, parameters={"alpha": alphas}, seed=3)
    for k, alpha in enumerate(alphas):
        alone = build(spec, method=method, parameters={"alpha": float(alpha)}).start("a", h=0.1, seed=3, member=k)
        assert np.array_equal(alone.steps(12).w, found.w[k])
    same = smidgen.ensemble(spec, start=np.tile(found.w[:1], (2, 1, 1)), method=method, h=0.1, steps=2, seed=3)
    assert not np.array_equal(same.w[0], same.w[1])


def test_threads_change_no_bit():
    spec = spec_of(CUBE, 0, space='sphere = "n*n*n"', values="n = 32\nkT = 0.5\nalpha = 0.2")
    assert "by rows" in build(spec).notes["reason"]
    assert np.array_equal(build(spec).start("a", h=0.05).steps(3).w, build(spec, threads=2).start("a", h=0.05).steps(3).w)


@pytest.mark.parametrize("effects, sites, space", [(AXIS, 1, "sphere = 1"), pytest.param(PAIRS, 4, "sphere = 4", marks=pytest.mark.long)])
def test_compilers_give_the_same_states(tmp_path, effects, sites, space):
    """gcc and clang, -O0 and -O2."""
    files, found = generate(spec_of(effects, sites, space=space)), []
    write_files(files, tmp_path)
    for compiler, how in (("gcc", "-O0"), ("gcc", "-O2"), ("clang", "-O0"), ("clang", "-O2")):
        if shutil.which(compiler):
            library = tmp_path / f"{compiler}{how}.so"
            subprocess.run([compiler, "-std=c11", how, "-ffp-contract=off", "-fPIC", "-shared", *include_flags(), *(str(tmp_path / f) for f in files if f.endswith(".c")),
                            "-o", str(library), "-lm"], check=True)
            found.append(bytes(stepped(ctypes.CDLL(str(library)), sites)))
    assert len(found) >= 2 and len(set(found)) == 1


def stepped(library, sites):
    """The state after 50 steps with the spec's values, by the flat functions."""
    scalars = (ctypes.c_double * 2)(0.5, 0.5)
    w, status, done = (ctypes.c_double * (3 * sites))(*([0.6, 0.0, 0.8] * sites)), ctypes.c_int(), ctypes.c_int64()
    library.warm_abi_new.restype = ctypes.c_void_p
    state = ctypes.c_void_p(library.warm_abi_new(scalars, None, w, ctypes.c_double(0), ctypes.c_double(0.1), ctypes.byref(status)))
    assert status.value == 0
    library.warm_abi_set_seed(state, ctypes.c_int64(4), ctypes.c_int64(0))
    assert library.warm_abi_steps(state, ctypes.c_int64(50), ctypes.byref(done)) == 0
    library.warm_abi_state(state, w)
    library.warm_abi_free(state)
    return w


# --- what is given up, refused, left out

@quick
def test_a_step_that_does_not_exist_is_taken_as_two_halves():
    """Pairs at a step at which some states have no midpoint: each is counted, the path goes on, and a restart keeps the count."""
    spec = spec_of(PAIRS + AXIS[len(SPIN):].replace("0.4", "1.5"), 6, values="n = 6\nkT = 2.0\nalpha = 0.05")
    one = build(spec).start("a", h=1.0, seed=1)
    calm = build(spec.calm)
    one.steps(100)
    assert 0 < one.halved < 100
    again = build(spec).start("a", h=1.0).restore(one.save())
    assert again.halved == one.halved and np.array_equal(again.steps(5).w, one.steps(5).w)
    assert calm.start("a", h=1.0).halved == 0


@quick
@pytest.mark.parametrize("name, method", [("pairs", "spherical-midpoint"), ("pairs", "gauss-4"), ("cube", "spherical-midpoint")])
def test_without_kT_there_is_nothing_of_it(name, method):
    spec = spec_of(*((PAIRS, 4) if name == "pairs" else (CUBE, 216)), space='sphere = 4' if name == "pairs" else 'sphere = "n*n*n"')
    text = spec.sources[0][1]
    other = smidgen.load_text(text.replace('kT = "kT"\n', ""))
    mine, theirs = ({n: t for n, t in generate(select(s, None), method).items()} for s in (spec, other))
    assert all(word not in "".join(theirs.values()) for word in ("THERMAL", "seed", "unturned", "halved", "diffusion"))
    assert "SMG_THERMAL" in mine["warm.c"]


@quick
def test_what_does_not_go_with_noise_is_refused():
    spec = spec_of(SPIN, 2, more='[runs.demo]\nstart = "a"\nh = 0.05\nsteps = 20\n')
    with pytest.raises(UsageError, match="with noise, steps cannot be negative"):
        build(spec).start("a", h=-0.1)
    with pytest.raises(UsageError, match="`substeps` cannot be used with thermal noise"):
        smidgen.run(spec, substeps=True)
    with pytest.raises(UsageError, match="the feature `tangent` requires motion without noise"):
        build(spec, features=("tangent",))
    with pytest.raises(UsageError, match="ask for the error of a mean"):
        smidgen.choose(spec, energy=1e-3)
    with pytest.raises(UsageError, match="the seed of noise must be an integer from 0 to 18446744073709551615"):
        build(spec).start("a", h=0.1, seed=2**64)
    with pytest.raises(UsageError, match="no effect of the scene has kT"):
        build(spec.calm).start("a", h=0.1, member=1)
    with pytest.raises(UsageError, match="the kT of `w.0.` is -1"):
        build(spec, parameters={"kT": -1.0})
    with pytest.raises(UsageError, match=r"does not support damping \(effect"):
        build(spec, method="axis-splitting")
    for method in ("spherical-midpoint", "heun"):
        one = build(spec, method=method).start("a", h=0.1)
        late = one.save()
        late[COUNT_HIGH] = 2**16
        with pytest.raises(RunError, match="a parameter or a size is out of range"):
            one.restore(late).step()        # from 2^48 steps on the counter would repeat itself
    result = smidgen.run(spec, estimate=True)
    assert result.meta["end_error"] is None and "a different trajectory" in result.meta["end_error_withheld"]


@quick
def test_reports_say_what_is_given_up():
    spec = spec_of(PAIRS, 4, more='[runs.demo]\nstart = "a"\nh = 0.05\nsteps = 200\n')
    words = " ".join(smidgen.explain(spec).words())
    assert "Thermal noise rotates the vectors of w" in words and "exp(-H/kT) is stationary" in words and "energy decreases" not in words
    assert smidgen.explain(spec).as_dict()["heated"] == ["w"] and "Thermal" not in " ".join(smidgen.explain(spec.calm).words())
    found = smidgen.run(spec)
    assert set(found.summary["errors"]) == {"casimirs"} and found.summary["halved"] == 0
    report = smidgen.validate(spec, points=2, steps=20)
    assert any("with noise" in line.check and line.passed for line in report.lines)


def test_its_certificate_passes(few_states):
    spec = spec_of(PAIRS + AXIS[len(SPIN):], 4, values="n = 6\nkT = 0.5\nalpha = 0.3", more='[runs.demo]\nstart = "a"\nh = 0.05\nsteps = 200\n')
    found = smidgen.verify(spec, tier="quick")
    found.check()
    assert found.row("noise").verdict == found.row("noise restored").verdict == "yes"


@pytest.mark.parametrize("compiler, real", [("gcc", "double"), ("clang++", "long double"), *(pytest.param(c, r, marks=pytest.mark.long) for c in COMPILERS for r in REALS)])
@pytest.mark.parametrize("effects, sites, method, features", [(AXIS, 1, "spherical-midpoint", ("ensemble",)), (PAIRS, 4, "spherical-midpoint-4", ()), pytest.param(CUBE, 216, "spherical-midpoint", (), marks=pytest.mark.long),
                                                              (PAIRS, 4, "dop853", ("ensemble",))])
def test_no_compiler_complains(tmp_path, effects, sites, method, features, compiler, real):
    """A single sphere and its ensemble, a composition, a lattice by rows, step control."""
    if compiler not in COMPILERS:
        pytest.skip("no such compiler")
    files = generate(spec_of(effects, sites, space='sphere = "n*n*n"' if effects is CUBE else f"sphere = {sites}"), method, features=features)
    write_files(files, tmp_path)
    assert not compile_all(tmp_path, [f for f in files if f.endswith(".c")], compiler, real=real, how=OPTIMISED if compiler == "gcc" else READ)
