"""`smidgen effects`: the library, one piece, the laws."""
import json
import re
import subprocess
import sys

import pytest

pytestmark = pytest.mark.quick


def effects(*words, cwd=None):
    done = subprocess.run([sys.executable, "-m", "smidgen", "effects", *map(str, words)], capture_output=True, text=True, cwd=cwd)
    return done.returncode, done.stdout, done.stderr


OWN = """[piece]
title = "Mine"
[piece.arguments]
B = { meaning = "field" }
[effect]
over = "site(i) of w"
energy = "-$B*w[i].z"
[test]
arguments = { B = 0.4 }
law = ["w[0] == turned(w0[0], vec(0, 0, 1), 0.4*t/1.7)", "energy == SIGN0.4*(w[0].z + w[1].z)"]
"""


def test_a_line_a_piece_and_all_of_one(tmp_path):
    code, out, _ = effects()
    assert code == 0 and re.search(r"^spins/slonczewski +torque   Slonczewski", out, re.MULTILINE)
    code, out, _ = effects("spins/bath")
    assert code == 0 and "kind: bath" in out and "damping = $alpha" in out and "  kT     temperature; energy; needed" in out
    assert json.loads(effects("spins/bath", "--json")[1])[0]["kind"] == "bath"


@pytest.mark.parametrize("sign, code", [("-", 0), ("", 5)])
def test_laws_of_pieces_of_the_user_are_checked(tmp_path, sign, code):
    (tmp_path / "pump.toml").write_text(OWN.replace("SIGN", sign))
    (tmp_path / "plain.toml").write_text(OWN.partition("[test]")[0])
    found, out, err = effects("pump", "--test", "--library", tmp_path)
    assert found == code and "turned(w0[0]" in out and ("these laws do not hold: pump" in err) == bool(code)
    found, out, err = effects("plain", "--test", "--library", tmp_path, "--json")
    assert found == 0 and json.loads(out) == {"laws": [], "without": ["plain"]} and "without a [test]: plain" in err


def test_a_name_that_is_none():
    code, _, err = effects("spins/bathe")
    assert code == 2 and "did you mean `spins/bath`?" in err
