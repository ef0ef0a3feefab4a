"""Values with units on the command line and in Python."""
from types import SimpleNamespace

import numpy as np
import pytest
import smidgen

from smidgen.check.validate import Report
from smidgen.cli import main
from smidgen.cli.average import table
from smidgen.cli.options import assignment
from smidgen.cli.sweep import axis
from smidgen.errors import UsageError
from smidgen.language.units import TIME
from smidgen.run.settings import settle

SPEC = """
[model]
name = "spin"

[units]
energy = "meV"
time = "ps"

[space]
w = { sphere = 1, kappa = "1 hbar" }

[parameters]
n = 3
J = "5.7 meV"
g = { default = ["1 meV", "2 meV"], size = 2 }
a = 0.5

[effects.field]
energy = "-(J + g[0] + g[1])*a*n*w.z"

[starts.up]
theta = 0.5
phi = 0

[runs.demo]
start = "up"
h = "1 fs"
time = "20 fs"
"""


@pytest.fixture
def spec(tmp_path):
    path = tmp_path / "spin.toml"
    path.write_text(SPEC)
    return path


@pytest.mark.quick
@pytest.mark.parametrize("given, found", [("6 meV", 6.0), ("0.006 eV", 6.0), (6.0, 6.0), ("-6 meV", -6.0)])
def test_values_in_python(spec, given, found):
    settled = settle(smidgen.load(spec), parameters={"J": given, "g": ["3 meV", 1]})
    assert settled.parameters == {"J": found, "g": [3.0, 1]} and settled.numbers.values["J"] == found


@pytest.mark.quick
@pytest.mark.parametrize("choice, said", [({"parameters": {"J": "6 T"}}, "an energy is needed here"), ({"parameters": {"J": "6 mev"}}, "there is no unit `mev`"), ({"h": "0.1"}, "h must be a time"),
                                          ({"h": "1 meV"}, "h must be a time"), ({"time": "20"}, "time must be a time"), ({"parameters": {"a": "1 T"}}, "a number without a unit is needed"),
                                          ({"period": "J"}, "period must be a time"), ({"averages": {"after": "2 T"}}, "after must be a time")])
def test_what_does_not_fit_is_refused(spec, choice, said):
    with pytest.raises(UsageError, match=said):
        settle(smidgen.load(spec), **choice)


@pytest.mark.quick
def test_times_in_python(spec):
    settled = settle(smidgen.load(spec), h="2 fs", time="40 fs", averages={"after": "4 fs", "what": ["energy"]})
    assert (settled.h, settled.steps, settled.averages["after"]) == (0.002, 20, 0.004)
    assert settle(smidgen.load(spec), h="1 hbar/J/100", steps=3).h == pytest.approx(0.6582119569509 / 570, rel=1e-12)


@pytest.mark.quick
def test_the_command_line_reads_units():
    assert assignment("J=6 meV") == ("J", "6 meV") and assignment("g=1 meV,2 meV") == ("g", ["1 meV", "2 meV"])
    assert assignment("J=6") == ("J", 6) and assignment("J=1e3") == ("J", 1000.0) and assignment("J=2.5e-3") == ("J", 0.0025)
    name, values, swept = axis("J=0 meV:2 meV:5")
    assert (name, swept) == ("J", True) and values == ["0 meV", "0.5 meV", "1 meV", "1.5 meV", "2 meV"]


def test_runs_of_the_command(spec, capsys):
    """Bare numbers of what has a unit are refused; a result is repeated with the same bits."""
    out = spec.with_suffix(".npz")
    assert main(["run", str(spec), "--set", "J=6", "--out", str(out)]) == 2 and '6 meV' in capsys.readouterr().err
    assert main(["run", str(spec), "--set", "J=6 meV", "--set", "n=2", "--h", "2 fs", "--out", str(out)]) == 0
    found = smidgen.load_result(out)
    assert found.meta["set"] == {"J": 6.0, "n": 2} and found.meta["h"] == 0.002
    assert np.array_equal(smidgen.repeat(out).final, found.final)
    capsys.readouterr()
    assert main(["sweep", str(spec), "--set", "J=1 meV:2 meV:2", "--out", str(spec.parent / "sweep")]) == 0
    cells = sorted(smidgen.load_result(path).meta["parameters"]["J"] for path in (spec.parent / "sweep").glob("*.*") if path.suffix in (".h5", ".npz"))
    assert cells == [1.0, 2.0]


def test_the_summary_has_units(spec, capsys):
    assert main(["run", str(spec), "--what", "states"]) == 0
    said = capsys.readouterr().out
    assert "h = 0.001 ps, 20 of 20 steps to t = 0.02 ps" in said
    assert " meV" in next(line for line in said.splitlines() if "energy" in line)


def test_averages_have_units(spec, capsys):
    assert main(["average", str(spec), "--after", "5 fs"]) == 0
    assert any("meV" in line.split() for line in capsys.readouterr().out.splitlines() if " energy " in line)
    assert main(["average", str(spec), "--after", "5"]) == 2


def test_times_in_tables_have_their_unit():
    """Of `validate` and `average`; one member is no members."""
    assert "h = 0.1 fs, 1 site" in Report("m", "r", "x", 0.1, 1, 1, 1.0, (), "fs").table().title
    spec = smidgen.load("film_in_units")
    time = spec.units.spelt(TIME)
    one = SimpleNamespace(mean=1.0, error=0.1, variance=0.2, correlation=3.0)
    shown = table(SimpleNamespace(meta={"spec": "m", "samples": 8, "members": 1, "steps": 10, "h": 2.0, "after": 5.0}, of={"energy": one}), spec)
    assert shown.title == f"m: 8 samples of 1 member to t = 20 {time}, from t = 5 {time} on"
    assert [column.header for column in shown.columns] == ["", "mean", "standard error", "unit", "variance", f"correlation time ({time})"]
