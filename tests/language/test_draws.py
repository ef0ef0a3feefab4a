"""uniform(seed, i) and normal(seed, i, j): the same bits in C, in Python and in the witness, by whatever layout and however often they are asked for."""
import shutil
import subprocess

import numpy as np
import pytest
from scipy import stats

import smidgen
from smidgen.check.witness import Witness, disorder
from smidgen.compile.emit.emit import generate
from smidgen.language import draws
from smidgen.language.evaluate import evaluate
from smidgen.language.expr import Idx, Num, Op, Par
from smidgen.resources import include_flags
from smidgen.run.step.start import initial_state

quick = pytest.mark.quick
KNOWN = [((0, 0, 0, 0), 0, "6627e8d5 e169c58d bc57ac4c 9b00dbd8"), ((2**32 - 1,) * 4, 2**64 - 1, "408f276d 41c83b0e a20bc7c6 6d5451fd"),
         ((0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344), 0x299f31d0a4093822, "d16cfe09 94fdcceb 5001e420 24126ea1")]
PROGRAM = """#include <stdio.h>
#include "smg_random.h"
int main(void) {
  for (int64_t k = 0; k < 3000; ++k) {
    const int64_t seed = k * k * k - 5, i = k * 7919 % 100003 - 3, j = k % 7 ? k * 104729 % 99991 : -1;
    printf("%a %a %a %a\\n", smg_uniform_number(smg_words_of_site(seed, i, SMG_USE_UNIFORM)), smg_normal_number(smg_words_of_site(seed, i, SMG_USE_NORMAL)),
           smg_uniform_number(smg_words_of_bond(seed, i, j, SMG_USE_UNIFORM)), smg_normal_number(smg_words_of_bond(seed, j, i, SMG_USE_NORMAL)));
  }
  return 0;
}
"""
GLASS = """[model]
name = "glass"
[space]
w = {{ sphere = "{sites}", kappa = "{kappa}" }}
[parameters]
n = {n}
seed = 7
K = 0.4
[effects.bonds]
over = "bond(i, j) of {lattice}"
energy = "-{bond}*dot(w[i], w[j])"
[effects.anisotropy]
over = "site(i) of w"
energy = "-K*(1 + 0.3*normal(4, i) + if(uniform(9, i) < 0.3, 1, 0))*w[i].z^2 - {field}*w[i].x"
[observables.mx]
over = "site(i) of w"
value = "uniform(seed, i)*w[i].x"
[starts.r]
random = 3
[starts.f]
theta = "pi*uniform(1, i)"
phi = "2*pi*uniform(2, i)"
[runs.demo]
start = "r"
h = 0.1
steps = 20
"""


def glass(lattice="chain(n, periodic)", sites="n", n=12, bond="normal(seed, i, j)", field="0", kappa="1"):
    return smidgen.load_text(GLASS.format(lattice=lattice, sites=sites, n=n, bond=bond, field=field, kappa=kappa))


@quick
def test_python_has_the_known_answers():
    for counter, key, words in KNOWN:
        assert " ".join(f"{int(x):08x}" for x in draws.philox(counter, np.uint64(key))) == words


@quick
def test_c_python_and_witness_have_the_same_bits(tmp_path):
    (tmp_path / "draws.c").write_text(PROGRAM)
    k = np.arange(3000)
    seed, i, j = k**3 - 5, k * 7919 % 100003 - 3, np.where(k % 7, k * 104729 % 99991, -1)
    mine = np.stack([draws.uniform(seed, i), draws.normal(seed, i), draws.uniform(seed, i, j), draws.normal(seed, i, j)], axis=1)
    witness = [[disorder.number(kind, int(a), *map(int, sites)) for kind, sites in (("uniform", (b,)), ("normal", (b,)), ("uniform", (b, c)), ("normal", (c, b)))]
               for a, b, c in zip(seed[:500], i, j)]
    assert np.array_equal(witness, mine[:500])
    for compiler, *flags in (("gcc", "-O2"), ("clang", "-O2"), ("gcc", "-O0")):
        if shutil.which(compiler):
            subprocess.run([compiler, "-std=c11", "-ffp-contract=off", *flags, *include_flags(), str(tmp_path / "draws.c"), "-o", str(tmp_path / "draws"), "-lm"], check=True)
            lines = subprocess.run([str(tmp_path / "draws")], check=True, capture_output=True, text=True).stdout.split()
            assert np.array_equal(np.array([float.fromhex(x) for x in lines]).reshape(-1, 4), mine)


