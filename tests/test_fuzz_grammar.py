"""The grammar under random input: a Spec, or an error with its place; never a traceback, never long.

The corpus of tests/fuzz/corpus was found by the coverage-guided fuzzer (docs/fuzzing.md) and is
replayed here.
"""
import subprocess
import sys
from pathlib import Path

import pytest
from fuzz.grammar import almost, documents, edited, formulas, spec_around
from fuzz.judge import judge, judge_further
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from support.random_specs import random_spec

from smidgen.read import load_text
from smidgen.spec import Spec

ROOT = Path(__file__).parent.parent
SHIPPED = [p.read_text(encoding="utf-8") for p in sorted((ROOT / "specs").glob("*.toml"))]
MANY = settings(max_examples=300, deadline=None, suppress_health_check=list(HealthCheck))


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


@settings(max_examples=30, deadline=None, suppress_health_check=list(HealthCheck))
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


@settings(max_examples=100, deadline=None)
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
