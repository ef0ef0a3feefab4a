"""Extrapolation of the explicit midpoint rule: weights, order, round-off, the witness, what the certificate says, clean C."""
import re
from fractions import Fraction
from math import factorial
from pathlib import Path

import numpy as np
import pytest
import smidgen
from mpmath import log, mpf
from smidgen.compile.emit.emit import generate
from smidgen.errors import RunError, UsageError
from smidgen.resources import include_flags
from support.compositions import SPECS, STARTS, compile_model, run
from support.strict import MODES, compile_all
from support.triples import apart
from test_comparators import MIX

METHOD, ORDER, ROWS = "extrapolation-12", 12, 6
HEADER = Path(__file__).parents[2] / "runtime" / "method" / "tables" / "smg_tableau.h"
FREE, FORCED, VORTICES = (smidgen.load(name) for name in ("free_rigid_body", "forced_rigid_body", "point_vortices"))
# w(10) from (cos 1.1, 0, sin 1.1), I = (1, 2, 4), by elliptic functions
FREE_AT_10 = (-0.4503635330766926960600452, -0.09362899305780025785077625, 0.8879224626810953221192839)


@pytest.mark.quick
def test_the_weights_are_those_of_the_polynomials_at_0():
    """W_j/j = prod over i != j of j^2/(j^2 - i^2), over j: whole numbers over one for all."""
    text = HEADER.read_text()
    numbers = [int(x) for x in re.search(r"smg_tableau_weights\[.*?\] = \{(.*?)\}", text)[1].split(",")]
    unit = int(re.search(r"smg_tableau_unit = (\d+)", text)[1])
    wanted = [Fraction(2 * (-1)**j * j**11, factorial(6 - j) * factorial(6 + j)) for j in range(1, ROWS + 1)]
    assert [Fraction(n, unit) for n in numbers] == wanted and sum(j * w for j, w in enumerate(wanted, 1)) == 1
    assert all(sum(w / Fraction(j)**(2 * k - 1) for j, w in enumerate(wanted, 1)) == 0 for k in range(1, ROWS))


@pytest.mark.parametrize("name", ["irreversible body", "driven body", "vortices"])
def test_the_order_in_quadruple_precision(tmp_path, name):
    spec, start, steps = SPECS[name], STARTS[name], 8
    exact = run(compile_model(tmp_path / "exact", spec, "gauss-16"), start, 1 / 128, 128).w
    program = compile_model(tmp_path / "own", spec, METHOD)
    errors = [apart(run(program, start, 1 / n, n).w, exact) for n in (steps, 2 * steps)]
    assert errors[1] > mpf(10)**-26
    assert abs(log(errors[0] / errors[1], 2) - ORDER) < 0.4


@pytest.mark.quick
@pytest.mark.parametrize("h, error", [(1.0, 3e-13), (0.25, 2e-15)])
def test_the_free_body_is_where_theory_has_it(h, error):
    end = smidgen.build(FREE, method=METHOD).start("paper", h=h).steps(round(10 / h)).w[0]
    assert np.abs(end - FREE_AT_10).max() < error


@pytest.mark.quick
def test_round_off_is_not_enlarged_by_the_weights():
    """Half of the bodies are off by a few ulps after 1000 steps; weights W_j as rounded numbers leave ten times as much."""
    off, dice = [], np.random.default_rng(5)
    double, extended = smidgen.build(FREE, method=METHOD), smidgen.build(FREE, method=METHOD, real="long double")
    for _ in range(41):
        w = dice.standard_normal(3)
        w = (w / np.linalg.norm(w))[None]
        exact = extended.start(w.astype(np.longdouble), h=0.1).steps(1000).w
        off.append(np.abs(double.start(w, h=0.1).steps(1000).w - exact).max())
    assert np.median(off) < 1e-14


@pytest.mark.parametrize("spec, h", [(FREE, 0.5), (FORCED, 0.3), (MIX, 0.1), (smidgen.load("nambu_a31"), 0.1),
                                     *(pytest.param(smidgen.load(name), h, marks=pytest.mark.long) for name, h in (("point_vortices", 0.1), ("product", 0.1), ("vortex_tracers", 0.1)))],
                         ids=lambda x: getattr(x, "name", None))
def test_the_witness_takes_the_same_steps(spec, h):
    report = smidgen.validate(spec, method=METHOD, h=h, steps=20)
    assert report.passed, [line for line in report.lines if not line.passed]


@pytest.mark.usefixtures("few_states", "optimised_here")
def test_the_certificate_says_what_it_is_not():
    rows = {row.name: row for row in smidgen.verify(smidgen.load("irreversible_rigid_body"), method=METHOD, h=0.5, tier="quick").rows}
    assert {name for name in ("symplectic", "casimirs", "reversible") if rows[name].verdict == "no"} == {"symplectic", "casimirs", "reversible"}
    assert rows["step"].verdict == rows["field"].verdict == rows["outputs"].verdict == rows["order"].verdict == "yes"


@pytest.mark.quick
def test_explain_claims_neither_leaf_nor_energy():
    assert not any(i.kept for i in smidgen.explain(FREE, method=METHOD).integrals)


@pytest.mark.quick
@pytest.mark.parametrize("spec, start", [(MIX, "a"), (FORCED, FORCED.runs[0].start)], ids=["general", "one sphere"])
def test_restored_it_goes_on_with_the_same_bits_and_a_tolerance_changes_none(spec, start):
    model = smidgen.build(spec, method=METHOD)
    whole = model.start(start, h=0.1).steps(12).w.copy()
    saved = model.start(start, h=0.1).steps(5).save()
    assert np.array_equal(model.start(start, h=0.2).restore(saved).steps(7).w, whole)
    assert np.array_equal(model.start(start, h=0.1, tolerance=1e-4).steps(12).w, whole)


@pytest.mark.quick
@pytest.mark.parametrize("spec, start", [(VORTICES, VORTICES.runs[0].start), (FREE, "paper")], ids=["general", "one sphere"])
def test_a_step_that_is_no_number_leaves_the_state(spec, start):
    model = smidgen.build(spec, method=METHOD).start(start, h=1e200)
    before = model.w.copy()
    with pytest.raises(RunError, match="not finite"):
        model.step()
    assert np.array_equal(model.w, before) and model.count == 0


@pytest.mark.quick
def test_a_step_backward_comes_back_but_for_its_error():
    model = smidgen.build(FORCED, method=METHOD).start(FORCED.runs[0].start, h=0.1)
    before = model.w.copy()
    there = model.steps(10).w.copy()
    assert np.abs(smidgen.build(FORCED, method=METHOD).start(there, t0=1.0, h=-0.1).steps(10).w - before).max() < 1e-14


@pytest.mark.quick
def test_it_has_no_features():
    with pytest.raises(UsageError, match="no feature 'plain-sums'"):
        smidgen.build(FREE, method=METHOD, features=["plain-sums"])


@pytest.mark.parametrize("compiler, mode", MODES)
@pytest.mark.parametrize("name", ["product", "forced_rigid_body"])
def test_clean_c(tmp_path, name, compiler, mode):
    for file, text in generate(smidgen.load(name), method=METHOD, amalgamate=True).items():
        (tmp_path / file).write_text(text)
    assert not compile_all(tmp_path, [f"{name}.c", f"{name}_abi.c"], compiler, *include_flags(), how=mode)
