"""The hard cases of tests/hard, one test each, and the page made of them."""
import pytest
from hard.case import CASES, TIERS, Case, Row, below, case, near, same_bits
from hard.table import page, read_table, table_of

import numpy as np


SLOW = ("a rough chain, from small steps to where they end", "two vortex pairs on their wrong branches",
        "close vortex pair, up to the fold", "close vortex pair, beyond the fold", "plain iteration where it does not contract",
        "chaos of the forced body: two Lyapunov exponents", "a stiff easy axis over many steps",
        "noise so strong that a half step forgets the direction", "a temperature of zero")    # seconds, even if of the quick tier

MANY_STEPS = ("round-off over a million steps of the free body",)      # to run takes longer than to compile: compiled with -O1


@pytest.mark.parametrize("one", [pytest.param(c, id=c.name, marks=pytest.mark.long if c.tier == "long" or c.name in SLOW else ())
                                 for c in CASES])
def test_hard_case(one, request):
    """Every row holds, and the page in docs has these rows."""
    if one.tier == "long":
        request.getfixturevalue("as_shipped")
    elif one.name in MANY_STEPS:
        request.getfixturevalue("optimised_here")
    rows = one.run()
    failed = [f"{r.what}: must be {r.criterion}, is {r.measured}" for r in rows if not r.holds]
    assert not failed, "\n".join([one.about, *failed])
    assert [r.what for r in rows] == [line.what for line in read_table() if line.case == one.name], "docs/hard.csv is old: make hard"


@pytest.mark.quick
def test_the_page_is_made_of_the_table(root):
    """docs/hard.md comes from docs/hard.csv, which has every case, none failed."""
    lines = read_table()
    assert (root / "docs" / "hard.md").read_text() == page(lines)
    assert list(dict.fromkeys(line.case for line in lines)) == [c.name for c in CASES]
    assert {line.holds for line in lines} == {"yes"}


@pytest.mark.quick
def test_names_and_tiers():
    assert len({c.name for c in CASES}) == len(CASES)
    assert {c.tier for c in CASES} == set(TIERS)
    with pytest.raises(ValueError):
        case("none", tier="never")


@pytest.mark.quick
def test_what_fails_is_a_row_that_fails():
    """An exception, no row, NaN, one bit: each is a failure, and prints."""
    def broken():
        yield near("fine", 1.0, 1.0, 0)
        raise ZeroDivisionError("here")
    for rows, count in ((broken, 2), (lambda: iter(()), 1)):
        one = Case("a case", "quick", "none", "about", rows)
        found = one.run()
        assert len(found) == count and not found[-1].holds
        assert table_of(one, found, 0.0).row_count == count
    nan = float("nan")
    assert not any(r.holds for r in (near("", nan, 1, 1), below("", nan, 1), same_bits("", np.zeros(1), np.array([-0.0]))))
    assert isinstance(found[0], Row) and "nothing" in found[0].measured
