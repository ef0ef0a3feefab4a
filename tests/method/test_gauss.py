"""Gauss collocation of the registry, through everything: command, run, restore, witness, certificate, explanation, picture."""
import json
import subprocess

import numpy as np
import pytest
import smidgen
from smidgen.compile.emit.emit import generate
from smidgen.errors import SpecError, UsageError
from smidgen.resources import include_flags
from support.strict import COMMANDS, WARNINGS

ORDERS = tuple(range(2, 17, 2))
FREE = smidgen.load("free_rigid_body")
# w(10) from (cos 1.1, 0, sin 1.1), I = (1, 2, 4), by elliptic functions
FREE_AT_10 = (-0.4503635330766926960600452, -0.09362899305780025785077625, 0.8879224626810953221192839)

NAMBU = """
[model]
name = "leaf"
[space]
v = { nambu = 1, C = "(v.x^2 + 2*v.y^2 + 3*v.z^2)/2" }
[effects.h]
over = "site(i)"
energy = "v[i].x^2"
[starts.a]
vectors = [[1, 0.5, 0.25]]
[runs.r]
start = "a"
method = "gauss-4"
h = 0.1
steps = 3
"""


@pytest.mark.quick
@pytest.mark.parametrize("order, h, error", [(4, 1 / 32, 1e-8), (8, 1 / 4, 1e-9), (16, 1.0, 1e-9)])
def test_the_free_body_is_where_theory_has_it(order, h, error):
    end = smidgen.build(FREE, method=f"gauss-{order}").start("paper", h=h).steps(round(10 / h)).w[0]
    assert np.abs(end - FREE_AT_10).max() < error


@pytest.mark.parametrize("name", ["free_rigid_body", "point_vortices", "vortex_tracers", "forced_rigid_body"])
@pytest.mark.parametrize("order", [2, 6, pytest.param(12, marks=pytest.mark.long)])
def test_validate(name, order):
    """Steps beside the witness's own collocation, and the order against the flow."""
    report = smidgen.validate(smidgen.load(name), method=f"gauss-{order}", steps=20)
    assert report.passed, report


@pytest.mark.parametrize("order", [2, 6])
@pytest.mark.usefixtures("few_states", "optimised_here")
def test_the_certificate_says_symplectic_and_claims_no_quadratic_integral(order):
    rows = {row.name: row for row in smidgen.verify(FREE, method=f"gauss-{order}", tier="quick").rows}
    assert rows["symplectic"].verdict == rows["order"].verdict == rows["casimirs"].verdict == "yes"
    assert rows["quadratic integrals"].verdict == rows["energy"].verdict == "does not apply"
    assert not [name for name, row in rows.items() if row.verdict == "no"]


@pytest.mark.quick
def test_explain_knows_what_it_keeps():
    chain = {i.name: i.kept for i in smidgen.explain(smidgen.load("heisenberg_chain"), method="gauss-6").integrals}
    assert any(chain.values())
    assert not any(i.kept for i in smidgen.explain(FREE, method="gauss-6").integrals if i.kind in ("quadratic", "energy"))


@pytest.mark.quick
def test_restored_it_goes_on_with_the_same_bits():
    model = smidgen.build(smidgen.load("point_vortices"), method="gauss-6")
    start = smidgen.load("point_vortices").runs[0].start
    whole = model.start(start, h=0.1).steps(20).w.copy()
    saved = model.start(start, h=0.1).steps(9).save()
    assert np.array_equal(model.start(start, h=0.3).restore(saved).steps(11).w, whole)


@pytest.mark.quick
def test_other_spaces_and_features_are_refused():
    with pytest.raises(SpecError, match="gauss-4 does not support the factor"):
        smidgen.load_text(NAMBU)
    with pytest.raises(UsageError, match="does not support Nambu"):
        smidgen.build(smidgen.load("nambu_a31"), method="gauss-4")
    with pytest.raises(UsageError, match="no feature 'tangent'"):
        smidgen.build(FREE, method="gauss-4", features=["tangent"])
    with pytest.raises(UsageError, match="midpoint"):
        smidgen.advise(FREE, method="gauss-4")


@pytest.mark.quick
def test_a_hopeless_step_is_refused_and_leaves_the_state():
    model = smidgen.build(smidgen.load("point_vortices"), method="gauss-8").start(smidgen.load("point_vortices").runs[0].start, h=1000.0)
    before = model.w.copy()
    with pytest.raises(smidgen.RunError):
        model.step()
    assert np.array_equal(model.w, before)


@pytest.mark.quick
def test_the_command(command):
    said = command("run", "free_rigid_body", "--method", "gauss-6", "--h", "0.5", "--steps", "20", "--json")
    assert said.returncode == 0 and json.loads(said.stdout)
    assert command("gen", "free_rigid_body", "--method", "gauss-6", "--out", "c").returncode == 0


@pytest.mark.parametrize("order", [2, 8, *(pytest.param(p, marks=pytest.mark.long) for p in ORDERS if p not in (2, 8))])
@pytest.mark.parametrize("compiler", COMMANDS[:3])
@pytest.mark.parametrize("amalgamate", [False, True])
def test_clean_c(tmp_path, order, compiler, amalgamate):
    files = generate(smidgen.load("vortex_tracers"), method=f"gauss-{order}", amalgamate=amalgamate)
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    subprocess.run([*compiler, *WARNINGS, *include_flags(), "-I.", "-fsyntax-only", "vortex_tracers.c"], cwd=tmp_path, check=True)
