"""Energies that jump where a vector crosses an edge of a formula: found, and told from edges without a jump."""
import pytest
import smidgen
from smidgen.analyse.symmetry.jumps import jumps

SPEC = """
[model]
name = "edges"
[space]
w = {{ {space} }}
[parameters]
a = 0.2
[effects.field]
energy = "w[0].z"
[effects.e]
{over}energy = "{energy}"
[starts.s]
random = 1
[runs.r]
start = "s"
h = 0.1
steps = 10
"""
RING = 'over = "bond(i, j) of chain(4, periodic)"\n'

quick = pytest.mark.quick


def spec_of(energy, over="", space="sphere = 4"):
    return smidgen.load_text(SPEC.format(energy=energy, over=over, space=space))


@quick
@pytest.mark.parametrize("energy, size", [("floor(2*w[0].x)*w[0].y", 1), ("if(w[0].x < a, w[0].x, 0.5*w[0].z)^2", 0.2), ("mod(w[0].x, 0.3)*w[0].z", 0.3),
                                          ("min(w[1].y, if(w[0].x >= a, 2, -2))", 3)])
def test_a_jump_is_found(energy, size):
    assert jumps(spec_of(energy))["e"] == pytest.approx(size, rel=0.25)


@quick
def test_a_jump_of_a_term_is_found():
    assert jumps(spec_of("if(dot(w[i], w[j]) > 0.95, 1, 0)*w[i].z", RING))["e"] > 0.5
    assert jumps(spec_of("floor(w[i].x)*dot(w[i], w[j])", RING, "r3 = 4"))["e"] > 0.5


@quick
@pytest.mark.parametrize("energy", ["if(w[0].x < a, (w[0].x - a)^2*w[0].y, 0)", "max(w[0].x, w[0].y)*w[0].z + abs(w[0].z)", "floor(3*t)*w[0].z",
                                    "if(w[0].x < 5, w[0].y, w[0].z)", "exp(200*w[0].x)"])
def test_an_edge_without_a_jump_is_none(energy):
    assert jumps(spec_of(energy)) == {}


@quick
def test_numbers_by_site_are_no_jump():
    assert jumps(spec_of("floor(i/2)*dot(w[i], w[j])", RING)) == {}


@quick
def test_explain_and_check_say_so(command, tmp_path):
    (tmp_path / "edges.toml").write_text(SPEC.format(energy="floor(2*w[0].x)*w[0].y", over="", space="sphere = 4"))
    said = command("explain", "edges.toml").stdout
    assert "The energy of 'e' is discontinuous" in said and "'field' is discontinuous" not in said
    assert "warning: the energy of 'e' is discontinuous" in command("check", "edges.toml").stdout
    assert smidgen.explain(smidgen.load(tmp_path / "edges.toml"), effects=["field"]).jumps == {}


@quick
def test_a_run_warns_of_the_effects_that_it_takes(command, tmp_path):
    (tmp_path / "edges.toml").write_text(SPEC.format(energy="floor(2*w[0].x)*w[0].y", over="", space="sphere = 4"))
    assert command("run", "edges.toml", "--time", "0.1").stderr.count("warning: the energy of 'e' is discontinuous") == 1
    assert "discontinuous" not in command("run", "edges.toml", "--time", "0.1", "--effects", "field").stderr
