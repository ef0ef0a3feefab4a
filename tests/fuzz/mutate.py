"""Mutations that keep a document mostly well-formed: whole lines, keys, values and formulas change, bytes seldom."""
import re

from .grammar import FUNCTIONS, JUNK, KEYS, NAMES, NUMBERS, OVERS, PAIRS, SCALARS, TABLES, VALUES, quoted

STRING = re.compile(r'"([^"\n]*)"')
ATOMS = NAMES + SCALARS + NUMBERS
FORMS = ("({0} + {1})", "{0}*{1}", "-({0})", "({0})^2", "({0})/({1})", "dot({0}, {1})", "cross({0}, {1})", "norm({0})", "vec({0}, {1}, {2})",
         "triple({0}, {1}, {2})", "({0}).x", "{0}.z", "if({0} < {1}, {1}, {2})", "if(not {0} == 1 and {1} > 2, {0}, {2})", "({0}) ** {1}")


def formula(dice, depth=3):
    """A random formula; its types need not fit."""
    if depth == 0 or dice.random() < 0.3:
        return dice.choice(ATOMS)
    forms = FORMS + tuple(f"{f}({{0}})" for f in FUNCTIONS) + tuple(f"{f}({{0}}, {{1}})" for f in PAIRS)
    return dice.choice(forms).format(*(formula(dice, depth - 1) for _ in range(3)))


def entry(dice):
    """`key = value` of any kind."""
    key = dice.choice(KEYS)
    value = dice.choice((dice.choice(VALUES), quoted(formula(dice)), quoted(dice.choice(OVERS))))
    return f"{key if key.isidentifier() and key.isascii() else quoted(key)} = {value}"


def in_string(text, dice):
    """One quoted string gets another content, or another piece within."""
    places = list(STRING.finditer(text))
    if not places:
        return text
    found = dice.choice(places)
    inner, at = found[1], dice.randint(0, len(found[1]))
    words = (formula(dice), inner[:at] + dice.choice(ATOMS + JUNK) + inner[at:], dice.choice(OVERS), dice.choice(KEYS),
             f"{inner} + {formula(dice)}", f"({inner})*{formula(dice, 1)}", inner[:at])
    return text[:found.start()] + quoted(dice.choice(words)) + text[found.end():]


def in_lines(text, dice):
    """A line goes, comes, moves, or gives way to an entry or the head of a table."""
    lines = text.split("\n")
    k, line = dice.randrange(len(lines)), dice.choice(lines)
    new = dice.choice((entry(dice), f"[{dice.choice(TABLES)}]", line, line))
    lines[k:k + dice.randint(0, 1)] = [new] * dice.randint(0, 1)
    return "\n".join(lines)


def in_value(text, dice):
    """What stands right of a `=` is exchanged."""
    places = [m.end() for m in re.finditer("= ", text)]
    if not places:
        return text
    at = dice.choice(places)
    end = re.compile(r"[\n,}]|$").search(text, at).start()
    return text[:at] + dice.choice(VALUES) + text[end:]


def mutated(data, dice):
    """Bytes of a document after one to three such changes."""
    text = data.decode("utf-8", "replace")
    for _ in range(dice.randint(1, 3)):
        text = dice.choice((in_string, in_string, in_lines, in_value))(text, dice)
    return text.encode("utf-8", "replace")
