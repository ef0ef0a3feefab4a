"""Lattices by name and their shells, from a table written by hand; places of lattices that users declare, and what is refused."""
import math
from pathlib import Path

import numpy as np
import pytest

import smidgen
from smidgen.errors import SpecError
from smidgen.language.crystals import CRYSTALS
from smidgen.language.places import bond_vectors, bonds, positions
from smidgen.run.step.evaluated import Evaluated

R2, R3, R7 = math.sqrt(2), math.sqrt(3), math.sqrt(7)

# of three shells: neighbours of a site, their distance, and the smallest angle between two of them in degrees; all sites of a lattice are alike
SHELLS = {
    "chain": [(2, 1, 180), (2, 2, 180), (2, 3, 180)],
    "ladder": [(3, 1, 90), (2, R2, 90), (2, 2, 180)],
    "square": [(4, 1, 90), (4, R2, 90), (4, 2, 90)],
    "triangular": [(6, 1, 60), (6, R3, 60), (6, 2, 60)],
    "honeycomb": [(3, 1 / R3, 120), (6, 1, 60), (3, 2 / R3, 120)],
    "kagome": [(4, 1 / 2, 60), (4, R3 / 2, 60), (6, 1, 60)],
    "cubic": [(6, 1, 90), (12, R2, 60), (8, R3, math.degrees(math.acos(1 / 3)))],
    "bcc": [(8, R3 / 2, math.degrees(math.acos(1 / 3))), (6, 1, 90), (12, R2, 60)],
    "fcc": [(12, 1 / R2, 60), (6, 1, 90), (24, math.sqrt(3 / 2), math.degrees(math.acos(5 / 6)))],
    "hcp": [(12, 1, 60), (6, R2, math.degrees(math.acos(1 / 3))), (2, math.sqrt(8 / 3), 180)],
    "diamond": [(4, R3 / 4, math.degrees(math.acos(-1 / 3))), (12, 1 / R2, 60), (12, math.sqrt(11) / 4, math.degrees(math.acos(7 / 11)))],
    "pyrochlore": [(6, R2 / 4, 60), (12, math.sqrt(6) / 4, math.degrees(math.acos(5 / 6))), (12, 1 / R2, 60)],
}
# For example, in the third shell of diamond stand (3, -1, 1)/4 and (3, 1, -1)/4; in the second of hcp (0, 2/sqrt(3), sqrt(2/3)) and its mirror image;
# in the second of pyrochlore (2, 1, 1)/4 and (1, 2, 1)/4.


def spec(over: str, count: str, more: str = ""):
    return smidgen.load_text(f"""
[model]
name = "m"
[space]
w = {{ sphere = "{count}" }}
[parameters]
n = 8
{more}
[effects.e]
over = "bond(i, j) of {over}"
energy = "-dot(w[i], w[j])"
""")


def around(one, family: str = "w"):
    """Of every site the vectors to its neighbours."""
    values = Evaluated(one).values
    pairs, vectors = bonds(one, family, values), bond_vectors(one, family, values)
    found = [[] for _ in positions(one, family, values)]
    for (i, j), v in zip(pairs, vectors):
        found[i].append(v)
        found[j].append(-v)
    return [np.array(rows) for rows in found]


def smallest_angle(rows) -> float:
    units = rows / np.linalg.norm(rows, axis=1, keepdims=True)
    return math.degrees(math.acos(max(-1, (units @ units.T - 2 * np.eye(len(rows))).max())))


def cells_of(name: str):
    d = CRYSTALS[name].directions
    return ", ".join("n" * d), "*".join([str(len(CRYSTALS[name].positions)), *"n" * d])


def test_the_table_has_every_lattice():
    assert list(SHELLS) == list(CRYSTALS)


@pytest.mark.parametrize("name", SHELLS)
def test_shells_of_every_lattice_by_name(name):
    sizes, count = cells_of(name)
    for word, (number, distance, angle) in zip(("first", "second", "third"), SHELLS[name]):
        for rows in around(spec(f"{name}({sizes}, periodic).{word}", count)):
            assert len(rows) == number
            np.testing.assert_allclose(np.linalg.norm(rows, axis=1), distance, rtol=1e-12)
            assert smallest_angle(rows) == pytest.approx(angle, abs=1e-9)


