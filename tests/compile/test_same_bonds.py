"""Effects on the same bonds are one term of the motion: its cost, its bounds and its step; their energies stay apart."""
from itertools import count

import numpy as np
import pytest
import smidgen
import sympy as sp

from smidgen.check.witness import Witness
from smidgen.compile.assemble.model import Model
from smidgen.compile.assemble.norms import spectral_bound
from smidgen.compile.emit.emit import generate
from smidgen.compile.plan.plan import choose
from smidgen.compile.select import select

HEAD = """[model]
name = "many"
[space]
w = {{ sphere = "n*n" }}
[parameters]
n = 4
J = 0.7
D = 0.4
K = 0.3
[starts.any]
random = 1
"""
FILM = 'over = "bond(i, j) of square(n, n, {})"\nenergy = "{}"'
AXES = ["J*w[i].x*w[j].x", "J*w[i].y*w[j].y", "J*w[i].z*w[j].z"]
SPLIT = {1: ["J*dot(w[i], w[j])"], 3: AXES, 6: [f"{one}/2" for one in (*AXES, *AXES)]}
PLACES = """[lattices.film]
vectors = [[1, 0, 0], [0, 1, 0]]
size = ["n", "n"]
boundary = ["periodic", "open"]
bonds.near = [{ offset = [1, 0] }, { offset = [0, 1] }]
bonds.rows = [{ offset = [1, 0] }]
bonds.columns = [{ offset = [0, 1] }]
"""
# Bonds that coincide in part, by other names of their indices, with strengths in time and by bond, and one that is alone.
PARTLY = PLACES + """[effects.exchange]
over = "bond(i, j) of film.near"
energy = "-J*dot(w[i], w[j])"
[effects.driven]
over = "bond(b, a) of film.rows"
energy = "D*cos(2*t)*triple(vec(0, 1, 0), w[a], w[b]) + 0.1*(w[a].z + w[b].z)"
[effects.twist]
over = "bond(i, j) of film.near"
energy = "0.2*triple(r(i, j), w[i], w[j])"
[effects.random]
over = "bond(k, l) of film.columns"
energy = "K*uniform(3, k, l)*w[k].x*w[l].z"
[effects.biquadratic]
over = "bond(i, j) of film.rows"
energy = "-0.1*dot(w[i], w[j])^2"
"""


def spec_of(effects, more=""):
    number = count()
    return select(smidgen.load_text(HEAD.format() + more + "\n".join(f"[effects.e{next(number)}]\n{one}" for one in effects)))


def split(number: int, boundary="periodic"):
    return spec_of([FILM.format(boundary, one) for one in SPLIT[number]])


def model_of(spec, method="spherical-midpoint"):
    return Model(spec, choose(spec, method, "auto"))


@pytest.mark.quick
@pytest.mark.parametrize("number", [3, 6])
def test_effects_on_one_bond_are_one_term_with_the_bound_of_the_sum(number):
    one, many = model_of(split(1)), model_of(split(number))
    assert len(many.energies) == 1 and many.energies[0].operations == (0, one.energies[0].operations[1])
    bounds = [sp.simplify(spectral_bound(t.derived.hessian[0, 1], t.derived.joined)) for t in (*one.energies, *many.energies)]
    assert bounds[0] == bounds[1] == sp.Abs(sp.Symbol("p.J", real=True))
    assert list(many.sums) == [f"e{k}" for k in range(number)] and len({t.prefix for some in many.sums.values() for t in some}) == number


@pytest.mark.quick
def test_a_spec_without_such_effects_is_left_alone():
    """Other bonds, other boundaries, a formula that is not quadratic: none of them is joined."""
    apart = spec_of([FILM.format("periodic", "J*dot(w[i], w[j])"), FILM.format("open", "D*dot(w[i], w[j])"), FILM.format("periodic", "K*dot(w[i], w[j])^2"),
                     'over = "site(i) of w"\nenergy = "w[i].z"', 'over = "site(i) of w"\nenergy = "w[i].x"'])
    model = model_of(apart)
    assert model.values == () and [t.prefix for t in model.energies] == [f"effect_e{k}" for k in range(5)]


@pytest.mark.quick
def test_bonds_are_shared_one_by_one():
    spec = select(smidgen.load_text(HEAD.format() + PARTLY))
    found = {t.prefix.removeprefix("effect_"): (t.derived.joined, len(t.over.bonds)) for t in model_of(spec).energies}
    assert [joined for joined, _ in found.values()] == [("exchange", "driven", "twist_1_of_2"), ("exchange", "twist_2_of_2", "random"), ()]
    assert all(bonds == 1 for _, bonds in found.values())


@pytest.mark.quick
def test_methods_that_turn_bond_after_bond_have_each_effect_as_it_is():
    spec = spec_of([FILM.format("periodic", f"{x}*dot(w[i], w[j])") for x in "JDK"])
    assert len(model_of(spec, "pair-rotations").energies) == 3 and len(model_of(spec).energies) == 1


@pytest.mark.parametrize("method", ["spherical-midpoint", "gauss-4", "dop853"])
def test_steps_and_energies_are_those_of_the_witness(method):
    spec = smidgen.load_text(HEAD.format() + PARTLY)
    model, h = smidgen.build(spec, method=method), 0.05
    model.start("any", h=h)
    begin = model.w.copy()
    model.steps(3)
    witness = Witness(model.scene, model.parameters)
    state = begin
    for k in range(3):
        state = witness.step(state, k * h, h, method)
    assert np.abs(model.w - state).max() < 2e-13
    mine = dict(zip(model.columns, model.values()))
    for name, energy in witness.energies(state, 3 * h).items():
        assert abs(mine[f"energy.{name}"] - energy) < 1e-13, name


def test_the_generated_text_says_which_effects_there_are():
    files = generate(split(3))
    assert "e0, e1, e2" in files["many.h"] and all(f"many_energy_e{k}" in files["many.h"] for k in range(3))


def test_a_neighbour_in_terms_of_several_effects_is_taken_once():
    """Biquadratic exchange beside exchange: its bonds stay terms of their own, but six neighbours are taken, not twelve."""
    over = 'over = "bond(i, j) of cubic(6, 6, 6, {})"'
    text = '[model]\nname = "m"\n[space]\nw = {{ sphere = 216 }}\n[effects.a]\n{0}\nenergy = "-dot(w[i], w[j])"\n[effects.b]\n{0}\nenergy = "-0.2*dot(w[i], w[j])^2"\n'
    for boundary, times in (("periodic", 6), ("open", 12)):
        source = generate(smidgen.load_text(text.format(over.format(boundary))))["m.c"]
        gradient = source[source.index("void smg_slot_gradient"):].partition("\n}")[0]
        assert gradient.count("smg_take_beside(") == times
