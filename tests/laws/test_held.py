"""Sites that do not move (`pinned`, `fixed`) and sites that are not there (`absent`): in every method that takes them, against the witness and against specs that never had
the sites."""
import ctypes
import re
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from support.strict import REALS, WARNINGS

import smidgen
from smidgen.check.validate import Case as ValidateCase
from smidgen.check.verify.case import Case as VerifyCase
from smidgen.check.witness import Witness
from smidgen.compile.emit.emit import generate
from smidgen.compile.select import select
from smidgen.cost.measure.case import Case as CostCase
from smidgen.methods import METHODS
from smidgen.resources import include_flags
from smidgen.run.settings import settle
from smidgen.run.step.start import initial_state

quick = pytest.mark.quick
CHAIN = """[model]
name = "held"
orientation = {orientation}
[space]
w = {{ sphere = "{sites}"{space} }}
[parameters]
n = {n}
K = 0.4
[effects.bonds]
over = "bond(i, j) of {lattice}"
energy = "{bond}"
[effects.axis]
over = "site(i) of w"
energy = "-K*w[i].z^2/2 - 0.3*w[i].x"
{more}[observables.mz]
over = "site(i) of w"
value = "w[i].z + 1"
[starts.r]
random = 3
[runs.demo]
start = "r"
h = 0.1
steps = 20
output = {{ every = 10, what = ["states", "energy", "momentum", "casimirs", "mz"] }}
"""
PINNED = '[effects.edge]\nover = "site(i) of w"\npinned = "{}"\n'
ABSENT = '[effects.holes]\nover = "site(k) of w"\nabsent = "{}"\n'
BATH = '[effects.bath]\nover = "site(i) of w"\ndamping = 0.1\nform = "{}"\nkT = {}\n'
DAMPED = '[effects.bath]\nover = "site(i) of w"\ndamping = 0.1\n'
TORQUE = '[effects.current]\nover = "site(i) of w"\ntorque = "0.2*cross(w[i], cross(w[i], vec(0, 1, 0)))"\n'
PUSH = '[effects.push]\nover = "bond(i, j) of chain(n, open)"\ntorque = "0.1*cross(w[i], w[j])*w[i].z"\n'
BOTH = PINNED.format("i < 2 or i == 7") + ABSENT.format("k == 4 or k == 5 or k == 10")
FEW = [2, 3, 6, 8, 9, 11]      # of twelve those that move


def held(more=BOTH, n=12, lattice="chain(n, periodic)", bond="-dot(w[i], w[j])", sites="n", space="", orientation=1):
    return smidgen.load_text(CHAIN.format(more=more, n=n, lattice=lattice, bond=bond, sites=sites, space=space, orientation=orientation))


RESPONDING = [name for name, m in METHODS.items() if m.responds and not m.free_body]


@pytest.mark.parametrize("method", [pytest.param(m, marks=quick if METHODS[m].stages == 1 and m not in ("gauss-10", "gauss-12", "gauss-14", "gauss-16") else ()) for m in RESPONDING])
def test_every_method_leaves_them_where_they_are(method):
    """To the bit, though their vectors are some ulps off their spheres, where no step has put them."""
    spec = held()
    one = smidgen.build(spec, method=method)
    w = initial_state(spec, "r")
    w[[0, 1, 7]] *= np.array([[1 + 1.5e-15], [1 - 1.5e-15], [1 + 4e-16]])
    w[[4, 5, 10]] = 0, 0, 1
    found = one.start(w.copy(), h=0.05).steps(6).w
    assert np.array_equal(found[[0, 1, 4, 5, 7, 10]], w[[0, 1, 4, 5, 7, 10]])
    assert np.abs(found[FEW] - w[FEW]).max(axis=1).min() > 1e-3
    tolerance = 1e-9 if METHODS[method].controlled else 2e-13
    assert np.abs(found - Witness(spec).steps(w, 0.0, 0.05, 6, method)[-1]).max() < tolerance


@pytest.mark.parametrize("kind", ["sphere", "r3"])
@pytest.mark.parametrize("method", ["dop853-projected", "cf4"])
def test_a_pinned_site_alone_stays_where_it_is(method, kind):
    """Of an ensemble too, whose members do not go in lanes then."""
    spec = smidgen.load_text(f'[model]\nname = "alone"\n[space]\nw = {{ {kind} = 1 }}\n[effects.field]\nenergy = "-w.z - 0.3*w.x^2"\n' + PINNED.format("i < 1"))
    w = np.array([[0.6, 0, 0.8]]) * (1 + 1.5e-15)
    assert np.array_equal(smidgen.build(spec, method=method).start(w.copy(), h=0.05).steps(6).w, w)
    assert np.array_equal(smidgen.ensemble(spec, start=np.array([w] * 9), h=0.05, steps=6, method=method).w, np.array([w] * 9))


