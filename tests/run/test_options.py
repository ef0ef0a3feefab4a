"""The choices of a run stand in one list: keywords, metadata and command have those, and no others."""
import argparse
import dataclasses
import inspect

import pytest
import smidgen
from smidgen.cli.parser import make_parser
from smidgen.run.files import received
from smidgen.run.files.options import ALWAYS, OPTIONS
from smidgen.run.settings import Settings, settle

NAMES = {option.name for option in OPTIONS}
pytestmark = pytest.mark.quick


def keywords(function) -> set:
    return {name for name, p in inspect.signature(function).parameters.items() if p.kind == p.KEYWORD_ONLY}


def options_of(command: str) -> dict:
    """name -> action, of a sub-command."""
    sub, = (a for a in make_parser()._actions if isinstance(a, argparse._SubParsersAction))
    return {action.dest: action for action in sub.choices[command]._actions}


def test_python_has_the_choices_of_the_list():
    assert keywords(settle) == NAMES and keywords(smidgen.run) == NAMES | {"out", "keep", "progress"}
    assert {f.name for f in dataclasses.fields(Settings)} == NAMES - {"time"} | {"run", "numbers"}


@pytest.mark.parametrize("name, other", [("run", {"averages", "keep", "progress"}), ("sweep", {"parameters", "tell"}), ("average", {"progress"})])
def test_python_and_the_command_have_the_same(name, other):
    """But what is no text; a sweep has its parameters in `axes`."""
    assert keywords(getattr(smidgen, name)) - options_of(name).keys() == other
    assert {"every", "period", "tolerance", "native"} <= options_of(name).keys()


def test_the_metadata_have_those_that_say_of_what_kind_they_are():
    told = {option.key for option in OPTIONS if option.kind}
    meta = smidgen.run(smidgen.load("free_rigid_body"), steps=2).meta
    assert told <= meta.keys() == received.META.keys()
    assert {option.key for option in OPTIONS if option.older is not ALWAYS} <= received.ADDED.keys()
    assert all(option.kind(option.older) for option in OPTIONS if option.older is not ALWAYS)


def test_the_command_has_them_with_the_words_of_the_list():
    found = options_of("run")
    for option in OPTIONS:
        if option.reads:
            assert found[option.name].help == (option.help or None) and found[option.name].option_strings == [f"--{option.name}"]
    assert {option.name for option in OPTIONS if not option.reads} == {"averages", "parameters", "native", "estimate"}     # --set, --portable, --no-estimate
    for command in ("sweep", "cost", "spectrum", "advise"):
        shared = options_of(command)
        assert "effects" in shared and shared["effects"].help == found["effects"].help
