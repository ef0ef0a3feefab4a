"""find_package(smidgen): a program with a generated integrator, built by CMake as docs/linking.md has it."""
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from smidgen.cli import main
from support.pages import blocks
from smidgen.resources import HERE as GEN

HERE = Path(__file__).parent
COMMAND = Path(sys.executable).parent / "smidgen"
pytestmark = pytest.mark.skipif(shutil.which("cmake") is None, reason="no cmake")


def cmake(place, *words):
    return subprocess.run(["cmake", "-S", place, "-B", place / "build", f"-Dsmidgen_DIR={GEN / 'cmake'}", f"-DSMIDGEN_EXECUTABLE={COMMAND}", *words],
                          capture_output=True, text=True)


@pytest.fixture
def project(tmp_path):
    (tmp_path / "CMakeLists.txt").write_text(blocks("linking.md", "cmake")[0])
    for file in (HERE / "chain.c", HERE.parents[1] / "specs/heisenberg_chain.toml"):
        shutil.copy(file, tmp_path)
    return tmp_path


@pytest.mark.quick
def test_the_folder_is_told(capsys):
    with pytest.raises(SystemExit):
        main(["--cmake-dir"])
    assert (Path(capsys.readouterr().out.strip()) / "smidgen-config.cmake").is_file()


@pytest.mark.long
def test_a_program_is_built_and_runs(project):
    said = cmake(project)
    assert said.returncode == 0, said.stderr
    built = subprocess.run(["cmake", "--build", project / "build"], capture_output=True, text=True)
    assert built.returncode == 0, built.stdout + built.stderr
    ran = subprocess.run([project / "build/chain"], capture_output=True, text=True)
    assert ran.returncode == 0 and ran.stdout


def test_a_bad_spec_ends_the_configuration_with_its_errors(project):
    spec = project / "heisenberg_chain.toml"
    spec.write_text(spec.read_text().replace("dot(w[i], w[j])", "dot(w[i], v[j])"))
    said = cmake(project)
    assert said.returncode != 0 and "error[E" in said.stderr and "v[j]" in said.stderr


def test_an_argument_that_is_not_known(project):
    lists = project / "CMakeLists.txt"
    lists.write_text(lists.read_text().replace("METHOD", "METHODS"))
    said = cmake(project)
    assert said.returncode != 0 and "smidgen_add_model(chain_model)" in said.stderr and "METHODS" in said.stderr


def test_without_the_command(project):
    said = subprocess.run(["cmake", "-S", project, "-B", project / "build", f"-Dsmidgen_DIR={GEN / 'cmake'}"],
                          capture_output=True, text=True, env={**os.environ, "PATH": "/usr/bin:/bin"})
    assert said.returncode != 0 and "the command smidgen is not on the path" in " ".join(said.stderr.split())
