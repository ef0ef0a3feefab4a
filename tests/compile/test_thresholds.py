"""The thresholds of the solvers: each is measured, and the page is that of the table."""
import pytest
from bench.thresholds import DOCS, Effect, page, read, said, thresholds

TABLE = DOCS / "thresholds.csv"


@pytest.mark.quick
def test_every_threshold_is_measured_at_half_and_twice():
    assert {(name, factor) for name, _ in thresholds() for factor in (0.5, 2.0)} <= {(r.threshold, r.factor) for r in read(TABLE)}


@pytest.mark.quick
def test_the_page_is_that_of_the_table():
    assert page(TABLE) == (DOCS / "thresholds.md").read_text()


@pytest.mark.quick
def test_what_is_lost_is_said():
    assert said(Effect("SMG_X", 2.0, 9, 0, 3, 0, 1, 1.5, 7.0, "chain")) == "3 lost; 1 other refusals; iterations x 1.500; drift x 7 (chain)"
    assert said(Effect("SMG_X", 2.0, 9, 0, 0, 0, 0, 1.0, 1.0, "")) == "round-off alone"
    assert said(Effect("SMG_X", 2.0, 0, 0, 0, 0, 0, 1.0, 1.0, "")) == "nothing changes"
