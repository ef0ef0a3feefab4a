"""A site alone in its family has the number 0: formulas of i are formulas of 0, in every path of the C."""
import dataclasses
import re
from itertools import cycle

import pytest
from support.features import ANYWHERE
from support.strict import MODES, WARNINGS, compile_all

from smidgen.build.binary import write_files
from smidgen.compile.emit.emit import generate
from smidgen.read import load_text

pytestmark = pytest.mark.quick
SPEC = """
[model]
name = "alone"
[space]
w = {{ {kind} = {count}, kappa = "{kappa}"{radius} }}
{more}
[parameters]
one = {{ default = 1, fixed = true }}
b = 0.5
ga = {{ default = [2.0], size = 1 }}
gf = {{ default = [2.0], size = 1, fixed = true }}
[effects.own]
over = "site(i) of w"
energy = "{energy}"
"""
BODY = "w[i].z^2 + w[i].x^2/2"
PLAIN = dict(kind="sphere", count="1", kappa="1", radius="", more="", energy=BODY)
CASES = [dict(kappa="ga[i] + 3"), dict(kappa="1 + 0.5*mod(i, 2)"), dict(kappa="gf[i] - b*i", count='"one"'),
         dict(kind="r3", kappa="1/(1 + i)"), dict(kind="nambu", kappa="ga[i]", radius=', C = "w.x^2 + w.y^2/2"'),
         dict(radius=', radius = "1 + i"'), dict(radius=', radius = "ga[i]"', kappa="exp(i)"),
         dict(energy=BODY + " + ga[i]*w[i].x"), dict(energy=BODY + " + (i + 1)*w[i].y*cos(t)"),
         dict(energy=BODY + " + if(i < 1, b, 2)*w[i].y"),
         dict(kappa="1 + i", more='p = { sphere = 1, tracer = true, kappa = "2 + i" }\n')]
METHODS = [("spherical-midpoint", ()), ("spherical-midpoint", ANYWHERE), ("classical-midpoint", ())]


def files_of(case, method, features):
    spec = load_text(SPEC.format(**{**PLAIN, **case}))
    return generate(dataclasses.replace(spec, digest=""), method=method, features=features)


def at_zero(text):
    """The formula with 0 in place of i, but for the vectors w[i]."""
    return re.sub(r"(?<!w\[)\bi\b", "0", text)


@pytest.mark.parametrize("case, method, features", [(case, *method) for case, method in zip(CASES, cycle(METHODS))],
                         ids=lambda x: " ".join(x.values()) if isinstance(x, dict) else None)
def test_the_number_of_the_only_site_is_zero(case, method, features):
    here = {key: at_zero(text) for key, text in case.items()}
    assert files_of(case, method, features) == files_of(here, method, features)


def test_a_bond_that_has_no_second_end_is_nowhere(tmp_path):
    """A single sphere on an open chain of one site: its effect has no term."""
    bond = '[effects.bond]\nover = "bond(i, j) of chain(1, open)"\nenergy = "dot(w[i], w[j])"\n[effects'
    spec = load_text(SPEC.format(**{**PLAIN, **CASES[0]}).replace("[effects", bond, 1))
    write_files(generate(spec), tmp_path)
    assert not compile_all(tmp_path, ["alone.c"], "gcc")


@pytest.mark.parametrize("case", CASES[1:8:6], ids=lambda case: " ".join(case.values()))
def test_its_c_compiles(case, tmp_path):
    assert "-Werror" in WARNINGS
    write_files(files_of(case, *METHODS[1]), tmp_path)
    assert not compile_all(tmp_path, ["alone.c"], "gcc")


@pytest.mark.parametrize("compiler, how", MODES)
def test_a_fixed_strength_of_zero_leaves_no_block(tmp_path, compiler, how):
    """Its Hessian is empty, and Newton's loop asks for none."""
    spec = load_text('[model]\nname = "none"\n[space]\nw = { sphere = 4 }\n[parameters]\nJ = { default = 0.0, fixed = true }\n'
                             '[effects.nothing]\nover = "pair(i, j) of w"\nenergy = "J*dot(w[i], w[j])"\n[effects.bonds]\nover = "bond(i, j) of chain(4, open)"\nenergy = "w[i].x*w[j].y"\n')
    files = generate(spec)
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    assert "effect_nothing_hessian" not in files["none.c"]
    assert not compile_all(tmp_path, [f for f in files if f.endswith(".c")], compiler, how=how)
