"""Functions that run a spec, or look at its runs, take the same keywords in one order, with the same defaults."""
import inspect

import pytest
import smidgen
from smidgen.run.files.options import OPTIONS

pytestmark = pytest.mark.quick
ORDER = [option.name for option in OPTIONS]
OF_A_RUN = ("run", "build", "average", "ensemble", "sweep", "validate", "verify", "cost", "choose", "advise", "explain", "spectrum", "spin_waves", "plot")
LAST = ("out", "keep", "progress")


def keywords(name):
    return inspect.signature(getattr(smidgen, name)).parameters


@pytest.mark.parametrize("name", OF_A_RUN)
def test_the_spec_comes_first_then_its_run_and_the_rest_by_name(name):
    spec, run, *rest = keywords(name).values()
    assert spec.name == ("source" if name == "plot" else "spec") and spec.default is spec.empty
    assert run.name == "run" and run.default is None and run.kind == run.POSITIONAL_OR_KEYWORD
    assert rest and all(one.kind == one.KEYWORD_ONLY for one in rest)


@pytest.mark.parametrize("name", OF_A_RUN)
def test_choices_of_a_run_stand_in_the_order_of_the_list_with_the_defaults_of_run(name):
    mine, runs = keywords(name), keywords("run")
    choices = [word for word in mine if word in ORDER]
    assert choices == [word for word in ORDER if word in choices]
    for word in choices:
        assert mine[word].default == runs[word].default, word
        assert mine[word].annotation == runs[word].annotation or (name, word) in {("spectrum", "start"), ("spin_waves", "start")}, word


def test_the_test_sees_every_function_that_has_a_run():
    assert {name for name in smidgen.__all__ if inspect.isroutine(getattr(smidgen, name)) and "run" in keywords(name)} == set(OF_A_RUN)


def test_a_method_or_a_start_in_the_place_of_the_run_is_told_where_it_goes():
    spec = smidgen.load("free_rigid_body")
    for name in OF_A_RUN[:-1]:
        more = {"sweep": {"out": "nowhere"}, "choose": {"error": 1e-6}}.get(name, {})
        with pytest.raises(smidgen.UsageError, match="has no run 'gauss-8'.*that is a method: method='gauss-8'"):
            getattr(smidgen, name)(spec, "gauss-8", **more)
    with pytest.raises(smidgen.UsageError, match="its keyword `start`"):
        smidgen.ensemble(spec, *[[[1.0, 0.0, 0.0]]])


def test_build_and_explain_take_what_the_run_says():
    """As the commands of these names do; what is given goes before."""
    spec = smidgen.load_text("""[model]
name = "top"
[parameters]
a = 2.0
[space]
w = { sphere = 1 }
[effects.spin]
energy = "a*w.z^2"
[effects.field]
energy = "w.x"
[starts.s]
theta = 1.0
phi = 0.0
[runs.first]
start = "s"
h = 0.1
steps = 2
effects = ["spin"]
method = "gauss-4"
set = { a = 3.0 }
[runs.second]
start = "s"
h = 0.1
steps = 2
""")
    first, second, own = smidgen.build(spec), smidgen.build(spec, "second"), smidgen.build(spec, effects=["field"], parameters={"a": 4.0})
    assert (first.method, first.scene.effect_names, first.parameters) == ("gauss-4", ("spin",), {"a": 3.0})
    assert (second.method, second.scene.effect_names, second.parameters) == ("spherical-midpoint", ("spin", "field"), {"a": 2.0})
    assert own.method == "gauss-4" and own.scene.effect_names == ("field",)
    assert smidgen.explain(spec).parameters == {"a": 3.0} and smidgen.explain(spec, "second").parameters == {"a": 2.0}


def test_public_modules_are_modules():
    import smidgen.lattice
    import smidgen.lyapunov
    for module in (smidgen.lattice, smidgen.lyapunov):
        assert inspect.ismodule(module) and module.__name__ in ("smidgen.lattice", "smidgen.lyapunov")
        assert all(hasattr(module, name) for name in module.__all__) and len(inspect.getdoc(module)) > 60
