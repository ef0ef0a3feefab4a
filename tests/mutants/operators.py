"""Candidates everywhere: each operator, index, coefficient, comparison, constant and statement of the code.

An operator is (kind, pattern, change): wherever the pattern matches in a line of code, `change`
of the match gives the text that takes its place; None means no mutant there.
"""
import functools
import hashlib
import re
from dataclasses import dataclass
from pathlib import Path

from .masks import code_lines
from .rules import RULES

STEP = ("templates/*.j2", "runtime/**/*.h")       # the C as it is written
GENERATOR = ("gen/compile/derive/derivatives.py", "gen/compile/lower/lowering.py", "gen/compile/lower/loops.py", "gen/compile/lower/kernels.py", "gen/compile/lower/integers.py", "gen/compile/lower/code.py", "gen/compile/plan/ordering.py",
             "gen/compile/assemble/*.py", "gen/compile/emit/*.py")     # what decides the rest of it

# What cannot be wrong, only slow, wordy or elsewhere in memory: no faults are planted there.
SPARED = (
    ("runtime/core/smidgen.h", r".", "types, statuses and messages; no arithmetic"),
    ("templates/model.*", r".", "the outline of a file: declarations and comments"),
    ("gen/compile/emit/amalgamate.py", r".", "copies the runtime into the file; tests/build/test_build.py compiles it"),
    ("gen/compile/emit/text.py", r"comment|plain|return plain", "text of comments"),
    ("*", r"SMG_MAX_NEWTON|SMG_MAX_SWEEPS|SMG_TRIED_SWEEPS|SMG_NEWTON_STEPS|SMG_CONTINUATION_STEPS|SMG_LATE|SMG_FARTHEST|SMG_STRAIGHT|SMG_ALONG|SMG_PANEL\b"
          r"|SMG_MAX_POINTS|SMG_CURVE_WORK|SMG_MAX_CORRECTIONS|^HISTORY|^SOLO|^ROWS|MOST_", "limits of iterations and lengths of histories, of which any value is correct"),
    ("gen/compile/emit/interface.py", r"_text=|comment\(|note = |counts = |title=", "comments of the header"),
    ("gen/*", r"operations|count_ops", "the count of operations in the header's comment"),
    ("gen/compile/assemble/solo.py", r"len\(sp\.Add|work\(|count_ops|shorter", "which of two equal formulas is shorter"),
    ("runtime/newton/smg_dense.h", r"if \(n == 2 \|\| n == 3\) return smg_solve|n <= \d \* SMG_PANEL", "two ways to compute the same solution"),
    ("templates/abi.c.j2", r"free\(", "memory that would be freed too late; this file is not linked into programs"),
    ("gen/compile/assemble/buffers.py", r".", "sizes of arrays: larger ones are not a fault; smaller ones are found by the sanitizers of tests/compile/test_generated_c.py"),
    ("runtime/lattice/smg_row_ranks.h", r".", "used only for MPI ranks; tests/runtime/test_ranks.py compares all their bits"),
    ("runtime/lattice/smg_row_halo.h", r".", "as for `smg_row_ranks.h`"),
    ("runtime/lattice/smg_row_grid.h", r".", "used only for MPI ranks; tests/runtime/test_ranks_grids.py compares all their bits"),
    ("runtime/lattice/smg_row_faces.h", r".", "as for `smg_row_grid.h`"),
    ("runtime/lattice/smg_row_layers.h", r".", "as for `smg_row_grid.h`"),
    ("runtime/lattice/smg_row_parts.h", r".", "used only for ranks with memory of their own; tests/runtime/test_distributed.py compares all their bits"),
    ("gen/compile/plan/ordering.py", r"limit|multiplications|fill=|size \+ sum", "how much fill is accepted, and how it is counted"),
)


@dataclass(frozen=True)
class Mutant:
    """One changed line: `old` -> `new` is line number `line` (from 1) of `file`, relative to the tree."""
    kind: str
    file: str
    line: int
    old: str
    new: str
    id: str


def turn(pairs):
    """A change that swaps each text of a pair for the other."""
    both = {**dict(pairs), **{b: a for a, b in pairs}}
    return lambda m: both.get(m[0])


def cycle(texts):
    after = dict(zip(texts, (*texts[1:], texts[0])))
    return lambda m: after.get(m[0])


def bumped(m):
    return str(int(m[0]) + 1)


def other_number(m):
    return {"0": "1", "0.0": "1.0"}.get(m[0]) or (str(float(m[0]) * 2) if "." in m[0] else bumped(m))


