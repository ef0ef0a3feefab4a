"""The table of the effects of a scene: what is counted, measured and given up."""
import pytest

import smidgen
from smidgen.cost.effects import effects_table, table
from smidgen.read.origins import origins
from smidgen.tables import text_of

pytestmark = pytest.mark.quick
BASE = """[model]
name = "film"
[space]
w = { sphere = "n*n" }
[parameters]
n = 6
K = { default = 0.3, size = "n*n" }
[effects.exchange]
over = "bond(i, j) of square(n, n, periodic)"
energy = "-dot(w[i], w[j])"
[effects.easy]
over = "site(i) of w"
energy = "-K[i]*w[i].z^2"
[effects.gone]
use = "spins/uniaxial"
K = 0.1
[starts.a]
random = 1
[runs.demo]
start = "a"
h = 0.05
steps = 10
[runs.bare]
like = "demo"
without = ["pulse", "bath"]
"""
SCENE = """[scene]
base = "film.toml"
without = ["gone"]
[effects.pulse]
over = "site(i) of w"
energy = "-cos(t)*w[i].x"
[effects.bath]
use = "spins/bath"
alpha = 0.1
kT = 0.2
[effects.drag]
over = "bond(i, j) of square(n, n, periodic)"
torque = "cross(w[i], cross(w[i], 0.1*w[j]))"
"""
BESIDE = """[effects.along]
over = "bond(i, j) of chain(n*n, open)"
energy = "-dot(w[i], w[j])"
"""


@pytest.fixture
def rows(tmp_path):
    (tmp_path / "film.toml").write_text(BASE)
    (tmp_path / "hot.toml").write_text(SCENE)

    def made(run=None, times=False, **more):
        spec, places = origins(tmp_path / "hot.toml")
        return {row.effect: row for row in effects_table(spec, places, run, times=times, **more)}
    return made


def test_where_effects_come_from_and_which_are_called_for(rows):
    found = rows()
    assert list(found) == ["exchange", "easy", "gone", "pulse", "bath", "drag"]
    assert [row.called for row in found.values()] == [True, True, False, True, True, True]
    assert [row.kind for row in found.values()] == ["energy", "energy", "energy", "energy", "bath", "torque"]
    assert found["gone"].source.startswith("spins/uniaxial: Chik") and found["easy"].source.endswith("film.toml:11") and found["pulse"].source.endswith("hot.toml:4")
    assert [name for name, row in rows("bare").items() if row.called] == ["exchange", "easy", "drag"]
    assert [name for name, row in rows(effects=["easy"]).items() if row.called] == ["easy"]


def test_operations_and_bytes_of_a_site_are_those_of_the_formula(rows):
    """A site has four neighbours, twice as many terms as there are sites: -w[j], added to the sum, for each end. The slope of K w_z^2 is two products and an addition."""
    found = rows()
    assert found["exchange"].operations == 2 * 2 * 3 and found["exchange"].bytes == 2 * 2 * 2 * 24
    assert found["easy"].operations == 3 and found["easy"].bytes == 2 * 24 + 8
    assert found["gone"].operations is None


def test_what_is_lost_and_why(rows):
    found = rows()
    assert found["exchange"].lost == {}
    assert found["easy"].lost == {"momentum": "conserved only along (0, 0, 1)"}
    assert set(found["pulse"].lost) == {"energy", "momentum"} and found["pulse"].lost["energy"] == "depends on the time"
    assert set(found["bath"].lost) == {"energy", "momentum", "symplectic", "reversible"}
    assert found["drag"].lost == dict.fromkeys(("energy", "momentum", "symplectic"), "a torque does not derive from an energy")


def test_an_effect_that_prevents_rows(rows, tmp_path):
    (tmp_path / "hot.toml").write_text(SCENE + BESIDE)
    found = rows()
    assert found["along"].lost["layout"] == "rows without it, sites with it" and "layout" not in found["exchange"].lost


def test_times_with_and_without(rows):
    found = rows("bare", times=True)
    assert found["exchange"].ns == found["easy"].ns > 0 and found["exchange"].without > 0
    assert found["bath"].without == found["exchange"].ns and found["bath"].ns > found["bath"].without
    assert "spins/bath" in text_of(table(found.values()))


def test_tracers_are_what_an_effect_of_tracers_moves():
    path = smidgen.resources.shipped()["vortex_tracers"]
    found = {row.effect: row for row in effects_table(*origins(path), times=False)}
    assert found["interaction"].lost == {} and found["transport"].lost == {}
    assert found["transport"].bytes == 3 * (3 * 24 + 8)


HOLDING = BASE + """[effects.edge]
use = "spins/pinned_edge"
where = "i < n"
[effects.holes]
over = "site(i) of w"
absent = "i > 30"
"""


def test_sites_that_are_held_cost_no_operation(tmp_path):
    (tmp_path / "film.toml").write_text(HOLDING.replace(', "bath"]', "]").replace('without = ["pulse"]', 'without = ["gone"]'))
    found = {row.effect: row for row in effects_table(*origins(tmp_path / "film.toml"), "bare", times=False)}
    assert [(found[name].kind, found[name].operations, found[name].bytes) for name in ("edge", "holes")] == [("pinned", 0, 0), ("absent", 0, 0)]
    assert "do not move" in found["edge"].lost["momentum"] and found["holes"].lost == {}
