"""The README, as its reader would follow it."""
import re
import subprocess
from pathlib import Path

import pytest

import smidgen
from support.pages import python, sh
from smidgen.resources import folder

ROOT = Path(__file__).parents[2]


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```$", (ROOT / "README.md").read_text(), re.MULTILINE | re.DOTALL)


@pytest.fixture
def place(tmp_path):
    (tmp_path / "two_tops.toml").write_text(blocks("toml")[0])
    return tmp_path


@pytest.mark.long
def test_commands(place):
    sh(blocks("sh")[0], place)
    for name in ("tops.csv", "tops.html", "two_tops.h", "two_tops.c"):
        assert (place / name).stat().st_size > 1000


def test_python(place):
    time, *state = python(blocks("python")[0], place).replace("[", " ").replace("]", " ").split()
    assert abs(float(time) - 100) < 1e-9
    w = [float(x) for x in state]
    for k in (0, 3):
        assert abs(sum(x * x for x in w[k:k + 3]) - 1) < 1e-7     # printed to eight digits


def test_linking(place):
    sh("smidgen gen two_tops.toml --amalgamate --out .", place)
    (place / "main.c").write_text(blocks("c")[0])
    subprocess.run(["gcc", "-std=c11", "-O2", "-Wall", "-Wextra", "-Werror", "main.c", "two_tops.c", "-lm", "-o", "main"],
                   cwd=place, check=True)
    assert subprocess.run(["./main"], cwd=place).returncode == 0


@pytest.mark.long
def test_the_certificate_that_is_shown(place):
    """The same verdicts and criteria of the same properties."""
    shown = (ROOT / "README.md").read_text().partition("property  ")[2].partition("\n\n")[0].splitlines()[1:]
    certificate = smidgen.verify(smidgen.load(place / "two_tops.toml"), tier="quick")
    assert certificate.passed and len(shown) > 5
    for line in shown:
        name, *said = re.split(r"  +", line.strip())
        row = certificate.row(name)
        assert row.verdict in said and (row.measured is None or row.criterion in said), line


def test_nothing_points_outside():
    """The package's data lie in the checkout (or the wheel)."""
    assert folder("runtime").is_relative_to(ROOT)
