"""The faults that `make mutants` plants: its rules follow the code, and its draw is what it says."""
from pathlib import Path

import pytest
from mutants.judge import MADE_FOR
from mutants.operators import candidates, spared, stale
from mutants.plant import Tree
from mutants.report import explanations
from mutants.rules import KINDS
from mutants.run import DRAWN, drawn

ROOT = Path(__file__).parents[2]
NAMED = {"sign", "coefficient", *KINDS}


@pytest.fixture(scope="module")
def found():
    return candidates(ROOT)


@pytest.mark.quick
def test_every_rule_fits_a_line_of_code():
    assert stale(ROOT) == []


@pytest.mark.quick
def test_tests_are_made_for_files_that_are_there(found):
    """Or for faults of a kind."""
    files = {m.file for m in found}
    assert [of for of in MADE_FOR if of not in NAMED and not any(f.startswith(of) or Path(f).name.startswith(of) for f in files)] == []


def test_the_draw_is_the_seeds_and_of_every_kind(found):
    """At least sixty, five of each kind that is named; the same seed draws the same, another one others."""
    first, again, other = ({kind: [m.id for m in drawn(found, kind, seed)[:count]] for kind, count in DRAWN.items()}
                           for seed in (1, 1, 2))
    assert sum(map(len, first.values())) >= 60 and all(len(first[kind]) >= 5 for kind in NAMED)
    assert first == again and first != other


def test_mutants_change_one_line_of_what_is_not_spared(found):
    assert all(m.old != m.new and spared(m.file, m.old) is None for m in found)
    assert len({m.id for m in found}) == len(found)
    assert {Path(m.file).parts[0] for m in found} == {"templates", "runtime"}


def test_a_planted_fault_is_healed(found, tmp_path):
    tree, mutant = Tree(ROOT, tmp_path / "copy"), found[0]
    path, before = tree.tree / mutant.file, (ROOT / mutant.file).read_text()
    tree.plant(mutant)
    assert path.read_text().count("\n") == before.count("\n") and path.read_text() != before
    with pytest.raises(ValueError):
        tree.plant(mutant)
    tree.heal(mutant)
    assert path.read_text() == before


def test_what_is_explained_has_a_reason():
    assert all(entry["reason"].strip() for entry in explanations().values())


@pytest.mark.long
def test_the_unchanged_tree_compiles():
    """What the tool compiles to see whether a fault does: without one all of it does, and every method is there."""
    from mutants.compiles import digests
    from mutants.trial import MODELS
    found = digests("few", "syntax", ["headers", *MODELS])
    assert set(MODELS) <= found.keys() and len(found) > len(MODELS) + 40
