"""Steps whose equation has several solutions end in the one connected to h = 0, or in a refusal.

The guess is put on another solution: the newest increment of the history is made to lead there, so
that the predictor begins where no orbit would take it. Every solver must leave that place or say no.
"""
import functools
import itertools
import subprocess
from math import asin, cos, pi, sin, tan

import numpy as np
import pytest

import smidgen
from smidgen.compile.emit.emit import generate
from smidgen.errors import RunError
from smidgen.read import load_text
from smidgen.resources import include_flags

OK, WRONG_BRANCH = 0, 3

# -- two spins in which Newton's iteration leads elsewhere ---------------------------------------

STRAYS = """
[model]
name = "strays"
[space]
w = { sphere = 2 }
[parameters]
a = 0.0
b = 0.0
c = 0.0
d = 0.0
e = 0.0
f = 0.0
[effects.own]
over = "site(i) of w"
energy = "a*w[i].x^2 + b*w[i].y^2*w[i].z + c*w[i].z^4 + d*w[i].x*w[i].y + e*w[i].y + f*w[i].x^3"
[effects.pair]
over = "pair(i, j) of w"
energy = "f*dot(w[i], w[j]) + a*w[i].x*w[j].x"
"""
# steps, h, parameters, w: found among 60,000 random orbits. In the last step J is coercive at a solution on another branch, with row sums below 4; and what
# the name says happens there
ORBITS = {
    "slow residuals": (1, 1.3636302760106398, [-1.1800553126659912, -0.29341022213755208, -0.60581064500231063, 0.12138818132288343, 0.71432718986891253, 0.079354082850621843],
        [[-0.77266620428822619, -0.63359691547701802, 0.039266849234864877], [0.21792752273600824, 0.24842535725660278, -0.94381801037386215]]),
    "another solution": (1, 1.1293394341342564, [-0.9038791595372047, 0.9654656043486758, 0.853887161141561, 0.6517987177002047, 0.7695171222339721, -0.643174759852483],
        [[0.5092203249584812, -0.20214894191164562, -0.836558704415405], [-0.9738207405652104, 0.09226302454262222, 0.20775153320077455]]),
    "a fold": (1, 1.0465475000401097, [-1.0753863432980926, 0.1903427177543635, -0.5897688308199802, -0.029458856732450966, 1.0541796834063135, 0.5117026561434523],
        [[0.18472311451708334, -0.9823562760499415, -0.0292150281259434], [-0.4576192883078273, -0.5615232069570578, 0.6894028394322863]]),
    "a fold nearby": (1, 0.8187176307549813, [0.45046716111420393, -0.6719248976893195, -1.2007649635597824, -0.5404315395469868, -0.5829444328779031, 0.49644402841529556],
        [[-0.45376058072690234, -0.7919505236569403, -0.40855318314496397], [0.2586063057920257, -0.17251700528214642, 0.9504528717895913]]),
    "a start where J is not coercive": (2, 0.8543912223309902, [-0.3171152595017773, 0.2630425653046864, 0.6441170427604033, 1.2720819142931827, 0.5911956994699152, 1.2231639765359665],
        [[-0.42581479494961216, -0.6264768032536028, -0.652846517481074], [-0.09564412116702856, 0.9198460195933276, 0.3804411943053727]]),
    "a predictor that leads astray": (2, 1.3886030348562222, [0.9169573320298705, -0.6536917758723005, 0.9903021785372073, -0.2804382730586985, 0.1470724692261427, -0.37010804123284],
        [[-0.9807205595093048, 0.1952365310007074, -0.008359492721833527], [-0.7421531277258359, 0.1545963821371433, 0.6521569547561887]]),
}


def gradient(m, a, b, c, d, e, f):
    (x, y, z), other = m.T, m[::-1].T
    return np.array([2*a*x + d*y + 3*f*x**2 + (f + a)*other[0], 2*b*y*z + d*x + e + f*other[1], b*y**2 + 4*c*z**3 + f*other[2]]).T


def residual(mbar, w, h, parameters):
    mbar = mbar.reshape(2, 3)
    m = mbar / np.linalg.norm(mbar, axis=1)[:, None]
    return (w + h/2*np.cross(m, gradient(m, *parameters)) - mbar).ravel()


def continued(w, h, parameters, parts=100):
    """W on the branch of W = w at h = 0, by continuation in h; None beyond a fold."""
    y, signs = w.ravel().copy(), set()
    for part in range(1, parts + 1):
        for _ in range(4):
            J = np.array([residual(y - 1e-6*e, w, h*part/parts, parameters) - residual(y + 1e-6*e, w, h*part/parts, parameters) for e in np.eye(6)]).T / 2e-6
            y = y + np.linalg.solve(J, residual(y, w, h*part/parts, parameters))
        signs.add(np.sign(np.linalg.det(J)))
        if len(signs) > 1 or np.abs(residual(y, w, h*part/parts, parameters)).max() > 1e-9:
            return None
    return 2*y.reshape(2, 3) - w


