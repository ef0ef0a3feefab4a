"""What `import smidgen` gives: every name, whatever is imported first; keywords, attributes, reprs."""
import importlib
import inspect
import subprocess
import sys

import numpy as np
import pytest

import smidgen
from smidgen.renamed import KEYWORDS
from smidgen.read.shipped import shipped

pytestmark = pytest.mark.quick
FUNCTIONS = {name: getattr(smidgen, name) for name in smidgen.__all__ if inspect.isroutine(getattr(smidgen, name))}
CALLED = {**FUNCTIONS, "Integrator.start": smidgen.Integrator.start, "exponents": smidgen.lyapunov.exponents,
          "nearby": smidgen.lyapunov.nearby}
SHARED = ("build", "run")       # functions named as packages
TOP = """[model]
name = "top"
[space]
w = { sphere = 2 }
[effects.spin]
over = "site(i) of w"
energy = "w[i].z^2 + w[i].x"
[starts.a]
vectors = [[1, 0, 0], [0, 0.6, 0.8]]
[runs.demo]
start = "a"
h = 0.1
steps = 20
"""


@pytest.fixture(scope="module")
def spec():
    return smidgen.load_text(TOP)


@pytest.fixture(scope="module")
def result(spec):
    return smidgen.run(spec)


# Names

def test_every_name_is_there_and_shown():
    assert set(smidgen.__all__) <= set(dir(smidgen)) and all(hasattr(smidgen, name) for name in smidgen.__all__)
    assert {"plot", "validate", "lyapunov", "explain", "advise"} <= set(smidgen.__all__)
    with pytest.raises(AttributeError, match="no attribute 'exlpain'"):
        smidgen.exlpain


IMPORTS = """
import importlib, sys
shared = {shared!r}
def fresh():
    for name in [n for n in sys.modules if n.split(".")[0] == "smidgen"]:
        del sys.modules[name]
for first in [(), shared, shared[::-1], ("show.plot.facts", "show.plot.draw", "analyse.advice", "analyse.symmetry")]:
    fresh()
    for name in first:
        importlib.import_module("smidgen." + name)
    import smidgen
    for again in range(2):
        for name in shared:
            function = getattr(smidgen, name)
            assert callable(function) and function.__name__ == name, (first, name, function)
    from smidgen.show.plot import kinds
    assert "player" in kinds()
    assert callable(smidgen.explain) and callable(smidgen.advise) and smidgen.lyapunov.exponents
"""


def test_names_mean_the_same_whatever_is_imported_first():
    said = subprocess.run([sys.executable, "-c", IMPORTS.format(shared=SHARED)], capture_output=True, text=True)
    assert said.returncode == 0, said.stderr


def test_importing_draws_in_neither_matplotlib_nor_sympy():
    said = subprocess.run([sys.executable, "-c", "import smidgen, sys; print({'sympy', 'matplotlib'} & set(sys.modules))"],
                          capture_output=True, text=True)
    assert said.stdout == "set()\n"


def test_the_help_of_the_command_needs_none_of_the_large_packages():
    code = "import smidgen.cli.parser as p, sys; p.make_parser(); print({'numpy', 'sympy', 'matplotlib', 'h5py', 'jinja2'} & set(sys.modules))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout == "set()\n"


def test_all_that_is_public_has_a_place():
    assert {*smidgen.PLACES, *smidgen.MODULES} <= {*smidgen.__all__} and {name for name in smidgen.__all__ if not name.endswith("Error") and name != "MissingTool"} | {
        "CheckpointError"} == {*smidgen.PLACES, *smidgen.MODULES}
    importlib.import_module("smidgen.run.step.integrator")      # a package of the name of a function
    assert callable(smidgen.run)


def test_the_package_says_that_it_is_typed():
    from importlib.resources import files
    assert (files("smidgen") / "py.typed").is_file()


def test_load_takes_a_shipped_name_or_a_path(tmp_path):
    name, path = next(iter(shipped().items()))
    assert smidgen.load(name) == smidgen.load(str(path)) == smidgen.load(path)
    with pytest.raises(smidgen.UsageError, match=f"did you mean '{name}'"):
        smidgen.load(name[:-1])
    with pytest.raises(smidgen.SpecError):
        smidgen.load(tmp_path / "none.toml")


# Keywords

@pytest.mark.parametrize("name", CALLED)
def test_signatures_are_explicit_and_documented(name):
    function = CALLED[name]
    parameters = inspect.signature(function).parameters.values()
    assert not any(p.kind in (p.VAR_KEYWORD, p.VAR_POSITIONAL) for p in parameters)
    assert len(inspect.getdoc(function)) > 60


