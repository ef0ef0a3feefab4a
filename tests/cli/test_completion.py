"""Completion in a shell: the script is one, and knows the commands."""
import shutil
import subprocess

import pytest
from smidgen.cli import main

pytestmark = pytest.mark.quick


@pytest.mark.parametrize("shell", ["bash", "zsh", "tcsh"])
def test_a_script_for_each_shell(shell, capsys):
    assert main(["completion", shell]) == 0
    said = capsys.readouterr().out
    assert all(word in said for word in ("validate", "spectrum", "doctor"))


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash")
def test_bash_completes(capsys):
    main(["completion", "bash"])
    script = capsys.readouterr().out + '\nCOMP_WORDS=(smidgen val); COMP_CWORD=1; _shtab_smidgen; printf "%s\\n" "${COMPREPLY[@]}"\n'
    assert subprocess.run(["bash"], input=script, capture_output=True, text=True).stdout.split() == ["validate"]
