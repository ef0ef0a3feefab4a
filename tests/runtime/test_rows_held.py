"""Lattices by rows with sites that are pinned or absent: the step that the equation has, the state from site to site, and why others go site by site."""
import numpy as np
import pytest
import smidgen
from smidgen.check.witness import Witness
from smidgen.compile.emit.emit import generate
from support.by_sites import by_sites
from support.going_on import one_by_one, restored
from support.strict import COMPILERS
from support.widths import same_by_clang, same_in_lanes
from test_rows import DM, EXCHANGE
from test_rows_by_site import KINDS, PLACES, drawn
from test_rows_in_time import by_rows

PINNED = '[effects.edge]\nover = "site(i) of w"\npinned = "mod(i, 7) == 2"\n'
ABSENT = '[effects.holes]\nover = "site(i) of w"\nabsent = "uniform(3, i) < 0.2"\n'
DAMPED = '[effects.bath]\nover = "site(i) of w"\ndamping = 0.1\n'
WARM = DAMPED.replace("0.1\n", '0.1\nkT = 0.2\n')
TORQUE = '[effects.current]\nover = "site(i) of w"\ntorque = "0.2*cross(w[i], cross(w[i], vec(0, 1, 0)))"\n'
HELD = {"pinned": PINNED, "absent": ABSENT, "both": PINNED + ABSENT, "damped": PINNED + ABSENT + DAMPED, "warm": PINNED + ABSENT + WARM}


def held(place, kind, energy="both in one", bonds=EXCHANGE + DM):
    """A lattice with a field by site that depends on time, and sites of that kind."""
    return drawn(place, KINDS[energy], KINDS["in time"], bonds=bonds + HELD.get(kind, kind))


SOME, BLOCKS = held("three colours", "both"), held("blocks", "damped")
QUICK = (("ring", "absent"), ("blocks", "both"), ("three colours", "damped"), ("odd square", "pinned"))


@pytest.mark.parametrize("place, kind", [pytest.param(p, k, marks=() if (p, k) in QUICK else pytest.mark.long) for p, k in
                                         [*QUICK, *((p, "both") for p in PLACES if p != "blocks"), *(("honeycomb", k) for k in HELD if k != "both")]])
def test_rows_solve_the_step(place, kind):
    spec = held(place, kind)
    model, witness = smidgen.build(spec).start("random", h=0.08, t0=0.37, **({"seed": 5} if kind == "warm" else {})), Witness(spec, **({"seed": 5} if kind == "warm" else {}))
    w, steps = model.w.copy(), 4 if PLACES[place][3] < 200 else 2
    assert by_rows(spec) and witness.still.any()
    assert np.abs(model.steps(steps).w - witness.steps(w, 0.37, 0.08, steps)[-1]).max() <= 2e-14
    assert np.array_equal(model.w[witness.still], w[witness.still])


@pytest.mark.parametrize("place", ["odd square", pytest.param("honeycomb", marks=pytest.mark.long), pytest.param("odd cubic", marks=pytest.mark.long)])
def test_states_are_those_from_site_to_site(place):
    """Where no h is small enough for rows, Newton proves the steps site by site."""
    spec, ends = held(place, "both"), []
    for build in (smidgen.build, by_sites):
        ends.append(build(spec).start("random", h=0.07, t0=0.2).steps(12).w.copy())
    assert np.abs(ends[0] - ends[1]).max() <= 1e-13


@pytest.mark.long
def test_the_same_bits_for_any_number_of_lanes(monkeypatch):
    def built(lanes, spec=SOME, compiler="gcc"):
        monkeypatch.setenv("CC", f"{compiler} -Wno-psabi -DSMG_LANES={lanes}")
        return smidgen.build(spec)
    assert same_in_lanes(built, (2, 4, 8)) and same_in_lanes(lambda lanes: built(lanes, BLOCKS), (4, 8))
    if "clang" in COMPILERS:
        assert same_by_clang(built)


@pytest.mark.long
@pytest.mark.parametrize("kind", ["both", "damped"])
def test_the_same_bits_for_two_threads(kind):
    spec = held("pieces", kind)
    ends = [smidgen.build(spec, threads=n).start("random", h=0.08).steps(10).save() for n in (1, 2)]
    assert np.array_equal(*ends)


@pytest.mark.parametrize("spec", [SOME, BLOCKS], ids=["rows", "blocks"])
def test_restored_it_goes_on(spec):
    model = smidgen.build(spec)
    assert restored(model) and one_by_one(model)


BONDS = {       # of these lattices, by numbers of their ends
    "drawn": '[effects.random]\nover = "bond(i, j) of {}"\nenergy = "-normal(1, i, j)*dot(w[i], w[j])/4"\n', "in time": '[effects.random]\nover = "bond(i, j) of {}"\nenergy = "0.3*cos(t + i - j)*w[i].x*w[j].z"\n',
    "by site": '[effects.random]\nover = "bond(i, j) of {}"\nenergy = "0.4*a[i]*triple(vec(0, 0, 1), w[i], w[j]) + 0.2*(w[i].x + w[j].y)*b[j]"\n'}


@pytest.mark.parametrize("place, kind", [("odd square", "drawn"), ("ladder", "in time"), *(pytest.param(p, k, marks=pytest.mark.long) for p, k in
                                         [("ring", "drawn"), ("open chain", "by site"), ("blocks", "drawn"), ("ladder", "by site"), ("pieces", "drawn")])])
def test_bonds_that_differ_go_by_rows(place, kind):
    """Without absent sites, with fields by site beside them."""
    spec = drawn(place, KINDS["field"], bonds=BONDS[kind].format(PLACES[place][0]))
    model, steps = smidgen.build(spec).start("random", h=0.08, t0=0.37), 4 if PLACES[place][3] < 200 else 2
    w = model.w.copy()
    assert by_rows(spec) and np.abs(model.steps(steps).w - Witness(spec).steps(w, 0.37, 0.08, steps)[-1]).max() <= 2e-14


@pytest.mark.parametrize("method", ["sublattice-rotations", pytest.param("gauss-4", marks=pytest.mark.long)])
def test_so_they_do_by_other_methods(method):
    spec = drawn("ladder", KINDS["field"], bonds=BONDS["drawn"].format("rungs.all"))
    model = smidgen.build(spec, method=method).start("random", h=0.08)
    w, found = model.w.copy(), model.steps(4).w
    assert by_rows(spec, method) and np.abs(found - Witness(spec).steps(w, 0.0, 0.08, 4, method)[-1]).max() <= 2e-14


@pytest.mark.parametrize("what, said", [
    (ABSENT + '[effects.squares]\nover = "bond(i, j) of chain(n, periodic)"\nenergy = "exp(dot(w[i] - w[j], w[i] - w[j]))"\n', "the field of `squares` does not vanish where one of its spins is 0, but some sites are absent"),
    ('[effects.kinked]\nover = "bond(i, j) of chain(n, periodic)"\nenergy = "abs(dot(w[i], w[j]))"\n', "`kinked` has branches")])
def test_what_prevents_it_is_said(what, said):
    """In `gen` and `run`, by the notes, and by `explain`."""
    spec = held("ring", what)
    notes = generate(spec).notes
    assert not by_rows(spec) and notes["reason"].endswith(f"; site by site, because {said}")
    assert any(line.endswith(f"because {said}.") for line in smidgen.explain(spec).words())


def test_where_nothing_prevents_it_nothing_is_said():
    assert "site by site" not in generate(SOME).notes["reason"]
    assert not any("site by site" in line for line in smidgen.explain(SOME).words())
