"""Code blocks of the documents, taken out and run as a reader would."""
import os
import re
import subprocess
import sys
from pathlib import Path

DOCS = Path(__file__).parents[2] / "docs"


def blocks(page, language):
    """The fenced blocks of docs/`page` in one language."""
    text = (DOCS / page).read_text()
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)


def sh(script, folder, **env):
    """Run shell lines with `smidgen` on the path; returns what they print."""
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    said = subprocess.run(["sh", "-e"], input=script, cwd=folder, text=True, capture_output=True,
                          env={**os.environ, "PATH": path, **env})
    assert said.returncode == 0, said.stderr
    return said.stdout


def python(program, folder):
    """Run a Python program; returns what it prints."""
    said = subprocess.run([sys.executable, "-c", program], cwd=folder, text=True,
                          capture_output=True)
    assert said.returncode == 0, said.stderr
    return said.stdout
