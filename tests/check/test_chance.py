"""Random numbers of measurements are never those of a start, and NaN never passes for a good number."""
import ast
import itertools
import math
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from support.systems import begin, load

import smidgen
from smidgen.analyse.lyapunov import exponents
from smidgen.chance import USES, generator
from smidgen.check.verify import (casimirs, equivariant, integrals, order, residual, reversible, round_off, symplectic,
                                  tangent, whole_space, witness_check)
from smidgen.check.verify.along import along
from smidgen.check.verify.case import Case
from smidgen.check.verify.row import NO, YES
from smidgen.check.verify.subject import emitted
from smidgen.extremes import largest, smallest, with_largest, with_smallest
from smidgen.language.draws import directions
from smidgen.run.record.record import Deviations
from smidgen.run.settings import settle
from smidgen.run.step.start import initial_state

validation = import_module("smidgen.check.validate")     # its name in the package is the function's
GEN = Path(smidgen.__file__).parent
MAKERS = {"default_rng", "PCG64", "PCG64DXSM", "Philox", "MT19937", "SFC64", "SeedSequence", "RandomState", "Random"}
quick = pytest.mark.quick
nan = math.nan

RANDOM = """
[model]
name = "random_start"
[space]
w = { sphere = %d }
[effects.alone]
over = "site(i) of w"
energy = "0.5*w[i].x^2 + 0.24*w[i].y^2 + 0.2*w[i].z^3"
%s
[starts.any]
random = %d
[runs.demo]
start = "any"
h = 0.1
steps = 10
"""
PAIRS = """
[effects.pairs]
over = "pair(i, j) of w"
energy = "0.8*dot(w[i], w[j])"
"""


def system(seed, sites=1):
    return smidgen.load_text(RANDOM % (sites, PAIRS * (sites > 1), seed))


# -- generators ------------------------------------------------------------------------------------

def names_in(path):
    tree = ast.parse(path.read_text())
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute):
            yield node.attr
        if isinstance(node, ast.Name):
            yield node.id
        if isinstance(node, (ast.Import, ast.ImportFrom)):
            yield from (a.name for a in node.names)
            if isinstance(node, ast.Import) and any(a.name == "random" for a in node.names) or getattr(node, "module", "") == "random":
                yield "Random"


@quick
def test_generators_are_made_in_one_file():
    found = {str(p.relative_to(GEN)) for p in GEN.rglob("*.py") if MAKERS & set(names_in(p))}
    assert found == {"chance.py"}


@quick
def test_no_use_draws_what_another_or_a_start_draws():
    seeds = range(21)
    starts = [directions(s, family, 1)[0] for s in seeds for family in range(3)]
    drawn = [dice.standard_normal(3) for dice in (generator(use, s) for use in USES for s in seeds)]
    found = starts + [x / np.linalg.norm(x) for x in drawn]
    assert len({x.tobytes() for x in found}) == len(found)
    assert len(set(USES.values())) == len(USES)
    assert np.array_equal(generator("times", 3).uniform(size=5), generator("times", 3).uniform(size=5))


@pytest.mark.parametrize("sites", [1, 3])
def test_exponents_sum_to_zero_at_every_seed(sites):
    """Hamiltonian systems, where start and tangent vectors have the same seed. (A vector along w is none.)"""
    model = smidgen.build(system(0, sites), features=("tangent",))
    for seed in range(21):
        w = initial_state(system(seed, sites), "any")
        found = exponents(model, w, 0.1, 200, seed=seed)
        assert abs(found.growth.sum()) < 1e-10, seed
        assert exponents(model, w, 0.1, 50, columns=1, seed=seed).growth.shape == (50, 1)


def test_reversible_is_a_number_at_every_seed():
    for seed in range(21):
        spec = system(seed)
        settings = settle(spec, None)
        case, subject = Case(spec, settings, 1), emitted(spec, settings)
        case.find_states(subject)
        row, = reversible.reversible(case, subject)
        assert row.verdict == YES and math.isfinite(row.measured), (seed, row)
        with np.errstate(divide="raise", invalid="raise"):      # 0/0 where an axis is that of the state
            stretch = [reversible.stretch(subject, w, subject.step(w, t, h), t, h) for w, t, h in case.trials()]
        assert all(1 <= x < 10 for x in stretch), (seed, stretch)


# -- NaN -------------------------------------------------------------------------------------------

@quick
@pytest.mark.parametrize("numbers", sorted(set(itertools.permutations([1.0, 2.0, 3.0, nan, math.inf])), key=str))
def test_nan_is_the_largest_and_the_smallest(numbers):
    rest = [x for x in numbers if x == x]
    assert math.isnan(largest(*numbers)) and math.isnan(smallest(*numbers))
    assert math.isnan(with_largest([(x,) for x in numbers], lambda x: x[0])[0])
    assert math.isnan(with_smallest([(x,) for x in numbers], lambda x: x[0])[0])
    assert (largest(*rest), smallest(*rest)) == (math.inf, 1)
    assert (with_largest(rest, float), with_smallest(rest, float)) == (math.inf, 1)


@pytest.fixture(scope="module")
def looked():
    """(case, subject, known) of the free rigid body, with its path."""
    spec = load("free_rigid_body")
    settings = settle(spec, None, steps=20)
    case, subject = Case(spec, settings, 2, tier="quick"), emitted(spec, settings)
    case.find_states(subject)
    along(case, subject)
    return case, subject, integrals.known_integrals(case)