@pytest.mark.parametrize("name", CALLED)
def test_a_misspelt_keyword_is_told_by_the_public_name_with_a_guess(name):
    function = CALLED[name]
    known = [word for word in inspect.signature(function).parameters if word != "self" and len(word) > 2]
    assert known
    for word in known:
        for wrong in (word[:-1], word + "s", word[0] + word[2] + word[1] + word[3:]):
            if wrong in known or wrong in KEYWORDS:
                continue
            with pytest.raises(smidgen.KeywordError) as caught:
                function(**{wrong: 10})
            assert f"{name}() has no keyword '{wrong}'" in str(caught.value)
            assert "did you mean" in str(caught.value)
            assert isinstance(caught.value, TypeError) and isinstance(caught.value, smidgen.UsageError)
    with pytest.raises(smidgen.KeywordError, match=f"there are: .*{known[0]}"):
        function(xyzzy_123=1)


# Attributes

def attributes(kind):
    """Annotated fields and properties of a class."""
    return [n for n in {*inspect.get_annotations(kind), *(n for n, v in vars(kind).items() if isinstance(v, property))}
            if not n.startswith("_")]


@pytest.fixture(scope="module")
def model(spec):
    return smidgen.build(spec)


@pytest.mark.parametrize("started", [False, True])
@pytest.mark.parametrize("name", sorted(attributes(smidgen.Integrator)))
def test_attributes_of_an_integrator_are_read_and_say_what_to_call(spec, model, name, started):
    if started:
        model.start(h=0.1).steps(3)
    before = dict(vars(model))
    with pytest.raises(smidgen.ReadOnlyError, match=f"'{name}' of Integrator is read-only: .*(start|build|steps|set_parameters)\\(") as caught:
        setattr(model, name, 0.2)
    assert isinstance(caught.value, AttributeError) and all(vars(model)[n] is before[n] for n in before)


@pytest.mark.parametrize("name", sorted(attributes(smidgen.Result)))
def test_attributes_of_a_result_are_read(result, name):
    with pytest.raises(smidgen.ReadOnlyError, match=f"'{name}' of Result is read-only: .*run\\("):
        setattr(result, name, None)


@pytest.mark.parametrize("wrong, right", [("hh", "h"), ("ws", "w"), ("metod", "method")])
def test_an_unknown_attribute_is_told_with_a_guess(spec, wrong, right):
    with pytest.raises(smidgen.ReadOnlyError, match=f"Integrator has no attribute '{wrong}'; did you mean '{right}'"):
        setattr(smidgen.build(spec), wrong, 0.2)


def test_the_trajectory_still_moves(spec):
    model = smidgen.build(spec).start(h=0.1)
    saved = model.steps(3).save()
    w = model.steps(4).w.copy()
    assert (model.count, model.h) == (7, 0.1) and model.t == pytest.approx(0.7)
    assert model.restore(saved).count == 3 and np.array_equal(model.steps(4).w, w)


# Reprs

def short(thing):
    return len(repr(thing)) <= 300 and "\n" not in repr(thing) and not repr(thing).startswith("<smidgen.")


@pytest.mark.parametrize("name", shipped())
def test_the_repr_of_a_spec_is_a_line(name):
    spec = smidgen.load(name)
    assert short(spec) and spec.name in repr(spec)


def test_reprs_are_lines_that_say_what_it_is(spec, result, tmp_path):
    smidgen.run(spec, out=tmp_path / "a.npz")
    model = smidgen.build(spec, features=("tangent",))
    things = [result, model, smidgen.lyapunov.exponents(model, "a", h=0.1, steps=4), model, smidgen.explain(spec),
              smidgen.advise(spec), smidgen.load_result(tmp_path / "a.npz"), smidgen.validate(spec, steps=2, points=1)]
    assert all(short(thing) for thing in things), [repr(thing) for thing in things]
    assert "21 outputs over t = 0 .. 2" in repr(result) and "complete" in repr(result)


def test_many_names_are_cut_short():
    effects = "".join(f'[effects.effect{k}]\nenergy = "{k + 1}*w[0].x"\n' for k in range(40))
    text = TOP[:TOP.index("[effects")] + effects + TOP[TOP.index("[starts"):]
    assert short(smidgen.load_text(text)) and "(40)" in repr(smidgen.load_text(text))


@pytest.mark.parametrize("name", ["free_rigid_body", pytest.param("cubic_lattice", marks=pytest.mark.long)])
def test_a_model_that_is_compiled_already_runs_without_sympy(name, tmp_path):
    """Nothing is derived, so that the second run of a spec is spared its import."""
    words = ["run", name, "--steps", "9", "--out", str(tmp_path / "found.csv")]
    for first in ("", "sys.modules['sympy'] = None; "):
        said = subprocess.run([sys.executable, "-c", f"import sys; {first}from smidgen.cli import main; sys.exit(main({words!r}))"], capture_output=True, text=True, check=False)
        assert said.returncode == 0, said.stderr[-2000:]
