"""Words of earlier versions: their errors name the present word, and files that hold them are read."""
import inspect
import json
import re
import subprocess
import sys

import numpy as np
import pytest
import smidgen
from smidgen import renamed
from smidgen.run.files.received import META

pytestmark = pytest.mark.quick
TOP = """[model]
name = "top"
[parameters]
a = 2.0
[space]
w = { sphere = 2 }
[effects.spin]
over = "site(i) of w"
energy = "a*w[i].z^2 + w[i].x"
[starts.s]
vectors = [[1, 0, 0], [0, 0.6, 0.8]]
[runs.demo]
start = "s"
h = 0.1
steps = 20
output = { period = 0.5 }
set = { a = 3.0 }
"""
OLD = TOP.replace("period =", "section =")
FUNCTIONS = {name: getattr(smidgen, name) for name in smidgen.__all__ if inspect.isroutine(getattr(smidgen, name))} | {
    "lattice.of": smidgen.lattice.of}


@pytest.fixture(scope="module")
def spec():
    return smidgen.load_text(TOP)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_an_old_keyword_is_told_with_the_new_one(name):
    known = inspect.signature(FUNCTIONS[name]).parameters
    for old, new in renamed.KEYWORDS.items():
        if new in known and old not in known:
            with pytest.raises(smidgen.KeywordError, match=f"has no keyword '{old}'; it is now called '{new}'"):
                FUNCTIONS[name](**{old: 1})


def test_every_old_keyword_is_one_of_a_function():
    for old, new in renamed.KEYWORDS.items():
        assert any(new in inspect.signature(f).parameters and old not in inspect.signature(f).parameters for f in FUNCTIONS.values())


def test_an_old_attribute_is_told_with_the_new_one(spec):
    model = smidgen.build(spec)
    for old, new in renamed.ATTRIBUTES.items():
        with pytest.raises(AttributeError, match=f"Integrator has no attribute '{old}'; it is now called '{new}'"):
            getattr(model, old)
        with pytest.raises(smidgen.ReadOnlyError, match=f"'{old}'; it is now called '{new}'"):
            setattr(model, old, 1)
        assert hasattr(model, new) and not hasattr(model, old)
    with pytest.raises(AttributeError, match="no attribute 'xyzzy'$"):
        model.xyzzy


def test_an_old_key_of_a_spec_is_told_with_the_new_one():
    with pytest.raises(smidgen.SpecError, match="has no key `section`(.|\n)*it is now called `period`"):
        smidgen.load_text(OLD)


@pytest.mark.parametrize("old", renamed.OPTIONS)
def test_an_old_option_is_told_with_the_new_one(old, tmp_path):
    (tmp_path / "top.toml").write_text(TOP)
    new = renamed.OPTIONS[old]
    command = next(word for word in ("run", "gen", "snapshot") if new in subprocess.run([sys.executable, "-m", "smidgen", word, "--help"], capture_output=True, text=True).stdout)
    said = subprocess.run([sys.executable, "-m", "smidgen", command, "top.toml", old, "0.5"], cwd=tmp_path, capture_output=True, text=True)
    assert said.returncode == 2 and f"'{old}' is now called '{renamed.OPTIONS[old]}'" in said.stderr


def test_a_result_of_an_earlier_version_is_read_and_repeated(spec, tmp_path):
    """Its metadata have the old keys, and so has the spec in it."""
    now, then = tmp_path / "now.csv", tmp_path / "then.csv"
    result = smidgen.run(spec, out=now, what=["states"])
    head, meta, rest = re.split(r"(?m)^(# meta: .*\n)", now.read_text())
    old = json.loads(meta.removeprefix("# meta: "))
    for was, is_ in renamed.META.items():
        assert is_ in META
        old[was] = old.pop(is_)
    old["sources"][0][1] = OLD
    then.write_text(f"{head}# meta: {json.dumps(old)}\n{rest}")
    found = smidgen.load_result(then)
    assert found.meta["parameters"] == result.meta["parameters"] == {"a": 3.0} and found.meta["period"] == 0.5
    again = smidgen.repeat(then, keep=True)
    assert np.array_equal(again.w["w"], result.w["w"]) if result.w else np.array_equal(again.final, result.final)
    assert smidgen.plot(found, out=tmp_path / "a.png").exists()
