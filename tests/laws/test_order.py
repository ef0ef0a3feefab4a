"""The order in which a spec names its effects, bonds and sites decides nothing but round-off. Only splittings that go bond after bond, or off
lattices site after site, are another map; it has the same order of accuracy and is as reversible."""
import itertools

import numpy as np
import pytest
import smidgen
from smidgen.check.witness import Witness, splittings
from smidgen.methods import METHODS
from smidgen.run.record.computed import film_of
from smidgen.run.step.evaluated import Evaluated
from smidgen.show.plot import facts
from support.lattices import random_spins

HEAD = '[model]\nname = "ordered"\n[space]\nw = {{ sphere = {sites}{more} }}\n'
OFTEN = ["spherical-midpoint", "sublattice-rotations", "gauss-4"]
METHODS_OF_ALL = [m.name if m.name in OFTEN else pytest.param(m.name, marks=pytest.mark.long) for m in METHODS.values() if not m.scheme and not m.free_body]
COLOURED = ["sublattice-rotations", *(pytest.param(name, marks=pytest.mark.long) for name in ("spherical-midpoint", "pair-rotations", "gauss-4"))]
LADDER = '[lattices.l{k}]\nsize = [{cells}]\nboundary = "{ends}"\nsites = 2\nbonds.a = [{bonds}]\n'
RUNG, LEG, OTHER = "{ from = 0, to = 1, offset = [0] }", "{ from = 0, to = 0, offset = [1] }", "{ from = 1, to = 1, offset = [1] }"


def effect(k, over, strength):
    return f'[effects.e{k}]\nover = "bond(i, j) of {over}"\nenergy = "{strength}*dot(w[i], w[j])"\n'


CHAINS = [effect(k, over, s) for k, (over, s) in enumerate([("chain(7, open)", 0.7), ("chain(7, periodic)", -0.4), ("chain(7, open)", 0.2)])]
SQUARES = [effect(k, f"square(6, 5, {ends})", s) for k, (ends, s) in enumerate([("open", 0.7), ("periodic, open", -0.4), ("open, periodic", 0.3)])]
CUBES = [effect(k, f"cubic(4, 3, 4, {ends})", s) for k, (ends, s) in enumerate([("periodic, open, periodic", 0.7), ("open, periodic, open", -0.4)])]
LADDERS = [LADDER.format(k=k, cells=5, ends=ends, bonds=", ".join(bonds)) + effect(k, f"l{k}.a", s)
           for k, (ends, bonds, s) in enumerate([("open", (RUNG, LEG), 0.7), ("periodic", (LEG, OTHER), -0.4), ("open", (OTHER,), 0.2)])]
SYSTEMS = {"chain": (7, CHAINS), "square": (30, SQUARES), "cube": (48, CUBES), "ladder": (10, LADDERS)}


def orders(effects):
    """As it is, reversed, and with each effect in front once."""
    found = [effects, effects[::-1], *([e, *(other for other in effects if other is not e)] for e in effects[1:])]
    return list(dict.fromkeys(map(tuple, found)))


def spec_of(sites, effects, more=""):
    return smidgen.load_text(HEAD.format(sites=sites, more=more) + "".join(effects) + "[starts.random]\nrandom = 1\n")


def at_end(model, w, h, steps):
    return model.start(w.copy(), h=h).steps(steps).w.copy()


def is_symmetric_of_order_two(spec, method):
    model, w = smidgen.build(spec, method=method), random_spins(spec_sites(spec))
    back = at_end(model, at_end(model, w, 0.1, 1), -0.1, 1)
    ends = [at_end(model, w, 0.8 / 2 ** k, 2 ** k) for k in (4, 5, 6)]
    return np.abs(back - w).max() < 1e-14 and np.abs(ends[0] - ends[1]).max() > 3.5 * np.abs(ends[1] - ends[2]).max()


def spec_sites(spec):
    return Witness(spec).sites


@pytest.mark.parametrize("method", METHODS_OF_ALL)
def test_the_order_of_effects(method):
    sites, effects = SYSTEMS["chain"]
    check_orders(method, sites, orders(effects)[:2])


@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("method", COLOURED)
def test_the_order_of_effects_on_lattices_with_several_kinds_of_ends(method, name):
    sites, effects = SYSTEMS[name]
    check_orders(method, sites, orders(effects))


