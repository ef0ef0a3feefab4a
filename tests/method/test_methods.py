"""Every method of the registry alike: on spheres of any radius beside R^3, strengths of both signs, the other orientation, a drive."""
import subprocess

import numpy as np
import pytest
import smidgen
from smidgen.compile.emit.emit import generate
from smidgen.methods import METHODS
from support.strict import COMMANDS, WARNINGS

MIX = smidgen.load_text("""
[model]
name = "mix"
orientation = -1
[space]
s = { sphere = "n", kappa = "g[i]", radius = 2 }
b = { r3 = 1, kappa = -0.5 }
[parameters]
n = { default = 3 }
g = { default = [1.0, -0.7, 2.5], size = "n" }
J = { default = 0.4 }
[effects.pairs]
over = "pair(i, j) of s"
energy = "-J*dot(s[i], s[j])"
[effects.body]
over = "site(k) of b"
energy = "b[k].x^2/2 + b[k].y^2/4 + 0.1*b[k].z^3"
[effects.join]
over = "each(i of s, k of b)"
energy = "0.2*dot(s[i], b[k])*cos(t)"
[starts.a.s]
theta = "0.4 + 0.5*i"
phi = "2*i"
[starts.a.b]
vectors = [[0.3, -0.8, 0.5]]
[runs.demo]
start = "a"
h = 0.1
steps = 50
""")
ANY = [name for name, m in METHODS.items() if not m.free_body]
SERVES = [name for name in ANY if METHODS[name].splitting in ("", "axes")]      # this H; for others of the splittings see test_splittings.py
SOME = [name if name in ("spherical-midpoint", "gauss-6", "dop853", "axis-splitting") else pytest.param(name, marks=pytest.mark.long) for name in SERVES]


@pytest.mark.parametrize("method", SOME)
def test_validate(method):
    report = smidgen.validate(MIX, method=method, steps=20)
    assert report.passed, [line for line in report.lines if not line.passed]


@pytest.mark.quick
@pytest.mark.parametrize("method", ANY)
def test_explain_says_in_words_what_it_found(method):
    report = smidgen.explain(MIX, method=method)
    said = [line for line in report.words() if "|" in line]
    kept = [i.kept for i in report.integrals if i.kind == "casimir"]
    assert kept == [METHODS[method].keeps_leaf] * 2
    assert ["not shown" not in line for line in said] == kept


@pytest.mark.quick
@pytest.mark.parametrize("method", SOME)
def test_restored_it_goes_on_with_the_same_bits(method):
    model = smidgen.build(MIX, method=method)
    whole = model.start("a", h=0.1).steps(12).w.copy()
    saved = model.start("a", h=0.1).steps(5).save()
    assert np.array_equal(model.start("a", h=0.2).restore(saved).steps(7).w, whole)


@pytest.mark.quick
@pytest.mark.parametrize("method", ["spherical-midpoint", "gauss-2", "gauss-6", "gauss-16"])
def test_a_refused_step_names_only_what_helps(method):
    """`advise` knows midpoint methods alone."""
    model = smidgen.build(smidgen.load("point_vortices"), method=method).start(smidgen.load("point_vortices").runs[0].start, h=40.0)
    before = model.w.copy()
    with pytest.raises(smidgen.RunError) as refused:
        model.step()
    assert METHODS[method].midpoint or "advise" not in str(refused.value)
    assert np.array_equal(model.w, before)


@pytest.mark.parametrize("compiler", COMMANDS)
@pytest.mark.parametrize("method", [name if name in ("dormand-prince-8", "dop853") else pytest.param(name, marks=pytest.mark.long) for name in METHODS])
def test_a_single_file_has_no_table_that_it_does_not_use(tmp_path, method, compiler):
    """Compilers warn of those in a file of their own, not of those in headers."""
    name = "heisenberg_chain" if method in ANY else "free_rigid_body"
    for file, text in generate(smidgen.load(name), method=method, amalgamate=True).items():
        (tmp_path / file).write_text(text)
    subprocess.run([*compiler, *WARNINGS, "-fsyntax-only", f"{name}.c"], cwd=tmp_path, check=True)
