"""Scenes: specs that build on others; what they leave out is gone, and errors point into the file that holds the fault."""
import dataclasses
import re

import pytest

import smidgen
from smidgen.build.export import export_sources
from smidgen.errors import SpecError
from smidgen.language import limits
from smidgen.language.spec import Spec
from smidgen.read import load, shown
from smidgen.read.shipped import shipped

pytestmark = pytest.mark.quick
FILM = """[model]
name = "film"
title = "A film"
[space]
w = { sphere = "nx*ny" }
[parameters]
nx = { default = 4, meaning = "sites along x" }
ny = 4
J = { default = 1.5, meaning = "exchange" }
K = 0.3
B = { default = [0.0, 0.0, 1.0], vector = true }
[effects.exchange]
over = "bond(i, j) of square(nx, ny, periodic)"
energy = "-J*dot(w[i], w[j])"
[effects.anisotropy]
over = "site(i) of w"
energy = "-K*w[i].z^2"
[effects.field]
over = "site(i) of w"
energy = "-dot(B, w[i])"
[starts.tilted]
theta = "0.5 + 0.1*i"
phi = "0.2"
[runs.demo]
meaning = "of the base"
start = "tilted"
h = 0.01
time = 1
output = { every = 10, what = ["states", "energy"] }
"""


@pytest.fixture
def written(tmp_path):
    """Files from their texts; the last one is read."""
    def write(**texts):
        for name, text in texts.items():
            path = tmp_path / f"{name.replace('__', '/')}.toml"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        return path
    return write


def on_film(text: str) -> str:
    return f'[scene]\nbase = "film.toml"\n{text}'


def same(one: Spec, other: Spec) -> bool:
    """But for where they come from."""
    def plain(spec):
        return dataclasses.replace(spec, path="", digest="", sources=())
    return plain(one) == plain(other)


def errors(path, library=()):
    with pytest.raises(SpecError) as caught:
        load(path, library)
    return caught.value.diagnostics


# What merges

def test_the_nearest_value_counts_and_tables_merge(written):
    path = written(film=FILM, hot=on_film('title = "Hot"\n[parameters]\nJ = 3\nK = { default = 0.5, unit = "meV" }\nB = [1.0, 0.0, 0.0]\nT = 2.0\n'
                                          '[effects.anisotropy]\nenergy = "-K*T*w[i].x^2"\n[starts.tilted]\nrandom = 3\n'
                                          '[runs.demo]\nsteps = 7\noutput = { every = 2 }\n'))
    spec, film = load(path), load(path.with_name("film.toml"))
    values = {p.name: p for p in spec.parameters}
    assert (spec.name, spec.title) == ("hot", "Hot")
    assert values["J"].default == 3.0 and values["J"].kind == "real" and values["J"].meaning == "exchange"
    assert (values["K"].default, values["K"].unit, values["B"].default) == (0.5, "meV", (1.0, 0.0, 0.0))
    assert [e.name for e in spec.effects] == ["exchange", "anisotropy", "field"] and spec.effects[1].over == film.effects[1].over
    assert spec.starts[0].families[0].kind == "random"
    run = spec.runs[0]
    assert (run.time, run.steps.value, run.every, run.what) == (None, 7, 2, ("states", "energy"))


SITES = """[model]
name = "sites"
[units]
energy = "meV"
field = "T"
[space]
w = { sphere = 4, kappa = "2 hbar" }
[parameters]
K = { file = "k.csv", size = 4, unit = "meV" }
B = "1 meV"
[lattices.net]
size = [2, 2]
vectors = [[1, 0], [0, 2]]
bonds.near = [{ offset = [1, 0] }]
[graphs.ring]
edges = [[0, 1], [1, 2], [2, 3]]
[effects.axis]
over = "site(i) of w"
energy = "-K[i]*w[i].z^2 - B*w[i].x"
[effects.net]
over = "bond(i, j) of net.near"
energy = "-B*dot(w[i], w[j])"
[effects.ring]
over = "edge(i, j) of ring"
energy = "-B*dot(w[i], w[j])"
[starts.a]
random = 1
[runs.demo]
start = "a"
h = "0.01 ps"
time = "1 ps"
output = { every = 10 }
[runs.other]
like = "demo"
output = { period = "0.5 ps" }
"""


