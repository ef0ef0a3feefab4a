"""What rows of `verify` look at: nothing passes unseen, and no right model is refused for what it is."""
from types import SimpleNamespace

import numpy as np
import pytest

import smidgen
from smidgen.check.verify import noise as noise_rows, outputs as output_rows
from smidgen.check.verify.branch import branch, followed
from smidgen.check.verify.case import Case
from smidgen.check.verify.casimirs import casimirs
from smidgen.check.verify.contraction import slopes
from smidgen.check.verify.leaves import lengths
from smidgen.check.verify.along import along
from smidgen.check.verify.effort import effort
from smidgen.check.verify.equivariant import equivariant
from smidgen.check.verify.integrals import known_integrals
from smidgen.check.verify.order import order
from smidgen.check.verify.outputs import outputs
from smidgen.check.verify.refusals import SURE, longest, refusals
from smidgen.check.verify.round_off import round_off
from smidgen.check.verify.row import NO, NOT_APPLICABLE, YES
from smidgen.check.verify.subject import Emitted
from smidgen.check.verify.symplectic import symplectic
from smidgen.check.verify.whole_space import whole_space
from smidgen.errors import RunError
from smidgen.run.settings import settle

pytestmark = pytest.mark.quick
TEXT = """
[model]
name = "looked_at"
[space]
{space}
{effects}
[starts.any]
{start}
[runs.demo]
start = "any"
h = {h}
steps = 100
"""
PLAIN = '[effects.field]\nover = "site(i) of w"\nenergy = "{}"\n'
HOLES = """
[effects.exchange]
over = "bond(i, j) of chain(4, periodic)"
energy = "-dot(w[i], w[j])"
[effects.hole]
over = "site(i) of w"
absent = "i == 1"
[effects.pin]
over = "site(i) of w"
pinned = "i == 2"
"""


def cased(space, effects):
    """What is looked at, without the compiled code."""
    spec = smidgen.load_text(TEXT.format(space=space, effects=effects, start="w = { random = 3 }", h=0.1))
    return Case(spec, settle(spec), 2, tier=1000)


def made(space, effects, at="w = { random = 3 }", h=0.1, **given):
    spec = smidgen.load_text(TEXT.format(space=space, effects=effects, start=at, h=h))
    settings = settle(spec, **given)
    case = Case(spec, settings, 2, tier=1000)
    subject = Emitted(smidgen.build(spec), smidgen.build(spec, real="long double"))
    case.find_states(subject)
    return case, subject


def steps_of(row) -> int:
    """How many were looked at, as the note begins."""
    return int(row.note.split()[0])


def test_a_torque_alone_moves_sites():
    case, subject = made("w = { sphere = 2 }", '[effects.turn]\nover = "site(i) of w"\ntorque = "cross(w[i], cross(w[i], vec(0.3, 0.1, 1)))"\n')
    assert case.probe > case.h
    for row in (*branch(case, subject), *refusals(case, subject)):
        assert row.verdict == YES and steps_of(row) > 0, row


@pytest.mark.parametrize("effect", ['torque = "cross(w[i], cross(w[i], vec(0.3, 0.1, 1)))"', 'energy = "w[i].z"'])
def test_steps_in_closed_form_have_no_iterations_to_certify(effect):
    rows = effort(*made("w = { sphere = 2 }", f'[effects.turn]\nover = "site(i) of w"\n{effect}\n'))
    assert {row.verdict for row in rows} == {NOT_APPLICABLE} and all("closed form" in row.note for row in rows)


def test_steps_that_iterate_are_looked_at():
    rows = effort(*made("w = { sphere = 2 }", PLAIN.format("w[i].z^2")))
    assert {row.verdict for row in rows} == {YES} and not any("closed form" in row.note for row in rows)


class Refuses:
    def step(self, *_):
        raise RunError("no step")


CHAIN = '[effects.ex]\nover = "bond(i, j) of chain(40, periodic)"\nenergy = "-dot(w[i], w[j])"\n'


@pytest.mark.parametrize("space, form, damping", [("sphere", "gilbert", 0), ("sphere", "gilbert", 3), ("sphere", "ll", 3), ("r3", "ll", 3)])
def test_the_longest_step_of_many_sites_is_shorter_with_damping(space, form, damping):
    """Up to it no two solutions are possible: changes of R over the space, by differences, are as bounded."""
    case = cased(f"w = {{ {space} = 40 }}", CHAIN + f'[effects.bath]\nover = "site(i) of w"\ndamping = {damping}\nform = "{form}"\n')
    w = 2 * case.w if space == "r3" else case.w
    h = longest(case, w, *slopes(case)) / SURE
    changed, largest = 0.0, 0.0
    for _ in range(200):
        first, second = (case.placed(w * np.where(case.dice.uniform(size=(40, 1)) < 0.5, 1, -1) + 1e-3 * case.dice.standard_normal(w.shape)) for _ in range(2))
        one, other = case.witness.turning(first, 0.0), case.witness.turning(second, 0.0)
        changed = max(changed, np.abs(one - other).max() / np.abs(first - second).max() * lengths(w).max())
        largest = max(largest, lengths(one).max())
    assert 0.05 < h / 2 * np.hypot(changed, largest) <= 1


