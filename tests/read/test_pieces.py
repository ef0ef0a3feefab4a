"""Pieces: effects used by name, whose arguments take the place of their words, with places in both files."""
import dataclasses
import re

import pytest

import smidgen
from smidgen.check.laws import verdicts
from smidgen.errors import SpecError
from smidgen.read import load, shown
from smidgen.read.catalogue import piece
from smidgen.resources import pieces, shipped

pytestmark = pytest.mark.quick
HEAD = '[model]\nname = "m"\n[space]\nw = { sphere = "n" }\n[parameters]\nn = 4\nJ = 0.7\naxis = { default = [0.0, 1.0, 1.0], vector = true }\n[effects.plain]\nenergy = "w[0].z"\n'
EASY = '[piece]\ntitle = "Easy"\n[piece.arguments]\nK = { meaning = "strength" }\naxis = { default = [0, 0, 1] }\non = { default = "w" }\n' \
       '[effect]\nover = "site(i) of $on"\nenergy = "-$K*dot($on[i], $axis)^2"\n'


@pytest.fixture
def spec_of(tmp_path):
    """A spec with the effect `e` of these lines; pieces by name from their texts."""
    def make(lines: str, library=(), **texts):
        for name, text in texts.items():
            path = tmp_path / f"{name.replace('__', '/')}.toml"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        path = tmp_path / "spec.toml"
        path.write_text(f"{HEAD}[effects.e]\n{lines}\n")
        return load(path, library)
    return make


def effect(spec):
    return next(e for e in spec.effects if e.name == "e")


def errors(make):
    with pytest.raises(SpecError) as caught:
        make()
    return caught.value.diagnostics


@pytest.mark.parametrize("lines, energy", [
    ("K = 2.0", "-2.0*dot(w[i], vec(0, 0, 1))^2"),
    ("K = -2", "-(-2)*dot(w[i], vec(0, 0, 1))^2"),
    ('K = "J"', "-J*dot(w[i], vec(0, 0, 1))^2"),
    ('K = "J - 1"\naxis = "axis"', "-(J - 1)*dot(w[i], axis)^2"),
    ('K = "J*sin(t)"\naxis = ["J", 0, -1]', "-(J*sin(t))*dot(w[i], vec(J, 0, (-1)))^2"),
    ('K = 1\naxis = "vec(i, 0, 1)"', "-1*dot(w[i], vec(i, 0, 1))^2"),
])
def test_a_piece_is_the_effect_written_out(spec_of, lines, energy):
    used = effect(spec_of(f'use = "easy"\n{lines}', easy=EASY))
    by_hand = effect(spec_of(f'over = "site(i) of w"\nenergy = "{energy}"\nmeaning = "Easy"'))
    assert used == by_hand


def test_own_meaning_and_other_values_than_formulas(spec_of):
    used = effect(spec_of('use = "spins/bath"\nalpha = 0.2\nkT = "J"\nform = "ll"\nmeaning = "mine"'))
    by_hand = effect(spec_of('over = "site(i) of w"\ndamping = 0.2\nkT = "J"\nform = "ll"\nmeaning = "mine"'))
    assert used == by_hand


def test_beside_the_spec_in_a_library_or_shipped(spec_of, tmp_path):
    other = EASY.replace("-$K", "+$K")
    lines = 'use = "spins/uniaxial"\nK = 1'
    assert effect(spec_of(lines)).meaning == "Uniaxial anisotropy"
    library = [tmp_path / "library"]
    assert effect(spec_of(lines, library, library__spins__uniaxial=other)).meaning == "Easy"
    spec = spec_of(lines, library, spins__uniaxial=EASY.replace("Easy", "Own"))
    assert effect(spec).meaning == "Own" and [name for name, _ in spec.sources] == ["", "spins/uniaxial.toml"]


