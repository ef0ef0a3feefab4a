"""Arguments of a wrong type: every public function says what is accepted, before it does anything."""
import inspect

import numpy as np
import pytest
import smidgen
from smidgen import public

pytestmark = pytest.mark.quick
FUNCTIONS = {name: getattr(smidgen, name) for name in smidgen.__all__ if inspect.isfunction(getattr(smidgen, name))} | {
    f"{module.__name__}.{name}": f for module in (smidgen.lattice, smidgen.lyapunov) for name, f in vars(module).items() if hasattr(f, "__wrapped__")} | {
    f"Integrator.{name}": f for name, f in vars(smidgen.Integrator).items() if hasattr(f, "__wrapped__")}
CASES = [(name, p) for name, f in FUNCTIONS.items() for p in inspect.signature(f).parameters.values() if public.words(p.name, p.annotation)]
OWN = {"self", "spec", "run", "source", "start", "theory", "q", "basis", "cell", "axes", "w", "result"}     # which the functions look at themselves


class Nothing:
    """Of no type that an argument has."""

    def __repr__(self):
        return "Nothing()"


@pytest.mark.parametrize("name, argument", CASES, ids=[f"{name}-{p.name}" for name, p in CASES])
def test_an_argument_of_a_wrong_type_is_told_with_what_is_accepted(name, argument):
    with pytest.raises(smidgen.UsageError, match=rf"^{argument.name} must be .*, not Nothing\(\)$"):
        FUNCTIONS[name](**{argument.name: Nothing()})


def test_every_argument_has_a_type_that_is_checked_or_is_looked_at():
    checked = {(name, p.name) for name, p in CASES}
    left = {p.name for name, f in FUNCTIONS.items() for p in inspect.signature(f).parameters.values() if (name, p.name) not in checked}
    assert left <= OWN


@pytest.mark.parametrize("given", [dict(out=5), dict(out=[]), dict(what=5), dict(what=[None]), dict(what=np.zeros(2)), dict(effects=[1]), dict(effects=True), dict(native="yes"),
                                   dict(native=2), dict(substeps=()), dict(method=5), dict(h=[0.1]), dict(h=np.zeros(1)), dict(steps="7"), dict(every=[2]), dict(parameters=[1]),
                                   dict(parameters={1: 2.0}), dict(progress=7), dict(threads="2"), dict(seed=b"1"), dict(averages=["energy"]), dict(start=7), dict(start=object())])
def test_a_run_refuses_it(given):
    (name,) = given
    with pytest.raises(smidgen.UsageError, match=f"{name} must be|a state"):
        smidgen.run("free_rigid_body", **{"steps": 2} | given)


def test_what_is_accepted():
    """Numbers of numpy, one name alone, anything that gives names."""
    alone, listed, array, once = (smidgen.run("free_rigid_body", steps=np.int64(4), every=2.0, h=np.float32(0.125), native=np.bool_(False), effects=names, what=what).values["energy"]
                                  for names, what in (("rotation", "energy"), (["rotation"], ["energy"]), (np.array(["rotation"]), np.array(["energy"])),
                                                      ((name for name in ["rotation"]), {"energy": 1}.keys())))
    assert len(alone) == 3 and all(np.array_equal(alone, other) for other in (listed, array, once))


def test_an_ensemble_a_comparison_and_a_sweep(tmp_path):
    for function, more in ((smidgen.ensemble, {}), (smidgen.validate, {}), (smidgen.sweep, {"out": tmp_path / "s"})):
        for start in (7, [1, 2], np.zeros(2), object()):
            with pytest.raises(smidgen.UsageError):
                found = function("free_rigid_body", start=start, steps=2, **more)
                raise smidgen.UsageError(found[0]["error"])     # of a sweep: a cell that says so
    with pytest.raises(smidgen.UsageError, match="t0 must be finite"):
        smidgen.ensemble("free_rigid_body", steps=2, t0=np.nan)
    with pytest.raises(smidgen.UsageError, match="points must be"):
        smidgen.validate("free_rigid_body", points=2.5)


def test_a_trajectory():
    top = smidgen.build("free_rigid_body").start(h=0.1)
    before = top.steps(2).state()
    for wrong in (lambda: top.steps("5"), lambda: top.steps(2.5), lambda: top.steps(None), lambda: top.advance([1]), lambda: top.restore("x"), lambda: top.energy(t="now"),
                  lambda: top.field(t=[1]), lambda: top.start(7, h=0.1), lambda: top.start(h="0.1"), lambda: top.start(h=0.1, t0="0")):
        with pytest.raises(smidgen.UsageError):
            wrong()
    assert np.array_equal(before, top.state())


@pytest.mark.parametrize("name, shape", [("state", (1, 3)), ("values", (5,)), ("casimirs", (1,))])
def test_an_array_to_write_to_that_is_too_short_is_refused(name, shape):
    """C would write beyond its end."""
    top = smidgen.build("free_rigid_body").start(h=0.1)
    whole, call = np.zeros(getattr(top, name)().shape), getattr(top, name)
    read_only = whole.copy()
    read_only.flags.writeable = False
    for wrong in (whole.ravel()[1:], np.zeros((*whole.shape, 2))[..., 0] if whole.size > 1 else np.zeros(2), whole.astype(np.float32), read_only, list(whole), 5):
        with pytest.raises(smidgen.UsageError, match="out must be a contiguous array"):
            call(out=wrong)
    assert call(out=whole) is whole and np.array_equal(whole, call())