@quick
@pytest.mark.parametrize("method", [m for m in METHODS if m not in RESPONDING and not METHODS[m].free_body and METHODS[m].stages == 1])
def test_other_methods_say_why_not(method):
    with pytest.raises(smidgen.UsageError, match="does not support sites that do not move|sublattice|bond|single site"):
        smidgen.build(held(), method=method)


KINDS = {"damped": DAMPED, "ll": BATH.format("ll", 0).replace("kT = 0\n", ""), "current": DAMPED + TORQUE, "pushed": PUSH, "pushed and damped": PUSH + DAMPED}


@quick
@pytest.mark.parametrize("orientation", [1, -1])
@pytest.mark.parametrize("kind", KINDS)
def test_damping_and_torques_do_not_move_them(kind, orientation):
    spec = held(BOTH + KINDS[kind], space=', kappa = "if(mod(i, 3) == 0, -0.5, 2)", radius = 1.5', orientation=orientation)
    one = smidgen.build(spec).start("r", h=0.1)
    w = one.w.copy()
    assert np.abs(one.steps(5).w - Witness(spec).steps(w, 0.0, 0.1, 5)[-1]).max() < 1e-13
    assert np.array_equal(one.w[[0, 1, 4, 5, 7, 10]], w[[0, 1, 4, 5, 7, 10]])


@quick
def test_noise_does_not_turn_them():
    spec = held(BOTH + BATH.format("gilbert", 0.3))
    one = smidgen.build(spec).start("r", h=0.1, seed=5)
    w = one.w.copy()
    assert np.abs(one.steps(5).w - Witness(spec, seed=5).steps(w, 0.0, 0.1, 5)[-1]).max() < 1e-13
    assert np.array_equal(one.w[[0, 1, 4, 5, 7, 10]], w[[0, 1, 4, 5, 7, 10]])


LATTICES = {"chain": ("chain(n, open)", "n", 12), "square": ("square(n, 4, periodic)", "4*n", 6), "pairs": ("", "n", 6), "log": ("chain(n, open)", "n", 12)}


@quick
@pytest.mark.parametrize("solver", ["auto", "newton", "rotation", "plain"])
@pytest.mark.parametrize("place", LATTICES)
def test_every_solver(place, solver):
    lattice, sites, n = LATTICES[place]
    bond = "-0.2*log(2.5 - 2*dot(w[i], w[j]))" if place in ("log", "pairs") else "-dot(w[i], w[j]) + 0.2*triple(vec(0, 0, 1), w[i], w[j])"
    text = CHAIN.format(more=BOTH.replace("k == 10", "uniform(2, k) < 0.2"), n=n, lattice=lattice, bond=bond, sites=sites, space="", orientation=1)
    spec = smidgen.load_text(text.replace("bond(i, j) of ", "pair(i, j) of w") if place == "pairs" else text)
    if solver == "newton" and place == "square":
        pytest.skip("a lattice has no factorisation")
    one = smidgen.build(spec, solver=solver).start("r", h=0.1)
    w = one.w.copy()
    assert np.abs(one.steps(5).w - Witness(spec).steps(w, 0.0, 0.1, 5)[-1]).max() < 1e-13


@quick
def test_the_rest_moves_as_without_the_absent_sites():
    """Of a ring of 12 without the sites 4 and 5 what is left is an open chain of ten, 6 .. 11, 0 .. 3."""
    order = [6, 7, 8, 9, 10, 11, 0, 1, 2, 3]
    ring = smidgen.build(held(ABSENT.format("k == 4 or k == 5"))).start("r", h=0.1)
    chain = smidgen.build(held("", n=10, lattice="chain(n, open)")).start(ring.w[order].copy(), h=0.1)
    a, b = ring.steps(20), chain.steps(20)
    assert np.abs(a.w[order] - b.w).max() < 1e-14
    assert dict(zip(a.columns, a.values())) == pytest.approx(dict(zip(b.columns, b.values())), abs=1e-13)
    assert np.abs(np.delete(a.casimirs(), [4, 5]) - 1).max() < 1e-14 and not a.casimirs()[[4, 5]].any()


