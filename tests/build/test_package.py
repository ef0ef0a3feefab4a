"""The wheel: complete, and at work away from the checkout."""
import json
import os
import shutil
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import pytest

LEFT_OUT = {".git", ".venv", "build", "out", "dist"}     # at the top of a checkout


def left_out(folder, names):
    """What is no source: folders at the top, and bytecode anywhere."""
    at_top = (Path(folder) / "pyproject.toml").is_file()
    return {n for n in names if n == "__pycache__" or n.endswith(".egg-info") or at_top and n in LEFT_OUT}


PLACES = {"gen": "smidgen", "templates": "smidgen/templates", "runtime": "smidgen/runtime",
          "specs": "smidgen/specs"}


def called(*words, **more):
    """Run and return what is said on stdout; a failure shows stderr."""
    said = subprocess.run([str(w) for w in words], capture_output=True, text=True, **more)
    assert said.returncode == 0, said.stdout + said.stderr
    return said.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The wheel of the checkout, built in a copy of it."""
    root, copy = Path(__file__).parents[2], tmp_path_factory.mktemp("copy") / "smidgen"
    shutil.copytree(root, copy, ignore=left_out)
    called(sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation",
           "--no-index", "--wheel-dir", copy / "dist", copy)
    (built,) = (copy / "dist").glob("*.whl")
    return built


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """A fresh environment with the wheel; its requirements are lent by this one."""
    home = tmp_path_factory.mktemp("fresh")
    called(sys.executable, "-m", "venv", "--without-pip", home)
    called(sys.executable, "-m", "pip", "--python", home / "bin/python", "install", "--quiet",
           "--no-deps", "--no-index", wheel)
    (site,) = home.glob("lib/python*/site-packages")
    (site / "lent.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return home / "bin"


@pytest.fixture
def away(tmp_path):
    """Keywords for a call from a folder that knows nothing of the checkout."""
    env = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    return {"cwd": tmp_path, "env": {**env, "SMIDGEN_CACHE": str(tmp_path / "cache")}}


def sources(root):
    """Every file of the package's folders, by its name in the wheel."""
    for place, package in PLACES.items():
        for path in (root / place).rglob("*"):
            if path.is_file() and "__pycache__" not in path.parts:
                yield f"{package}/{path.relative_to(root / place)}"


def test_the_wheel_is_complete(wheel, root):
    inside = set(zipfile.ZipFile(wheel).namelist())
    wanted = {"/".join(Path(name).parts) for name in sources(root)}
    assert wanted and wanted <= inside, wanted - inside
    assert {n.split("/")[0] for n in inside} == {"smidgen", wheel.name.rsplit("-", 3)[0] + ".dist-info"}


def test_the_package_is_the_wheels(installed, away, root):
    place = called(installed / "python", "-c", "import smidgen; print(smidgen.__file__)", **away)
    assert Path(place.strip()).is_relative_to(installed.parent)


def test_it_runs_away_from_the_checkout(installed, away, tmp_path):
    names = {spec["name"] for spec in json.loads(called(installed / "smidgen", "list", "--json", **away))}
    assert "free_rigid_body" in names
    said = json.loads(called(installed / "smidgen", "run", "free_rigid_body", "--json",
                             "--out", "a.h5", **away))
    assert said["status"] == "complete" and (tmp_path / "a.h5").exists()
    called(installed / "smidgen", "run", "--repeat", "a.h5", "--out", "b.h5", **away)
    assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "b.h5").read_bytes()


def test_it_generates_away_from_the_checkout(installed, away, tmp_path):
    called(installed / "smidgen", "new", "mine", **away)
    called(installed / "smidgen", "gen", "mine.toml", "--amalgamate", "--out", "c", **away)
    assert sorted(p.name for p in (tmp_path / "c").iterdir()) == ["mine.c", "mine.h"]


@pytest.mark.long
def test_it_validates_away_from_the_checkout(installed, away):
    called(installed / "smidgen", "validate", "free_rigid_body", "--steps", "10", **away)


def test_its_requirements_are_those_of_the_pins(root):
    """What the wheel asks for is pinned for `make`."""
    import tomllib
    asked = tomllib.loads((root / "pyproject.toml").read_text())["project"]["dependencies"]
    pinned = {line.split("==")[0].lower() for line in
              (root / "requirements.txt").read_text().splitlines() if "==" in line}
    assert {name.split(">=")[0].lower() for name in asked} <= pinned


