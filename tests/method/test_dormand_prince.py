"""The step of Dormand and Prince of order 8 without control of its size: order, witness, and the steps of dop853 where that takes h whole."""
import numpy as np
import pytest
import smidgen
from mpmath import log, mpf
from smidgen.errors import RunError
from support.compositions import SPECS, STARTS, compile_model, run
from support.triples import apart
from test_comparators import MIX

METHOD, ORDER = "dormand-prince-8", 8
FREE, FORCED, VORTICES, CHAIN = (smidgen.load(name) for name in ("free_rigid_body", "forced_rigid_body", "point_vortices", "heisenberg_chain"))


@pytest.mark.parametrize("name", [pytest.param("irreversible body", marks=pytest.mark.long), "driven body", pytest.param("vortices", marks=pytest.mark.long)])
def test_the_order_in_quadruple_precision(tmp_path, name):
    spec, start = SPECS[name], STARTS[name]
    exact = run(compile_model(tmp_path / "exact", spec, "gauss-16"), start, 1 / 128, 128).w
    program = compile_model(tmp_path / "own", spec, METHOD)
    errors = [apart(run(program, start, 1 / n, n).w, exact) for n in (16, 32)]
    assert errors[1] > mpf(10)**-26
    assert abs(log(errors[0] / errors[1], 2) - ORDER) < 0.4


@pytest.mark.parametrize("spec, h", [(FORCED, 0.3), (MIX, 0.1), *(pytest.param(spec, h, marks=pytest.mark.long) for spec, h in ((FREE, 0.5), (VORTICES, 0.1), (CHAIN, 0.1)))],
                         ids=lambda x: getattr(x, "name", None))
def test_the_witness_takes_the_same_steps(spec, h):
    report = smidgen.validate(spec, method=METHOD, h=h, steps=10)
    assert report.passed, [line for line in report.lines if not line.passed]


@pytest.mark.quick
@pytest.mark.parametrize("spec", [FREE, FORCED, VORTICES], ids=lambda s: s.name)
def test_the_steps_are_those_of_dop853_where_its_tolerance_allows_them(spec):
    """To the bit: both have one text."""
    start = spec.runs[0].start
    controlled = smidgen.build(spec, method="dop853").start(start, h=1e-3, tolerance=1e-3).steps(5)
    assert controlled.report()["iterations"] == 1
    assert np.array_equal(smidgen.build(spec, method=METHOD).start(start, h=1e-3, tolerance=1e-3).steps(5).w, controlled.w)


@pytest.mark.quick
def test_a_tolerance_changes_nothing_and_a_restored_state_goes_on():
    model = smidgen.build(MIX, method=METHOD)
    whole = model.start("a", h=0.1).steps(12).w.copy()
    saved = model.start("a", h=0.1, tolerance=1e-2).steps(5).save()
    assert np.array_equal(model.start("a", h=0.2).restore(saved).steps(7).w, whole)


@pytest.mark.quick
def test_a_step_that_is_no_number_leaves_the_state():
    model = smidgen.build(VORTICES, method=METHOD).start(VORTICES.runs[0].start, h=1e200)
    before = model.w.copy()
    with pytest.raises(RunError, match="not finite"):
        model.step()
    assert np.array_equal(model.w, before) and model.count == 0


@pytest.mark.quick
def test_explain_claims_neither_leaf_nor_energy():
    assert not any(i.kept for i in smidgen.explain(FREE, method=METHOD).integrals)
