"""Random scenes (docs/fuzzing.md): what their files say together is what one spec says, and the judge sees where it is not."""
import dataclasses
import random
import re

import pytest
from fuzz.invent import WHOLE, files_of, put_files
from fuzz.pieces import written_out
from fuzz.scenes import commented, scene_text
from fuzz.specs import SCENES, kinds_of
from fuzz.through import Fault, through

import smidgen
from smidgen.compile.emit.emit import generate
from smidgen.compile.select import select


def both(text, where):
    """The scene, and the spec that says the same as one."""
    put_files(where, files_of(text) | {"model.toml": text})
    return [dataclasses.replace(smidgen.load(where / name, library=[where / "library"] if (where / "library").exists() else []), digest="") for name in ("model.toml", WHOLE)]


@pytest.mark.parametrize("seed", [0, 10, *(pytest.param(k, marks=pytest.mark.long) for k in range(11, 40))])
def test_a_scene_has_the_c_of_the_spec_written_as_one(seed, tmp_path):
    scene, whole = both(scene_text(random.Random(seed)), tmp_path)
    assert generate(select(scene)) == generate(select(whole))


def test_all_that_scenes_have_is_drawn():
    kinds = {k for seed in range(60) for k in kinds_of(scene_text(random.Random(seed)))}
    assert {*SCENES, "damping", "kT", "torque", "pinned", "absent"} <= kinds


@pytest.mark.long
@pytest.mark.parametrize("seed", [12, 0])       # 12: a single sphere on a chain of one site
def test_a_random_scene_goes_through(seed):
    assert through(scene_text(random.Random(seed)))["verdict"] in ("fine", "refused")


def test_a_scene_that_says_something_else_is_found():
    text = scene_text(random.Random(10))
    whole = files_of(text)[WHOLE]
    another = re.sub(r'energy = "', 'energy = "2*', whole, count=1)
    stages = []
    with pytest.raises(Fault, match="the C of the scene is another one"):
        through(text.replace(commented(WHOLE, whole), commented(WHOLE, another)), stages.append)
    assert another != whole and stages[-1] == "scene"


def test_words_are_replaced():
    piece = {"piece": {"arguments": {"J": {}, "on": {"default": "w"}, "p": {}}}, "effect": {"energy": "-$J*dot($on[i], $p)", "over": "site(i) of $on"}}
    assert written_out(piece, {"J": "a + 1", "p": [1, -2.5, 0]}) == {"energy": "-(a + 1)*dot(w[i], vec((1), (-2.5), (0)))", "over": "site(i) of w"}
