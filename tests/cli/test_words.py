"""docs/names.md against the keys of the reader, the options of the command, the signatures of Python and the functions of C."""
import argparse
import ast
import inspect
import re
from pathlib import Path

import pytest
import smidgen
from smidgen import renamed
from smidgen.cli.parser import make_parser
from smidgen.compile.emit.signatures import PUBLIC
from smidgen.effects.kinds import KINDS
from smidgen.read import pieces, places, runs, scene, space, starts, units
from smidgen.read.load import SECTIONS

pytestmark = pytest.mark.quick
ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs/names.md").read_text(encoding="utf-8")
COLUMNS = ("spec", "command", "Python", "C")
EVERYWHERE = {"-h", "--help"}


def tables() -> list:
    """Rows of the tables with these columns: (thing, words of each column, note)."""
    found = []
    for line in PAGE.partition("## Words of earlier versions")[0].splitlines():
        cells = [cell.strip() for cell in line.strip()[1:-1].split("|")] if line.startswith("| ") else []
        if len(cells) == 6 and cells[0] != "concept":
            found.append((cells[0], {name: re.findall(r"`([^`]+)`", cell) for name, cell in zip(COLUMNS, cells[1:5])}, cells[5]))
    return found


def rows():
    return [pytest.param(*row, id=row[0][:40]) for row in tables()]


def keys_of_specs() -> set:
    """The lists of the reader, and what stands in its calls of `table`."""
    found = {*SECTIONS, *runs.KEYS, *runs.OUTPUT, *runs.AVERAGES, *(key for kind in KINDS for key in (*kind.keys, "over", "meaning", "unit")), *starts.KEYS, *scene.KEYS, *places.KEYS, *units.KEYS, *pieces.PIECE, *pieces.ARGUMENT,
             *space.KINDS, *(key for one in space.KEYS.values() for key in one), "value", "like", "use"}
    for path in (ROOT / "gen/read").glob("*.py"):
        for call in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(call, ast.Call) and isinstance(call.func, ast.Attribute) and call.func.attr == "table":
                found |= {word.value for word in call.args if isinstance(word, ast.Constant)}
    return found


def words_of_the_command() -> set:
    """Commands, options, and arguments in capitals."""
    commands, = (a for a in make_parser()._actions if isinstance(a, argparse._SubParsersAction))
    actions = [action for parser in commands.choices.values() for action in parser._actions]
    return {*commands.choices, *(word for action in actions for word in action.option_strings or [action.metavar])} - EVERYWHERE


def words_of_python() -> set:
    """What the package shows, keywords, and what an Integrator has."""
    functions = [getattr(smidgen, name) for name in smidgen.__all__ if inspect.isroutine(getattr(smidgen, name))]
    keywords = {word for f in (*functions, smidgen.Integrator.start) for word in inspect.signature(f).parameters}
    mine = {word for word in {*vars(smidgen.Integrator), *inspect.get_annotations(smidgen.Integrator)} if not word.startswith("_")}
    return {*smidgen.__all__, *keywords, *mine} - {"self", "INSTEAD"}


def words_of_c() -> set:
    return {one.word for one in PUBLIC} | {name for one in PUBLIC for name, _ in one.arguments}


REGISTRIES = {"spec": keys_of_specs, "command": words_of_the_command, "Python": words_of_python, "C": words_of_c}


@pytest.mark.parametrize("column", COLUMNS)
def test_the_tables_hold_every_word_and_no_other(column):
    told, there = {word for _, words, _ in tables() for word in words[column]}, REGISTRIES[column]()
    assert told - there == set(), "docs/names.md has words that nothing has"
    assert there - told == set(), "docs/names.md lacks words"


@pytest.mark.parametrize("thing, words, note", rows())
def test_a_thing_of_two_words_says_why(thing, words, note):
    bare = [{word.removeprefix("--").lower() for word in found} for found in words.values() if found]
    assert note or all(found == bare[0] for found in bare), f"{thing}: {bare}"


def test_a_word_of_two_things_is_told_in_a_note():
    for column in COLUMNS:
        places = {}
        for thing, words, note in tables():
            for word in words[column]:
                places.setdefault(word, []).append((thing, note))
        for word, found in places.items():
            assert len(found) == 1 or any(note for _, note in found), (column, word, found)


def test_the_words_of_earlier_versions_are_those_that_errors_know():
    told = set(re.findall(r"(?m)^\| `([^`]+)` \| `([^`]+)` \|", PAGE.partition("## Words of earlier versions")[2]))
    known = [renamed.KEYS, renamed.OPTIONS, renamed.KEYWORDS, renamed.ATTRIBUTES, renamed.META]
    assert told == {pair for one in known for pair in one.items()}
