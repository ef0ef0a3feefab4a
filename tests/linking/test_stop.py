"""Stop and go on in a program of one's own: the section of docs/linking.md."""
import shutil
from pathlib import Path

import pytest
from pages import blocks, sh
from test_linking import STRICT, compilers     # noqa: F401

HERE = Path(__file__).parent


def test_the_page_stops_and_goes_on(tmp_path):
    shutil.copy(HERE / "stop.c", tmp_path)
    script = next(text for text in blocks("linking.md", "sh") if "stop.c" in text)
    assert sh("smidgen gen free_rigid_body --amalgamate\n" + script, tmp_path).endswith("t = 100, the same bits\n")


@pytest.mark.parametrize("name", ["free_rigid_body", "heisenberg_chain", "vortex_tracers"])
def test_saving_compiles_without_a_warning(tmp_path, compilers, name):
    """One sphere alone, coupled sites, tracers: with all warnings of C and of C++."""
    sh(f"smidgen gen {name} --amalgamate", tmp_path)
    flags = " ".join(STRICT)
    sh(f"{compilers[0]} -std=c11 {flags} -c {name}.c -o c.o; {compilers[1]} -x c++ -std=c++17 {flags} -c {name}.c -o cpp.o",
       tmp_path)