@pytest.mark.quick
def test_what_the_doctor_looks_for_is_what_the_project_asks_for(root):
    """Packages and the extras that bring them, as pyproject.toml has both."""
    import tomllib
    from smidgen.check.doctor import OTHERS, PACKAGES
    from smidgen.packages import EXTRAS
    said = tomllib.loads((root / "pyproject.toml").read_text())["project"]
    extras = {name.split(">=")[0]: extra for extra, names in said["optional-dependencies"].items() if extra != "all" for name in names}
    assert sorted(PACKAGES) == sorted(name.split(">=")[0].lower() for name in said["dependencies"])
    assert all(extras[package] == extra for package, extra in {**EXTRAS, **OTHERS}.items())


def test_the_version_is_that_of_the_project(root):
    import smidgen
    assert f'version = "{smidgen.__version__}"' in (root / "pyproject.toml").read_text()


@pytest.mark.quick
def test_pins_are_installed(root):
    """The environment is the one that the requirements describe."""
    from importlib.metadata import version
    for file in ("requirements.txt", "requirements-test.txt"):
        for line in (root / file).read_text().splitlines():
            if "==" in line:
                name, wanted = line.split("==")
                assert version(name) == wanted


@pytest.mark.quick
def test_what_is_missing_is_named(root, tmp_path):
    """Without a compiler and without the right to install one: one line, exit code 6."""
    tools = tmp_path / "bin"
    tools.mkdir()
    for name in ("sh", "dirname", "tr", "rm", "cat"):
        (tools / name).symlink_to(shutil.which(name))
    (tools / "python3").symlink_to(sys.executable)
    said = subprocess.run([shutil.which("sh"), root / "tests" / "install.sh", tmp_path / "venv"],
                          env={"PATH": str(tools)}, capture_output=True, text=True)
    assert said.returncode == 6 and said.stderr.count("\n") == 1
    assert said.stderr.startswith("smidgen: install these first: apt-get install gcc")
    for name in ("g++", "pkg-config", "libgsl-dev"):
        assert name in said.stderr
    assert not (tmp_path / "venv").exists()


@pytest.mark.quick
def test_the_citation_is_of_this_version(root):
    import yaml
    cited = yaml.safe_load((root / "CITATION.cff").read_text())
    assert cited["version"] == __import__("smidgen").__version__
    assert cited["preferred-citation"]["doi"] in (root / "README.md").read_text()


WITHOUT = """
import sys
for name in ("h5py", "matplotlib", "pandas", "xarray", "distributed", "mpi4py"):
    sys.modules[name] = None
from smidgen.cli import main
sys.exit(main(sys.argv[1:]))
"""


def without_extras(*words, cwd):
    return subprocess.run([sys.executable, "-c", WITHOUT, *words], cwd=cwd, capture_output=True, text=True)


def test_what_needs_no_extra_runs_without(tmp_path):
    assert without_extras("gen", "free_rigid_body", cwd=tmp_path).returncode == 0
    said = without_extras("run", "free_rigid_body", "--steps", "2", "--out", "body.npz", cwd=tmp_path)
    assert said.returncode == 0, said.stderr


@pytest.mark.parametrize("words, message", [
    (("run", "free_rigid_body", "--steps", "2", "--out", "a.h5"), "HDF5 needs the package `h5py`: pip install 'smidgen[hdf5]'"),
    (("run", "free_rigid_body", "--steps", "2", "--checkpoint", "1", "--out", "a.csv"), "a checkpoint needs the package `h5py`: pip install 'smidgen[hdf5]'"),
    (("plot", "free_rigid_body"), "a picture needs the package `matplotlib`: pip install 'smidgen[pictures]'")])
def test_an_extra_that_is_missing_is_named(tmp_path, words, message):
    said = without_extras(*words, cwd=tmp_path)
    assert said.returncode == smidgen_exit("TOOL") and message in said.stderr and "Traceback" not in said.stderr
    assert [*tmp_path.iterdir()] == []


def smidgen_exit(name):
    from smidgen.errors import Exit
    return Exit[name]
