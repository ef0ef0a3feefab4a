"""Lattices by rows whose effects over single sites differ from site to site, in time as well: the step that the equation has, and the state from site to site."""
import re

import numpy as np
import pytest
import smidgen
from smidgen.check.witness import Witness
from smidgen.compile.emit.emit import generate
from support.by_sites import by_sites
from support.going_on import one_by_one, restored
from support.strict import COMPILERS, MODES, compile_all
from support.widths import same_by_clang, same_in_lanes
from test_rows import DM, EXCHANGE, FAR, HONEY, LADDER, SKEW, lattice
from test_rows_in_time import MIDPOINT, TURNS, WAVE, by_rows, field

ARRAYS = '\na = {{ default = [{}], size = "{}" }}\nb = {{ default = [{}], size = "{}" }}\nomega = 2.0\n'
SITED = "-0.6*a[i]*w[i].z"
KINDS = {
    "field": SITED, "anisotropy": "-0.3*a[i]*w[i].z^2 + 0.2*b[i]*w[i].x*w[i].y", "both in one": "0.4*a[i]*(w[i].y - b[i])^2",
    "in time": "-0.5*a[i]*cos(omega*t)*w[i].z + 0.1*b[i]*w[i].x", "phases": "0.5*cos(omega*t + 3*b[i])*w[i].x - 0.4*sin(b[i] - t)*w[i].y", "a wave": "0.4*sin(0.3*i - omega*t)*w[i].z",
    "frequencies": "0.3*cos((1 + a[i])*t)*w[i].x", "a part": "if(i < 5, 0.4, 0)*w[i].z^2 + if(i < 5, 0, cos(t))*w[i].x", "staggered": "0.3*(1 - 2*mod(i, 2))*w[i].z", "bent in time": "0.3*a[i]*sin(3*t)*w[i].z^2",
    "a window": "-0.5*if(mod(i, 3) < 1 and t < 0.55, a[i], 0)*w[i].y", "fixed": "0.2*floor(i/4)/(1 + i)*w[i].x",
}
PLACES = {          # over, n, sites, lattice
    "ring": ("chain(n, periodic)", 17, "n", 17, ""), "open chain": ("chain(n, open)", 35, "n", 35, ""), "odd square": ("square(n, 5, open)", 9, "5*n", 45, ""), "blocks": ("cubic(n, n, 4, periodic)", 8, "4*n*n", 256, ""),
    "honeycomb": ("honey.all", 5, "6*n", 30, HONEY), "three colours": ("skew.near", 13, "4*n", 52, SKEW), "ladder": ("rungs.all", 7, "2*n", 14, LADDER), "far": ("reach.all", 14, "n", 14, FAR),
    "pieces": ("square(n, 30, periodic)", 20, "30*n", 600, ""), "odd cubic": ("cubic(n, 3, 5, periodic)", 5, "15*n", 75, ""),
}


def drawn(place, *energies, seed=1, bonds=EXCHANGE + DM):
    over, n, sites, count, cells = PLACES[place]
    dice = np.random.default_rng(seed)
    numbers = [", ".join(f"{x:.3f}" for x in dice.uniform(-1, 1, count)) for _ in "ab"]
    broken = [text.replace(", ", ",\n", count).replace("\n", "\n ") for text in numbers]
    effects = "".join(field(e, f"field{k}") for k, e in enumerate(energies))
    spec = lattice(place.replace(" ", "_"), over, n, sites, bonds + effects.replace("{", "{{").replace("}", "}}"), ARRAYS.format(broken[0], sites, broken[1], sites).replace("{{", "{").replace("}}", "}") + cells)
    return spec


SOME = drawn("three colours", KINDS["in time"], KINDS["anisotropy"])
BLOCKS = drawn("blocks", KINDS["in time"], KINDS["staggered"])
QUICK = (("ring", "in time"), ("blocks", "anisotropy"), ("three colours", "phases"), ("ladder", "a part"))


def close(spec, method=MIDPOINT, steps=5, t0=0.37) -> float:
    """The distance from the witness, which knows no rows, part of the size of w."""
    model = smidgen.build(spec, method=method).start("random", h=0.08, t0=t0)
    w = model.w.copy()
    found = Witness(spec).steps(w, t0, 0.08, steps, method)
    return np.abs(model.steps(steps).w - (found if np.ndim(found) == 2 else found[-1])).max() / np.abs(w).max()


@pytest.mark.parametrize("place, kind", [pytest.param(p, k, marks=() if (p, k) in QUICK else pytest.mark.long) for p, k in [*QUICK, *(("odd square", k) for k in KINDS), *((p, "in time") for p in PLACES if p != "ring")]])
def test_rows_solve_the_step(place, kind):
    spec = drawn(place, KINDS[kind])
    assert by_rows(spec)
    assert close(spec, steps=5 if PLACES[place][3] < 200 else 2) <= 2e-14


