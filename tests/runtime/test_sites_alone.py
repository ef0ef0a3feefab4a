"""Sites that are solved alone: the step ends where that of the first of them ends, whichever is solved first.

A spin across its field B has a step up to |h B/kappa| = 2, on a sphere of any radius: W = -w there. So n of them have
one up to the least of n numbers.
"""
import random
import re

import numpy as np
import pytest

import smidgen
from smidgen.analyse.advice import advise
from smidgen.check.witness import Witness
from smidgen.errors import RunError
from smidgen.read import load_text

HEAD = '''[model]
name = "alone"
orientation = {orientation}
[space]
w = {{ {space}, kappa = "k[i]" }}
[parameters]
B = {{ default = {fields}, size = {n} }}
k = {{ default = {kappas}, size = {n} }}
[effects.field]
over = "site(i) of w"
energy = "B[i]*w[i].{axis}{more}"
[starts.across{of}]
vectors = {rows}
'''
PAIR = '''[effects.exchange]
energy = "0.01*dot(v[0], v[1]) + {field}*v[0].z + {field}*v[1].z"
[starts.across.v]
vectors = [[1, 0, 0], [1, 0, 0]]
'''


class Free:
    """Spins across their fields: the spec, and where the step of the first of them ends."""

    def __init__(self, seed, pair=""):
        r = random.Random(seed)
        n, axis = r.randint(2, 6), r.randrange(3)
        fields, kappas = ([r.choice((-1, 1)) * round(r.uniform(0.2, 4), 3) for _ in range(n)] for _ in range(2))
        ball = seed % 2 == 0
        rows = np.array([[r.gauss(0, 1) for _ in range(3)] for _ in range(n)])
        rows[:, axis] = 0
        size = [1.0 if ball else r.uniform(0.3, 2) for _ in range(n)]
        rows = rows / np.linalg.norm(rows, axis=1)[:, None] * np.array(size)[:, None]
        letter = "xyz"[axis]
        more = ("", f" + 0.7*w[i].{letter}^3")[seed // 2 % 2]      # 0 on these orbits, and solved by Newton
        self.text = HEAD.format(orientation=r.choice((1, -1)), space=f"{'sphere' if ball else 'r3'} = {n}", n=n,
                                fields=fields, kappas=kappas, axis=letter, more=more, rows=rows.tolist(),
                                of=".w" if pair else "")
        self.text = self.text.replace("[parameters]", "v = { sphere = 2 }\n[parameters]") + pair if pair else self.text
        self.rel = 1e-6 if more else 1e-13                     # of a curve that is followed, of a closed form
        ends = 2 / np.abs(np.array(fields) / kappas)
        self.end, self.site, self.all = float(ends.min()), int(np.argmin(ends)), ends
        self.sign = r.choice((1, -1))
        self.spec = load_text(self.text)


def refusal(spec, h) -> RunError:
    with pytest.raises(RunError) as caught:
        smidgen.build(spec).start(h=h).step()
    return caught.value


@pytest.mark.quick
@pytest.mark.parametrize("seed", range(4))
def test_the_part_of_h_is_that_of_the_first_end(seed):
    """Just beyond it, beyond all of them, and at the end of each."""
    free = Free(seed)
    model = smidgen.build(free.spec).start(h=free.sign * 0.999 * free.end).step()
    assert model.count == 1
    for h in (1.001 * free.end, *free.all, 1.3 * free.all.max(), 100 * free.all.max()):
        error = refusal(free.spec, free.sign * h)
        assert error.reached * h == pytest.approx(free.end, rel=free.rel)
        assert h == free.end or error.site == free.site


@pytest.mark.quick
@pytest.mark.parametrize("seed", range(4))
def test_what_the_command_says_is_what_advise_says(seed):
    free = Free(seed)
    said = re.search(r"steps exist up to \|h\| = (\S+):", str(refusal(free.spec, free.sign * 3 * free.all.max())))
    assert float(said[1]) == pytest.approx(free.end, rel=1e-5)
    advice = advise(free.spec, h=free.sign * 1.0, steps=1)
    assert advice.limit == pytest.approx(free.end, rel=1e-5) and advice.sites == (free.site,)
    assert 0.8 * free.end < abs(advice.h) < free.end


@pytest.mark.quick
@pytest.mark.parametrize("field, first", [(0.0, "alone"), (300.0, "pair")])
def test_sites_alone_beside_a_pair(field, first):
    """The pair has a step of any size, or one up to 2/field about: the first end counts, of whichever it is."""
    free = Free(3, PAIR.format(field=field))
    error = refusal(free.spec, 1.2 * free.all.max())
    end = free.end if first == "alone" else 2 / field
    assert error.reached * 1.2 * free.all.max() == pytest.approx(end, rel=1e-2)
    error = refusal(load_text(free.text.replace(f"{field}*v", "0.3*v")), 40.0)     # both fail, the pair is solved first
    assert error.reached * 40 == pytest.approx(min(free.end, 2 / 0.3), rel=1e-6)


MANY = '''[model]
name = "many"
[space]
w = { sphere = "n" }
[parameters]
n = 1000
B = { default = 1.0, size = "n" }
[effects.field]
over = "site(i) of w"
energy = "B[i]*w[i].z"
[starts.up]
theta = 0.0
phi = 0.0
'''


@pytest.mark.quick
def test_a_thousand_sites():
    fields, w = np.ones(1000), np.tile([1.0, 0.0, 0.0], (1000, 1))
    fields[700] = 5.0
    spec, values = load_text(MANY), {"B": fields}
    with pytest.raises(RunError) as caught:
        smidgen.build(spec, parameters=values).start(w, h=2.5).step()
    assert caught.value.reached * 2.5 == pytest.approx(0.4, rel=1e-12) and caught.value.site == 700
    advice = advise(spec, parameters=values, start=w, h=2.5, steps=1)
    assert advice.limit == pytest.approx(0.4, rel=1e-12) and advice.sites == (700,)


JUMP = """[model]
name = "jump"
[space]
w = { sphere = 2 }
[effects.e]
over = "site(i) of w"
energy = "if(w[i].z < 0.2, 3*w[i].x, 2*w[i].y)"
[starts.s]
theta = "1 + i/2"
phi = "0.3 + i"
[runs.r]
start = "s"
h = 0.4
steps = 1
"""


@pytest.mark.quick
def test_a_field_that_jumps_is_no_constant_one():
    """Its second derivatives vanish, but at the midpoint it is not what it is at the start: each step solves the step equation, or
    is refused."""
    spec, taken = smidgen.load_text(JUMP), 0
    model, witness, dice = smidgen.build(spec), Witness(spec), np.random.default_rng(5)
    for _ in range(200):
        w = dice.normal(size=(2, 3))
        before = w / np.linalg.norm(w, axis=1)[:, None]
        try:
            after = model.start(before.copy(), h=0.4).step().state()
        except RunError:
            continue
        taken += 1
        assert np.abs(witness.residual(before, after, 0.0, model.h, "spherical-midpoint")).max() < 1e-14
    assert taken > 50


EDGE = """
[model]
name = "edge"
[space]
w = { sphere = 2, radius = "10^(-10*i)" }
[effects.edge]
over = "site(i) of w"
energy = "abs(w[i].x) + 0.7*w[i].z"
"""


def turned(w, field, h):
    """(m, W) of a unit spin in a constant field: the closed form of smg_spin.h, k < 1."""
    g = h / 2 * np.array(field)
    k, d = g @ g, w @ g
    rho = np.sqrt((1 - k + np.sqrt((1 - k) ** 2 + 4 * d * d)) / 2)
    m = (rho * w + np.cross(w, g) + d / rho * g) / (rho**2 + k)
    return m, 2 * rho * m - w


def to_the_edge(w):
    """The h of [0.01, 1.2] at which the midpoint comes to x = 0, where the field of x > 0 ends, or None."""
    low, high = 0.01, 1.2
    if turned(w, (1, 0, 0.7), high)[0][0] >= 0:
        return None
    for _ in range(60):
        h = (low + high) / 2
        low, high = (h, high) if turned(w, (1, 0, 0.7), h)[0][0] >= 0 else (low, h)
    return low


@pytest.mark.quick
def test_a_small_site_at_an_edge_of_its_field():
    """Steps that end within round-off of the edge: another evaluation may be on its other side, and is then no part of the step, however small the site is."""
    model, dice, taken = smidgen.build(smidgen.load_text(EDGE)), np.random.default_rng(1), 0
    for w in dice.normal(size=(60, 3)):
        w = w * np.sign(w[0]) / np.linalg.norm(w)
        found = to_the_edge(w)
        for h in () if found is None else found * (1 + 2.2e-16 * np.arange(-4, 5)):
            try:
                after = model.start(np.array([[0.6, 0, 0.8], 1e-10 * w]), h=h).step().w[1] * 1e10
            except RunError:
                continue
            taken += 1
            assert min(np.abs(after - turned(w, (side, 0, 0.7), h)[1]).max() for side in (1, -1)) < 1e-12
    assert taken > 20


MIXED = """
[model]
name = "mixed"
[space]
{families}
{effects}
"""
APART = {"v": ("sphere = 2", "pair(i, j) of v", "0.3*v[i].z*v[j].z - 0.5*v[i].x*v[j].x"), "w": ("sphere = 2", "site(i) of w", "0.2*w[i].x^4 + 0.1*w[i].y"),
         "u": ("sphere = 1", "site(i) of u", "0.4*u[i].z")}


def apart(*names):
    families = "\n".join(f"{name} = {{ {APART[name][0]} }}" for name in names)
    effects = "".join(f'[effects.of_{name}]\nover = "{APART[name][1]}"\nenergy = "{APART[name][2]}"\n' for name in names)
    return smidgen.build(smidgen.load_text(MIXED.format(families=families, effects=effects)), solver="newton")


def test_the_report_of_sites_that_are_solved_separately_is_that_of_the_one_that_takes_most():
    """Sites that are solved together, by Newton's method each, and in closed form, which takes no iteration: none leaves its own for all."""
    together, alone, model = apart("v"), apart("w"), apart("v", "w", "u")
    v, w = np.array([[0.6, 0, 0.8], [0, 1.0, 0]]), np.array([[1.0, 0, 0], [0.28, 0.96, 0]])
    u = np.array([[0, 0.6, 0.8]])
    for h in np.linspace(0.02, 0.9, 12):
        of = [one.start(start.copy(), h=h).step().report() for one, start in ((together, v), (alone, w), (alone, w[::-1]), (model, np.concatenate((v, w, u))))]
        for number in ("iterations", "residual"):
            assert of[1][number] == of[2][number]
            assert of[3][number] == max(of[0][number], of[1][number])
        assert of[3]["iterations"] > 0


FOLLOWED = """
[model]
name = "followed"
[space]
v = { sphere = 1 }
u = { sphere = 1, kappa = "k" }
[parameters]
k = 1e-300
B = 1e150
[effects.body]
energy = "v[0].z^4 + v[0].x*v[0].y"
[effects.field]
energy = "B*u[0].z"
"""


@pytest.mark.quick
def test_a_site_whose_field_is_not_finite_has_no_part_of_another_ones_curve():
    """The curve of v is followed to its end; of u there is none."""
    spec, w = smidgen.load_text(FOLLOWED), np.array([[0.6, 0, 0.8], [1.0, 0, 0]])
    assert smidgen.build(spec, parameters={"k": 1.0, "B": 0.1}).start(w, h=0.65).step().report()["reached"] >= 1
    with pytest.raises(RunError) as caught:
        smidgen.build(spec).start(w, h=0.65).step()
    assert caught.value.site == 1 and caught.value.reached == 0


SCALED = """
[model]
name = "scaled"
[space]
w = {{ {space}, kappa = "r[i]" }}
[parameters]
n = 2
r = {{ default = 1.0, size = "n" }}
[effects.body]
over = "site(i) of w"
energy = "0.5*(w[i].x^2 + 0.5*w[i].y^2 + 0.25*w[i].z^2) + 0.3*r[i]*w[i].y"
{more}
"""
COUPLED = """[effects.pair]
over = "pair(i, j) of w"
energy = "0.05*r[i]*r[j]*dot(w[i], w[j])"
"""
SPHERE, R3 = 'sphere = "n", radius = "r[i]"', 'r3 = "n"'


def second(model, starts, small):
    """Of large steps, the status and where the second site is in units of its size."""
    for v, h in starts:
        try:
            yield None, model.start(np.array([[1.0, 0, 0], small * v]), h=h).steps(1).w[1] / small
        except RunError as error:
            yield error.status, np.zeros(3)


@pytest.mark.parametrize("space, more, sizes", [(SPHERE, "", (1, 2.0**-30)), pytest.param(R3, "", (1, 2.0**-30), marks=pytest.mark.long), pytest.param(SPHERE, COUPLED, (2.0**-9, 2.0**-40), marks=pytest.mark.long)],
                         ids=["spheres", "R3", "coupled"])
def test_a_small_site_has_the_branch_of_a_large_one(space, more, sizes):
    """The motion of each is the same in units of its size, and the second acts on the first by next to nothing; the unit of a curve was that of the
    largest, in which small sites do not move."""
    rng = np.random.default_rng(1)
    spec, starts = smidgen.load_text(SCALED.format(space=space, more=more)), [(unit(rng.normal(size=3)), 10**rng.uniform(0, 1.3)) for _ in range(60)]
    large, small = (list(second(smidgen.build(spec, parameters={"r": [1.0, size]}), starts, size)) for size in sizes)
    assert [status for status, _ in large] == [status for status, _ in small] and len({status for status, _ in large}) > 1
    assert max(np.abs(a - b).max() for (_, a), (_, b) in zip(large, small)) <= (0.02 if more else 1e-9)


def unit(v):
    return v / np.linalg.norm(v)
