"""Every header of runtime/ compiles alone, with gcc and clang: no generated file before it, as an editor sees it (smg_stub_model.h)."""
import shutil
import subprocess

import pytest
from smidgen.resources import folder, include_flags

pytestmark = pytest.mark.quick
RUNTIME = folder("runtime")


def compiles(header: str, compiler: str, place) -> bool:
    (place / "alone.c").write_text(f'#include "{header}"\n')
    return subprocess.run([compiler, "-std=c11", "-fsyntax-only", "-w", *include_flags(), str(place / "alone.c")], capture_output=True, check=False).returncode == 0


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_headers_compile_alone(compiler, tmp_path):
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    names = sorted(path.name for path in RUNTIME.rglob("*.h"))
    assert [name for name in names if not compiles(name, compiler, tmp_path)] == []


def test_what_asks_for_more_than_the_stub_has_does_not_compile(tmp_path):
    assert not compiles("smg_model.h\"\nint of(void) { return smg_unheard_of; }\n//", "gcc", tmp_path)