@quick
def test_a_neighbour_of_absent_sites_alone_is_free():
    one = smidgen.build(held(ABSENT.format("mod(k, 2) == 1"))).start("r", h=0.1)
    alone = [smidgen.build(held("", n=3)).start(one.w[[0, 2, 4]].copy(), h=0.1)]
    free = smidgen.build(smidgen.load_text(CHAIN.format(more="", n=6, lattice="chain(n, open)", bond="0*dot(w[i], w[j])", sites="n", space="", orientation=1)))
    free.start(one.w[::2].copy(), h=0.1)
    assert np.abs(one.steps(20).w[::2] - free.steps(20).w).max() < 1e-14
    assert np.abs(alone[0].steps(20).w - free.w[:3]).max() > 0.1


@quick
def test_pinned_sites_are_felt():
    """A spin beside a pinned one moves as in a field."""
    field = smidgen.load_text('[model]\nname = "one"\n[space]\nw = { sphere = 1 }\n[effects.field]\nenergy = "-w.z"\n')
    spec = smidgen.load_text('[model]\nname = "two"\n[space]\nw = { sphere = 2 }\n[effects.bond]\nenergy = "-dot(w[0], w[1])"\n'
                             '[effects.edge]\nover = "site(i) of w"\npinned = "i < 1"\n')
    w = np.array([[0, 0, 1.0], [np.sin(1), 0, np.cos(1)]])
    one = smidgen.build(spec).start(w.copy(), h=0.01).steps(100)
    assert np.array_equal(one.w[0], w[0])
    assert np.abs(one.w[1] - smidgen.build(field).start(w[1:].copy(), h=0.01).steps(100).w[0]).max() < 1e-14


@quick
def test_a_fixed_family():
    text = """[model]
name = "fixed"
[space]
w = { sphere = "n" }
s = { sphere = 3, fixed = true }
[parameters]
n = 4
[effects.join]
over = "each(i of w, k of s)"
energy = "-0.4*dot(w[i], s[k])*(1 + 0.1*uniform(1, i, k))"
[effects.pairs]
over = "pair(i, j) of w"
energy = "-dot(w[i], w[j])"
[starts.r.w]
random = 1
[starts.r.s]
random = 2
[runs.demo]
start = "r"
h = 0.1
steps = 10
"""
    spec = smidgen.load_text(text)
    one = smidgen.build(spec).start("r", h=0.1)
    w = one.w.copy()
    assert np.array_equal(one.steps(10).w[4:], w[4:])
    assert np.abs(one.w - Witness(spec).steps(w, 0.0, 0.1, 10)[-1]).max() < 1e-13


@quick
def test_outputs_have_no_absent_site(tmp_path):
    result = smidgen.run(held())
    assert not result.w["w"][:, [4, 5, 10]].any() and result.w["w"][:, [0, 3]].any()
    there = [k for k in range(12) if k not in (4, 5, 10)]
    assert np.abs(result.values["momentum.w"] - result.w["w"][:, there].sum(axis=1)).max() < 1e-14
    assert np.abs(result.values["mz"] - (result.w["w"][:, there, 2] + 1).sum(axis=1)).max() < 1e-14
    assert not result.values["casimirs"][:, [4, 5, 10]].any()
    assert not result.final[[4, 5, 10]].any() and np.array_equal(result.final, result.w["w"][-1])


@quick
def test_a_start_says_nothing_of_absent_sites():
    """Whatever stands there, the bits are the same; so they are after a save and in an ensemble."""
    spec = held()
    w = initial_state(spec, "r")
    other = w.copy()
    other[[4, 5, 10]] = [[0, 0, 0], [7, 0, 0], [0, -1, 0]]
    one = smidgen.build(spec).start(w.copy(), h=0.1).steps(7)
    saved, wanted = one.save(), one.steps(9).save()
    assert np.array_equal(smidgen.build(spec).start(other.copy(), h=0.1).steps(16).save(), wanted)
    assert np.array_equal(smidgen.build(spec).start(w.copy(), h=0.03).restore(saved).steps(9).save(), wanted)
    many = smidgen.ensemble(spec, start=np.array([w, other]), h=0.1, steps=16)
    assert np.array_equal(many.w[0], one.w) and np.array_equal(many.w[1], one.w)