def test_scenes_change_arguments(spec_of, tmp_path):
    spec_of('use = "easy"\nK = 1', easy=EASY)
    (tmp_path / "scene.toml").write_text('[scene]\nbase = "spec.toml"\n[effects.e]\nK = "3*J"\n')
    flat = shown(tmp_path / "scene.toml")
    (tmp_path / "flat.toml").write_text(flat)
    one, other = (dataclasses.replace(load(tmp_path / f"{name}.toml"), path="", digest="", sources=()) for name in ("scene", "flat"))
    assert one == dataclasses.replace(other, name="scene")
    assert re.search(r"energy = .* # .*easy\.toml:9, .*scene\.toml:4", flat)


def test_a_run_with_pieces_is_repeated_from_its_file(spec_of, tmp_path):
    spec_of('use = "easy"\nK = 1\n[starts.a]\nrandom = 1\n[runs.demo]\nstart = "a"\nh = 0.1\nsteps = 3', easy=EASY)
    out = tmp_path / "r.npz"
    smidgen.run(load(tmp_path / "spec.toml"), out=out)
    (tmp_path / "easy.toml").unlink()
    assert smidgen.repeat(out).meta["done"] == 3


@pytest.mark.parametrize("lines, text, code, file, line", [
    ('use = "easy"', EASY, "E202", "spec", 11),                                 # no K
    ('use = "easy"\nK = 1\nL = 2', EASY, "E201", "spec", 14),
    ('use = "eazy"\nK = 1', EASY, "E302", "spec", 12),
    ('use = 3\nK = 1', EASY, "E203", "spec", 12),
    ('use = "../easy"\nK = 1', EASY, "E504", "spec", 12),
    ('use = ""\nK = 1', EASY, "E504", "spec", 12),
    ('use = "easy"\nK = "Q"', EASY, "E302", "spec", 13),                        # a formula of the argument
    ('use = "easy"\nK = true', EASY, "E203", "spec", 13),
    ('use = "easy"\nK = 1\naxis = [0, 1]', EASY, "E304", "spec", 14),
    ('use = "easy"\nK = 1', EASY.replace("$K*", "$Q*"), "E302", "easy", 9),
    ('use = "easy"\nK = 1', EASY.replace("$K*", "$*"), "E302", "easy", 9),
    ('use = "easy"\nK = 1', EASY.replace("[effect]", "[effects]"), "E201", "easy", 7),
    ('use = "easy"\nK = 1', EASY.replace("title", "titel"), "E201", "easy", 2),
    ('use = "easy"\nK = 1', EASY.replace('over = "site(i) of $on"', 'use = "spins/uniaxial"'), "E309", "easy", 8),
    ('use = "easy"\nK = 1', EASY.replace("energy", "enrgy"), "E201", "easy", 9),
    ('use = "easy"\nK = 1', EASY[:-2], "E103", "easy", 9),
    ('use = "easy"\nK = 1\non = "v"', EASY, "E302", "spec", 14),
    ('use = "spins/kitaev"\nK = 1\naxis = "q"\nbonds = "chain(n, open)"', EASY, "E205", "spec", 14),
])
def test_faults_are_told_where_they_stand(spec_of, lines, text, code, file, line):
    first = errors(lambda: spec_of(lines, easy=text))[0]
    assert (first.code, first.file.rpartition("/")[2], first.line) == (code, f"{file}.toml", line) and first.hint


def test_a_piece_with_errors_is_told_once(spec_of):
    lines = 'use = "easy"\nK = 1\n[effects.f]\nuse = "easy"\nK = 2'
    assert len(errors(lambda: spec_of(lines, easy=EASY.replace("title", "titel")))) == 1


def test_shipped_pieces_are_no_specs():
    assert len(pieces()) >= 19 and not set(pieces()) & set(shipped()) and "spins/exchange" in pieces()


