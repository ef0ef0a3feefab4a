"""Dormand-Prince 8(5,3) of the registry, through everything: runs, restore, witness, certificate, explanation."""
import subprocess

import numpy as np
import pytest
import smidgen
from smidgen.compile.emit.emit import generate
from smidgen.errors import UsageError
from smidgen.resources import include_flags
from support.strict import COMMANDS, WARNINGS

METHODS = ("dop853", "dop853-projected")
FREE = smidgen.load("free_rigid_body")
# w(10) from (cos 1.1, 0, sin 1.1), I = (1, 2, 4), by elliptic functions
FREE_AT_10 = (-0.4503635330766926960600452, -0.09362899305780025785077625, 0.8879224626810953221192839)


@pytest.mark.quick
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("h", [0.5, 10.0])
def test_the_free_body_is_where_theory_has_it(method, h):
    """Whatever h: the steps within it are the method's own."""
    end = smidgen.build(FREE, method=method).start("paper", h=h).steps(round(10 / h)).w[0]
    assert np.abs(end - FREE_AT_10).max() < 1e-11


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", ["forced_rigid_body", "lagrange", *(pytest.param(n, marks=pytest.mark.long) for n in ("point_vortices", "vortex_tracers", "nambu_a31", "product"))])
def test_validate(name, method):
    report = smidgen.validate(smidgen.load(name), method=method, steps=20)
    assert report.passed, report


@pytest.mark.usefixtures("few_states", "optimised_here")
def test_the_certificate_refuses_what_it_is_not():
    rows = {row.name: row.verdict for row in smidgen.verify(smidgen.load("irreversible_rigid_body"), method="dop853", tier="quick").rows}
    assert rows["symplectic"] == rows["casimirs"] == rows["reversible"] == "no"
    assert rows["step"] == rows["field"] == rows["outputs"] == "yes" and rows["order"] == "does not apply"


@pytest.mark.quick
def test_projection_keeps_leaves_and_nothing_else_does():
    away = {}
    for method in METHODS:
        model = smidgen.build(smidgen.load("irreversible_rigid_body"), method=method).start(smidgen.load("irreversible_rigid_body").runs[0].start, h=0.5)
        before = model.casimirs().copy()
        away[method] = np.abs(model.steps(200).casimirs() - before).max() / np.abs(before).max()
    assert away["dop853-projected"] < 1e-14 and away["dop853"] > 10 * away["dop853-projected"]


@pytest.mark.quick
def test_explain_claims_neither_leaf_nor_energy():
    kept = {m: {i.kind: i.kept for i in smidgen.explain(FREE, method=m).integrals} for m in METHODS}
    assert not any(kept["dop853"].values())
    assert kept["dop853-projected"]["casimir"] and not kept["dop853-projected"]["energy"]


@pytest.mark.quick
def test_restored_it_goes_on_with_the_same_bits():
    model, start = smidgen.build(smidgen.load("point_vortices"), method="dop853"), smidgen.load("point_vortices").runs[0].start
    whole = model.start(start, h=0.7).steps(20).w.copy()
    saved = model.start(start, h=0.7).steps(9).save()
    assert np.array_equal(model.start(start, h=0.3).restore(saved).steps(11).w, whole)


@pytest.mark.quick
def test_it_has_no_features():
    with pytest.raises(UsageError, match="no feature 'tangent'"):
        smidgen.build(FREE, method="dop853", features=["tangent"])


@pytest.mark.parametrize("compiler", COMMANDS[:3])
@pytest.mark.parametrize("name", ["vortex_tracers", "product"])
@pytest.mark.parametrize("amalgamate", [False, True])
def test_clean_c(tmp_path, name, compiler, amalgamate):
    for file, text in generate(smidgen.load(name), method="dop853-projected", amalgamate=amalgamate).items():
        (tmp_path / file).write_text(text)
    subprocess.run([*compiler, *WARNINGS, *include_flags(), "-I.", "-fsyntax-only", f"{name}.c"], cwd=tmp_path, check=True)
