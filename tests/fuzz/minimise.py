"""Keep of many inputs those that reach new arcs (line to line) of the reader, the shortest first.

    python -m fuzz.minimise CORPUS FOLDER ...     # what is new in the folders joins CORPUS
"""
import hashlib
import sys
from pathlib import Path

from smidgen import read

from .judge import judge_bytes

READER = str(Path(read.__file__).parent)
LONGEST = 2000          # bytes of an input that is kept


def arcs(data: bytes) -> set:
    """(file, line before, line) of every step of the reader over this input."""
    found, before = set(), {}

    def local(frame, event, _):
        if event == "line":
            found.add((frame.f_code.co_filename, before.get(frame, 0), frame.f_lineno))
            before[frame] = frame.f_lineno
        return local

    def call(frame, *_):
        return local if frame.f_code.co_filename.startswith(READER) else None

    sys.settrace(call)
    try:
        judge_bytes(data)
    finally:
        sys.settrace(None)
    return found


def minimal(inputs):
    """(the inputs that bring new arcs, in order; all arcs)."""
    known, kept = set(), []
    for data in inputs:
        new = arcs(data) - known
        known |= new
        if new:
            kept.append(data)
    return kept, known


def contents(folder):
    return sorted((p.read_bytes() for p in Path(folder).iterdir() if p.is_file()), key=lambda d: (len(d), d))


def main(words):
    corpus = Path(words[0])
    old = contents(corpus)
    new = sorted({d for folder in words[1:] for d in contents(folder) if len(d) <= LONGEST}, key=lambda d: (len(d), d))
    kept, known = minimal(old + new)
    for data in kept:
        (corpus / hashlib.sha256(data).hexdigest()[:16]).write_bytes(data)
    print(f"{len(kept)} inputs, {sum(map(len, kept))} bytes, {len(known)} arcs of the reader")


if __name__ == "__main__":
    main(sys.argv[1:])
