"""Judge every input of the corpus again, with the memory of the process bounded.

    python -m fuzz.replay [FILE ...]
"""
import resource
import sys
from pathlib import Path

from .judge import judge_bytes

CORPUS = Path(__file__).parent / "corpus"
MEMORY = 2 << 30        # bytes of address space: the interpreter and numpy take a quarter of it


def main(words):
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    paths = [Path(w) for w in words] or sorted(CORPUS.iterdir())
    for path in paths:
        try:
            judge_bytes(path.read_bytes())
        except BaseException:
            print(f"{path.name}: {path.read_bytes()[:500]!r}", file=sys.stderr)
            raise
    print(f"{len(paths)} inputs")


if __name__ == "__main__":
    main(sys.argv[1:])