@functools.cache
def strays(solver):
    return smidgen.build(load_text(STRAYS), solver=solver)


@pytest.mark.parametrize("name", ORBITS)
@pytest.mark.parametrize("solver", ["newton", "auto"])
def test_a_coercive_solution_is_not_always_that_of_the_branch(name, solver):
    steps, h, parameters, start = ORBITS[name]
    model = strays(solver)
    model.set_parameters(dict(zip("abcdef", parameters)))
    model.start(np.array(start), h=h)
    assert model.advance(steps - 1) == steps - 1
    W = continued(model.w.copy(), h, parameters)
    assert (W is None) == ("fold" in name)
    if W is None:
        assert model.advance(1) == 0
    else:
        assert np.abs(model.step().w - W).max() < 1e-5


# -- one top: three solutions -------------------------------------------------------------------

TOP = """
[model]
name = "top"
[space]
w = {{ sphere = 1{radius} }}
[effects.axis]
energy = "w.z^2/2"
[starts.any]
random = 1
"""
TOPS = {"one unit sphere": ("", 1.0), "another radius": (", radius = 1.5", 1.5)}


ROW = """
[model]
name = "pairs"
[space]
w = { sphere = "n" }
[parameters]
n = 4
J = 0.0
[effects.axis]
over = "site(i) of w"
energy = "w[i].z^2/2"
[effects.bond]
over = "bond(i, j) of chain(n, open)"
energy = "J*dot(w[i], w[j])"
"""


def tangents(z, h):
    """t = tan(phi/2) of every solution W = R(phi) w of a unit top with w.z = z, ascending.

    2 tan(phi/2) (z^2 + (1 - z^2) cos^2(phi/2)) = h z, that is z^2 t^3 - (h z/2) t^2 + t - h z/2 = 0.
    """
    found = np.roots([z * z, -h * z / 2, 1, -h * z / 2])
    return np.sort(found[np.abs(found.imag) < 1e-9].real)


@pytest.mark.parametrize("which, count", [("another radius", 800), *(pytest.param(which, 2000, marks=pytest.mark.long) for which in TOPS)])
def test_a_top_takes_the_smallest_of_three_angles(which, count):
    """From rest, at steps far beyond the fold too: the first solution, or none."""
    radius, size = TOPS[which]
    one, dice = smidgen.build(load_text(TOP.format(radius=radius))), np.random.default_rng(3)
    taken = refused = 0
    for _ in range(count):
        z, h = 10 ** dice.uniform(-2, -0.3), 10 ** dice.uniform(0, 3)
        t = tangents(z, h * size)
        start = size * np.array([[np.sqrt(1 - z * z), 0, z]])
        try:
            after = one.start(start, h=h).step().w[0]
        except RunError:
            refused += 1
            assert len(t) == 1      # the branch has folded, what is left lies elsewhere
            continue
        angle = abs(np.arctan2(after[1], after[0]))
        assert angle == pytest.approx(2 * np.arctan(t[0]), abs=1e-7)    # near a fold half the digits are lost
        taken += len(t) == 3
    assert taken > count / 10 and refused > count / 10


@pytest.mark.parametrize("solver", [pytest.param("auto", marks=pytest.mark.long), "rotation", "newton", "plain"])
def test_a_row_of_tops_led_to_another_angle(solver, tmp_path):
    """h z/2 = 0.3 with z = 0.1 has three angles; one top of four that a bond of no strength joins is led to the
    second or third, which the turning of the tops about their own axis alone decides."""
    z, h = 0.1, 6.0
    t, r = tangents(z, h), np.sqrt(1 - z * z)
    turned = [np.array([r * np.cos(a), -r * np.sin(a), z]) for a in 2 * np.arctan(t)]
    w = np.tile([r, 0, z], (4, 1))
    program, right = compiled(generate(load_text(ROW), solver=solver), w.size, tmp_path), np.tile(turned[0], (4, 1))
    for which in (1, 2):
        led = np.array([turned[0], turned[which], turned[0], turned[0]])
        status, after = step_of(program, w, led - w, h)
        distance = np.abs(after - (right if status == OK else w)).max()
        assert status == OK or solver in ("rotation", "plain"), which      # these two cannot follow a branch so far
        assert distance < 1e-12 if status == OK else distance == 0, which


# -- pairs of vortices: two solutions -----------------------------------------------------------

