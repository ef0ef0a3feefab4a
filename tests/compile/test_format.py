"""The C of runtime/ is as clang-format writes it with the .clang-format of this project, in lines of at most 120 columns."""
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from smidgen.resources import folder

pytestmark = pytest.mark.quick
ROOT = Path(__file__).parents[2]
HEADERS = sorted(folder("runtime").rglob("*.h"))
CLANG_FORMAT = next(filter(None, map(shutil.which, ("clang-format-14", "clang-format"))), None)
VERSION = "14."         # another one breaks some lines elsewhere


def said(*words: str) -> subprocess.CompletedProcess:
    return subprocess.run([CLANG_FORMAT, *words], cwd=ROOT, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def formatter():
    if CLANG_FORMAT is None:
        pytest.skip("no clang-format (Debian: install clang-format-14)")
    found = re.search(r"version ([\d.]+)", said("--version").stdout)[1]
    if not found.startswith(VERSION):
        pytest.skip(f"clang-format {found}, and headers are formatted by {VERSION}x")


def test_headers_are_formatted(formatter):
    checked = said("--dry-run", "-Werror", "--style=file", *map(str, HEADERS))
    assert checked.returncode == 0, checked.stderr[:2000]


def test_what_is_not_formatted_is_seen(formatter, tmp_path):
    shutil.copy(ROOT / ".clang-format", tmp_path)
    (tmp_path / "a.h").write_text("static int  a ;\n")
    assert said("--dry-run", "-Werror", "--style=file", str(tmp_path / "a.h")).returncode == 1


def test_lines_have_120_columns_at_most():
    """Comments and tables too, which clang-format leaves alone."""
    long = [f"{path.name}:{number}" for path in HEADERS for number, line in enumerate(path.read_text().splitlines(), 1) if len(line) > 120]
    assert long == []


def test_headers_have_500_lines_at_most():
    assert [path.name for path in HEADERS if len(path.read_text().splitlines()) > 500] == []
