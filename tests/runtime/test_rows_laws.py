"""Lattices by rows whose sites respond to their fields each in its own way: dampings and torques that differ from site to site, and torques beside sites that do not move."""
import numpy as np
import pytest
import smidgen
from smidgen.check.verify.contraction import HISTORY, KEPT
from smidgen.check.witness import Witness
from support.by_sites import by_sites
from support.going_on import one_by_one, restored
from support.widths import same_in_lanes
from test_rows import DM, EXCHANGE, lattice
from test_rows_by_site import KINDS, PLACES, drawn
from test_rows_held import ABSENT, DAMPED, PINNED, TORQUE, WARM
from test_rows_in_time import by_rows

BY_SITE = DAMPED.replace("0.1", '"0.1 + 0.2*mod(i, 2)"')
LAWS = {
    "gilbert": BY_SITE, "of an array": DAMPED.replace("0.1\n", '"0.3*abs(a[i])"\nform = "ll"\n'), "warm": WARM.replace("0.1", '"0.2*uniform(4, i)"'), "held": BY_SITE + PINNED + ABSENT,
    "torque": TORQUE.replace("0.2*", "(0.2 + 0.1*mod(i, 3))*"), "damped torque": BY_SITE + TORQUE, "torque, held": TORQUE + PINNED + ABSENT, "all": BY_SITE + TORQUE + PINNED + ABSENT}
QUICK = (("three colours", "all"), ("blocks", "held"), ("odd square", "torque"))
SOME, BLOCKS = (drawn(place, KINDS["in time"], bonds=EXCHANGE + DM + LAWS["all"]) for place in ("three colours", "blocks"))


def close(spec, steps, seed=None, rows=True) -> float:
    """The distance from the witness; rows: do steps go by rows, which keep less of their history?"""
    more = {} if seed is None else {"seed": seed}
    model = smidgen.build(spec).start("random", h=0.08, t0=0.37, **more)
    w = model.w.copy()
    found = np.abs(model.steps(steps).w - Witness(spec, **more).steps(w, 0.37, 0.08, steps)[-1]).max()
    assert seed is not None or rows == (model.steps(KEPT + 1).save()[HISTORY] < KEPT)
    return found


@pytest.mark.parametrize("place, kind", [pytest.param(p, k, marks=() if (p, k) in QUICK else pytest.mark.long) for p, k in
                                         [*QUICK, *(("ring", k) for k in LAWS), *((p, "all") for p in PLACES if p not in ("ring", "three colours"))]])
def test_rows_solve_the_step(place, kind):
    """Against the witness, which knows no rows."""
    spec = drawn(place, KINDS["in time"], bonds=EXCHANGE + DM + LAWS[kind])
    assert by_rows(spec) and close(spec, 4 if PLACES[place][3] < 200 else 2, 5 if kind == "warm" else None) <= 2e-14


@pytest.mark.parametrize("kind", ["all", pytest.param("damped torque", marks=pytest.mark.long)])
def test_strengths_of_both_signs(kind):
    """What a torque adds is divided by the strength of its own site."""
    strengths = ', kappa = "(1 + mod(i, 2))*(1 - 2*mod(i, 3)/3)"'
    spec = lattice("strengths", "square(n, 5, open)", 9, "5*n", EXCHANGE + DM + LAWS[kind], more=strengths)
    assert by_rows(spec) and close(spec, 4) <= 2e-14


@pytest.mark.parametrize("place", ["ladder", pytest.param("odd cubic", marks=pytest.mark.long)])
def test_states_are_those_from_site_to_site(place):
    """Where no h is small enough for rows, Newton proves the steps site by site."""
    spec, ends = drawn(place, KINDS["field"], bonds=EXCHANGE + DM + LAWS["all"]), []
    for build in (smidgen.build, by_sites):
        ends.append(build(spec).start("random", h=0.07, t0=0.2).steps(12).w.copy())
    assert np.abs(ends[0] - ends[1]).max() <= 1e-13


@pytest.mark.long
def test_the_same_bits_for_any_number_of_lanes(monkeypatch):
    def built(lanes, spec=SOME):
        monkeypatch.setenv("CC", f"gcc -Wno-psabi -DSMG_LANES={lanes}")
        return smidgen.build(spec)
    assert same_in_lanes(built, (2, 4, 8)) and same_in_lanes(lambda lanes: built(lanes, BLOCKS), (4, 8))


@pytest.mark.long
def test_the_same_bits_for_two_threads(monkeypatch):
    wanted = smidgen.build(SOME).start("random", h=0.08).steps(9).save()
    monkeypatch.setenv("CC", "gcc -Wno-psabi -DSMG_SHARE=8")
    assert np.array_equal(smidgen.build(SOME, threads=2).start("random", h=0.08).steps(9).save(), wanted)


@pytest.mark.parametrize("spec", [SOME, pytest.param(BLOCKS, marks=pytest.mark.long)], ids=["rows", "blocks"])
def test_restored_it_goes_on(spec):
    model = smidgen.build(spec)
    assert restored(model) and one_by_one(model)


def test_the_strongest_law_decides():
    """One site feels a torque for which no step goes by rows: it has the state from site to site."""
    spec = lattice("strong", "chain(n, periodic)", 16, "n", EXCHANGE + '[effects.push]\nover = "site(i) of w"\ntorque = "if(i == 5, 30, 0.1)*cross(w[i], vec(0, 1, 0))"\n')
    assert by_rows(spec) and close(spec, 3, rows=False) <= 1e-12