@pytest.mark.parametrize("name", SHELLS)
def test_an_open_lattice_has_the_bonds_whose_ends_stand_in_it(name):
    """Counted from positions alone: the pairs of sites at the distance of a shell."""
    sizes, count = cells_of(name)
    one = spec(f"{name}({sizes.replace('n', '3')}, open).second", count.replace("n", "3"))
    values = Evaluated(one).values
    r = positions(one, "w", values)
    apart = np.linalg.norm(r[:, None] - r, axis=-1)
    near = {tuple(pair) for pair in np.argwhere(np.triu(np.abs(apart - SHELLS[name][1][1]) < 1e-9)).tolist()}
    assert {tuple(sorted(pair)) for pair in bonds(one, "w", values).tolist()} == near


def test_the_first_shell_is_the_bonds_without_a_word_and_the_boundary_is_periodic():
    for name in SHELLS:
        sizes, count = cells_of(name)
        assert spec(f"{name}({sizes}).first", count).effects == spec(f"{name}({sizes}, periodic)", count).effects
    assert spec("chain(n, open).second", "n").effects == spec("chain(n, open, 2)", "n").effects


def test_directions_may_be_open_or_periodic():
    one = spec("honeycomb(n, n, open, periodic)", "2*n*n")
    assert {len(rows) for rows in around(one)} == {2, 3}
    vectors = bond_vectors(one, "w", Evaluated(one).values)
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=1), 1 / R3)


KITE = """
[lattices.own]
size = ["n", "n"]
boundary = "periodic"
constant = 2
vectors = [[1, 0], [0, "sqrt(3)"]]
positions = [[0, 0], [0.5, 0.5]]
"""


def test_a_lattice_of_users_own_has_places_and_shells():
    """Rectangles with a site in the middle are a triangular lattice: here with neighbours at 2."""
    for word, (number, distance, angle) in zip(("first", "second", "third"), SHELLS["triangular"]):
        for rows in around(spec(f"own.{word}", "2*n*n", KITE)):
            assert len(rows) == number and smallest_angle(rows) == pytest.approx(angle)
            np.testing.assert_allclose(np.linalg.norm(rows, axis=1), 2 * distance)
    assert spec("own", "2*n*n", KITE).effects == spec("own.first", "2*n*n", KITE).effects


def test_positions_are_in_the_order_of_the_sites():
    one = spec("own", "2*n*n", KITE)
    r = positions(one, "w", Evaluated(one, {"n": 3}).values)
    x, y, s = 2, 1, 1
    np.testing.assert_allclose(r[2 * (x + 3 * y) + s], [2 * (x + 0.5), 2 * R3 * (y + 0.5), 0])


def test_lists_of_bonds_stay_and_go_before_shells():
    own = KITE + "bonds.up = [{ from = 0, to = 1, offset = [0, 0] }]\nbonds.first = [{ offset = [2, 0] }]\n"
    assert len(spec("own.up", "2*n*n", own).effects[0].over.bonds) == 1
    assert len(spec("own.second", "2*n*n", own).effects[0].over.bonds) == 6
    (only,) = bond_vectors(one := spec("own.first", "2*n*n", own), "w", Evaluated(one).values)[:1]
    np.testing.assert_allclose(only, [4, 0, 0])


def test_a_lattice_by_name_may_be_declared():
    named = '[lattices.film]\nname = "square"\nsize = ["n", "n"]\nboundary = ["open", "periodic"]\nconstant = 0.27\n'
    one = spec("film", "n*n", named)
    assert one.effects == spec("square(n, n, open, periodic)", "n*n").effects
    np.testing.assert_allclose(positions(one, "w", Evaluated(one).values)[9], [0.27, 0.27, 0])


def test_without_vectors_there_are_no_places():
    bare = '[lattices.own]\nsize = ["n"]\nboundary = "periodic"\nbonds.x = [{ offset = [1] }]\n'
    one = spec("own", "n", bare)
    values = Evaluated(one).values
    assert positions(one, "w", values) is None and bond_vectors(one, "w", values) is None
    assert bonds(one, "w", values).shape == (8, 2)