@pytest.mark.parametrize("far, near, seen", [
    ("", "[parameters]\nK = \"2 meV\"", lambda spec: spec.parameters[0].default == (2,) * 4),
    ("", '[parameters]\nK = ["1 meV", "2 meV", "3 meV", "4 meV"]', lambda spec: spec.parameters[0].default == (1, 2, 3, 4)),
    ("", '[parameters]\nB = { file = "k.csv", size = 4, unit = "meV" }\n[effects.axis]\nenergy = "-(K[i] + B[i])*w[i].z^2"\n[effects.net]\nenergy = "-B[i]*dot(w[i], w[j])"\n'
     '[effects.ring]\nenergy = "-B[i]*dot(w[i], w[j])"', lambda spec: spec.parameters[1].default == (5, 6, 7, 8)),
    ("", '[runs.demo]\noutput = { period = "0.2 ps" }', lambda spec: spec.runs[0].period is not None),
    ('{ every = 10 }|{ period = "0.2 ps" }', "[runs.demo]\noutput = { every = 5 }", lambda spec: spec.runs[0].every == 5 and spec.runs[0].period is None),
    ("", '[space]\nw = { moment = "2 mu_B" }', lambda spec: spec.families[0].kappa != load_sites().families[0].kappa),
    ("", '[graphs.ring]\nfile = "edges.csv"', lambda spec: smidgen.build(spec).sites == 4),
    ("edges = [[0, 1], [1, 2], [2, 3]]|file = \"edges.csv\"", "[graphs.ring]\nedges = [[0, 3]]", lambda spec: smidgen.build(spec).sites == 4),
    ("", '[lattices.net]\nname = "square"', lambda spec: smidgen.build(spec).sites == 4)])
def test_a_key_takes_the_place_of_those_that_it_excludes(written, tmp_path, far, near, seen):
    (tmp_path / "k.csv").write_text("5\n6\n7\n8\n")
    (tmp_path / "edges.csv").write_text("0,2\n1,3\n")
    spec = load(written(sites=SITES.replace(*far.split("|")) if far else SITES, top=f'[scene]\nbase = "sites.toml"\n{near}\n'))
    assert seen(spec) and spec.runs[1].period is not None


@pytest.mark.parametrize("base", ["{ default = [1.0, 2.0], size = 2 }", "{ default = 1.0, size = 2 }"])
def test_a_fault_in_a_list_for_a_parameter_of_the_base_is_pointed_at(written, base):
    film = FILM.replace("K = 0.3", f"K = {base}").replace("-K*", "-K[0]*")
    (found,) = errors(written(film=film, hot=on_film('[parameters]\nK = [1, "a"]\n')))
    assert found.file.endswith("hot.toml") and (found.line, found.text) == (4, 'K = [1, "a"]')


def load_sites():
    return smidgen.load_text(SITES.replace('file = "k.csv"', 'default = "1 meV"').replace(', unit = "meV"', ""))


def test_an_integer_default_stays_one(written):
    path = written(film=FILM, wide=on_film("[parameters]\nnx = 6\n"))
    assert {p.name: p.kind for p in load(path).parameters}["nx"] == "int"


def test_a_chain_of_bases_each_in_its_folder(written):
    path = written(parts__film=FILM, parts__hot=on_film("[parameters]\nJ = 2.0\n"), top='[scene]\nbase = "parts/hot.toml"\n[parameters]\nK = 9.0\n')
    spec = load(path)
    assert [(p.name, p.default) for p in spec.parameters if p.name in "JK"] == [("J", 2.0), ("K", 9.0)] and spec.name == "top"
    assert {name for name, _ in spec.sources} == {"", "parts/hot.toml", "parts/film.toml"}


def test_the_digest_tells_a_changed_base(written):
    path = written(film=FILM, hot=on_film(""))
    before = load(path).digest
    written(film=FILM.replace("1.5", "1.6"))
    assert load(path).digest != before


# What a scene calls for

@pytest.mark.parametrize("said", ['effects = ["exchange", "twist"]', 'without = ["anisotropy", "field"]',
                                  'effects = ["exchange", "field", "twist"]\nwithout = ["field"]'])
def test_what_is_left_out_is_gone(written, said, tmp_path):
    twist = '[effects.twist]\nover = "site(i) of w"\nenergy = "-K*w[i].x"\n'
    scene = load(written(film=FILM, hot=on_film(said + "\n" + twist)))
    assert scene.effect_names == ("exchange", "twist") and [p.name for p in scene.parameters] == ["nx", "ny", "J", "K"]
    by_hand = re.sub(r"\[effects\.(anisotropy|field)\]\n.*\n.*\n", "", FILM).replace("[starts", twist + "[starts", 1).replace('"film"', '"hot"').replace(
        "B = { default = [0.0, 0.0, 1.0], vector = true }\n", "")
    other = smidgen.load_text(by_hand)
    assert lines_of(scene, tmp_path / "scene") == lines_of(other, tmp_path / "hand")