def test_the_command_lists_and_shows_pieces(spec_of, tmp_path, capsys):
    from smidgen.cli import main
    spec_of('use = "mine/easy"\nK = 1', mine__easy=EASY)
    assert main(["effects"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == list(pieces())
    assert main(["effects", "--library", str(tmp_path)]) == 0
    assert "mine/easy" in capsys.readouterr().out
    assert main(["effects", "spins/uniaxial"]) == 0
    out = capsys.readouterr().out
    assert "energy = -$K*dot($on[i], $axis)^2/dot($axis, $axis)" in out and "law: a spin" in out and "axis  direction" in out
    assert main(["effects", "spins/uniaxal"]) == 2 and "did you mean" in capsys.readouterr().err
    spec_of('use = "spins/exchange"\nJ = 1\nbonds = "chain(n, open)"', mine__easy=EASY.replace("title", "titel"))
    assert main(["effects", "mine/easy", "--library", str(tmp_path)]) == 3


def test_the_piece_of_the_page_is_one_and_its_law_holds(spec_of, tmp_path):
    from pathlib import Path
    page = (Path(__file__).parents[2] / "docs/spec.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"^```toml-piece\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    assert effect(spec_of('use = "mine/pump"\nB = 0.2', mine__pump=text)).meaning == "Field that turns in the plane"
    (law,) = re.findall(r"^```toml-test\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    (tmp_path / "mine/pump.toml").write_text(text + law)
    (found,) = verdicts(piece("mine/pump", [tmp_path]), [tmp_path])
    assert found.passed


def test_where_a_piece_leaves_no_site_the_effect_that_uses_it_is_named():
    text = """[model]
name = "empty"
[space]
w = { sphere = 3 }
[effects.field]
energy = "w[0].z"
[effects.holes]
use = "spins/vacancies"
part = 1
"""
    with pytest.raises(smidgen.SpecError, match="E307.*every site is absent") as error:
        smidgen.load_text(text, "empty.toml")
    assert "empty.toml:7:1" in str(error.value)


def test_a_default_that_does_not_fit_is_told_in_the_scene():
    """Of each effect that uses the piece, with the argument to give; nothing else follows from it."""
    text = '[model]\nname = "x"\n[space]\nm = { sphere = 3 }\n[effects.field]\nuse = "spins/zeeman"\nB = [0, 0, 1]\n[effects.bath]\nuse = "spins/bath"\nalpha = 0.1\nkT = 0.2\n'
    with pytest.raises(smidgen.SpecError) as told:
        smidgen.load_text(text)
    assert [(d.line, d.cause, d.hint) for d in told.value.diagnostics] == [
        (line, "there is no family `w`", "that is the default of `on`, so give `on = ...`; known here: m") for line in (6, 9)]
    smidgen.load_text(text.replace("B = [0, 0, 1]", 'B = [0, 0, 1]\non = "m"').replace("kT = 0.2", 'kT = 0.2\non = "m"'))


def test_a_temperature_alone_changes_the_bath_of_a_base(tmp_path):
    """kT is a key of effects, and an argument of the piece."""
    (tmp_path / "base.toml").write_text('[model]\nname = "x"\n[space]\nv = { sphere = 3 }\n[effects.field]\nover = "site(i) of v"\nenergy = "v[i].z"\n'
                                        '[effects.bath]\nuse = "spins/bath"\nalpha = 0.1\nkT = 0.2\non = "v"\n')
    (tmp_path / "scene.toml").write_text('[scene]\nbase = "base.toml"\n[effects.bath]\nkT = 0.5\n')
    (bath,) = [e for e in smidgen.load(tmp_path / "scene.toml").effects if e.name == "bath"]
    assert bath.kT.value == 0.5 and bath.alpha.value == 0.1
    (tmp_path / "scene.toml").write_text('[scene]\nbase = "base.toml"\n[effects.bath]\nover = "site(i) of v"\ndamping = 0.3\n')
    (bath,) = [e for e in smidgen.load(tmp_path / "scene.toml").effects if e.name == "bath"]
    assert bath.kT is None and bath.alpha.value == 0.3