def of_pair(kind, seed, i, j):
    return float(getattr(draws, kind)(seed, np.array(i), np.array(j)))


@quick
@pytest.mark.parametrize("kind", ["uniform", "normal"])
def test_pairs_of_negative_indices_have_numbers_of_their_own(kind):
    """A pair whose larger index is -1 has not the number of the single site of the other."""
    indices = range(-6, 7)
    pairs = [(i, j) for i in indices for j in indices if i <= j]
    found = [of_pair(kind, 7, i, j) for i, j in pairs] + [float(getattr(draws, kind)(7, np.array(i))) for i in indices]
    assert len(set(found)) == len(found)
    assert found == [disorder.number(kind, 7, *pair) for pair in pairs] + [disorder.number(kind, 7, i) for i in indices]
    spec = glass(bond=f"{kind}(seed, i - n, j - n - 4)")
    assert smidgen.validate(spec).passed


@quick
def test_their_distributions():
    i = np.arange(200_000)
    for sites in ((i,), (i, i[::-1])):
        some = tuple(x[:100_000] for x in sites)        # of a pair and its mirror image there is one number
        assert stats.kstest(draws.uniform(11, *some), "uniform").pvalue > 1e-3
        assert stats.kstest(draws.normal(11, *some), "norm").pvalue > 1e-3
    x = np.stack([draws.uniform(s, i) for s in (1, 2)] + [draws.uniform(1, i + 1), draws.normal(1, i), draws.normal(2, i), draws.normal(1, i, i)])
    assert np.abs(np.corrcoef(x) - np.eye(len(x))).max() < 0.012
    assert np.abs(draws.directions(5, 0, 100_000).mean(axis=0)).max() < 0.01


@quick
def test_a_start_has_other_numbers_than_formulas_noise_and_other_families():
    w = initial_state(glass(n=50), "r")
    assert np.allclose(np.linalg.norm(w, axis=1), 1, atol=1e-15)
    assert np.array_equal(w, draws.directions(3, 0, 50))
    assert not np.isin(draws.directions(3, 1, 50), w).any()


@quick
def test_numbers_of_starts_strengths_effects_and_observables():
    spec = glass(kappa="1 + 0.1*uniform(3, i)")
    one, w = smidgen.build(spec).start("f", h=0.1), initial_state(spec, "f")
    assert np.array_equal(w[:, 2], np.cos(np.pi * draws.uniform(1, np.arange(12))))
    witness, i = Witness(spec), np.arange(12)
    assert np.array_equal(witness.kappa, 1 + 0.1 * draws.uniform(3, i))
    values = dict(zip(one.columns, one.values()))
    assert values["mx"] == pytest.approx(np.sum(draws.uniform(7, i) * w[:, 0]), abs=1e-14)
    bonds = -np.sum(draws.normal(7, i, (i + 1) % 12) * np.sum(w * np.roll(w, -1, axis=0), axis=1))
    assert values["energy.bonds"] == pytest.approx(bonds, abs=1e-13)
    assert np.abs(one.field() - witness.field(w)).max() < 1e-14
    assert np.abs(one.steps(20).w - witness.steps(w, 0.0, 0.1, 20)[-1]).max() < 1e-13


@quick
def test_other_parameters_give_other_numbers():
    """A state that goes on with them is as one that begins with them."""
    spec = glass(bond="1", field="uniform(seed, i)")
    one, other = smidgen.build(spec).start("r", h=0.1), smidgen.build(spec, parameters={"K": 0.9})
    one.steps(3).set_parameters({"K": 0.9})
    assert np.array_equal(other.start(one.w.copy(), h=0.1, t0=one.t).steps(3).w, one.steps(3).w)
    assert np.abs(smidgen.build(spec, parameters={"seed": 8}).start("r", h=0.1).steps(3).w - smidgen.build(spec).start("r", h=0.1).steps(3).w).max() > 0.01