def test_torques_of_many_sites_have_no_bound():
    case = cased("w = { sphere = 40 }", '[effects.turn]\nover = "site(i) of w"\ntorque = "cross(w[i], vec(0.3, 0.1, w[i].x^3))"\n')
    (row,) = refusals(case, Refuses())
    assert row.verdict == NOT_APPLICABLE and "torques" in row.note and "torques act" in case.unseen[-1]


def test_where_nothing_was_followed_nothing_is_certified(monkeypatch):
    case, _ = made("w = { sphere = 1 }", PLAIN.format("w[i].x^2"))
    (row,) = branch(case, Refuses())
    assert row.verdict == NOT_APPLICABLE and any("followed back" in said for said in case.unseen)
    monkeypatch.setattr(case, "fastest", lambda *_: 0.0)
    assert refusals(case, Refuses())[0].verdict == NOT_APPLICABLE


@pytest.mark.parametrize("found, measured, note", [([True] * 18 + [False] + [None] * 41, 1 / 19, "19 followed back to h = 0, 41 others undecided; on another branch: 1"),
                                                   ([True, True], 0, "2 followed back to h = 0; on another branch: 0")])
def test_steps_whose_way_back_is_lost_are_not_counted_as_followed(found, measured, note):
    case = SimpleNamespace(unseen=[])
    row = followed(case, 99, found)
    assert row.measured == measured and row.note == f"99 long steps, {note}" and (row.verdict == NO) == (measured > 0)
    assert len(case.unseen) == (None in found)


def test_sites_that_are_absent_or_pinned():
    case, subject = made('w = { sphere = 4, radius = 2.5, kappa = "2.5 + i" }', HOLES)
    (turned,), (long,), (spread,) = equivariant(case, subject, known_integrals(case).actions), branch(case, subject), whole_space(case, subject)
    assert turned.verdict == YES and "all rotations" in turned.note
    assert long.verdict == YES and "undecided" not in long.note
    assert "empty cap is 1e+02 %" not in spread.note


def test_turns_on_a_leaf_of_a_large_casimir():
    case, subject = made('w = { nambu = 1, C = "50*(w.x^2 + w.y^2) + 80*w.z^2" }', '[effects.field]\nenergy = "w[0].z^2/2 + w[0].z"\n',
                         "w = { vectors = [[0.3, 0.4, 0.5]] }", 0.001)
    (row,) = equivariant(case, subject, known_integrals(case).actions)
    assert row.verdict == YES, row


@pytest.mark.filterwarnings("error")
def test_a_zero_vector_of_r3():
    case, subject = made("w = { r3 = 2 }", PLAIN.format("w[i].x^2/2 + w[i].y^2 + 0.3*w[i].z"), start=np.array([[0.3, 0.4, 0.5], [0, 0, 0]]))
    along(case, subject)
    rows = [*casimirs(case, subject), *symplectic(case, subject), *round_off(case, subject, known_integrals(case))]
    assert [row.verdict for row in rows] == [YES] * 4, rows


@pytest.mark.parametrize("h", [1e-13, -1e-13, 0.1])
def test_times_of_a_run_lie_within_it(h):
    case, _ = made("w = { sphere = 1 }", PLAIN.format(f"cos(3*t/{abs(h)})*w[i].x/{abs(h)}"), h=h)
    times = np.array(case.times())
    assert len(np.unique(times)) > 32 and np.all((0 <= times / h) & (times / h <= 101))
    assert all((t + x) - t == x for t in times for x in [np.float32(h).item()])


def test_the_order_of_a_small_step_is_that_of_a_larger_one():
    case, subject = made("w = { sphere = 1 }", PLAIN.format("w[i].x^2 + 0.3*w[i].y^2"), h=1e-9)
    (row,) = order(case, subject)
    assert row.verdict == YES and "2.000 of one step" in row.note


def test_a_run_whose_noise_ends_it_says_no(monkeypatch):
    hot = PLAIN.format("w[i].x^2") + '[effects.bath]\nover = "site(i) of w"\ndamping = 0.1\nkT = 0.2\n'
    spec = smidgen.load_text(TEXT.format(space="w = { sphere = 1 }", effects=hot, start="w = { random = 3 }", h=0.1))
    monkeypatch.setattr(noise_rows, "model_of", lambda *_: Ends())
    assert [row.verdict for row in noise_rows.noise(spec, Case(spec.calm, settle(spec), 2))] == [NO]


class Ends:
    def start(self, *_, **__):
        return self

    def steps(self, _):
        raise RunError("step 1: no solution")


def test_values_that_code_refuses_are_not_left_out(monkeypatch):
    case, subject = made("w = { sphere = 1 }", PLAIN.format("w[i].x^2"))
    good, calls = subject.outputs, []

    def refusing(w, t):
        calls.append(None)
        if len(calls) == 3:
            raise RunError("cannot start")
        return good(w, t)
    monkeypatch.setattr(subject, "outputs", refusing)
    with pytest.raises(RunError):
        outputs(case, subject)
    monkeypatch.setattr(output_rows, "expectation", Refuses().step)
    assert outputs(case, subject)[0].verdict == NOT_APPLICABLE
