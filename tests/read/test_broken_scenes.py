"""Broken scenes: each is told with its file, its line, the cause and a hint."""
from pathlib import Path

import pytest

from smidgen.errors import SpecError
from smidgen.read import load

pytestmark = pytest.mark.quick
FILM = """[model]
name = "film"
[space]
w = { sphere = "n*n" }
[parameters]
n = 4
J = { default = 1.5, meaning = "exchange" }
[effects.exchange]
over = "bond(i, j) of square(n, n, periodic)"
energy = "-J*dot(w[i], w[j])"
[effects.field]
over = "site(i) of w"
energy = "-w[i].z"
[starts.tilted]
theta = "0.5 + 0.1*i"
phi = "0.2"
[runs.demo]
start = "tilted"
h = 0.01
time = 1
"""
ON = '[scene]\nbase = "film.toml"\n'
PIECE = '[piece]\ntitle = "P"\n[piece.arguments]\nK = {}\n[effect]\nover = "site(i) of w"\nenergy = "%s"\n'
HOT = '[effects.bath]\nuse = "spins/bath"\nalpha = 0.1\nkT = %s\n'
TWO = '[scene]\nbase = "two.toml"\nwithout = ["other"]\n'
WITH_V = {"two": FILM.replace('"n*n" }\n', '"n*n" }\nv = { sphere = 1 }\n').replace("n, periodic)", "n, periodic) on w").replace(
    "[starts", '[effects.other]\nover = "site(i) of v"\nenergy = "v[i].x"\n[observables.turn]\nvalue = "v[0].y"\n[starts', 1).replace("[runs", '[starts.tilted.v]\nrandom = 1\n[runs', 1)}