LATTICE = '[lattices.own]\nsize = ["n", "n"]\nboundary = "periodic"\n'
REFUSED = [     # what stands in the spec, its over, code, words of the cause, where the caret stands
    ("vectors = [[1, 0], [2, 0]]", "own", "E307", "linearly dependent", "[[1, 0], [2, 0]]"),
    ("vectors = [[1, 0], [0, 1], [1, 1]]", "own", "E307", "linearly dependent", "[[1, 0], [0, 1], [1, 1]]"),
    ("vectors = [[1, 0], [0, 0]]", "own", "E307", "zero", "[0, 0]"),
    ("vectors = [[1, 0]]", "own", "E403", "1 vector for 2 directions", "[[1, 0]]"),
    ("vectors = [[1, 0], [0, 1, 0]]", "own", "E403", "components", "[1, 0]"),
    ('vectors = [[1, 0], [0, "n"]]', "own", "E309", "without parameters", '"n"'),
    ('vectors = [[1, 0], [0, "sqrt(-1)"]]', "own", "E307", "finite", "sqrt(-1)"),
    ("vectors = [[1, 0], [0, 1e400]]", "own", "E204", "", "1e400"),
    ("vectors = 3", "own", "E203", "list of vectors", "3"),
    ("vectors = [[1, 0], [0, 1]]\npositions = [[0, 0], [0.5, 1.5]]", "own", "E307", "outside the cell", "[0.5, 1.5]"),
    ("vectors = [[1, 0], [0, 1]]\npositions = [[0, 0], [0.5]]", "own", "E403", "1 number for 2 vectors", "[0.5]"),
    ("vectors = [[1, 0], [0, 1]]\npositions = [[0, 0], [0.5, 0], [0, 0]]", "own", "E307", "sites 0 and 2", "[[0, 0], [0.5, 0], [0, 0]]"),
    ("vectors = [[1, 0], [0, 1]]\npositions = []", "own", "E403", "0 positions", "[]"),
    ("vectors = [[1, 0], [0, 1]]\nsites = 2", "own", "E202", "need positions", "[[1, 0], [0, 1]]"),
    ("vectors = [[1, 0], [0, 1]]\nsites = 3\npositions = [[0, 0], [0.5, 0]]", "own", "E403", "2 positions for 3 sites", "[[0, 0], [0.5, 0]]"),
    ("positions = [[0, 0]]\nbonds.x = [{ offset = [1, 0] }]", "own.x", "E202", "no `vectors`", "[[0, 0]]"),
    ("vectors = [[1, 0], [0, 1]]\nconstant = 0", "own", "E307", "lattice constant", "0"),
    ('name = "kagme"', "own", "E205", "no lattice `kagme`", '"kagme"'),
    ('name = "cubic"', "own", "E403", "3 directions", '["n", "n"]'),
    ('name = "square"\nvectors = [[1, 0], [0, 1]]', "own", "E210", "has its own", "[[1, 0], [0, 1]]"),
    ('name = "kagome"\nsites = 2', "own", "E210", "3 sites", "2"),
    ('name = "square"', "own.secnd", "E302", "no bonds `secnd`", "secnd"),
    ("", "square(n, n, periodic).ninth", "E302", "no shell `ninth`", "ninth"),
    ("", "chain(n, periodic, 2).first", "E501", "distance of these neighbours is already given", "first"),
    ("", "kagom(n, n)", "E501", "no lattice `kagom(...)`", "kagom"),
    ("vectors = [[1, 0], [0.5, 0.86602]]", "own", "E502", "nearly one shell", "own"),
    ("vectors = [[1, 0], [0, 1000000]]", "own.sixth", None, "", ""),
    ("vectors = [[1, 0], [0.999999, 0.0001]]", "own.eighth", "E502", "", "eighth"),
]