AFTER = r"(?<=[\w\])}] )"       # a binary operator stands between blanks, after an operand
OPERATORS = (
    ("sign", AFTER + r"[+-](?= [\w({\[*-])", turn([("+", "-")])),
    ("sign", AFTER + r"[+-]=(?= )", turn([("+=", "-=")])),
    ("sign", r"(?<=[(=,?:] )-(?=[a-zA-Z({])|(?<=\()-(?=[a-zA-Z({])", lambda m: ""),
    ("coefficient", r"(?<![\w.\[])\d+\.\d+(?![\w.])", other_number),
    ("coefficient", r"(?<![\w.\[+] )(?<![\w.\[])[2-9](?= \* (?!\())|(?<=[\w\])}] / )[2-9]\b", bumped),
    ("comparison", AFTER + r"(<=|>=|<|>|==|!=)(?= )",
     lambda m: {"<": ">=", ">": "<=", "<=": ">", ">=": "<", "==": "!=", "!=": "=="}[m[0]]),
    ("comparison", r"(?<=; )(?P<a>\w+) (<|<=|>|>=) (?=[^;]*; )",
     lambda m: f"{m['a']} {turn([('<', '<='), ('>', '>=')])(re.match('.*', m[2]))} "),
    ("index", r"(?<=\w\[)[0-2](?=\])", cycle("012")),
    ("index", r"(?<=[a-zA-Z]\.)[xyz]\b", cycle("xyz")),
    ("index", r"\b3 \* (k|i|n|l|r)\b(?=[^*]*[\],)])", lambda m: f"3 * {m[1]} + 1"),
    ("index", r"\b(?P<a>\w+) \* n \+ (?P<b>\w+)\b", lambda m: f"{m['b']} * n + {m['a']}"),
    ("index", r"(?<=range\()\w+(?=\))|(?<=range\()len\(\w+\)", lambda m: f"{m[0]} - 1"),
    ("constant", r"(?<= = )[01](?=[,;])|(?<=return )[01](?=[;,])", turn([("0", "1")])),
    ("constant", r"(?<= [+-] )1(?![\w.])", lambda m: "2"),
    ("constant", r"(?<=^#define )(?P<a>\w+ .*?)(?P<b>\d+)(?=[ )]|$)", lambda m: f"{m['a']}{int(m['b']) + 1}"),
    ("operator", AFTER + r"[*/](?= [\w({])", turn([("*", "/")])),
    ("operator", AFTER + r"(&&|\|\||and|or)(?= )", turn([("&&", "||"), ("and", "or")])),
    ("operator", r"\bsmg_(min|max)\b(?=\(\w+->)|[&|]=", turn([("smg_min", "smg_max"), ("&=", "|=")])),
    ("statement", r"^ +(?! |return)(\*?[\w>.-]+(\[[^\]]*\])? [-+*/&|]?= [^;{}]*|[\w{}. ]+\([^;{}]*\));(?= *$)", lambda m: ";"),
)


ARITHMETIC = ("sign", "operator", "constant", "coefficient")


def places(root: Path, patterns=(*STEP, *GENERATOR)) -> list[Path]:
    """The files where faults are planted."""
    return sorted({p for pattern in patterns for p in root.glob(pattern) if p.name != "__init__.py"})


@functools.cache
def fits(file: str, pattern: str) -> bool:
    """Asked anew for every line of a file."""
    return Path(file).match(pattern)


def spared(file: str, line: str):
    """The reason why this line is left alone, or None."""
    for pattern, text, reason in SPARED:
        if fits(file, pattern) and re.search(text, line):
            return reason
    return None


def in_index(shown: str, at: int) -> bool:
    """Inside brackets, or between a pointer and what is added to it: what is wrong there is an index."""
    before = shown[:at]
    return before.count("[") > before.count("]") or re.match(r". \d \* |. \(?int64_t", shown[at:]) is not None


def changes(file: str, shown: str):
    """(kind, start, end, new text) of every operator and rule that fits a line of code."""
    c = file.endswith((".h", ".j2"))
    for kind, pattern, change in OPERATORS:
        for m in re.finditer(pattern, shown):
            new = change(m)
            if new is not None and (c or kind != "statement"):
                yield "index" if c and kind in ARITHMETIC and in_index(shown, m.start()) else kind, m.start(), m.end(), new
    for kind, where, pattern, new in RULES:
        if fits(file, where):
            for m in re.finditer(pattern, shown):
                yield kind, m.start(), m.end(), m.expand(new)


def mutants_of(root: Path, path: Path):
    """All candidates of one file, in the order of its lines."""
    file, text, seen = str(path.relative_to(root)), path.read_text(), {}
    for number, (line, shown) in enumerate(zip(text.split("\n"), code_lines(path.name, text)), 1):
        if not shown.strip() or spared(file, line):
            continue
        seen[line] = seen.get(line, 0) + 1      # equal lines are told apart by their order
        for kind, start, end, put in changes(file, shown):
            new = line[:start] + put + line[end:]
            if new != line:
                name = repr((file, line, seen[line], start, new)).encode()
                yield Mutant(kind, file, number, line, new, f"{kind}-{hashlib.sha256(name).hexdigest()[:8]}")


def stale(root: Path) -> list:
    """The rules that fit no line of code any more."""
    lines = [(p.relative_to(root), code_lines(p.name, p.read_text())) for p in places(root)]
    return [rule for rule in RULES if not any(
        file.match(rule[1]) and any(re.search(rule[2], line) for line in code) for file, code in lines)]


def candidates(root: Path, patterns=STEP) -> list[Mutant]:
    """Every mutant of the files that fit the patterns, each text once: a rule's kind goes before an operator's."""
    found = {}
    for path in places(root, patterns):
        for m in mutants_of(root, path):
            found[m.file, m.line, m.new] = m     # rules come last
    return list(found.values())