@pytest.mark.parametrize("place", ["odd cubic", pytest.param("honeycomb", marks=pytest.mark.long)])
def test_any_number_of_numbers(place):
    """Nine of each bond, six of an anisotropy, four of waves: 64 of a site on the cubic lattice."""
    tensor = " + ".join(f"0.1*normal({3 * p + q}, i, j)*w[i].{a}*w[j].{b}" for p, a in enumerate("xyz") for q, b in enumerate("xyz"))
    axes = " + ".join(f"0.2*normal({20 + p + q}, i)*w[i].{a}*w[i].{b}" for p, a in enumerate("xyz") for q, b in enumerate("xyz"))
    spec = drawn(place, axes, KINDS["phases"], bonds=f'[effects.tensor]\nover = "bond(i, j) of {{over}}"\nenergy = "{tensor}"\n')
    assert by_rows(spec) and close(spec) <= 2e-14


@pytest.mark.parametrize("seed", [pytest.param(s, marks=() if s < 2 else pytest.mark.long) for s in range(16)])
def test_states_are_those_from_site_to_site(seed):
    """Of drawn lattices and effects."""
    dice = np.random.default_rng(seed)
    place, kinds = dice.choice(list(PLACES)), dice.choice(list(KINDS), 2, replace=False)
    spec, ends = drawn(place, *(KINDS[k] for k in kinds), *([WAVE_TEXT] if seed % 3 == 0 else []), seed=seed), []
    assert by_rows(spec)
    for build in (smidgen.build, by_sites):
        model = build(spec).start("random", h=0.07, t0=0.2)
        ends.append(model.steps(12).w.copy())
    assert np.abs(ends[0] - ends[1]).max() <= 1e-13


WAVE_TEXT = re.search('energy = "(.*)"', WAVE)[1]


@pytest.mark.parametrize("kind", ["in time", pytest.param("phases", marks=pytest.mark.long), pytest.param("staggered", marks=pytest.mark.long)])
def test_turns_by_rows(kind):
    """Those from site to site are of a build for ensembles; fields by site are the same numbers there, where no wave was parted."""
    for place in ("honeycomb", "three colours"):
        spec = drawn(place, KINDS[kind])
        for method in (TURNS, f"{TURNS}-4"):
            assert by_rows(spec, method) and close(spec, method) <= 2e-14
            ends = [smidgen.build(spec, method=method, features=features).start("random", h=0.1).steps(8).w.copy() for features in ((), ("ensemble",))]
            assert np.abs(ends[0] - ends[1]).max() <= 1e-14


@pytest.mark.parametrize("place, kind", [("three colours", "in time"), pytest.param("ring", "anisotropy", marks=pytest.mark.long), pytest.param("ladder", "a part", marks=pytest.mark.long)])
def test_collocation_by_rows(place, kind):
    spec = drawn(place, KINDS[kind])
    assert by_rows(spec, "gauss-6") and close(spec, "gauss-6") <= 2e-14


@pytest.mark.parametrize("method, order", [(MIDPOINT, 2), ("gauss-4", 4), (f"{TURNS}-4", 4)])
def test_order(method, order):
    spec, ends = drawn("ladder", KINDS["in time"], KINDS["phases"], bonds=EXCHANGE), []
    for n in (32, 64, 128):
        ends.append(smidgen.build(spec, method=method).start("random", h=1 / n, t0=0.2).steps(n).w.copy())
    ratio = np.abs(ends[0] - ends[1]).max() / np.abs(ends[1] - ends[2]).max()
    assert abs(np.log2(ratio) - order) < 0.25


@pytest.mark.long
def test_the_same_bits_for_any_number_of_lanes(monkeypatch):
    def built(lanes, spec=SOME, method=MIDPOINT, compiler="gcc"):
        monkeypatch.setenv("CC", f"{compiler} -Wno-psabi -DSMG_LANES={lanes}")
        return smidgen.build(spec, method=method)
    assert same_in_lanes(built, (2, 4, 8)) and same_in_lanes(lambda lanes: built(lanes, BLOCKS), (4, 8)) and same_in_lanes(lambda lanes: built(lanes, SOME, "gauss-4"), (4,))
    if "clang" in COMPILERS:
        assert same_by_clang(built)


@pytest.mark.parametrize("spec, method", [(SOME, MIDPOINT), (BLOCKS, MIDPOINT), (SOME, "gauss-4"), (drawn("honeycomb", SITED), TURNS)], ids=["rows", "blocks", "collocation", "turns"])
def test_restored_it_goes_on(spec, method):
    model = smidgen.build(spec, method=method)
    assert restored(model) and one_by_one(model)


