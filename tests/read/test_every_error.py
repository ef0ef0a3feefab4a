"""Every error at once: faults planted together are all told in one round, with their lines, and nothing else is.

tests/support/faulty_specs.py says what a fault is. Faults of [space] and [parameters] are declarations: what they
leave unknown may hide what depends on it, and nothing more.
"""
import functools
import random

import pytest
from support.faulty_specs import BASE, MANY, errors_of, faults, planted

from smidgen.errors import SpecError
from smidgen.read import load_text
from smidgen.language.codes import BIG, BOND, COUNT, DURATION, EMPTY, INDEX, LATTICE, LIMIT, METHOD, OFF, START, STEP
from smidgen.language.codes import ARITY, CHOICE, EXPONENT, INTEGER, KIND, NOT_HERE, OVER, UNKNOWN_NAME, VALUE

pytestmark = pytest.mark.quick
DECLARING = ("space", "parameters")
WHOLE = {LIMIT, EMPTY}                          # of the file: nothing else is looked at
OF_VALUES = {INDEX, COUNT, BOND, LATTICE, OFF, START, STEP, DURATION, METHOD}   # judged with the numbers of a declaration
OF_VECTORS = OF_VALUES | {UNKNOWN_NAME, KIND, ARITY, EXPONENT, VALUE, NOT_HERE, INTEGER, BIG, OVER}     # with its names
NAMELESS = {"family_keyword", "space_not_table"}    # no vector has a name
CHANGES_OTHERS = {"run_set_size", "radius_on_r3"}   # other numbers, another kind of vector: other faults may be none


@functools.cache
def every():
    """What is planted here: each broken spec is read once, and not before a test needs it."""
    return [f for f in faults() if not {code for code, *_ in f.errors} & WHOLE and f.name not in CHANGES_OTHERS]


def test_the_table_is_large():
    assert len(every()) > 180 and {f.section for f in every()} == set(BASE)
    assert len({code for f in every() for code, *_ in f.errors}) >= 25
    assert errors_of(planted([])[0]) == []


def chosen(first, among, dice):
    """`first` and up to five more, at most one for a section that a spec has once."""
    found = [first]
    for fault in dice.sample(among, len(among)):
        if len(found) < dice.randint(2, 6) and fault not in found and (
                fault.section in MANY or all(f.section != fault.section for f in found)):
            found.append(fault)
    return found


def told_and_planted(first, among, dice):
    """(errors told, error -> its fault, names) of a spec with at most ten."""
    while True:
        found = chosen(first, among, dice)
        text, wanted = planted(found)
        if len(wanted) <= 10:
            return set(errors_of(text)), wanted, [f.name for f in found]


@pytest.mark.parametrize("section", [name for name in BASE if name not in DECLARING])
def test_all_planted_faults_are_told_in_one_round(section):
    among, dice = [f for f in every() if f.section not in DECLARING], random.Random(section)
    for first in [f for f in every() if f.section == section]:
        told, wanted, names = told_and_planted(first, among, dice)
        assert told == set(wanted), names


@pytest.mark.parametrize("section", DECLARING)
def test_a_wrong_declaration_hides_what_depends_on_it_alone(section):
    dice, hidden, seen = random.Random(section), 0, 0
    for first in [f for f in every() if f.section == section] * 3:
        told, wanted, names = told_and_planted(first, every(), dice)
        may_hide = OF_VECTORS if NAMELESS & set(names) else OF_VALUES
        missing = set(wanted) - told
        assert told <= set(wanted), (names, told - set(wanted))
        assert all(wanted[e].section not in DECLARING and e[0] in may_hide for e in missing), (names, missing)
        hidden, seen = hidden + len(missing), seen + len(wanted)
    assert hidden < seen / 10


# Faults of one item, and of kinds that the table has not

def rounds(text: str) -> list:
    """[(code, line)] of the errors, in order."""
    with pytest.raises(SpecError) as caught:
        load_text(text)
    return [(d.code, d.line) for d in caught.value.diagnostics]


ELEVEN = """[model]
name = "switch"
orientation = 3
[space]
w = { sphere = "n", kappa = "t" }
[parameter]
n = { default = 4 }
J = { default = nan, unit = "*/" }
[effects.exchange]
over = "bond(i, j) of chain(n, periodic)"
energy = "-J*dot(w[i], w[j]) + K*dot(w[i], L)"
[effects.field]
energy = w[0].z
[starts.s]
theta = "1 +"
phi = "q"
[runs.demo]
start = "z"
"""


def test_eleven_errors_of_different_kinds_in_one_round():
    """Ten of them, and when these are mended the rest: two rounds, and none for what is only a consequence."""
    told = rounds(ELEVEN)
    assert told == [("E207", 2), (CHOICE, 3), (NOT_HERE, 5), ("E201", 6), ("E204", 8), ("E209", 8), (UNKNOWN_NAME, 11),
                    (UNKNOWN_NAME, 11), ("E103", 13), ("E301", 15)]
    with pytest.raises(SpecError, match="there are more errors"):
        load_text(ELEVEN)
    mended = ELEVEN.replace('"switch"', '"m"').replace("= 3", "= 1").replace('"t"', '"1"').replace("[parameter]", "[parameters]")
    mended = mended.replace("nan", "1.0").replace("*/", "meV").replace("K*dot(w[i], L)", "dot(w[i], w[j])")
    mended = mended.replace("= w[0].z", '= "dot(w[0], w[0])"').replace("1 +", "1")
    assert rounds(mended) == [(UNKNOWN_NAME, 16), ("E202", 17), ("E202", 17), (UNKNOWN_NAME, 18)]


