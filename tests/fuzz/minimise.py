"""Keep of many inputs those that reach new arcs (line to line) of the reader, the shortest first, without the
lines and pieces that their arcs do not need.

    python -m fuzz.minimise CORPUS FOLDER ...     # what is new in the folders joins CORPUS
"""
import hashlib
import re
import sys
from pathlib import Path

from smidgen import read

from .judge import judge_bytes

READER = str(Path(read.__file__).parent)
LONGEST = 4096          # bytes of an input that is looked at
DEFECT = "defect"       # so begin the names of inputs that broke something once: they stay as they are


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
        judge_bytes(data, seconds=float("inf"))     # what is watched line by line takes its time
    finally:
        sys.settrace(None)
    return found


def minimal(inputs):
    """(inputs that bring new arcs, in order and made short; all arcs)."""
    known, kept = set(), []
    for data in inputs:
        new = arcs(data) - known
        if new:
            data = shortened(data, new)
            known |= arcs(data)
            kept.append(data)
    return kept, known


def shortened(data: bytes, wanted: set) -> bytes:
    """Without the lines, then without the words that the wanted arcs do not need."""
    for end in (rb"(?<=\n)", rb"(?<=[ ,+*])"):
        pieces, k = re.split(end, data), 0
        while k < len(pieces):
            less = pieces[:k] + pieces[k + 1:]
            if wanted <= arcs(b"".join(less)):
                pieces = less
            else:
                k += 1
        data = b"".join(pieces)
    return data


def contents(folder):
    return sorted((p.read_bytes() for p in Path(folder).iterdir() if p.is_file()), key=lambda d: (len(d), d))


def main(words):
    corpus = Path(words[0])
    old = contents(corpus)
    new = sorted({d for folder in words[1:] for d in contents(folder) if len(d) <= LONGEST}, key=lambda d: (len(d), d))
    kept, known = minimal(old + new)
    for path in corpus.iterdir():
        if not path.name.startswith(DEFECT):
            path.unlink()
    for data in kept:
        (corpus / hashlib.sha256(data).hexdigest()[:16]).write_bytes(data)
    print(f"{len(kept)} inputs, {sum(map(len, kept))} bytes, {len(known)} arcs of the reader")


if __name__ == "__main__":
    main(sys.argv[1:])
