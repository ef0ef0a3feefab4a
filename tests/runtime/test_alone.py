"""Every header of runtime/ compiles alone, with gcc and clang: no generated file before it, as an editor sees it (smg_stub_model.h)."""
import shutil
import subprocess

import pytest
from smidgen.resources import folder, include_flags

pytestmark = pytest.mark.quick
RUNTIME = folder("runtime")
# What needs more of a model than the stub has: functions by value, tables of a pattern, the other half of a layout.
# This list only becomes shorter.
NOT_ALONE = frozenset("""
    smg_lane_batch.h smg_lane_dop853.h smg_lane_extrapolation.h smg_lane_sphere.h smg_outputs.h
    smg_single_sphere.h smg_sphere_template.h smg_tableau_template.h""".split())


def compiles(header: str, compiler: str, place) -> bool:
    (place / "alone.c").write_text(f'#include "{header}"\n')
    return subprocess.run([compiler, "-std=c11", "-fsyntax-only", "-w", *include_flags(), str(place / "alone.c")], capture_output=True, check=False).returncode == 0


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_headers_compile_alone(compiler, tmp_path):
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    names = sorted(path.name for path in RUNTIME.rglob("*.h"))
    assert [name for name in names if name not in NOT_ALONE and not compiles(name, compiler, tmp_path)] == []


def test_what_does_not_compile_alone_is_there_and_does_not(tmp_path):
    assert NOT_ALONE <= {path.name for path in RUNTIME.rglob("*.h")}
    assert [name for name in sorted(NOT_ALONE) if all(compiles(name, c, tmp_path) for c in ("gcc", "clang") if shutil.which(c))] == []
