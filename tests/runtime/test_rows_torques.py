"""Lattices by rows with torques that have no closed form: fields beside the gradients, of a site alone and of its neighbours."""
import numpy as np
import pytest
import smidgen
from smidgen.compile.emit.emit import generate
from support.by_sites import by_sites
from support.going_on import one_by_one, restored
from support.widths import same_in_lanes
from test_field_rows import NEAR
from test_rows import DM, EXCHANGE, lattice
from test_rows_by_site import KINDS, PLACES, drawn
from test_rows_collocation import close as collocated
from test_rows_held import ABSENT, DAMPED, PINNED, TORQUE, WARM
from test_rows_in_time import by_rows
from test_rows_laws import BY_SITE, close


def pushed(torque: str, over="site(i) of w", name="push") -> str:
    return f'[effects.{name}]\nover = "{over}"\ntorque = "{torque}"\n'


def test_a_torque_of_all_pairs_prevents_it():
    """Beside bonds that differ."""
    bonds = EXCHANGE.replace('energy = "', 'energy = "(1 + 0.2*uniform(6, i, j))*', 1) + pushed("0.05*cross(w[i], cross(w[i], w[j]))", "pair(i, j) of w")
    assert generate(drawn("ring", bonds=bonds)).notes["reason"].endswith("site by site, because `push` is a sum neither over the sites nor over the bonds of the lattice")


OWN = pushed("0.2*w[i].z*cross(w[i], vec(0, 1, 0))")
TORQUES = {
    "own": OWN, "damped": OWN + WARM, "held": OWN + PINNED + ABSENT, "in time": pushed("0.3*cos(t)*cross(w[i], cross(w[i], vec(w[i].x, 0, 0)))"),
    "by site": pushed("0.2*(1 + mod(i, 3))*w[i].y*cross(w[i], vec(1, 0, 0.5))"), "both": OWN + TORQUE + BY_SITE, "of neighbours": "{beside}",
    "a pulse": TORQUE.replace("0.2*", "0.4*exp(-(t - 0.5)^2)*") + WARM, "a pulse by site": TORQUE.replace("0.2*", "0.4*cos(t + i)*") + DAMPED + PINNED, "all": OWN + TORQUE + BY_SITE + PINNED + "{beside}"}
QUICK = (("three colours", "all"), ("blocks", "held"), ("odd square", "a pulse by site"))


def spec_of(place, kind):
    beside = pushed("0.1*cross(w[i], cross(w[i], w[j]) - w[j])", f"bond(i, j) of {PLACES[place][0]}", "beside")
    return drawn(place, KINDS["in time"], bonds=EXCHANGE + DM + TORQUES[kind].replace("{beside}", beside))


@pytest.mark.parametrize("place, kind", [pytest.param(p, k, marks=() if (p, k) in QUICK else pytest.mark.long) for p, k in
                                         [*QUICK, *(("odd square", k) for k in TORQUES), *((p, "all") for p in ("ring", "ladder", "honeycomb", "pieces"))]])
def test_rows_solve_the_step(place, kind):
    """Against the witness, which knows no rows."""
    spec = spec_of(place, kind)
    assert by_rows(spec) and close(spec, 4 if PLACES[place][3] < 200 else 2, 5 if kind in ("damped", "a pulse") else None) <= 2e-14


@pytest.mark.parametrize("place, kind, method", [("three colours", "all", "gauss-4"), ("blocks", "all", "dormand-prince-8"), *(pytest.param(*one, marks=pytest.mark.long) for one in [
    ("odd square", "held", "gauss-6"), ("honeycomb", "by site", "gauss-4"), ("odd square", "in time", "dop853"), ("ring", "of neighbours", "dop853-projected"), ("honeycomb", "a pulse by site", "gauss-4"), ("pieces", "all", "extrapolation-12")])])
def test_methods_that_take_fields_have_them_by_rows(place, kind, method):
    """With Gilbert's damping too, where the stages of explicit methods leave the sphere."""
    spec = spec_of(place, kind)
    assert by_rows(spec, method) and collocated(spec, method) <= NEAR.get(method, 2e-14)


@pytest.mark.parametrize("method", ["dormand-prince-8", "spherical-midpoint"])
def test_a_damped_torque_is_that_of_the_witness_off_the_sphere(method):
    """In the closed form, the |w|^2 of w x (w x (w x Q)) = -|w|^2 w x Q was once that of the sphere: a difference of 1e-9 after 100 such steps."""
    spec = lattice("large", "chain(n, periodic)", 33, "n", EXCHANGE + DAMPED + TORQUE, more=", radius = 2.5")
    assert collocated(spec, method, steps=10) <= 2e-13


@pytest.mark.long
def test_states_are_those_from_site_to_site():
    """Where no h is small enough for rows, Newton proves the steps site by site."""
    ends = [build(spec_of("ladder", "all")).start("random", h=0.07).steps(12).w.copy() for build in (smidgen.build, by_sites)]
    assert np.abs(ends[0] - ends[1]).max() <= 1e-13


@pytest.mark.long
def test_the_same_bits_for_any_number_of_lanes(monkeypatch):
    def built(lanes, place="three colours"):
        monkeypatch.setenv("CC", f"gcc -Wno-psabi -DSMG_LANES={lanes}")
        return smidgen.build(spec_of(place, "all"))
    assert same_in_lanes(built, (2, 4, 8)) and same_in_lanes(lambda lanes: built(lanes, "blocks"), (4, 8))


@pytest.mark.long
def test_the_same_bits_for_two_threads(monkeypatch):
    spec = spec_of("three colours", "all")
    wanted = smidgen.build(spec).start("random", h=0.08).steps(9).save()
    monkeypatch.setenv("CC", "gcc -Wno-psabi -DSMG_SHARE=8")
    assert np.array_equal(smidgen.build(spec, threads=2).start("random", h=0.08).steps(9).save(), wanted)


@pytest.mark.parametrize("place", [pytest.param("blocks", marks=pytest.mark.long), "three colours"])
def test_restored_it_goes_on(place):
    model = smidgen.build(spec_of(place, "all"))
    assert restored(model) and one_by_one(model)


@pytest.mark.parametrize("method, torque, said", [("classical-midpoint", "0.2*w[i].z*cross(w[i], vec(0, 1, 0))", "the torque `push` has no closed form"), ("spherical-midpoint", "0.2*cross(w[i], vec(0, 1, 0))/w[i].z", "the field of `push` has no bound that holds at all times")])
def test_what_prevents_it_is_said(method, torque, said):
    assert generate(drawn("ring", bonds=EXCHANGE + pushed(torque)), method).notes["reason"].endswith(f"site by site, because {said}")
