"""`make bench`: every measurement in this folder, one after the other.

A measurement is a Python file here that can be called by itself; it writes what it finds
below docs/. Exit code 1 when one of them fails.
"""
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
HELPERS = {"run.py", "machine.py", "beside.py"}


def main() -> int:
    """Call them all, the later ones also after a failure."""
    failed = []
    for path in sorted(HERE.glob("*.py")):
        if path.name not in HELPERS:
            print(f"== {path.name}", file=sys.stderr, flush=True)
            if subprocess.run([sys.executable, path]).returncode:
                failed.append(path.name)
    print(f"failed: {', '.join(failed)}" if failed else "all measured", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