@quick
def test_the_tangent_map():
    spec = held(PINNED.format("i < 2") + ABSENT.format("k == 5"))
    one = smidgen.build(spec, features=["tangent"]).start("r", h=0.1)
    w, v = one.w.copy(), np.cross(one.w, np.random.default_rng(1).normal(size=(12, 3)))
    one.step()
    mine = one.tangent(v[None].copy())[0]
    other, size = smidgen.build(spec), 1e-6
    ends = [other.start((x := w + s * size * v) / np.linalg.norm(x, axis=1)[:, None], h=0.1).step().w.copy() for s in (1, -1)]
    difference = (ends[0] - ends[1]) / (2 * size)
    there = np.arange(12) != 5
    assert np.abs(mine - difference)[there].max() < 1e-8
    assert np.abs(mine[:2] - v[:2]).max() < 1e-15


@quick
def test_nothing_left_is_an_error():
    with pytest.raises(smidgen.SpecError, match="every site is absent"):
        held(ABSENT.format("k >= 0"))
    with pytest.raises(smidgen.UsageError, match="every site is absent"):
        smidgen.build(held(ABSENT.format("k >= n - 20 and n < 12")), parameters={"n": 10})


@quick
def test_parameters_that_leave_nothing_are_refused():
    spec = held("[parameters.q]\ndefault = 6\n" + ABSENT.format("k >= q"))
    one = smidgen.build(spec).start("r", h=0.1)
    with pytest.raises(smidgen.SmidgenError):
        one.set_parameters({"q": 0})
    assert one.parameters["q"] == 6 and one.step().count == 1
    scalars, status = one._passed[0].copy(), ctypes.c_int()         # as a program in C hands them over
    scalars[scalars == 6] = 0
    assert not one._c.new(scalars.ctypes.data, one._passed[2], one.w.ctypes.data, 0.0, 0.1, ctypes.byref(status)) and status.value == 5


@quick
def test_an_absent_site_of_r3_is_a_unit_vector():
    """Whatever is given there, and the other moves as if it were alone."""
    text = '''[model]
name = "one_body"
[space]
w = { r3 = 2 }
[effects.own]
over = "site(i) of w"
energy = "w[i].x^2/2 + w[i].y^2/3"
'''
    w = np.array([[5.0, 0, 0], [0.3, -0.4, 1.2]])
    one, both = (smidgen.build(smidgen.load_text(text + more)).start(w.copy(), h=0.2).steps(9) for more in (ABSENT.format("k == 0"), ""))
    assert np.array_equal(one.w[0], [0, 0, 1]) and np.array_equal(one.w[1], both.w[1])


@quick
def test_everything_pinned_stands():
    one = smidgen.build(held(PINNED.format("i >= 0"))).start("r", h=0.1)
    w = one.w.copy()
    assert np.array_equal(one.steps(10).w, w)


@quick
@pytest.mark.parametrize("text, said", [
    ('over = "site(i) of w"\npinned = "i"', "needs a condition"), ('over = "site(i) of w"\nabsent = "w[i].z < 0"', "is not allowed in a condition on sites"),
    ('over = "site(i) of w"\nabsent = "t < 1"', "time `t` is not allowed"), ('over = "pair(i, j) of w"\npinned = "i < j"', "applies to the sites of a family"),
    ('over = "site(i) of w"\npinned = "i < 2"\nabsent = "i < 1"', "`pinned` and `absent`"), ('over = "site(i) of w"\npinned = "i < 2"\nenergy = "w[i].x"', "`pinned` and `energy`"),
    ('pinned = "1 < 2"', "applies to the sites of a family"), ('over = "site(i) of w"\npinned = "i < 2"\nform = "ll"', "no key `form`|unknown|form"),
    ('over = "site(i) of w"\npinned = "unifrom(3, i) < 1"', "did you mean `uniform`")])
def test_what_is_not_accepted(text, said):
    with pytest.raises(smidgen.SpecError, match=said):
        held("[effects.edge]\n" + text + "\n")


@quick
def test_a_scene_that_leaves_them_out_has_the_c_of_one_that_never_had_them():
    plain, with_them = held(""), held()
    left = select(with_them, ["bonds", "axis"])
    assert generate(replace(left, digest="", sources=())) == generate(replace(select(plain, None), digest="", sources=()))


@quick
@pytest.mark.parametrize("real", REALS)
def test_compilers_have_nothing_to_say(tmp_path, real):
    files = generate(held(BOTH + DAMPED))
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    for compiler in ("gcc", "clang"):
        if shutil.which(compiler):
            subprocess.run([compiler, "-std=c11", *WARNINGS, *REALS[real], *include_flags(), "-fsyntax-only", str(tmp_path / "held.c")], check=True)


