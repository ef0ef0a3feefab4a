"""The last evaluation in extended precision, and sums without a carry: features of the generated C."""
import numpy as np
import pytest
import smidgen
from bench.round_off import programs
from bench.round_off.growth import apart
from bench.round_off.programs import DEFAULT, LONG, PAIRS, PLAIN, VARIANTS, ask, program, words
from support.strict import COMPILERS, compile_all
from support.systems import begin, load, model

from smidgen.build.binary import write_files
from smidgen.compile.emit.emit import generate
from smidgen.compile.select import select

# the worst of |W - W in quadruple precision| after one step, |w| = 1 or a little more: the digits of each end
OFF = {DEFAULT: 3e-16, LONG: 1e-19, PAIRS: 1e-24}
MODELS = ["free_rigid_body", "irreversible_rigid_body", "forced_rigid_body", "nambu_a39", "product", "point_vortices",
          "heisenberg_chain"]


def one_step(where, case, name, variant, real=""):
    """W of the first step as pairs of doubles (sites*3, 2)."""
    path = program(where, name, variant, "states.c", real)
    return ask(path, [repr(float(case.h)), 1], f"{len(case.w)} {words(case.w)}").reshape(1, 1, -1, 2)


@pytest.mark.parametrize("name", [MODELS[0], *(pytest.param(n, marks=pytest.mark.long) for n in MODELS[1:])])
def test_digits_of_a_step(name, tmp_path, monkeypatch):
    """Each variant beside the same map in quadruple precision: as many digits as it has, and no more."""
    monkeypatch.setattr(programs, "FLAGS", [f.replace("-O3", "-O0") for f in programs.FLAGS])
    case = begin(name)
    exact = one_step(tmp_path, case, name, LONG, "-DSMG_QUAD")
    off = {v: float(apart(one_step(tmp_path, case, name, v), exact)[0, 0]) for v in OFF}
    print(name, off)
    assert all(off[v] < OFF[v] * np.sqrt(len(case.w)) for v in OFF)
    assert off[DEFAULT] > 1e-19 and off[LONG] > 1e-23       # a default that used more would hide what the feature does


@pytest.mark.parametrize("name", [MODELS[0], pytest.param("heisenberg_chain", marks=pytest.mark.long),
                                  pytest.param("vortex_tracers", marks=pytest.mark.long),
                                  pytest.param("nambu_a31", marks=pytest.mark.long)])
@pytest.mark.parametrize("features", [("extended",), pytest.param(("plain-sums",), marks=pytest.mark.long),
                                      pytest.param(("extended", "plain-sums"), marks=pytest.mark.long)])
def test_features_compile_clean(name, features, tmp_path):
    files = generate(select(load(name)), features=features)
    write_files(files, tmp_path)
    sources = sorted(f for f in files if f.endswith(".c"))
    for compiler in COMPILERS:
        for real, flags in (("double", ()), ("double", ("-DSMG_DOUBLE_DOUBLE",)), ("long double", ())):
            said = compile_all(tmp_path, sources, compiler, *flags, real=real)
            assert not said, f"{compiler} {real} {flags}:\n{said[:2000]}"


def test_plain_sums_carry_nothing():
    """W = w + u rounded: the same first step as with a carry, and other bits soon after."""
    case = begin("free_rigid_body")
    plain, carried = model(case, features=("plain-sums",)), model(case)
    assert plain.start(case.w.copy(), h=case.h).step().w.tobytes() == carried.start(case.w.copy(), h=case.h).step().w.tobytes()
    assert plain.steps(200).w.tobytes() != carried.steps(200).w.tobytes()


@pytest.mark.quick
def test_variants_differ_in_what_they_say():
    """Every variant of the study is another text or another flag."""
    texts = {v: generate(select(load("free_rigid_body")), features=features)["free_rigid_body.c"]
             for v, (features, _) in VARIANTS.items()}
    assert len({texts[PLAIN], texts[DEFAULT], texts[LONG]}) == 3
    assert len({(texts[v], flags) for v, (_, flags) in VARIANTS.items()}) == len(VARIANTS)


@pytest.mark.quick
def test_remainders_of_whole_numbers_divide():
    """q*(1/q) < 1 for some q in pairs too: with the last evaluation the spins go where they go without it, to a few ulps."""
    spec = smidgen.load_text('[model]\nname = "rests"\n[space]\nw = { sphere = 60 }\n[effects.e]\nover = "site(i) of w"\nenergy = "(' + " + ".join(f"mod(i, {q})" for q in range(3, 60, 2)) + ')*w[i].z/500 + mod(i, 3)*w[i].x^2/9"\n')
    w = np.random.default_rng(4).normal(size=(60, 3))
    w /= np.linalg.norm(w, axis=1)[:, None]
    ends = [smidgen.build(spec, features=features).start(w.copy(), h=0.1).steps(3).state() for features in ((), ("extended",))]
    assert np.abs(ends[0] - ends[1]).max() < 1e-14