def check_orders(method, sites, several):
    specs, w = [spec_of(sites, effects) for effects in several], random_spins(sites)
    ends = [at_end(smidgen.build(spec, method=method), w, 0.05, 5) for spec in specs]
    for spec, end in zip(specs, ends):
        if method == "pair-rotations":
            assert is_symmetric_of_order_two(spec, method)
        else:
            np.testing.assert_allclose(end, ends[0], rtol=0, atol=1e-13)


@pytest.mark.parametrize("name", SYSTEMS)
def test_sublattice_rotations_are_reversible_of_order_two_and_those_of_the_witness(name):
    sites, effects = SYSTEMS[name]
    for order in orders(effects):
        spec = spec_of(sites, order)
        assert is_symmetric_of_order_two(spec, "sublattice-rotations")
        w = random_spins(sites)
        for method in ("sublattice-rotations", "pair-rotations"):
            wanted = Witness(spec).steps(w, 0.0, 0.05, 5, method)[-1]
            np.testing.assert_allclose(at_end(smidgen.build(spec, method=method), w, 0.05, 5), wanted, rtol=0, atol=1e-13)


@pytest.mark.parametrize("method", COLOURED)
def test_the_order_of_bonds(method):
    bonds = [RUNG, LEG, OTHER]
    ladders = [(LADDER.format(k=0, cells=6, ends="periodic", bonds=", ".join(order)) + effect(0, "l0.a", 0.7),)
               for order in (bonds, bonds[::-1], bonds[1:] + bonds[:1])]
    check_orders(method, 12, ladders)


@pytest.mark.parametrize("method", METHODS_OF_ALL)
def test_the_order_of_sites(method):
    """All pairs, with strengths and couplings that move with their sites."""
    places, w = np.array([3, 0, 4, 1, 2]), random_spins(5)
    kappa, coupling = np.array([1.0, 1.5, -2.0, 0.5, 1.0]), np.array([0.3, -0.7, 0.5, 1.1, 0.2])
    specs = [numbered(kappa[order].tolist(), coupling[order].tolist()) for order in (np.arange(5), places)]
    if METHODS[method].splitting in ("pairs", "sublattices"):
        assert all(is_symmetric_of_order_two(spec, method) for spec in specs)
        return
    one, other = (at_end(smidgen.build(spec, method=method), start, 0.05, 5) for spec, start in zip(specs, (w, w[places])))
    np.testing.assert_allclose(other, one[places], rtol=0, atol=1e-13)


def numbered(kappa, coupling):
    pairs = '[effects.all]\nover = "pair(i, j) of w"\nenergy = "g[i]*g[j]*dot(w[i], w[j])"\n'
    return spec_of(5, (f"[parameters]\ng = {{ default = {coupling}, size = 5 }}\n{pairs}",), f", kappa = {kappa}")


# Effects of every kind, by rows and from site to site

def on_sites(name, line):
    return f'[effects.{name}]\nover = "site(i) of w"\n{line}\n'


def kinds(r="mod(i, 3)/4", places="square(6, 6, periodic)", site="i"):
    """r: a number of each site; site: where it stands."""
    bonds = [f'[effects.{name}]\nover = "bond(i, j) of {over}"\nenergy = "{energy}"\n' for name, over, energy in
             (("exchange", places, "-0.7*dot(w[i], w[j])"), ("more", places.replace("periodic", "open"), "0.2*cos(t)*dot(w[i], w[j]) - 0.1*dot(w[i], w[j])^2"))]
    return [*bonds, on_sites("field", f'energy = "-(0.4 + {r})*cos(2*t)*w[i].z"'), on_sites("cubic", 'energy = "0.1*(w[i].x^4 + w[i].y^4)"'), on_sites("bath", f'damping = "0.1 + {r}"\nkT = HEAT'),
            on_sites("push", f'torque = "(0.1 + {r})*cross(w[i], cross(w[i], vec(0, 1, 0)))"'), on_sites("other", f'torque = "0.2*w[i].z*cross(w[i], vec(1, 0, 0.5))"'),
            on_sites("edge", f'pinned = "{site} == 3"'), on_sites("holes", f'absent = "{site} == 1"')]


