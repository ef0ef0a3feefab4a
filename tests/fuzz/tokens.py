"""The dictionary of the coverage-guided fuzzer: words of TOML and of the spec language.

    python -m fuzz.tokens > tokens.dict
"""
from .grammar import FUNCTIONS, JUNK, KEYS, NAMES, NUMBERS, OVERS, PAIRS, SCALARS, TABLES, VALUES

PIECES = (" = ", "\n", '"', '"""', "{ ", " }", "[", "]", "\n[", "]\n", "''", ", ", "#", "dot(", "cross(", "triple(", "vec(", "norm(")


def words():
    """Every word once, in order."""
    tables = tuple(f"\n[{t}]\n" for t in TABLES)
    keys = tuple(f"\n{k} = " for k in KEYS if k.isidentifier())
    return dict.fromkeys(PIECES + tables + keys + VALUES + OVERS + NAMES + SCALARS + NUMBERS + FUNCTIONS + PAIRS + JUNK)


def line(word):
    """A word as libFuzzer reads it: bytes in quotes, all but letters and digits escaped."""
    return '"' + "".join(chr(b) if chr(b).isalnum() and b < 128 else f"\\x{b:02x}" for b in word.encode("utf-8", "replace")) + '"'


if __name__ == "__main__":
    print("\n".join(line(w) for w in words() if w and len(w) < 60))
