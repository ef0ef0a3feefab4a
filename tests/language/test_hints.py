"""What a message says to write instead."""
import pytest

import smidgen
from smidgen.errors import SmidgenError, UsageError
from smidgen.language.names_used import unused
from smidgen.read import load_text
from smidgen.run.step.evaluated import parameter_values

TEXT = '''[model]
name = "m"
[space]
w = { sphere = "n" }
[parameters]
n = 3
B = 1.0
K = 1.0
[lattices.far]
size = ["n"]
boundary = "periodic"
bonds.a = [{ from = 0, to = 0, offset = [5] }]
[effects.a]
over = "site(i) of w"
energy = "B*w[i].z"
[starts.up]
theta = 0.3
phi = 0.2
[runs.demo]
start = "up"
h = 0.1
time = 1
'''
pytestmark = pytest.mark.quick


@pytest.mark.parametrize("old, new, said", [
    ('sphere = "n"', "e3 = 1", "the spaces are `sphere`, `r3`"), ('sphere = "n"', "canonical = 2", "canonical pairs, e"),
    ('sphere = "n"', "spere = 1", "did you mean `sphere`?"), ('sphere = "n"', 'sphere = "n^2"', "`n*n`"),
    ('"B*w[i].z"', '"B*(w[i].z + (1 + 2"', "character 13 of the formula is not closed; 2 brackets are not closed: write `))`"),
    ('"B*w[i].z"', '"w[i"', "`[` at character 2 of the formula"), ('"B*w[i].z"', '"2 t*w[i].z"', "`2*t`"), ('"B*w[i].z"', '"B t"', "`B*t`"),
    ('"B*w[i].z"', '"w[i].z*cosine(t)"', "= write `cos`"), ('"B*w[i].z"', '"w[i].z*cosinus(t)"', "= write `cos`"), ("B = 1.0", "B = [0, 0, 1]", "write `B = { default = [..], vector = true }`"), ("B = 1.0", "B = [0, 1]", "write `B = { default = [..], size = 2 }`"),
    ('"B*w[i].z"', '"w[i].z*cos B*t"', "write `cos(..)`, with all of its argument in the parentheses"), ('"B*w[i].z"', '"B*w[i].z -"', "= the formula ends here"),
    ("time = 1", "time = 1\nevery = 10", "it belongs to `output`: write `output = { every = ... }`"), ("time = 1", "time = 1\nafter = 10", "it belongs to `averages`"),
    ("time = 1", "time = 1\nwhat = ['energy']", "it belongs to `output`")])
def test_a_hint_says_what_to_write(old, new, said):
    with pytest.raises(SmidgenError) as refused:
        load_text(TEXT.replace(old, new))
    assert said in str(refused.value)


def test_a_formula_with_arguments_that_is_no_toml_gives_one_error():
    """What uses it would give others."""
    text = TEXT.replace("[lattices.far]", '[formulas]\nB(t) = "cos(t)"\n[lattices.far]').replace('"B*w[i].z"', '"B(t)*w[i].z"')
    with pytest.raises(smidgen.SpecError) as refused:
        load_text(text)
    assert [d.code for d in refused.value.diagnostics] == ["E103"] and '`"f(a, b)" = "a + b"`' in str(refused.value)


def test_a_start_off_its_sphere_may_be_meant_for_r3():
    with pytest.raises(smidgen.SpecError, match="or use `r3` if the length matters"):
        load_text(TEXT.replace("theta = 0.3\nphi = 0.2", "vectors = [[0, 0, 1.2], [0, 0, 1], [0, 0, 1]]"))


@pytest.mark.parametrize("call, said", [
    (lambda s: smidgen.build(s, method="gaus-8"), "did you mean 'gauss-8'"),
    (lambda s: smidgen.build(s, method="nothing at all"), "there are 6[0-9], such as"), (lambda s: smidgen.build(s, parameters={"b": 2.0}), "did you mean .B."),
    (lambda s: smidgen.run(s, parameters={"b": 2.0}), "did you mean .B."), (lambda s: parameter_values(s, {"b": 2.0}), "did you mean .B.")])
def test_a_name_that_is_none_gets_the_one_that_was_meant(call, said):
    with pytest.raises(UsageError, match=said) as refused:
        call(load_text(TEXT))
    assert len(str(refused.value)) < 300


def test_parameters_that_nothing_uses_are_named(command, tmp_path):
    (tmp_path / "m.toml").write_text(TEXT)
    out = command("check", "m.toml")
    assert out.returncode == 0 and "warning: the parameter 'K' is not used" in out.stdout and "'B'" not in out.stdout
    assert unused(load_text(TEXT.replace("theta = 0.3", 'theta = "K"'))) == []


def test_a_bond_that_is_longer_than_the_lattice_is_named():
    spec = load_text(TEXT.replace('over = "site(i) of w"\nenergy = "B*w[i].z"', 'over = "bond(i, j) of far.a"\nenergy = "B*K*dot(w[i], w[j])"'))
    with pytest.raises(SmidgenError, match="effect 'a': a bond reaches 5 cells along direction 1 of its lattice, which has 3"):
        smidgen.run(spec)
    assert smidgen.run(spec, parameters={"n": 6}).meta["status"] == "complete"


def test_going_on_with_a_complete_file_does_not_say_that_it_wrote_it(command, tmp_path):
    (tmp_path / "m.toml").write_text(TEXT)
    assert "wrote a.npz" in command("run", "m.toml", "--out", "a.npz").stdout
    again = command("run", "--resume", "a.npz")
    assert again.returncode == 0 and "a.npz is complete" in again.stdout and "wrote" not in again.stdout


def test_the_end_of_a_search_is_no_largest_safe_step():
    said = smidgen.advise(smidgen.load("free_rigid_body"), h=0.1, time=20)
    assert said.kind == "open" and not any("the largest safe step" in line for line in said.words())


def test_midpoint_alone_means_the_spherical_one():
    with pytest.raises(UsageError, match="did you mean 'spherical-midpoint'"):
        smidgen.build(load_text(TEXT.replace("periodic", "open").replace("[5]", "[1]")), method="midpoint")
    with pytest.raises(SmidgenError, match="did you mean `spherical-midpoint`"):
        load_text(TEXT.replace("h = 0.1", 'h = 0.1\nmethod = "midpoint"'))


@pytest.mark.parametrize("old, new", [("K = 1.0", "K\u00e4 = 1.0"), ("[effects.a]", "[effects.\u03bb]")])
def test_a_name_has_ascii_letters(old, new):
    with pytest.raises(SmidgenError, match="is not allowed in a name\n.*\n.*\n.*names consist of ASCII letters"):
        load_text(TEXT.replace(old, new))