@quick
def test_large_seeds_keep_all_digits():
    spec = glass(bond="uniform(1000000007*seed + 5, i, j)", field="normal(-1000000007*seed + i, 3*i - 1)")
    values, i = {"seed": 20251126}, np.arange(12)
    model, witness = smidgen.build(spec, parameters=values).start("f", h=0.1), Witness(spec, values)
    seed = 1000000007 * 20251126
    bonds = -np.sum(draws.uniform(seed + 5, i, (i + 1) % 12) * np.sum(model.w * np.roll(model.w, -1, axis=0), axis=1))
    assert model.values()[model.columns.index("energy.bonds")] == pytest.approx(bonds, abs=1e-13)
    assert np.abs(model.field() - witness.field(model.w)).max() < 1e-14
    drawn = Op("uniform", (Op("+", (Op("*", (Num(1000000007), Par("seed"))), Num(5))), Idx("i")))
    assert np.array_equal(evaluate(drawn, {**values, "i": i}), draws.uniform(seed + 5, i))


PLACES = {"square": ("square(n, 6, periodic)", "6*n", 8), "open": ("cubic(n, 3, 5, open)", "15*n", 6)}


@quick
@pytest.mark.parametrize("place", PLACES)
def test_rows_have_the_numbers_of_sites(place):
    lattice, sites, n = PLACES[place]
    spec = glass(lattice, sites, n, bond="0.7", field="0.2*normal(seed, i)*cos(3*t)")
    assert "define SMG_BY_ROWS" in generate(spec)["glass.c"]
    one = smidgen.build(spec).start("r", h=0.1)
    w = one.w.copy()
    assert np.abs(one.steps(4).w - Witness(spec).steps(w, 0.0, 0.1, 4)[-1]).max() < 1e-13
    assert np.array_equal(smidgen.build(spec, threads=2).start("r", h=0.1).steps(4).w, one.w)


@quick
def test_a_scene_without_them_has_no_trace_of_them():
    text = "".join(generate(smidgen.load("heisenberg_chain")).values())
    assert not any(word in text for word in ("smg_random", "of_sites", "SITE_NUMBERS"))


@quick
def test_their_names_stay_free():
    spec = smidgen.load_text(GLASS.format(lattice="chain(n, periodic)", sites="n", n=12, bond="uniform*normal(uniform(2.0), i)", field="0", kappa="1")
                             .replace("K = 0.4", 'K = 0.4\nuniform = 0.5\n[formulas]\n"normal(a, i)" = "a"').replace("uniform(2.0)", "2.0")
                             .replace("0.3*normal(4, i)", "0.3"))
    assert "smg_normal" not in generate(spec)["glass.c"]


@pytest.mark.parametrize("call, said", [("uniform(7)", "takes 2 arguments"), ("uniform(7, t)", "integers, integer parameters and indices"),
                                        ("normal(0.5, i)", "integers, integer parameters and indices"), ("uniform(7, w[i].x)", "integers"),
                                        ("uniform(7, i, K)", "integers"), ("unifrom(7, i)", "did you mean `uniform`"), ("normal", "function"), ("normal(7, w[i])", "does not take")])
@quick
def test_what_they_do_not_take(call, said):
    with pytest.raises(smidgen.SpecError, match=said):
        glass(field=call)


@quick
@pytest.mark.parametrize("sites", [1, 2])
def test_numbers_of_a_site_that_is_named(sites):
    """They are found with the coefficients, once a model or a step."""
    spec = smidgen.load_text(f'[model]\nname = "one"\n[space]\nw = {{ sphere = {sites} }}\n[effects.e]\nover = "site(k) of w"\nenergy = "0.1*normal(9, 1)*cos(t)*w[k].x + uniform(2, k)*w[k].z^2"\n')
    one = smidgen.build(spec).start(np.array([[0.6, 0, 0.8]] * sites), h=0.1)
    w = one.w.copy()
    assert one.energy() == pytest.approx(np.sum(0.06 * draws.normal(9, 1) + draws.uniform(2, np.arange(sites)) * 0.64), abs=1e-15)
    assert np.abs(one.steps(5).w - Witness(spec).steps(w, 0.0, 0.1, 5)[-1]).max() < 1e-14
