"""Models written in Python: the text they become, what runs, and what is refused."""
import numpy as np
import pytest
import smidgen
import sympy
from smidgen.errors import SpecError, UsageError
from smidgen.model import Model


def ring(n=8):
    model = Model("ring", title="Spins on a ring")
    n, J = model.parameter("n", n), model.parameter("J", 1.5, meaning="exchange")
    K = model.parameter("K", np.arange(1, 9)/8, size=n)
    w = model.sphere("w", n)
    i, j = model.indices("i j")
    model.energy("exchange", "bond(i, j) of chain(n, periodic)", -J*w[i].dot(w[j]))
    model.energy("anisotropy", "site(i) of w", -K[i]*w[i].z**2/2)
    model.observable("mz", "site(i) of w", w[i].z/n)
    model.start("random", random=1)
    model.run("demo", start="random", h=0.1, steps=5)
    return model


RING = """
[model]
name = "ring"
[parameters]
n = 8
J = { default = 1.5, meaning = "exchange" }
K = { default = [0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0], size = "n" }
[space]
w = { sphere = "n" }
[effects.exchange]
over = "bond(i, j) of chain(n, periodic)"
energy = "-J*dot(w[i], w[j])"
[effects.anisotropy]
over = "site(i) of w"
energy = "-K[i]*w[i].z^2/2"
[observables.mz]
over = "site(i) of w"
value = "w[i].z/n"
[starts]
random = { random = 1 }
[runs]
demo = { start = "random", h = 0.1, steps = 5 }
"""


@pytest.mark.quick
def test_it_is_the_spec_that_one_would_write():
    """All but the title, which the text below has not, and the text itself."""
    from dataclasses import replace
    mine, other = ring().spec(), smidgen.load_text(RING)
    assert replace(mine, title="", sources=(), parameters=(), digest="") == replace(other, title="", sources=(), parameters=(), digest="")
    assert mine.parameters == other.parameters


@pytest.mark.quick
def test_its_text_is_read_as_the_same_spec(tmp_path):
    path = ring().save(tmp_path / "ring.toml")
    assert path.read_text() == ring().to_toml() and [p.name for p in tmp_path.iterdir()] == ["ring.toml"]
    assert smidgen.load(path).effects == ring().spec().effects


def test_it_runs_in_place_of_a_spec():
    assert np.array_equal(smidgen.run(ring()).final, smidgen.run(smidgen.load_text(RING)).final)
    assert smidgen.build(ring(), parameters={"n": 8}).start("random", h=0.1) is not None


def test_large_arrays_go_to_files(tmp_path):
    model, strengths = Model("many"), np.linspace(1, 2, 1500)
    n = model.parameter("n", 1500)
    axis = model.parameter("axis", np.tile([0.0, 0.6, 0.8], (1500, 1)), size=n)
    K = model.parameter("K", strengths, size=n)
    w, i = model.sphere("w", n, kappa="K[i]"), model.indices("i")
    model.energy("anisotropy", "site(i) of w", -K[i]*w[i].dot(axis[i])**2)
    model.start("random", random=3)
    model.run("demo", start="random", h=0.1, steps=2)
    with pytest.raises(UsageError, match=r"axis, K: an array of more than 1000 numbers must be in a separate file; use save\(path\)"):
        model.to_toml()
    path = model.save(tmp_path / "many.toml")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["many.toml", "many_K.npy", "many_axis.npy"]
    assert np.array_equal(smidgen.run(model).final, smidgen.run(path).final)


@pytest.mark.quick
def test_other_effects_spaces_starts_and_units():
    model = Model("all", orientation=-1)
    T, B = model.parameter("T", 0.5), model.parameter("B", [0.0, 0.0, 1.0], vector=True)
    w, v = model.sphere("w", 2, kappa=[1.0, -2.0], radius=2), model.r3("v", 3)
    f = model.nambu("f", 1, C="f.x^2 + f.y^2")
    i, j = model.indices("i j")
    model.formula("twice", 2*T)
    model.energy("zeeman", "site(i) of w", -w[i].dot(B)*sympy.cos(model.t))
    model.energy("pair", "each(i of w, j of v)", (w[i] + 2*v[j]).norm()*sympy.Symbol("twice"))
    model.energy("leaf", "site(k) of f", f["k"].x)
    model.effect("push", over="site(i) of w", torque=w[i].cross((0, 1, 0))*model.call("uniform", 7, i))
    model.start("begin", "w", vectors=np.array([[2.0, 0, 0], [0, 2, 0]]))
    model.start("begin", "v", random=1)
    model.start("begin", "f", vectors=[[0.5, 0.5, 0]])
    spec = model.spec()
    assert [e.name for e in spec.effects] == ["zeeman", "pair", "leaf", "push"] and spec.orientation == -1
    assert '"norm(2*v[j] + w[i])*twice"' in model.to_toml() or '"twice*norm(2*v[j] + w[i])"' in model.to_toml()


@pytest.mark.quick
@pytest.mark.parametrize("act, message", [
    (lambda m, w, i: m.parameter("n", 3), r"\[parameters\] of this model already has 'n'"),
    (lambda m, w, i: m.parameter("a", np.ones((2, 2))), r"parameter 'a' has the shape \(2, 2\)"),
    (lambda m, w, i: m.parameter("a", np.ones(2), vector=True), r"parameter 'a' has the shape \(2,\)"),
    (lambda m, w, i: m.energy("e", "site(i) of w", sympy.gamma(w[i].z)), "`gamma` of sympy has no counterpart in the formulas of a spec"),
    (lambda m, w, i: m.energy("e", "site(i) of w", sympy.Function("erf")(w[i].z)), "specs have no function `erf`; there are: abs"),
    (lambda m, w, i: m.energy("e", "site(i) of w", sympy.oo*w[i].z), "`Infinity` of sympy has no counterpart"),
    (lambda m, w, i: m.energy("e", "site(i) of w", object()), "a object is not a formula"),
    (lambda m, w, i: m.energy("e", "site(i) of w", sympy.Piecewise((1, w[i].z > 0))), "a Piecewise must end with a piece"),
    (lambda m, w, i: m.energy("e", "site(i) of w", sympy.Integer(10)**400*w[i].z), "an integer of 401 digits exceeds the largest number allowed"),
    (lambda m, w, i: w[i]*w[i], "multiply two vectors with `.dot` or `.cross`"),
    (lambda m, w, i: w[i] + 3, "3 is not a vector: use a site such as")])
def test_what_is_refused_at_once(act, message):
    model = Model("refused")
    n = model.parameter("n", 2)
    w, i = model.sphere("w", n), model.indices("i")
    with pytest.raises(UsageError, match=message):
        act(model, w, i)


@pytest.mark.quick
def test_the_reader_refuses_the_rest_with_the_place_in_the_text():
    model = ring()
    model.energy("wrong", "site(i) of w", "K[i]*w[i].q")
    with pytest.raises(SpecError) as said:
        model.spec()
    (problem,) = said.value.diagnostics
    assert model.to_toml().splitlines()[problem.line - 1] == 'energy = "K[i]*w[i].q"'


@pytest.mark.quick
def test_no_text_is_evaluated(tmp_path):
    """Neither where a formula is a text nor where a number is one."""
    here = tmp_path / "made"
    for value in (f"open({str(here)!r}, 'w')", f"__import__('os').mkdir({str(here)!r})"):
        model = ring()
        model.energy("evil", "site(i) of w", value)
        with pytest.raises(SpecError):
            model.spec()
    assert not here.exists()
