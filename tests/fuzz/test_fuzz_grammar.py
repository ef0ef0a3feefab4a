"""The grammar under random input: a Spec, or an error with its place; never a traceback, never long.

The corpus of tests/fuzz/corpus was found by the coverage-guided fuzzer (docs/fuzzing.md) and is
replayed here.
"""
import dataclasses
import os
import random
import subprocess
import sys
from pathlib import Path

import fuzz.judge
import pytest
from fuzz.grammar import almost, documents, edited, formulas, spec_around
from fuzz.judge import judge, judge_bytes, judge_further
from fuzz.mutate import mutated
from fuzz.replay import CORPUS
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from support.random_specs import random_spec

from smidgen.errors import SpecError
from smidgen.read import load_text
from smidgen.language.spec import Spec

ROOT = Path(__file__).parents[2]
SHIPPED = [p.read_text(encoding="utf-8") for p in sorted((ROOT / "specs").glob("*.toml"))]
EXAMPLES = int(os.environ.get("SMIDGEN_FUZZ_EXAMPLES", 15))       # of each property; docs/fuzzing.md
MANY = settings(max_examples=EXAMPLES, deadline=None, suppress_health_check=list(HealthCheck))
FEW = settings(MANY, max_examples=EXAMPLES // 5)                   # each is compiled


@MANY
@given(spec_around())
def test_formulas(text):
    judge(text)


@MANY
@given(documents())
def test_documents(text):
    judge(text)


@MANY
@given(almost(documents()))
def test_damaged_documents(text):
    judge(text)


@MANY
@given(edited(SHIPPED))
def test_edited_specs(text):
    judge(text)


@FEW
@given(spec_around())
def test_what_loads_is_compiled_or_refused_in_words(text):
    found = judge(text)
    if isinstance(found, Spec):
        judge_further(found)


@MANY
@given(formulas(), st.sampled_from([" ", "  ", "\n", "\t", "\r\n"]))
def test_blanks_between_tokens_mean_nothing(formula, blank):
    """The same formula with other blanks is the same spec, or fails alike."""
    from fuzz.grammar import CONTEXT
    one, other = (judge(CONTEXT.format(over='"pair(i, j) of w"', energy=f'"""{text}"""'))
                  for text in (formula, formula.replace(" ", blank)))
    assert isinstance(one, Spec) == isinstance(other, Spec)
    if isinstance(one, Spec):
        assert one.effects == other.effects
    else:
        assert [d.code for d in one.diagnostics] == [d.code for d in other.diagnostics]


@MANY
@given(st.randoms(use_true_random=False))
def test_whole_random_specs_load(dice):
    """The generator of random Hamiltonians writes good specs only."""
    text, files = random_spec(dice)
    if not files:
        assert isinstance(load_text(text), Spec)


@pytest.mark.quick
def test_the_corpus_is_replayed():
    """In a process whose memory is bounded: no text of a few kilobytes may need more than the limits say."""
    done = subprocess.run([sys.executable, "-m", "fuzz.replay"], cwd=ROOT / "tests", capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert int(done.stdout.split()[0]) >= 100


def test_the_corpus_is_small():
    sizes = [path.stat().st_size for path in CORPUS.iterdir()]
    assert sum(sizes) < 300_000 and max(sizes) <= 4096


def test_mutations_of_the_guided_search_stay_text():
    """And, from good specs, one in twenty at least is a good spec again: so they get past the first checks."""
    dice, good = random.Random(1), 0
    for _ in range(200):
        data = mutated(dice.choice(SHIPPED).encode(), dice)
        good += isinstance(judge_bytes(data), Spec)
    assert good >= 10


@pytest.mark.parametrize("fault", [RecursionError, ValueError, KeyError])
def test_a_fault_of_the_reader_is_seen(monkeypatch, fault):
    """The judge lets nothing pass but a Spec and a SpecError."""
    def broken(text):
        raise fault
    monkeypatch.setattr(fuzz.judge, "load_text", broken)
    with pytest.raises(fault):
        judge_bytes(b"")


@pytest.mark.parametrize("line, column, text", [(3, 1, ""), (1, 9, "[model]"), (1, 1, "other")])
def test_an_error_at_a_wrong_place_is_seen(monkeypatch, line, column, text):
    wrong = SpecError([dataclasses.replace(caught("[model]"), line=line, column=column, text=text)])

    def broken(_):
        raise wrong
    monkeypatch.setattr(fuzz.judge, "load_text", broken)
    with pytest.raises(AssertionError):
        judge("[model]")


def caught(text):
    """The first diagnostic of a text."""
    return judge(text).diagnostics[0]
