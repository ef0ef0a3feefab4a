"""Reasons for branches that no test takes: of code that is there."""
import tomllib

import pytest


@pytest.mark.quick
def test_reasons_are_of_code_that_is_there(root):
    """As one line, however it is broken in the header."""
    text = " ".join(" ".join(p.read_text() for p in sorted((root / "runtime").rglob("*.h"))).split())
    reasons = tomllib.loads((root / "tests/covered/reasons.toml").read_text())["branch"]
    assert [entry["code"] for entry in reasons if entry["code"] not in text] == []
    assert all(entry["reason"].strip() for entry in reasons)
