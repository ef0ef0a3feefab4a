"""`r(i)` and `r(i, j)` in formulas, families that lie on a lattice, graphs with positions, and what is refused."""
import numpy as np
import pytest

import smidgen
from smidgen.check.witness import Witness
from smidgen.errors import SpecError
from smidgen.language.evaluate import evaluate
from smidgen.language.places import bond_vectors, positions
from smidgen.run.step.evaluated import Evaluated
from smidgen.run.step.start import initial_state

SPEC = """
[model]
name = "m"
[space]
w = {{ sphere = "{count}" }}
[parameters]
n = 3
{more}
[effects.e]
over = "{over}"
energy = "{energy}"
"""


def spec(over="bond(i, j) of square(n, n)", energy="dot(w[i], w[j])", count="n*n", more="", path=""):
    return smidgen.load_text(SPEC.format(over=over, energy=energy, count=count, more=more), path)


SKEW = '[lattices.skew]\nsize = ["n", 2]\nboundary = "periodic"\nvectors = [[2, 0], [0.3, 1.1]]\npositions = [[0, 0], [0.25, 0.5], [0.9, 0.1]]\n'


def test_a_place_as_a_formula_is_the_place():
    one = spec("bond(i, j) of skew", "w[i].z", "skew", SKEW + '[observables.o]\nover = "site(k) of w"\nvalue = "dot(r(k), vec(1, 10, 100))"\n')
    values = Evaluated(one).values
    found = [evaluate(one.observables[0].value, {**values, "k": k}) for k in range(18)]
    np.testing.assert_allclose(found, positions(one, "w", values) @ [1, 10, 100], atol=1e-14)


def test_places_stand_in_conditions_dampings_and_starts():
    one = spec("bond(i, j) of skew", "w[i].z", "skew", SKEW + """
[effects.hold]
over = "site(k) of w"
pinned = "r(k).x < 1"
[effects.loss]
over = "site(k) of w"
damping = "0.1*r(k).y"
[starts.s]
theta = "0.5 + 0.1*r(i).x"
phi = "r(i).y"
""")
    r = positions(one, "w", Evaluated(one).values)
    w = initial_state(one, "s")
    np.testing.assert_allclose(w[:, 2], np.cos(0.5 + 0.1 * r[:, 0]), atol=1e-15)
    witness = Witness(one)
    np.testing.assert_array_equal(witness.still, r[:, 0] < 1)
    np.testing.assert_allclose(witness._damped()[0], np.where(witness.still, 0, 0.1 * r[:, 1]), atol=1e-15)


def test_a_family_may_lie_on_a_lattice_by_its_name():
    one = spec("bond(i, j) of skew.second", count="skew", more=SKEW)
    assert one.families[0].count and positions(one, "w", Evaluated(one, {"n": 4}).values).shape == (24, 3)


def test_what_space_says_of_places_counts_before_what_bonds_say():
    one = spec("bond(i, j) of chain(6*n, periodic)", count="skew", more=SKEW)
    assert np.ptp(positions(one, "w", Evaluated(one).values)[:, 1]) > 1


def test_a_declared_lattice_counts_before_one_by_its_name():
    film = '[lattices.film]\nname = "square"\nsize = ["n", "n"]\nboundary = "open"\nconstant = 0.5\n[effects.more]\nover = "bond(i, j) of film.second"\nenergy = "r(i, j).x*w[i].z + r(i).x"\n'
    one = spec(more=film)
    assert positions(one, "w", Evaluated(one).values).max() == 1.0


def test_a_bond_through_the_boundary_has_its_own_vector():
    """On two cells a site has two bonds to the same neighbour, of opposite vectors."""
    one = spec("bond(i, j) of chain(2, periodic)", "r(i, j).x*w[i].z", "2")
    w = np.array([[0, 0, 1.0], [0, 1, 0]])
    assert Witness(one).energy(w) == 1.0
    np.testing.assert_array_equal(bond_vectors(one, "w", Evaluated(one).values), [[1, 0, 0], [1, 0, 0]])


def test_vectors_of_bonds_of_three_ends():
    three = '[lattices.line]\nsize = ["2*n"]\nboundary = "periodic"\nvectors = [[1.5]]\nbonds.triple = [{ at = [[0, 0], [0, 1], [0, 3]] }]\n'
    one = spec("bond(i, j, k) of line.triple", "r(i, k).x*w[i].z + r(k, j).x*w[j].z", "2*n", three)
    w = np.zeros((6, 3))
    w[:, 2] = 1
    assert Witness(one).energy(w) == pytest.approx(6 * (4.5 - 3.0))


def test_formulas_may_take_the_sites_of_a_place():
    one = spec(energy="far(i)*w[i].z + along(i, j)", more='[formulas]\n"far(a)" = "norm(r(a))"\n"along(a, b)" = "r(a, b).x"\n')
    assert Witness(one).energy(np.tile([0, 0, 1.0], (9, 1))) > 0


