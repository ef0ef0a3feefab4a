"""Broken specs: each gives exactly the errors that stand beside it, and never a traceback.

`SMIDGEN_UPDATE_GOLDEN=1 pytest tests/read/test_bad_specs.py` writes the expected texts anew.
"""
import os
import re
from pathlib import Path

import pytest

from smidgen.errors import Exit, SpecError
from smidgen.read import load
from smidgen.language.codes import CODES

pytestmark = pytest.mark.quick
BAD = Path(__file__).parents[1] / "bad"
SPECS = sorted(BAD.glob("*.toml"))
UPDATE = bool(os.environ.get("SMIDGEN_UPDATE_GOLDEN"))


def refused(path: Path) -> SpecError:
    """The error of a spec; the test fails when it is accepted."""
    with pytest.raises(SpecError) as caught:
        load(path)
    return caught.value


@pytest.mark.parametrize("spec", SPECS, ids=lambda p: p.stem)
def test_message(spec):
    message = str(refused(spec)).replace(str(BAD) + os.sep, "") + "\n"
    golden = spec.with_suffix(".txt")
    if UPDATE:
        golden.write_text(message, encoding="utf-8")
    assert message == golden.read_text(encoding="utf-8")


@pytest.mark.parametrize("spec", SPECS, ids=lambda p: p.stem)
def test_every_diagnostic_is_complete(spec):
    error = refused(spec)
    lines = spec.read_bytes().decode("utf-8", "replace").removeprefix("\ufeff").splitlines() or [""]
    assert error.exit_code == Exit.SPEC and 1 <= len(error.diagnostics) <= 10
    for d in error.diagnostics:
        assert d.code in CODES and d.cause and d.hint and d.file == str(spec)
        assert d.text == (lines[d.line - 1] if d.line <= len(lines) else "")
        assert 1 <= d.column <= len(d.text) + 1 and d.length >= 1


def test_the_set_is_large_and_has_no_strays():
    assert len(SPECS) >= 60
    assert {p.stem for p in BAD.glob("*.txt")} == {p.stem for p in SPECS}


def test_messages_hold_nothing_that_a_terminal_would_obey():
    for golden in BAD.glob("*.txt"):
        text = golden.read_text(encoding="utf-8")
        assert not re.search("[\x00-\x09\x0b-\x1f\x7f-\x9f\u200b-\u200f\u202a-\u202e\ufeff]", text)
