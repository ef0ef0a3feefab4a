"""The coverage-guided search itself: it runs, it keeps what is new, and it says so when something breaks."""
import subprocess
import sys
from pathlib import Path

import pytest
from fuzz import minimise, tokens

TESTS = Path(__file__).parents[1]
SEED = b'[model]\nname = "a"\n[space]\nw = { sphere = 1 }\n[effects.e]\nenergy = "w.z"\n'
PLANTED = """import fuzz.judge
real = fuzz.judge.load_text
def broken(text):
    assert 'r3' not in text
    return real(text)
fuzz.judge.load_text = broken
import sys
sys.argv = ['guided', *sys.argv[1:]]
import fuzz.guided
fuzz.guided.main()
"""


def search(folder, *more, code=None):
    """libFuzzer from one good spec in folder/live."""
    pytest.importorskip("atheris", reason="make fuzz installs it")
    (folder / "live").mkdir()
    (folder / "live" / "seed").write_bytes(SEED)
    start = ["-c", code] if code else ["-m", "fuzz.guided"]
    return subprocess.run([sys.executable, *start, str(folder / "live"), "-seed=1", "-max_len=500", f"-artifact_prefix={folder}/found-", *more],
                          cwd=TESTS, capture_output=True, text=True)


@pytest.mark.long
def test_inputs_that_reach_new_code_are_kept(tmp_path):
    done = search(tmp_path, "-runs=2000")
    assert done.returncode == 0, done.stderr[-2000:]
    assert len(list((tmp_path / "live").iterdir())) > 30 and not list(tmp_path.glob("found-*"))


@pytest.mark.long
def test_a_planted_fault_is_found(tmp_path):
    """A reader that breaks on the word `r3`, which the seed has not."""
    done = search(tmp_path, "-runs=20000", code=PLANTED)
    found = list(tmp_path.glob("found-crash-*"))
    assert done.returncode != 0 and len(found) == 1 and b"r3" in found[0].read_bytes()


def test_what_is_kept_is_short_and_reaches_the_same():
    """Lines and words that the arcs do not need are gone."""
    long = SEED.replace(b"[space]", b"title = \"t\"\n[space]")
    kept, known = minimise.minimal([SEED, long])
    assert len(kept) == 2 and kept[0] == SEED and b"effects" not in kept[1] and b"title" in kept[1]
    assert known == minimise.arcs(kept[0]) | minimise.arcs(kept[1])


def test_the_dictionary_is_one_of_libfuzzer():
    """Each word in quotes, all but letters and digits as \\xNN."""
    for word in tokens.words():
        line = tokens.line(word)
        assert line[0] == line[-1] == '"' and line.isascii()
        assert eval("b" + line).decode() == word.encode("utf-8", "replace").decode()