def lines_of(spec, folder) -> dict:
    """The C without the name of the text that it is made of."""
    export_sources(spec, folder, "spherical-midpoint", "auto")
    return {path.name: [line for line in path.read_text().splitlines() if "Generated by" not in line and "A film" not in line]
            for path in folder.glob("hot*")}


def test_an_effect_that_a_base_leaves_out_can_be_called_for_again(written):
    path = written(film=FILM, bare=on_film('effects = ["exchange"]\n'), again='[scene]\nbase = "bare.toml"\neffects = ["exchange", "field"]\n')
    assert load(path).effect_names == ("exchange", "field")
    assert load(path.with_name("bare.toml")).effect_names == ("exchange",)


def test_families_that_nothing_calls_for_are_gone(written):
    path = written(still='[scene]\nbase = "vortex_tracers"\neffects = ["interaction"]\n')
    whole, spec = load(shipped()["vortex_tracers"]), load(path)
    assert len(whole.families) == 2 and [f.name for f in spec.families] == ["w"]
    assert all(part.family == "w" for start in spec.starts for part in start.families)
    assert {p.name for p in spec.parameters} < {p.name for p in whole.parameters}
    assert smidgen.run(spec, steps=2).w["w"].shape[1:] == (3, 3)


def test_a_family_more_has_its_start_beside_that_of_the_base(written):
    path = written(film=FILM, two=on_film('[space]\nv = { sphere = 2 }\n[effects.other]\nover = "site(i) of v"\nenergy = "v[i].z"\n'
                                          '[effects.exchange]\nover = "bond(i, j) of square(nx, ny, periodic) on w"\n'
                                          '[starts.tilted.v]\nrandom = 1\n'))
    (start,) = load(path).starts
    assert [(part.family, part.kind) for part in start.families] == [("w", "formula"), ("v", "random")]


# Runs

def test_runs_like_others(written):
    path = written(film=FILM, hot=on_film('without = ["field"]\n[runs.demo]\nlike = "demo"\nh = 0.02\n[runs.short]\nlike = "demo"\nsteps = 3\n'
                                          '[runs.bare]\nlike = "short"\nwithout = ["anisotropy"]\noutput = { what = ["energy"] }\n'))
    demo, short, bare = load(path).runs
    assert demo.h.value == 0.02 and demo.meaning == "of the base" and short.meaning == ""
    assert (short.steps.value, short.time, short.every, short.h) == (3, None, 10, demo.h)
    assert (bare.effects, bare.what, bare.every, bare.steps) == (("exchange",), ("energy",), 10, short.steps)


def test_a_run_of_the_base_does_without_what_the_scene_leaves_out(written):
    path = written(film=FILM + 'effects = ["exchange", "field"]\n'.join(["", ""]) + '[runs.some]\nlike = "demo"\neffects = ["exchange", "field"]\n',
                   hot=on_film('without = ["field"]\n'))
    assert load(path).runs[1].effects == ("exchange",)


def test_a_run_of_the_base_does_not_set_parameters_that_are_gone(written):
    path = written(film=FILM + "set = { K = 0.5, J = 2.0 }\n", hot=on_film('without = ["anisotropy"]\n'))
    assert load(path).runs[0].parameters == (("J", 2.0),)


V = '[space]\nv = { sphere = 1 }\n[effects.other]\nover = "site(i) of v"\nenergy = "v[i].x"\n[observables.turn]\nvalue = "v[0].y"\n[starts.tilted.v]\nrandom = 1\n' \
    '[effects.exchange]\nover = "bond(i, j) of square(nx, ny, periodic) on w"\n'


@pytest.mark.parametrize("keys, what, means", [
    ('output = { what = ["turn", "energy"] }\n', ("energy",), None), ('output = { what = ["turn"] }\n', ("states", "energy"), None),
    ('output = { what = ["turn"] }\naverages = { what = ["turn"] }\n', (), ()),
    ('averages = { what = ["turn", "energy.field", "momentum.v.x", "energy.other", "energy"] }\n', ("states", "energy"), ("energy.field", "energy"))])
def test_a_run_of_the_base_does_without_outputs_and_averages_that_are_gone(written, keys, what, means):
    """Also in its flat text."""
    path = written(film=FILM, two=on_film(V + f'[runs.more]\nlike = "demo"\n{keys}'), bare='[scene]\nbase = "two.toml"\nwithout = ["other"]\n')
    for spec in (load(path), load(written(flat=smidgen.flat(path)))):
        run = spec.runs[1]
        assert run.what == what and (run.averages and run.averages.what) == means
        smidgen.run(spec, "more", steps=2, every=1)