RUN = """[model]
name = "m"
[space]
w = { sphere = 2 }
[effects.e]
energy = "a*w[0].z + b*w[1].z*sin(c, 1)"
[starts.s]
x = "p"
y = "q +"
z = 1
normalise = 3
[runs.demo]
start = "t"
method = "euler"
h = "u"
time = "v"
output = { every = 0, what = ["enrgy", "statess"] }
"""


def test_each_key_of_an_item_is_read():
    whole = rounds(RUN)
    assert len(whole) == 10         # more would be too many at once
    one = RUN.replace('y = "q +"', "y = 0").replace("a*w[0].z + ", "").replace('x = "p"', "x = 0")
    assert rounds(one) == [(UNKNOWN_NAME, 6), (UNKNOWN_NAME, 6), ("E203", 11), (UNKNOWN_NAME, 13), (CHOICE, 14), (UNKNOWN_NAME, 15),
                           (UNKNOWN_NAME, 16), (LIMIT, 17), ("E606", 17), ("E606", 17)]


@pytest.mark.parametrize("old, new, wanted", [
    ("[space]", "[spaces]", [("E201", 3)]),                             # read as the section that was meant
    ("[effects.e]", "[effect.e]", [("E201", 5)]),
    ("[starts.s]", "[origins.s]", [("E201", 7)]),                       # its names count as declared
    ("[space]", "[space", [("E103", 3)]),
    ("[starts.s]", "[starts.s", [("E103", 7)]),
    ("[runs.demo]", "[runs.demo of s]", [("E103", 10)]),
    ('energy = "w[0].z"', "energy = w[0].z", [("E103", 6)]),
    ("w = { sphere = 2 }", "w = { sphere = 2*n }", [("E103", 4)]),
    ("w = { sphere = 2 }", "w { sphere = 2 }", [("E103", 4)]),
    ('name = "m"', 'name = "m', [("E103", 2)]),
    ("h = 0.1", "h = 0.1\nh = 0.2", [("E104", 13)]),
    ("h = 0.1", "h = ", [("E103", 12)]),
    ("[effects.e]", "[effects.e]\n[effects.e]", [("E104", 6)]),
    ("theta = 1.0", "theta 1.0", [("E103", 8)]),
])
def test_an_error_of_the_outside_hides_nothing_and_brings_nothing(old, new, wanted):
    right = RIGHT.replace(old, new)
    assert rounds(right) == wanted
    also = right.replace('method = "spherical-midpoint"', 'method = "euler"')
    extra = [] if old == "[runs.demo]" else [(CHOICE, 1 + also[:also.index("euler")].count("\n"))]
    assert rounds(also) == sorted(wanted + extra, key=lambda e: e[1])


RIGHT = """[model]
name = "m"
[space]
w = { sphere = 2 }
[effects.e]
energy = "w[0].z"
[starts.s]
theta = 1.0
phi = "i"
[runs.demo]
start = "s"
h = 0.1
time = 1.0
method = "spherical-midpoint"
"""


BROKEN = ["a..b = 1", "= 1", ". = 1", 'x = """', "x = '''a", "x = [1, 2", "[", "[[", "[a", "]", "x = {", '"', "h = 0.2 0.3",
          "[runs.demo.h]", "[[runs]]", "\u00e9 = 1", "w", "h 0.3", "x=", "{}", "[runs]", "[effects.e.energy]", "w 3"]


@pytest.mark.parametrize("line", BROKEN)
def test_a_broken_line_anywhere_is_errors_and_an_end(line):
    for at in range(RIGHT.count("\n") + 1):
        lines = RIGHT.split("\n")
        lines.insert(at, line)
        try:
            load_text("\n".join(lines))
        except SpecError as error:
            assert 1 <= len(error.diagnostics) <= 10


def test_formulas_with_errors_are_not_expanded_again_and_again():
    """2^40 expansions of a body that names nothing known."""
    chain = "\n".join(f'f{k} = "f{k + 1} + f{k + 1}"' for k in range(40))
    text = RIGHT.replace('"w[0].z"', '"f0*w[0].z"') + f'[formulas]\n{chain}\nf40 = "q"\n'
    assert rounds(text) == [(UNKNOWN_NAME, 56)]
    doubling = text.replace('"q"', '"1"')
    assert [code for code, _ in rounds(doubling)] == [BIG]


def test_of_a_list_of_data_the_first_error_is_enough():
    rows = ", ".join("[1, 0]" for _ in range(50))
    text = RIGHT.replace('theta = 1.0\nphi = "i"', f"vectors = [{rows}]").replace("h = 0.1", "h = 0")
    assert rounds(text) == [(START, 8), (STEP, 11)]


def test_a_part_of_a_start_that_is_set_aside_is_not_missed():
    two = RIGHT.replace("w = { sphere = 2 }", "w = { sphere = 2 }\np = { sphere = 1 }")
    two = two.replace("[starts.s]\n", "[starts.s.p]\nvectors = [[1, 0, 0]]\n[starts.s.w]\n")
    assert rounds(two.replace("[starts.s.p]", "[starts.s.p")) == [("E103", 8)]
    assert rounds(two.replace("h = 0.1", "h = 0").replace("[starts.s.p]", "[starts.s.p")) == [("E103", 8), (STEP, 15)]