PAIR = "-log(2 - 2*dot(w[i], w[j]))/(4*pi)"
HEAD = '[model]\nname = "pairs"\n[space]\nw = {{ sphere = {n} }}\n{more}[effects.interaction]\nover = "{over}"\n' \
       'energy = "{energy}"\n[starts.any]\nrandom = 1\n'
SOLVERS = {     # solver asked for -> (solver chosen, pairs, model)
    "dense": ("auto", 2, HEAD.format(n=4, more="", over="edge(i, j, k) of g", energy="k*" + PAIR)),
    "band": ("newton", 3, HEAD.format(n='"n"', more="[parameters]\nn = 6\n", over="bond(i, j) of chain(n, open)",
                                      energy="(1 - mod(i, 2))*" + PAIR)),
    "sparse": ("newton", 8, HEAD.format(n=16, more="", over="edge(i, j, k) of g", energy="k*" + PAIR)),
    "rotation": ("rotation", 2, HEAD.format(n=4, more="", over="edge(i, j, k) of g", energy="k*" + PAIR)),
    "plain": ("plain", 2, HEAD.format(n=4, more="", over="edge(i, j, k) of g", energy="k*" + PAIR)),
}
DRIVER = """
#include "pairs.c"
#include <stdio.h>
int main(void) {{
  static double mem[1000000], h, w[{size}], u[{size}];
  pairs_params p; pairs_model model; pairs_state s;
  pairs_defaults(&p);
  if (scanf("%lf", &h) != 1) return 4;
  for (int k = 0; k < {size}; ++k) if (scanf("%lf", w + k) != 1) return 4;
  for (int k = 0; k < {size}; ++k) if (scanf("%lf", u + k) != 1) return 4;
  if (pairs_model_init(&model, &p) != SMG_OK || pairs_init(&s, &model, mem, w, 0, h) != SMG_OK) return 2;
  for (int k = 0; k < {size}; ++k) s.past[0][k] = u[k];
  s.history = 1;
  s.degree = 0;
  printf("%d", (int)pairs_step(&s));
  for (int k = 0; k < {size}; ++k) printf(" %.17g", s.w[k]);
  return 0;
}}
"""


def pair(a, angle):
    """Two vortices about the z axis at colatitude a, turned by -angle."""
    x, y = sin(a) * cos(angle), -sin(a) * sin(angle)
    return [[x, y, cos(a)], [-x, -y, cos(a)]]


def program_of(solver, place):
    """The program of a solver's pairs."""
    asked, pairs, text = SOLVERS[solver]
    (place / "edges.csv").write_text("i,j,k\n" + "".join(f"{2 * k},{2 * k + 1},1\n" for k in range(pairs)))
    (place / "model.toml").write_text(text.replace("[effects", '[graphs.g]\nfile = "edges.csv"\n[effects', 1)
                                      if "of g" in text else text)
    files = generate(smidgen.load(place / "model.toml"), solver=asked)
    assert files.notes["solver"] == solver
    return compiled(files, 6 * pairs, place)


def compiled(files, size, place):
    """The program of the model `pairs` with so many components; it reads h, w and u."""
    for name, content in {**files, "main.c": DRIVER.format(size=size)}.items():
        (place / name).write_text(content)
    subprocess.run(["gcc", "-O1", "-std=c11", "-ffp-contract=off", *include_flags(), "-I.", "main.c", "-lm",
                    "-o", "program"], cwd=place, check=True)
    return place / "program"


def step_of(program, w, u, h):
    """(status, W) of one step whose prediction is w + u."""
    numbers = " ".join(repr(float(x)) for v in (h, w, u) for x in np.ravel(v))
    said = subprocess.run([program], input=numbers, capture_output=True, text=True, check=True).stdout.split()
    return int(said[0]), np.array(said[1:], float).reshape(np.shape(w))


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_pair_led_to_its_second_solution(solver, tmp_path):
    """sin(theta) = h/(4 pi sin(a) tan(a)): theta is connected to h = 0, pi - theta is not; one pair or two
    are led to the latter, the others to the former. Where the sine is 0.9 both are so near that row sums allow either, and
    only the symmetric part of the matrix tells."""
    a, pairs, program = 0.15, SOLVERS[solver][1], program_of(solver, tmp_path)
    w = np.concatenate([pair(a, 0)] * pairs)
    for sine, wrong in itertools.product((0.53, 0.9), (1, 2)):
        theta, h = asin(sine), 4 * pi * sine * sin(a) * tan(a)
        right = np.concatenate([pair(a, theta)] * pairs)
        led = np.concatenate([pair(a, pi - theta)] * wrong + [pair(a, theta)] * (pairs - wrong))
        status, after = step_of(program, w, led - w, h)
        distance = np.abs(after - (right if status == OK else w)).max()
        assert status in (OK, WRONG_BRANCH), wrong
        assert distance < 1e-12 if status == OK else distance == 0, wrong
