"""A copy of the tree in which one fault at a time is planted."""
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

from .operators import Mutant

PARTS = ("gen", "templates", "runtime", "specs", "tests", "docs", "README.md", "pyproject.toml", "Makefile", "setup.py")
# Builds are quick, bits the same: the last -O wins, and test programs of the headers (they set SMG_BS) go without the
# sanitizers, which take most of their time. With ccache, if it is installed, what a fault does not touch is compiled once.
COMPILER = """#!/bin/sh
case "$*" in
  *-DSMG_BS=*)
    for word in "$@"; do
      shift
      case "$word" in -fsanitize=* | -fno-sanitize-recover=*) ;; *) set -- "$@" "$word" ;; esac
    done ;;
esac
exec {compiler} "$@" -O1
"""


class Tree:
    """A copy of the checkout `root` in the folder `place`; its package comes first on the path."""

    def __init__(self, root: Path, place: Path):
        self.place, self.tree = place, place / "tree"
        shutil.rmtree(place, ignore_errors=True)
        self.tree.mkdir(parents=True)
        for part in PARTS:
            copy(root / part, self.tree / part)
        (self.tree / "smidgen").symlink_to("gen")
        (place / "bin").mkdir()
        compiler = place / "bin" / "gcc"
        compiler.write_text(COMPILER.format(compiler=" ".join(compiler_words())))
        compiler.chmod(0o755)

    def environment(self) -> dict:
        """Of a process that works on this copy alone."""
        return {**os.environ, "PYTHONPATH": f"{self.tree}:{self.tree / 'tests'}", "CC": "gcc", "PATH": f"{self.place / 'bin'}:{os.environ['PATH']}",
                "SMIDGEN_CACHE": str(self.place / "cache"), "CCACHE_DIR": str(self.place / "ccache"), "PYTHONDONTWRITEBYTECODE": "1",
                "OPENBLAS_NUM_THREADS": "1", "PYTHONHASHSEED": "0"}

    def plant(self, mutant: Mutant) -> None:
        """Change the one line. Raises ValueError when the file is not the one the mutant was drawn from."""
        path = self.tree / mutant.file
        lines = path.read_text().split("\n")
        if lines[mutant.line - 1] != mutant.old:
            raise ValueError(f"{mutant.file}:{mutant.line} is not {mutant.old!r}")
        lines[mutant.line - 1] = mutant.new
        path.write_text("\n".join(lines))

    def heal(self, mutant: Mutant) -> None:
        """The line as it was."""
        self.plant(Mutant(mutant.kind, mutant.file, mutant.line, mutant.new, mutant.old, mutant.id))

    def digests(self, which: str, how: str, *names, limit: float = 600) -> dict | None:
        """What `compiles.py` finds; None when something does not generate or compile."""
        words = [sys.executable, str(self.tree / "tests/mutants/compiles.py"), which, how, *names]
        try:
            said = subprocess.run(words, env=self.environment(), capture_output=True, text=True, timeout=limit)
        except subprocess.TimeoutExpired:
            return None
        return json.loads(said.stdout) if said.returncode == 0 else None


def compiler_words() -> list[str]:
    """gcc, by ccache if that is installed and gcc is not a link to it already."""
    gcc, ccache = shutil.which("gcc"), shutil.which("ccache")
    return [ccache, gcc] if ccache and Path(gcc).resolve() != Path(ccache).resolve() else [gcc]


def copy(source: Path, target: Path) -> None:
    if source.is_dir():
        shutil.copytree(source, target, ignore=shutil.ignore_patterns("__pycache__", "*.so"))
    elif source.exists():
        shutil.copy(source, target)