def test_verify_and_validate_say_yes():
    for spec in (held(), held(BOTH + DAMPED), held(ABSENT.format("k == 4"))):
        assert smidgen.validate(spec).passed
        assert smidgen.verify(spec, tier="quick").passed


@pytest.mark.parametrize("start", ["r", "array"])
@pytest.mark.parametrize("effects", [["bonds", "axis"], ["bonds", "axis", "holes"]])
def test_other_commands_begin_where_the_run_does(effects, start):
    """Sites are absent only with the effect that removes them; of outputs, where they are 0, all make the same state."""
    spec = held()
    start = smidgen.run(spec, effects=effects).final if start == "array" else start
    w = smidgen.build(spec, effects=effects).start(start if isinstance(start, str) else start.copy(), h=0.1).w
    settings = settle(spec, effects=effects, start=start)
    for found in (VerifyCase(spec, settings, 2), ValidateCase(settings, spec, 1), CostCase(spec, settings)):
        assert np.abs(found.w - w).max() < 1e-15
    assert VerifyCase(spec, settings, 2).numbers.present.all() == ("holes" not in effects)


INFINITE = """
[model]
name = "infinite"
[space]
w = {{ sphere = "n" }}
[parameters]
n = 8
[effects.exchange]
over = "bond(i, j) of chain(n, periodic)"
energy = "-0.7*dot(w[i], w[j])"
[effects.hole]
over = "site(i) of w"
absent = "i == 3"
[effects.push]
over = "site(i) of w"
torque = "({factor})*cross(w[i], {along})"
[starts.random]
random = 1
"""


@pytest.mark.parametrize("along", ["vec(0, 0.6, 0.8)", pytest.param("cross(w[i], vec(0, 0.6, 0.8))", marks=pytest.mark.long)])
def test_a_torque_that_is_infinite_at_an_absent_site_is_none(along):
    """Bit for bit as one that is 0 there, and as the witness has it."""
    infinite, none = (smidgen.load_text(INFINITE.format(factor=factor, along=along)) for factor in ("0.2/abs(i - 3)", "if(i == 3, 0, 0.2/(abs(i - 3) + if(i == 3, 1, 0)))"))
    one, other = (smidgen.build(spec).start("random", h=0.05).steps(3).w for spec in (infinite, none))
    assert np.array_equal(one, other)
    start = smidgen.build(infinite).start("random", h=0.05).w.copy()
    assert np.abs(Witness(infinite).steps(start, 0.0, 0.05, 3)[-1] - one).max() < 1e-14


@pytest.mark.parametrize("held", ["absent", pytest.param("pinned", marks=pytest.mark.long)])
@pytest.mark.parametrize("form, damping, kT", [("gilbert", "0.2/abs(i - 3)", "0.1/abs(i - 3)"), ("ll", "0.2 - 0.9*if(i == 3, 1, 0)", "0.1 - 0.9*if(i == 3, 1, 0)")])
def test_damping_and_temperature_of_a_site_that_does_not_move_are_never_asked(held, form, damping, kT):
    """As of torques: as ones that are 0 there, and as the witness has it."""
    def loaded(alpha, T):
        drag = f'[effects.push]\nover = "site(i) of w"\ndamping = "{alpha}"\nkT = "{T}"\nform = "{form}"\n'
        return smidgen.load_text(re.sub(r"(?s)\[effects\.push\].*?(?=\[starts)", drag, INFINITE.format(factor=0, along=0)).replace("absent =", f"{held} ="))
    odd, none = loaded(damping, kT), loaded(*(f"if(i == 3, 0, {e.replace('abs(i - 3)', '(abs(i - 3) + if(i == 3, 1, 0))')})" for e in (damping, kT)))
    one, other = (smidgen.build(spec).start("random", h=0.05, seed=4).steps(3).w for spec in (odd, none))
    assert np.abs(one - other).max() < 1e-15
    report = smidgen.validate(odd, start="random", h=0.05, steps=3)
    assert report.passed, report.text()
    with pytest.raises(smidgen.SpecError, match=r"the damping of `w\[4\]` is -"):
        loaded(damping.replace("i == 3", "i == 4").replace("0.2/abs(i - 3)", "0.2*(3.5 - i)"), kT)