def begun(spec, method, w, seed):
    """The state after a few steps."""
    return smidgen.build(spec, method=method).start(w.copy(), h=0.05, **seed).steps(5).w.copy()


@pytest.mark.parametrize("method, heat", [("spherical-midpoint", "0.2"), *(pytest.param(m, heat, marks=pytest.mark.long) for m, heat in
                                          (("spherical-midpoint-4", "0"), ("dop853", "0"), ("extrapolation-12", "0"), ("gauss-4", "0"), ("heun", "0.2"), ("spherical-midpoint", "0")))])
def test_the_order_of_effects_of_every_kind(method, heat):
    """Dampings, noise, torques and held sites too; noise is that of its site, whichever effect has it."""
    by_field = METHODS[method].how[:1] == ("explicit",) or method == "gauss-4"       # go by rows with torques in closed form alone
    effects = [e.replace("HEAT", heat).replace("\nkT = 0\n", "\n") for e in kinds() if not (by_field and "effects.other" in e)]
    several = [effects, effects[::-1], [*effects[4:], *effects[:4]]]
    specs = [spec_of(36, e, ', kappa = "1 + mod(i, 2)"') for e in several]
    ends = [begun(spec, method, random_spins(36), {"seed": 3} if heat != "0" else {}) for spec in specs]
    for end in ends[1:]:
        np.testing.assert_allclose(end, ends[0], rtol=0, atol=1e-12 if method == "dop853" else 1e-13)


@pytest.mark.parametrize("method", ["spherical-midpoint", *(pytest.param(m, marks=pytest.mark.long) for m in ("spherical-midpoint-4", "dop853", "extrapolation-12", "heun"))])
def test_the_order_of_sites_of_every_kind(method):
    """All pairs, whose numbers, radii, dampings, torques and holes move with their sites."""
    order, w, r = np.array([3, 0, 4, 1, 2, 5]), random_spins(6), np.array([0.1, 0.25, 0.3, 0.0, 0.2, 0.15])

    def moved(places):
        pairs = '[effects.all]\nover = "pair(i, j) of w"\nenergy = "-0.3*(1 + r[i]*r[j])*dot(w[i], w[j])"\n'
        arrays = f"[parameters]\nr = {{ default = {r[places].tolist()}, size = 6 }}\nplace = {{ default = {places.astype(float).tolist()}, size = 6 }}\n"
        effects = [e.replace("\nkT = HEAT", "") for e in kinds("r[i]", site="place[i]")[2:]]
        return spec_of(6, (arrays, pairs, *effects), ', radius = "1 + r[i]"')
    ends = [begun(moved(places), method, w[places] * (1 + r[places])[:, None], {}) for places in (np.arange(6), order)]
    np.testing.assert_allclose(ends[1], ends[0][order], rtol=0, atol=1e-12 if method == "dop853" else 1e-13)


@pytest.mark.quick
def test_the_rule_of_the_witness_on_every_kind_of_lattice():
    """Its colours, where it has any, keep the ends of all bonds apart; where it has none, a ring fits no multiple of the colours."""
    for ends, n in itertools.product(itertools.product(["open", "periodic"], repeat=2), (6, 7)):
        witness = Witness(spec_of(n, [effect(k, f"chain({n}, {end})", 1) for k, end in enumerate(ends)]))
        found, _ = splittings.lattice_colours(witness)
        assert (found is None) == ("periodic" in ends and n == 7)
        splittings.proper(witness, splittings.colours(witness))


@pytest.mark.quick
def test_what_pictures_and_charges_take_for_the_lattice():
    """The bonds of all effects; a charge where one lattice of two directions joins the sites."""
    bonds, charged = set(), set()
    effects = [effect(k, over, 0.3) for k, over in enumerate(("square(6, 5, periodic)", "square(5, 6, periodic)", "chain(30, open)"))]
    for order in itertools.permutations(effects):
        spec = spec_of(30, order)
        bonds.add(facts.bonds(Evaluated(spec))["w"].tobytes())
        charged.add(film_of(smidgen.build(spec), "w"))
    assert len(bonds) == 1 and charged == {None}
    assert film_of(smidgen.build(spec_of(30, effects[::2])), "w").size == (6, 5)
