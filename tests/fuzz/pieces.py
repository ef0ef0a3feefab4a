"""Effects by pieces, for random scenes: as a scene says them, and written out by a reader of `$word`s that shares nothing with the compiler's.

    said, written, files = shipped(dice, "w", "n", False)      # {"use": "spins/uniaxial", "K": 0.3, ..}, {"over": .., "energy": ..}, {}
"""
from __future__ import annotations

import re
import tomllib

from smidgen.resources import pieces

PLAIN = {"on", "bonds", "where", "seed", "form", "a", "b"}      # names, where brackets would say something else
LITERAL = re.compile(r"(?<![\w.\[])\d+\.\d+(?![\w.])")
FORMULAS = ("energy", "torque", "damping", "kT", "pinned", "absent")


OF_SITES = ("spins/uniaxial", "spins/cubic", "spins/zeeman", "spins/random_anisotropy", "bodies/rotation", "bodies/gyrostat", "bodies/gravity_gradient",
            "bodies/forcing", "vortices/rotation", "vortices/rossby_haurwitz")
ON_BONDS = ("spins/exchange", "spins/exchange_tensor", "spins/dmi", "spins/biquadratic", "spins/kitaev", "spins/gamma", "spins/random_bonds", "bodies/coupling")
MOVING, DAMPED, HELD = ("spins/slonczewski", "spins/spin_orbit"), ("spins/damping", "spins/bath", "spins/bath"), ("spins/pinned_edge", "spins/vacancies")


def number(dice, most=0.9):
    return round(dice.uniform(0.1, most), 3)


def direction(dice):
    return [round(dice.choice((-1, 1)) * dice.uniform(0.2, 1), 2) for _ in "xyz"]


def strength(dice):
    """A number, or a formula: of a parameter, too."""
    return dice.choice((number(dice), -number(dice), f"{number(dice)} + {number(dice)}*cos(2*i)", "0.3 - s_k/2"))


SPECIAL = {"Ixx": lambda d: 1.1, "Iyy": lambda d: 2, "Izz": lambda d: d.choice((3.5, "3 + s_k")), "Ixy": lambda d: d.choice((0, 0.2)), "seed": lambda d: d.randint(1, 9),
           "alpha": lambda d: d.choice((number(d), "0.1 + s_k", "0.1*(1 + mod(i, 2))")), "kT": lambda d: d.choice((number(d), "s_k", 40)),
           "axis": lambda d: d.choice((direction(d), "vec(cos(i), 0.3, sin(i))")), "B": lambda d: d.choice((direction(d), "vec(0, 0, cos(2*t))", "vec(s_k, exp(-(t - 1)^2), 0.1*i)")),
           "where": lambda d: d.choice(("i < 1", "mod(i, 3) == 1", "i > 1 and uniform(4, i) < 0.5")), "part": number}
VECTORS = {"rotor", "normal", "p", "D", "x", "y", "z"}
OF_BONDS = {"J": lambda d: d.choice((number(d), "0.3 - s_k")), "B": number, "mean": number, "spread": number}      # where i is an end


def argument(dice, word, says, bonds):
    """A value for one argument of a piece."""
    if "one_of" in says:
        return dice.choice(says["one_of"])
    if bonds and word in OF_BONDS:
        return OF_BONDS[word](dice)
    return SPECIAL[word](dice) if word in SPECIAL else direction(dice) if word in VECTORS else number(dice) if bonds else strength(dice)


def drawn(dice, names, family: str, count: str):
    """(the effect as a scene says it, written out) of one of these pieces."""
    name = dice.choice(names)
    piece = tomllib.loads(pieces()[name].read_text())
    known = piece["piece"]["arguments"]
    given = {word: argument(dice, word, says, "bonds" in known) for word, says in known.items()
             if word not in ("on", "bonds") and ("default" not in says or dice.randint(0, 1) and says["default"] != 0)}
    given |= {"bonds": f"chain({count}, open) on {family}"} if "bonds" in known else {}
    given |= {"on": family} if family != known["on"].get("default") or dice.randint(0, 1) else {}
    return {"use": name, **given}, written_out(piece, given)


def written_out(piece: dict, given: dict) -> dict:
    """The effect of a piece with its arguments in the place of its words."""
    words = {a: given.get(a, says.get("default")) for a, says in piece["piece"].get("arguments", {}).items()}

    def filled(text):
        return re.sub(r"\$(\w+)(?=(\[?))", lambda m: str(words[m[1]]) if m[2] else spoken(m[1], words[m[1]]), text) if isinstance(text, str) else text
    return {key: filled(text) for key, text in piece["effect"].items()}


def spoken(word, value) -> str:
    if isinstance(value, list):
        return f"vec({', '.join(f'({x!r})' for x in value)})"
    return str(value) if word in PLAIN or value in ("x", "y", "z") else f"({value})"


def own(dice, effect: dict):
    """(the effect as a scene says it, the text of its piece): numbers of its formulas and its family become arguments."""
    words, piece = {}, dict(effect)
    for key in [k for k in FORMULAS if isinstance(effect.get(k), str)]:
        literals = LITERAL.findall(piece[key])
        for literal in dice.sample(literals, min(len(literals), dice.randint(0, 2))):
            word = f"a{len(words)}"
            words[word] = dice.choice((float(literal), literal))
            piece[key] = re.sub(LITERAL.pattern.replace(r"\d+\.\d+", re.escape(literal)), f"${word}", piece[key], count=1)
    family = re.search(r"(?:site|pair)\([^)]*\) of (\w+)$", effect.get("over", ""))
    lines = [f"{word} = {dice.choice(('{}', '{ meaning = ' + repr('a number').replace(chr(39), chr(34)) + ' }'))}" for word in words]
    if family and dice.randint(0, 1):
        piece = {k: re.sub(rf"(?<![.\w]){family[1]}(?=\[|$)", "$on", v) if isinstance(v, str) else v for k, v in piece.items()}
        words["on"] = family[1]
        lines.append("on = {}")
    body = [f"{key} = {quoted(value)}" for key, value in piece.items()]
    return words, "\n".join(["[piece]", 'title = "Drawn"', "[piece.arguments]", *lines, "[effect]", *body]) + "\n"


def quoted(value) -> str:
    return f'"{value}"' if isinstance(value, str) else repr(value)
