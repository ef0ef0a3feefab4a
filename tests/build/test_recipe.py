"""The recipe for conda asks for what pyproject.toml asks for, and the manual page tells every command and option."""
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

pytestmark = pytest.mark.quick

CONDA = {"matplotlib": "matplotlib-base"}                # other names there
BESIDE = {"python", "c-compiler", "gsl", "pkg-config"}   # what pip does not install


def wanted(names):
    """Requirements of pip as conda has them, with their versions."""
    found = (re.fullmatch(r"([\w-]+)(>=[\d.]+)", name).groups() for name in names)
    return {CONDA.get(name, name.lower().replace("_", "-")): version for name, version in found}


@pytest.fixture
def project(root):
    return tomllib.loads((root / "pyproject.toml").read_text())


@pytest.fixture
def recipe(root):
    return yaml.safe_load((root / "recipe" / "meta.yaml").read_text())


def test_the_recipe_is_of_this_project(project, recipe):
    said = project["project"]
    assert recipe["package"] == {"name": said["name"], "version": said["version"]}
    assert recipe["build"]["entry_points"] == [f"{name} = {target}" for name, target in said["scripts"].items()]
    assert recipe["about"]["license"] == said["license"] and recipe["about"]["summary"] == said["description"]


def test_the_recipe_asks_for_what_the_project_asks_for(project, recipe):
    said, extras = project["project"], project["project"]["optional-dependencies"]
    run = {name: version for name, _, version in (line.partition(" ") for line in recipe["requirements"]["run"])}
    host = dict(line.split() for line in recipe["requirements"]["host"] if " " in line)
    assert {name: version for name, version in run.items() if name not in BESIDE} == wanted(said["dependencies"] + extras["hdf5"] + extras["pictures"])
    assert run["python"] == host["python"] == said["requires-python"]
    assert f"setuptools{host['setuptools']}" in project["build-system"]["requires"]


@pytest.fixture(scope="module")
def manual(tmp_path_factory):
    """The manual page as `make site` writes it."""
    pytest.importorskip("argparse_manpage")
    page = tmp_path_factory.mktemp("man") / "smidgen.1"
    said = subprocess.run(["make", "-s", "manual", f"VENV={sys.prefix}", f"PAGE={page}"], cwd=Path(__file__).parents[2], capture_output=True, text=True)
    assert said.returncode == 0, said.stderr
    return page


def test_the_manual_page_has_every_command_and_option(manual):
    from smidgen.cli.parser import make_parser
    text = manual.read_text().replace("\\-", "-")
    (commands,) = (action.choices for action in make_parser()._actions if action.choices)
    for name, parser in commands.items():
        assert f"smidgen {name}\\fR" in text
        assert all(option in text for option in parser._option_string_actions if option not in ("-h", "--help"))
    assert ".SH EXAMPLES" in text and ".SH ENVIRONMENT" in text


@pytest.mark.skipif(shutil.which("groff") is None, reason="no groff")
def test_the_manual_page_loses_no_line(manual):
    """A line that begins with a dot would be a request to troff, which drops it."""
    said = subprocess.run(["groff", "-man", "-ww", "-z", "-Tutf8", manual], capture_output=True, text=True)
    assert "not defined" not in said.stderr