def test_r_stays_free_as_a_name():
    one = spec(energy="r*w[i].z", more='r = 2.0\n')
    assert one.parameters[-1].name == "r"


GRAPH = '[graphs.g]\nfile = "edges.csv"\npositions = {positions}\n'


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "edges.csv").write_text("i,j,J\n0,1,1.5\n2,1,0.5\n")
    (tmp_path / "sites.csv").write_text("x,y,z\n0,0,0\n1,0,0\n1,2,3\n")
    (tmp_path / "short.csv").write_text("0,0\n1,0\n")
    return tmp_path


@pytest.mark.parametrize("positions_", ['"sites.csv"', "[[0, 0, 0], [1, 0, 0], [1, 2, 3]]"])
def test_graphs_may_carry_positions(folder, positions_):
    one = spec("edge(i, j, J) of g", "J*dot(r(i, j), w[j]) + r(i).y*w[i].z", "3", GRAPH.format(positions=positions_), str(folder / "m.toml"))
    values = Evaluated(one).values
    np.testing.assert_array_equal(positions(one, "w", values), [[0, 0, 0], [1, 0, 0], [1, 2, 3]])
    np.testing.assert_array_equal(bond_vectors(one, "w", values), [[1, 0, 0], [0, -2, -3]])
    w = np.array([[0, 0, 1.0], [1, 0, 0], [0, 0, 1]])
    assert Witness(one).energy(w) == 1.5 * 1 + 0.5 * 0 + 2.0


REFUSED = [
    (dict(energy="r(i).x + r(k).x"), "E302", "not declared", "k"),
    (dict(energy="r(i, j, i).x"), "E304", "1 or 2 arguments", "r"),
    (dict(energy="r(i + 1).x"), "E308", "bound indices", "i + 1"),
    (dict(energy="r(i, i).x"), "E309", "vector of a bond", "r"),
    (dict(over="pair(i, j) of w", energy="r(i, j).x", more='[observables.o]\nover = "bond(i, j) of square(n, n)"\nvalue = "1"\n'), "E309", "vector of a bond", "r"),
    (dict(over="pair(i, j) of w", energy="r(i).x"), "E501", "no positions", "r"),
    (dict(over="bond(i, j) of bare", energy="r(i, j).x", count="n", more='[lattices.bare]\nsize = ["n"]\nboundary = "open"\nbonds.x = [{ offset = [1] }]\n'), "E501", "no vectors", "r"),
    (dict(energy="r(i)"), "E303", "a vector", "r(i)"),
    (dict(more='[lattices.a]\nname = "square"\nsize = ["n", "n"]\nboundary = "open"\n[lattices.b]\nname = "square"\nconstant = 2\nsize = ["n", "n"]\nboundary = "open"\n'
      '[effects.f]\nover = "bond(i, j) of a"\nenergy = "r(i).x"\n[effects.g]\nover = "bond(i, j) of b"\nenergy = "1"\n'), "E501", "several lattices", "r"),
    (dict(more='[effects.f]\nover = "site(i) of w"\nenergy = "w[i].z"\n[runs.d]\nstart = "s"\nh = "r(0).x"\nsteps = 1\n[starts.s]\nrandom = 1\n'), "E309", "is not allowed", "r"),
    (dict(count="skew", more=SKEW.replace("[2, 0]", "[0, 0]"), over="site(i) of w", energy="w[i].z"), "E307", "zero", "[0, 0]"),
]


@pytest.mark.parametrize("parts, code, words, caret", REFUSED, ids=range(len(REFUSED)))
def test_what_is_refused(parts, code, words, caret):
    with pytest.raises(SpecError) as caught:
        spec(**parts)
    first = caught.value.diagnostics[0]
    assert first.code == code and words in first.cause and first.hint, str(caught.value)
    assert first.text[first.column - 1:first.column - 1 + first.length] == caret


@pytest.mark.parametrize("positions_, code, words", [
    ('"short.csv"', "E403", "names site 2"), ('"none.csv"', "E504", ""), ("[[0, 0], [1, 0], [0, 0]]", "E307", "sites 0 and 2"),
    ("[[0, 0], [1, 0], [2]]", "E505", "row 2 has 1 number"), ("7", "E203", "list of positions")])
def test_positions_of_a_graph_that_are_refused(folder, positions_, code, words):
    with pytest.raises(SpecError) as caught:
        spec("edge(i, j) of g", "w[i].z", "3", GRAPH.format(positions=positions_), str(folder / "m.toml"))
    first = caught.value.diagnostics[0]
    assert first.code == code and words in first.cause and first.hint, str(caught.value)