CASES = {       # name: (the scene, other files, file and line of the error, of the cause, of the hint)
    "a circle of bases": ('[scene]\nbase = "b.toml"\n', {"b": '[scene]\nbase = "a.toml"\n'}, "b.toml", 2, "builds on this file", "bases must not refer to each other in a circle"),
    "a base outside its folder": ('[scene]\nbase = "../film.toml"\n', {}, "a.toml", 2, "is outside the folder of the spec", "--library"),
    "a base that is misspelt": ('[scene]\nbase = "flim.toml"\n', {}, "a.toml", 2, "no such file", "did you mean `film.toml`?"),
    "a base without its ending": ('[scene]\nbase = "film"\n', {}, "a.toml", 2, "no spec `film` comes with smidgen", "`film.toml`"),
    "a fault in a base of a base": ('[scene]\nbase = "mid.toml"\n', {"mid": ON + '[effects.field]\nenergy = "-Q*w[i].z"\n'}, "mid.toml", 4, "`Q` is not declared", "known here: J"),
    "a parameter with the name of a family": (ON + "[parameters]\nw = 2.0\n", {}, "film.toml", 4, "`w` is already in use, in a.toml, line 4", "another name"),
    "an observable with the name of an effect": (ON + '[observables.exchange]\nvalue = "w[0].z"\n', {}, "a.toml", 3, "`exchange` is already the name of an effect", "rename the observable"),
    "an effect that is misspelt": (ON + 'effects = ["exchange", "feild"]\n', {}, "a.toml", 3, "there is no effect `feild`", "did you mean `field`?"),
    "no effect at all": (ON + "effects = []\n", {}, "a.toml", 3, "selects no effect", "at least one energy"),
    "a run that calls for what the scene leaves out": (ON + 'without = ["field"]\n[runs.x]\nlike = "demo"\neffects = ["exchange", "field"]\n', {},
                                                      "a.toml", 6, "the scene leaves out `field`", "add it to [scene]"),
    "an output that goes with its family": (TWO + '[runs.demo]\noutput = { what = ["energy", "turn"] }\n', WITH_V,
                                            "a.toml", 5, "there is no `turn`: the scene has no effect that moves or names `v`", "remove it from this list"),
    "an average that goes with its family": (TWO + '[runs.x]\nlike = "demo"\naverages = { what = ["turn"] }\n', WITH_V, "a.toml", 6, "there is no `turn`", "remove it from this list"),
    "an average of a family that is gone": (TWO + '[runs.x]\nlike = "demo"\naverages = { what = ["momentum.v.x"] }\n', WITH_V, "a.toml", 6, "that moves or names `v`", "add the effect"),
    "an average of an effect that the scene leaves out": (ON + 'without = ["field"]\n[runs.x]\nlike = "demo"\naverages = { what = ["energy.field"] }\n', {},
                                                         "a.toml", 6, "there is no `energy.field`: the scene leaves out the effect `field`", "add the effect to [scene]"),
    "a run like none": (ON + '[runs.x]\nlike = "dmeo"\n', {}, "a.toml", 4, "there is no run `dmeo`", "did you mean `demo`?"),
    "a piece beside the spec that is misspelt": (ON + '[effects.easy]\nuse = "sott"\n', {"sot": ""}, "a.toml", 4, "there is no piece `sott`", "did you mean `sot`?"),
    "a piece that is misspelt": (ON + '[effects.easy]\nuse = "spins/uniaxal"\nK = 1\n', {}, "a.toml", 4, "there is no piece `spins/uniaxal`", "`spins/uniaxial`"),
    "an argument that is missing": (ON + '[effects.easy]\nuse = "spins/uniaxial"\n', {}, "a.toml", 3, "does not give `K`", "`K = ...`"),
    "an argument too many": (ON + '[effects.easy]\nuse = "spins/uniaxial"\nK = 1\naxes = [0, 0, 1]\n', {}, "a.toml", 6, "no argument `axes`", "did you mean `axis`?"),
    "an argument that is no choice": (ON + HOT % 1 + 'form = "gilbret"\n', {}, "a.toml", 7, "is 'gilbret'", "one of gilbert, ll"),
    "an argument of unknown names": (ON + '[effects.easy]\nuse = "spins/uniaxial"\nK = "2*kk"\n', {}, "a.toml", 5, "`kk` is not declared", "known here: J"),
    "a fault in a piece": (ON + '[effects.e]\nuse = "p"\nK = 1\n', {"p": PIECE % "-$K*w[i].q"}, "p.toml", 7, "a vector has no `.q`", "`.x`, `.y` and `.z`"),
    "a word that is no argument": (ON + '[effects.e]\nuse = "p"\nK = 1\n', {"p": PIECE % "-$k*w[i].z"}, "p.toml", 7, "`$k` is not an argument", "did you mean `K`?"),
    "a torque with a normal part": (ON + '[effects.pump]\nover = "site(i) of w"\ntorque = "0.1*cross(w[i], vec(0, 0, 1)) + 0.2*w[i]"\n', {},
                                    "a.toml", 5, "but is 0.2", "`cross(w[i], ..)`"),
    "a torque that is a number": (ON + '[effects.pump]\nover = "site(i) of w"\ntorque = "0.1*w[i].z"\n', {}, "a.toml", 5, "a vector is needed", "`cross(w[i], p)`"),
    "a torque beside an energy": (ON + '[effects.field]\ntorque = "cross(w[i], vec(0, 0, 1))"\nenergy = "w[i].z"\n', {}, "a.toml", 5, "a torque and `energy`", "two separate effects"),
    "kT below 0": (ON + '[parameters]\nT = -0.5\n' + HOT % '"T"', {}, "a.toml", 8, "the kT of `w[0]` is -0.5", "not negative"),
    "kT without damping": (ON + '[effects.bath]\nover = "site(i) of w"\nkT = 0.5\n', {}, "a.toml", 5, "no `damping`", "`damping = 0.1`"),
    "damping below 0": (ON + '[effects.drag]\nuse = "spins/damping"\nalpha = -0.1\n', {}, "a.toml", 5, "the damping of `w[0]` is -0.1", "not negative"),
    "two dampings": (ON + HOT % 1 + '[effects.more]\nuse = "spins/damping"\nalpha = 0.1\n', {}, "a.toml", 7, "`bath` already damps the sites of `w`", "one damping"),
    "damping and nothing else": (ON + 'effects = ["drag"]\n[effects.drag]\nuse = "spins/damping"\nalpha = 0.1\n', {}, "a.toml", 4, "no effect has an energy", "add `energy"),
    "a method that takes no damping": (ON + HOT % 1 + '[runs.demo]\nmethod = "pair-rotations"\n', {}, "a.toml", 8, "does not support damping (effect `bath`)", "use spherical-midpoint"),
    "noise backward": (ON + HOT % 1 + "[runs.demo]\nh = -0.01\n", {}, "a.toml", 8, "with the noise of `bath` steps cannot be negative", "a positive step"),
    "an array of the wrong length": (ON + '[parameters]\ng = { default = [1.0, 2.0], size = "n" }\n[effects.field]\nenergy = "-g[0]*w[i].z"\n', {},
                                     "a.toml", 4, "2 entries, but its size is 4", "give 4 numbers"),
    "an array that is too short": (ON + '[parameters]\ng = { default = 1.0, size = "n" }\n[effects.field]\nenergy = "-g[i]*w[i].z"\n', {},
                                   "a.toml", 6, "takes the values 0 to 15", "a larger `size`"),
    "a new family without a start": (ON + '[space]\nv = { sphere = 2 }\n[effects.exchange]\nover = "bond(i, j) of square(n, n, periodic) on w"\n'
                                     '[effects.o]\nover = "site(i) of v"\nenergy = "v[i].z"\n', {}, "film.toml", 14, "several families: w, v", "[starts.tilted.v]"),
    "a parameter that does not exist": (ON + "[runs.demo]\nset = { K = 3 }\n", {}, "a.toml", 4, "no parameter `K`", "known here: J, n"),
}


@pytest.mark.parametrize("name", CASES)
def test_a_broken_scene_is_told(name, tmp_path, monkeypatch):
    scene, others, file, line, cause, hint = CASES[name]
    for stem, text in {"film": FILM, "a": scene, **others}.items():
        (tmp_path / f"{stem}.toml").write_text(text)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SpecError) as caught:
        load("a.toml")
    (found,) = caught.value.diagnostics
    assert (Path(found.file).name, found.line) == (file, line)
    assert cause in found.cause and hint in found.hint
    text = (tmp_path / file).read_text().splitlines()[line - 1]
    assert found.text == text and 1 <= found.column <= len(text)


@pytest.mark.parametrize("said", ['use = "spins/zeeman"\nB = [0, 0, 2]', 'over = "site(i) of w"\nenergy = "w[i].x"'])
def test_an_effect_by_a_piece_takes_the_place_of_a_formula_and_the_other_way_round(tmp_path, said):
    """Nothing of the farther one is meant."""
    (tmp_path / "film.toml").write_text(FILM)
    (tmp_path / "mid.toml").write_text(ON + '[effects.field]\nuse = "spins/uniaxial"\nK = 0.5\naxis = [1, 0, 0]\n')
    for base in ("film.toml", "mid.toml"):
        (tmp_path / "a.toml").write_text(f'[scene]\nbase = "{base}"\n[effects.field]\n{said}\n')
        spec, alone = load(tmp_path / "a.toml"), FILM.replace('over = "site(i) of w"\nenergy = "-w[i].z"', said)
        (tmp_path / "alone.toml").write_text(alone)
        assert spec.effects == load(tmp_path / "alone.toml").effects
