"""Stop and go on in a program of one's own: the section of docs/linking.md."""
import shutil
from pathlib import Path

import pytest
from support.pages import blocks, sh
from smidgen.cli import main
from test_linking import MODELS, STRICT, amalgamated, compilers, objects     # noqa: F401

HERE = Path(__file__).parent


def test_the_page_stops_and_goes_on(tmp_path, amalgamated):     # noqa: F811
    shutil.copytree(amalgamated, tmp_path, dirs_exist_ok=True)
    shutil.copy(HERE / "stop.c", tmp_path)
    script = next(text for text in blocks("linking.md", "sh") if "stop.c" in text)
    assert sh(script, tmp_path).endswith("t = 100, the same bits\n")


def test_the_page_splits(tmp_path, amalgamated):     # noqa: F811
    """Strang: the order of m_set_state with a map of the program's own is 2."""
    shutil.copytree(amalgamated, tmp_path, dirs_exist_ok=True)
    shutil.copy(HERE / "kicks.c", tmp_path)
    script = next(text for text in blocks("linking.md", "sh") if "kicks.c" in text)
    assert sh(script, tmp_path).endswith("halving h divides the error by 4.0 and 4.0\n")


@pytest.mark.parametrize("name", ["free_rigid_body", "heisenberg_chain", pytest.param("vortex_tracers", marks=pytest.mark.long)])
def test_saving_compiles_without_a_warning(tmp_path, compilers, objects, name):     # noqa: F811
    """One sphere alone, coupled sites, tracers: with all warnings of C (with the optimiser's) and of C++."""
    assert main(["gen", name, "--amalgamate", "--out", str(tmp_path)]) == 0
    flags = " ".join(STRICT)
    if name in MODELS:
        objects(compilers[0])
    else:
        sh(f"{compilers[0]} -std=c11 {flags} -c {name}.c -o c.o", tmp_path)
    sh(f"{compilers[1]} -x c++ -std=c++17 {flags} -fsyntax-only {name}.c", tmp_path)
