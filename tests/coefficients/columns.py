"""Tables of C in lines of at most 120 columns, which clang-format leaves alone."""
import re

WIDTH = 120
BREAK = re.compile(r"(?<=[,+]) (?![-\d.e]+\))")     # not between the two parts of SMG_PAIR(high, low)


def folded(text: str) -> str:
    """Lines that are too long continue below, one column farther in."""
    return "\n".join(part for line in text.split("\n") for part in parts(line))


def parts(line: str) -> list:
    """The lines that a line becomes."""
    indent = " " * (len(line) - len(line.lstrip()) + 1)
    found = [""]
    for piece in BREAK.split(line) if len(line) > WIDTH else [line]:
        if found[-1] and len(found[-1]) + 1 + len(piece) > WIDTH:
            found.append(indent + piece)
        else:
            found[-1] += " " * bool(found[-1]) + piece
    return found


def unformatted(text: str) -> str:
    """The same text between the marks that keep clang-format from it."""
    return f"/* clang-format off */\n{folded(text).strip()}\n/* clang-format on */\n"
