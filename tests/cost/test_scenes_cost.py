"""The scenes of docs/scenes.md: what they switch off leaves nothing in the C."""
import csv
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parents[1] / "bench"
DOCS = HERE.parents[1] / "docs"


@pytest.fixture(scope="module")
def bench():
    """The script of the table."""
    sys.path.insert(0, str(HERE))
    try:
        import scenes
        yield scenes
    finally:
        sys.path.remove(str(HERE))


def test_there_are_scenes_of_three_fields(bench):
    assert {s.field for s in bench.SCENES} == {"bodies", "vortices", "spins"} and len(bench.SCENES) >= 12
    assert all(set(s.without) < set(s.effects) for s in bench.SCENES)


def test_the_table_is_of_these_scenes_and_says_that_nothing_is_left(bench):
    with open(DOCS / "scenes.csv", newline="") as lines:
        rows = list(csv.DictReader(lines))
    assert [r["scene"] for r in rows] == [s.name for s in bench.SCENES]
    assert all(r["same_c"] == "yes" and float(r["ratio_to_the_rest_alone"]) == 1 for r in rows)


@pytest.mark.parametrize("k", [0, *(pytest.param(k, marks=pytest.mark.long) for k in range(1, 14))])
def test_the_c_of_a_scene_is_that_of_the_rest_alone(bench, k, tmp_path):
    base, without, rest = bench.specs_of(bench.SCENES[k], tmp_path)
    assert bench.c_of(without) == bench.c_of(rest) != bench.c_of(base)