@pytest.mark.parametrize("lines, over, code, words, caret", REFUSED, ids=range(len(REFUSED)))
def test_what_is_refused(lines, over, code, words, caret):
    def read():
        return spec(over, "n*n", LATTICE + lines if lines else "")
    if code is None:
        assert len(read().effects[0].over.bonds) == 1       # six times as far along the short vector
        return
    with pytest.raises(SpecError) as caught:
        read()
    told = caught.value.diagnostics
    assert told[0].code == code and words in str(told[0]), str(caught.value)
    assert f"= {told[0].hint}" in str(caught.value) and told[0].hint
    line = str(caught.value).splitlines()
    marks = next(k for k, text in enumerate(line) if "^" in text)
    start, width = line[marks].index("^"), line[marks].count("^") + line[marks].count("~")
    assert line[marks - 1][start:start + width] == caret


WALL = '''
[lattices.own]
size = ["n", "n"]
vectors = [[2, 0], [1, 1]]
positions = [[0, 0], [0.5, 0]]
bonds.mortar = [{ from = 0, to = 1, offset = [0, 0] }, { from = 1, to = 0, offset = [1, 0] }, { from = 1, to = 0, offset = [0, 1] }]
'''


def test_a_wall_of_bricks_has_three_neighbours_and_is_periodic_without_a_word():
    """The example of docs/spec.md: all at distance 1; a lattice by name is periodic without a boundary too."""
    assert all(line in (Path(__file__).parents[2] / "docs/spec.md").read_text() for line in WALL.splitlines()[3:])
    for rows in around(spec("own.mortar", "2*n*n", WALL)):
        assert len(rows) == 3
        np.testing.assert_allclose(np.linalg.norm(rows, axis=1), 1)


IN_UNITS = '''
[model]
name = "rect"
[units]
energy = "meV"
time = "fs"
field = "T"
[lattices.rect]
size = [3, 3]
{lines}
positions = [[0, 0], [0.5, 0.4]]
[space]
w = {{ sphere = "rect", moment = "2 mu_B" }}
[effects.near]
over = "bond(i, j) of rect.first"
energy = "3 meV*dot(w[i], w[j])"
[starts.one]
theta = "if(r(i).x < 4 angstrom, 0, pi)"
phi = 0
'''


def in_units(lines):
    return smidgen.load_text(IN_UNITS.format(lines=lines))


def test_vectors_may_be_lengths():
    """As with a constant that is one; mixed with bare numbers, or beside such a constant, they are refused. One error: that sites have no places is none."""
    one, same = (in_units(lines) for lines in ('vectors = [["4.2 angstrom", 0], [0, "0.31 nm"]]', 'vectors = [[4.2, 0], [0, 3.1]]\nconstant = "1 angstrom"'))
    np.testing.assert_allclose(*(positions(each, "w", Evaluated(each).values) for each in (one, same)), rtol=1e-14)
    assert one.families[0].lattice.places.measured and one.families[0].lattice.places.unit == "angstrom"
    for lines, words in [('vectors = [["4.2 angstrom", 0], [0, 3.1]]', "must be a length, but this has no unit"), ('vectors = [["4.2 fs", 0], [0, "3 fs"]]', "but this is a time"),
                         ('constant = "1 nm"\nvectors = [["4.2 angstrom", 0], [0, "3 nm"]]', "but so is the constant")]:
        with pytest.raises(SpecError) as caught:
            in_units(lines)
        assert words in str(caught.value) and "E501" not in {d.code for d in caught.value.diagnostics}


def test_a_bond_that_is_a_list_is_told_how_one_is_written():
    """Once for the bond; that no effect has an energy is not said where the only one has an error."""
    text = '''
[model]
name = "a"
[lattices.L]
size = [4]
boundary = "open"
sites = 2
bonds = { leg = [[0, 0, 1]] }
[space]
w = { sphere = 8 }
[effects.legs]
over = "bond(i, j) of L.leg"
energy = "dot(w[i], w[j])"
[effects.friction]
over = "site(i) of w"
damping = 0.1
'''
    with pytest.raises(SpecError) as caught:
        smidgen.load_text(text)
    first, *others = caught.value.diagnostics
    assert first.hint == "a bond is written `{ from = 0, to = 1, offset = [0] }`" and first.line == 8 and first.code == "E203"
    assert all("no effect has an energy" not in d.cause for d in others)
