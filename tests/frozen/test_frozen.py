"""`make frozen`: the cases, their digests, and what is said of a difference."""
import pytest
from frozen.cases import Case, cases
from frozen.run import compare
from frozen.states import bits

pytestmark = pytest.mark.quick
BODY = Case("free_rigid_body", (), "spherical-midpoint")


def test_every_case_has_a_key_of_its_own():
    found = [case.key for case in cases()]
    assert len(set(found)) == len(found) > 5000 and BODY.key in found


def test_a_digest_is_that_of_the_numbers():
    """The same again, another one for another method or step size; a refusal is named."""
    found = bits(BODY)
    assert found == bits(BODY) and found[0] != found[1]
    assert set(found).isdisjoint(bits(Case("free_rigid_body", (), "gauss-2")))
    assert bits(Case("nambu_a31", (), "gauss-2")) == ("UsageError", "UsageError")


def test_a_difference_is_counted_and_named(capsys):
    assert compare({"a": ("1", "2"), "b": ("3", "4")}, {"a": ("1", "2"), "b": ("3", "5")}) == 1
    assert "b: ('3', '5') before, ('3', '4') now" in capsys.readouterr().out