def kept(case, subject, known):
    one = integrals.Integral(lambda w: np.ones(2), 1.0)
    return [integrals.kept(case, subject, "momentum", [one, one], "")]


def energy(case, subject, known):
    return [integrals.energy(case, subject, integrals.Known([], [], [], True))]


# what measures, where it is looked up, what it returns where all is well, and the rows made of it
MEASURES = {
    "returned": (reversible, 0.0, lambda c, s, k: reversible.reversible(c, s)),
    "apart": (equivariant, 0.0, lambda c, s, k: equivariant.equivariant(c, s, [lambda *_: 0] * 3)),
    "defect": (symplectic, 0.0, lambda c, s, k: symplectic.symplectic(c, s)),
    "form_defect": (symplectic, 0.0, lambda c, s, k: symplectic.symplectic(c, s)),
    "compared": (tangent, (0.0, 0.0), lambda c, s, k: tangent.tangent(c, s)),
    "changed": (casimirs, 0.0, lambda c, s, k: casimirs.casimirs(c, s)),
    "change": (integrals, 0.0, kept),
    "along": (integrals, 0.0, kept),
    "energy_change": (integrals, 0.0, energy),
    "worst": (witness_check, 0.0, lambda c, s, k: [witness_check.residual(c, s)]),
    "worst ": (whole_space, 0.0, lambda c, s, k: whole_space.whole_space(c, s)),
    "formula_gaps": (witness_check, (0.0, 0.0), lambda c, s, k: witness_check.formulas(c, s)),
    "stretch": (witness_check, 1.0, lambda c, s, k: [witness_check.step(c, s)]),
    "one_step": (order, 2.0, lambda c, s, k: order.order(c, s)),
    "against_flow": (order, 2.0, lambda c, s, k: order.order(c, s)),
    "size_of": (round_off, 0.0, lambda c, s, k: round_off.round_off(c, s, k)),
}


@pytest.mark.parametrize("name", MEASURES)
def test_a_nan_in_any_place_gets_its_no(name, looked, monkeypatch):
    (module, good, rows), calls = MEASURES[name], []
    monkeypatch.setattr(case := looked[0], "unseen", [])
    monkeypatch.setattr(equivariant, "said", lambda *_: "")

    def measure(at):
        def one(*_):
            calls.append(None)
            return np.multiply(good, nan) if len(calls) - 1 == at else good
        calls.clear()
        monkeypatch.setattr(module, name.strip(), one)
        return [row.verdict for row in rows(*looked)]

    assert set(measure(-1)) == {YES}, case
    count = len(calls)
    assert count >= 1
    for at in {0, 1, count // 2, count - 1} & set(range(count)):
        assert NO in measure(at), (at, count)


def test_a_stretch_that_is_no_number_stays(looked):
    class Subject:
        def __init__(self, at):
            self.at, self.calls = at, 0

        def step(self, w, t, h):
            self.calls += 1
            return w * (nan if self.calls == self.at else 1)

    w = looked[0].w
    assert all(math.isnan(reversible.stretch(Subject(at), w, w, 0.0, 0.1)) for at in range(1, 5))


def test_a_residual_whose_growth_is_no_number(looked, monkeypatch):
    case, subject, _ = looked
    monkeypatch.setattr(residual, "growth", lambda *_: nan)
    states = np.array(case.path[:4]) * np.array([1, 1 + 1e-13, 1 + 3e-13, 1])[:, None, None]
    assert not residual.worst(case, subject, states, 0.0, case.h) <= residual.RESIDUAL


@quick
@pytest.mark.parametrize("at", range(3))
def test_a_law_of_growth_needs_numbers(at):
    rms = np.array([1.0, 3.0, 10.0]) / 100
    rms[at] = nan
    assert not round_off.law(rms) <= round_off.EXPONENT
    assert not round_off.law(1000 * rms) <= round_off.EXPONENT


@quick
@pytest.mark.parametrize("at", range(3))
def test_a_run_keeps_that_an_error_was_no_number(at):
    record = object.__new__(Deviations)
    record.largest = {}
    for k in range(3):
        record._raise("errors", "energy", np.array([nan if k == at else 0.1 * k]))
    assert math.isnan(record.largest["errors"]["energy"])


@pytest.mark.parametrize("name, good", [("difference", 0.0), ("compare_at", {"field": (0.0, 1.0), "energy": (0.0, 1.0)})])
def test_validate_says_no_to_nan(name, good, monkeypatch):
    spec, calls = begin("free_rigid_body").spec, []

    def one(*_):
        calls.append(None)
        bad = len(calls) - 1 == at
        return good if not bad else nan if name == "difference" else {k: (nan, 1.0) for k in good}
    monkeypatch.setattr(validation, name, one)
    for at in (0, 1, 3):
        calls.clear()
        assert not smidgen.validate(spec, steps=2).passed, at


@quick
@pytest.mark.parametrize("seed", [-1, 0.5, "1"])
def test_a_seed_that_is_no_natural_number_is_refused(seed):
    with pytest.raises(smidgen.UsageError, match="the seed must be a non-negative integer"):
        generator("tangent vectors", seed)