def test_a_result_of_a_scene_that_names_what_it_leaves_out_is_read(written):
    """As written by earlier versions."""
    path = written(film=FILM, two=on_film(V), bare='[scene]\nbase = "two.toml"\nwithout = ["other"]\n[runs.demo]\noutput = { what = ["turn", "energy"] }\n')
    assert load(path, recorded=True).runs[0].what == ("energy",)


def test_a_run_of_the_base_has_what_the_scene_adds(written):
    new = '[effects.more]\nover = "site(i) of w"\nenergy = "w[i].y"\n[effects.anisotropy]\nenergy = "-2*K*w[i].z^2"\n'
    path = written(film=FILM + 'effects = ["exchange"]\n', hot=on_film(new), top='[scene]\nbase = "hot.toml"\n[runs.own]\nlike = "demo"\neffects = ["field"]\n')
    demo, own = load(path).runs
    assert (demo.effects, own.effects) == (("exchange", "more"), ("field",))


# The flat text

SCENES = ("", 'title = "T"\neffects = ["exchange"]\n', '[parameters]\nJ = 3\n[runs.x]\nlike = "demo"\nwithout = ["field"]\n',
          'without = ["exchange"]\n[effects.field]\nenergy = """\n  -dot(B, w[i])\n  + w[i].x"""\n')


@pytest.mark.parametrize("text", SCENES)
def test_the_flat_text_is_the_same_scene(written, text):
    path = written(film=FILM, hot=on_film(text))
    flat = shown(path)
    assert same(load(path), load(written(flat=flat)))
    assert all("#" in line for line in flat.splitlines() if " = " in line and '"""' not in flat)


def test_the_flat_text_says_where_values_stand(written):
    path = written(film=FILM, hot=on_film("[parameters]\nJ = 3\n"))
    lines = {line.split(" = ")[0]: line for line in shown(path).splitlines()}
    assert re.search(r"J = \{ default = 3\.0, meaning = \"exchange\" \} +# .*hot\.toml:4, .*film\.toml:9$", lines["J"])
    assert lines["K"].endswith("film.toml:10") and "hot.toml:2" in lines["name"]


@pytest.mark.parametrize("name", sorted(shipped()))
def test_shipped_specs_are_their_own_flat_text(name, tmp_path):
    path = shipped()[name]
    for table in path.parent.glob("*.csv"):
        (tmp_path / table.name).write_bytes(table.read_bytes())
    flat = tmp_path / path.name
    flat.write_text(shown(path))
    assert same(load(path), load(flat))


# Files

def test_bases_and_their_tables_from_a_library(written, tmp_path):
    library, own = tmp_path / "library", tmp_path / "own"
    text = ('[model]\nname = "net"\n[space]\nw = { sphere = 3 }\n[graphs.g]\nfile = "tables/edges.csv"\n[effects.e]\nover = "edge(i, j) of g"\n'
            'energy = "-dot(w[i], w[j])"\n[starts.a]\nrandom = 1\n[runs.demo]\nstart = "a"\nh = 0.1\nsteps = 4\n')
    written(library__nets__net=text)
    (library / "nets/tables").mkdir()
    (library / "nets/tables/edges.csv").write_text("0, 1\n1, 2\n")
    path = written(own__scene='[scene]\nbase = "nets/net.toml"\n')
    assert [d.code for d in errors(path)] == ["E504"]
    spec = load(path, [library])
    assert {name for name, _ in spec.sources} == {"", ".library/nets/net.toml", ".library/nets/tables/edges.csv"}
    out = own / "scene.npz"
    result = smidgen.run(spec, out=out)
    again = smidgen.repeat(out)
    assert again.meta["spec"] == "scene" and (again.w["w"] == smidgen.load_result(out).w["w"]).all() and result.meta["digest"] == again.meta["digest"]


def test_a_run_on_a_shipped_base_is_repeated_from_its_file(written, tmp_path):
    path = written(warm='[scene]\nbase = "heisenberg_chain"\n[parameters]\nn = 6\n')
    out = tmp_path / "warm.npz"
    smidgen.run(load(path), steps=3, out=out)
    assert smidgen.repeat(out).meta["spec"] == "warm"