def test_arrays_are_those_of_the_run():
    """Another value of the parameter is another field, and may be one for which no step goes by rows."""
    for size in (0.1, -0.7, 20.0):
        values = {"a": [size * np.cos(k) for k in range(52)]}
        model = smidgen.build(SOME, parameters=values).start("random", h=0.05)
        w = model.w.copy()
        found = Witness(SOME, parameters=values).steps(w, 0.0, 0.05, 2)
        assert np.abs(model.steps(2).w - (found if np.ndim(found) == 2 else found[-1])).max() <= 1e-12


def test_threads_have_the_same_bits(monkeypatch):
    monkeypatch.setenv("OMP_WAIT_POLICY", "passive")
    for spec in (BLOCKS, SOME):
        monkeypatch.delenv("CC", raising=False)
        wanted = smidgen.build(spec).start("random", h=0.08).steps(9).save()
        monkeypatch.setenv("CC", "gcc -Wno-psabi -DSMG_SHARE=8")
        assert np.array_equal(smidgen.build(spec, threads=2).start("random", h=0.08).steps(9).save(), wanted)


WAVES = " + ".join(f"sin({k}*i)*w[i].x^2*{k % 2} + cos({k}*i)*cos({k}*t)*w[i].y" for k in range(1, 12))


@pytest.mark.parametrize("energy, rows", [("abs(i*w[i].z)", False), (WAVES, True)])
def test_branches_go_from_site_to_site(energy, rows):
    """More numbers a site than states have do not."""
    spec = lattice("general", "chain(n, periodic)", 16, "n", EXCHANGE + f'[effects.more]\nover = "site(i) of w"\nenergy = "{energy}"\n')
    assert by_rows(spec) == rows and by_rows(spec, "gauss-4") == rows


def test_a_scene_without_the_effect_has_the_c_of_one_that_never_had_it():
    plain, some = (generate(spec)[f"{spec.name}.c"] for spec in (drawn("ring"), drawn("ring", SITED)))
    assert "SITE_VALUES" not in plain and "row_values" not in generate(drawn("ring"))["ring.h"] and "SMG_SITE_VALUES 1" in some


STRENGTHS = {"by a formula": '"(1 + mod(i, 2))*(1 - 2*mod(i, 3)/3)"', "drawn": '"1.5 + uniform(3, i)"', "of an array": '"1 + a[i]/2"'}


@pytest.mark.parametrize("kind, method", [("by a formula", MIDPOINT), *(pytest.param(k, m, marks=pytest.mark.long) for k, m in (("drawn", TURNS), ("of an array", MIDPOINT), ("drawn", "gauss-4"), ("by a formula", f"{TURNS}-4")))])
def test_strengths_that_differ(kind, method):
    """With a pinned site; those of pair rotations must be alike."""
    numbers = "a = { default = [" + ",\n".join(f"{0.1 * (k % 7)}" for k in range(45)) + '], size = "5*n" }'
    held = '[effects.edge]\nover = "site(i) of w"\npinned = "i == 4"\n' if method == MIDPOINT else ""
    spec = lattice("strengths", "square(n, 5, open)", 9, "5*n", EXCHANGE + DM + field("0.3*w[i].x") + held, numbers, more=f", kappa = {STRENGTHS[kind]}")
    assert by_rows(spec, method) and close(spec, method) <= 2e-14


def test_the_bound_of_strengths_is_that_of_the_least():
    """A site that turns eight times as fast as the first one: no step goes by rows where it may not."""
    spec = lattice("fast", "chain(n, periodic)", 16, "n", EXCHANGE, more=', kappa = "if(i == 5, 0.125, 1)"')
    assert by_rows(spec) and close(spec, steps=2) <= 1e-13
    assert "smg_abs(smg_rate(c, k))*" in text_of(spec)


def text_of(spec) -> str:
    return generate(spec)[f"{spec.name}.c"]


@pytest.mark.parametrize("compiler, mode", MODES)
def test_clean_c(tmp_path, compiler, mode):
    for method in (MIDPOINT, "gauss-4"):
        for file, text in generate(SOME, method=method, amalgamate=True).items():
            (tmp_path / file).write_text(text)
        assert not compile_all(tmp_path, [f"{SOME.name}.c"], compiler, "-Wno-psabi", how=mode)


def test_bonds_that_differ_by_the_number_of_one_end_go_by_rows():
    spec = lattice("general", "chain(n, periodic)", 16, "n", EXCHANGE + '[effects.more]\nover = "bond(i, j) of chain(n, periodic)"\nenergy = "-0.1*(i + 1)*dot(w[i], w[j])"\n')
    model = smidgen.build(spec).start("random", h=0.03)
    w = model.w.copy()
    assert by_rows(spec) and np.abs(model.steps(3).w - Witness(spec).steps(w, 0.0, 0.03, 3)[-1]).max() <= 1e-14