@pytest.mark.parametrize("base, code", [("../film.toml", "E504"), ("/etc/passwd.toml", "E504"), ("missing.toml", "E504"), ("no_such_spec", "E302"),
                                        ("inner/../film.toml", "E504"), ("folder.toml", "E504"), ("link.toml", "E504"), ("..", "E504"), ("", "E504")])
def test_bases_lie_below_the_scene_or_in_a_library(written, tmp_path, base, code):
    outside = written(film=FILM)
    path = written(inner__scene=f'[scene]\nbase = "{base}"\n')
    (path.parent / "folder.toml").mkdir()
    (path.parent / "link.toml").symlink_to(outside)
    (found,) = errors(path)
    assert (found.code, found.line) == (code, 2) and found.hint


def test_a_text_without_a_file_names_none_but_those_that_are_shipped():
    with pytest.raises(SpecError, match="E504"):
        smidgen.load_text('[scene]\nbase = "film.toml"\nname = "x"\n')
    assert smidgen.load_text('[scene]\nbase = "free_rigid_body"\nname = "x"\n').name == "x"


# Errors

def test_a_fault_is_told_where_it_stands(written):
    path = written(film=FILM.replace("-K*w[i].z^2", "-K*w[i].q"), hot=on_film('[effects.field]\nenergy = "-Q*w[i].x"\n'))
    own, base = errors(path)
    assert (own.file, own.line, own.text) == (str(path), 4, 'energy = "-Q*w[i].x"')
    assert base.file.endswith("film.toml") and base.text == 'energy = "-K*w[i].q"' and base.text[base.column - 1] == "q"


def test_a_base_that_is_no_toml_is_told_at_its_place(written):
    path = written(film=FILM.replace('name = "film"', 'name = "film'), hot=on_film(""))
    first = errors(path)[0]
    assert first.file.endswith("film.toml") and first.line == 2


@pytest.mark.parametrize("texts, code, line", [
    ({"a": '[scene]\nbase = "a.toml"\n'}, "E305", 2),
    ({"film": FILM, "a": on_film('effects = ["exchnge"]\n')}, "E302", 3),
    ({"film": FILM, "a": on_film('without = ["exchange", "field", "anisotropy"]\n')}, "E202", 3),
    ({"film": FILM, "a": on_film("effects = []\n")}, "E202", 3),
    ({"film": FILM, "a": on_film("effects = 3\n")}, "E203", 3),
    ({"film": FILM, "a": on_film("bases = 3\n")}, "E201", 3),
    ({"film": FILM, "a": on_film('[runs.x]\nlike = "dem"\n')}, "E302", 4),
    ({"film": FILM, "a": on_film('[runs.x]\nlike = "x"\n')}, "E305", 4),
    ({"film": FILM, "a": on_film('[runs.x]\nlike = "y"\n[runs.y]\nlike = "x"\n')}, "E305", None),
    ({"film": FILM, "a": on_film('[runs.demo]\nwithout = ["exchange", "field", "anisotropy"]\n')}, "E202", 3),
    ({"film": FILM, "a": on_film('[runs.demo]\nwithout = ["fild"]\n')}, "E302", 4),
    ({"film": FILM, "a-b": on_film("")}, "E202", 1),
    ({"film": FILM, "a": '[scene]\nbase = ["film.toml"]\n'}, "E203", 2),
    ({"a": "scene = 3\n"}, "E203", 1),
])
def test_broken_scenes(written, texts, code, line):
    path = written(**texts)
    found = errors(path)
    assert found[0].code == code and (line is None or found[0].line == line) and found[0].file == str(path) and found[0].hint


def test_a_circle_of_bases(written):
    path = written(b='[scene]\nbase = "a.toml"\n', a='[scene]\nbase = "b.toml"\n')
    (found,) = errors(path)
    assert found.code == "E305" and found.file.endswith("b.toml") and found.line == 2


def test_as_many_bases_as_are_allowed(written):
    texts = {"film": FILM, "s0": on_film("")}
    for k in range(1, limits.BASES + 1):
        texts[f"s{k}"] = f'[scene]\nbase = "s{k - 1}.toml"\n'
    path = written(**texts)
    assert load(path.with_name(f"s{limits.BASES - 1}.toml")).effects
    assert errors(path)[0].code == "E105"


def test_the_command_shows_a_scene(written, capsys):
    from smidgen.cli import main
    path = written(film=FILM, hot=on_film('without = ["field"]\n'))
    assert main(["show", str(path)]) == 0
    assert "[effects.exchange]" in capsys.readouterr().out
    assert main(["show", str(path.with_name("none.toml"))]) != 0
