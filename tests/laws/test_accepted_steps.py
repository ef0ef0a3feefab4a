"""What a step returns solves W - w = h X(m) to round-off, whatever solver it came from; beyond a fold nothing is accepted,
and before it nothing is refused.

The judge knows the field of the log energies H = -sum k_i k_j log(2 - 2 w_i.w_j)/(4 pi) by its formula, in extended
precision, and takes from the generated code only w and W. Round-off is what the equation itself shows: how far its
residual moves when W does by an ulp. Where a pair's fold is known (tests/hard/vortices.py) it decides; elsewhere
the solver with a factored matrix does.
"""
import numpy as np
import pytest

import smidgen
from smidgen.errors import RunError
from smidgen.read import load_text

TEXT = """
[model]
name = "log_vortices"
[space]
w = {{ sphere = {count}, kappa = "k[i]" }}
[parameters]
nx = {{ default = {nx}, fixed = true }}
ny = {{ default = {ny}, fixed = true }}
k = {{ default = 1.0, size = {count} }}
[effects.interaction]
over = "{over}"
energy = "-k[i]*k[j]*log(2 - 2*dot(w[i], w[j]))/(4*pi)"
[starts.any]
random = 1
"""
REAL = np.longdouble
SOLVERS = ("auto", "newton", "rotation", "plain")
ULP = 2.0**-52
ULPS = 40       # times what an ulp of W moves: what a residual may be
long = pytest.mark.long
assert np.finfo(REAL).eps < 1e-18, "the judge needs extended precision"


class System:
    """Vortices of strengths k: all pairs, or the bonds of a square lattice of nx by ny."""

    def __init__(self, k, solver, square=None):
        self.k, (nx, ny) = np.asarray(k, float), square or (1, 1)
        count, over = ('"nx*ny"', "bond(i, j) of square(nx, ny, periodic)") if square else (len(k), "pair(i, j) of w")
        spec = load_text(TEXT.format(count=count, nx=nx, ny=ny, over=over))
        self.model = smidgen.build(spec, solver=solver, parameters={"k": list(map(float, k))})
        self.i, self.j = bonds(nx, ny) if square else np.triu_indices(len(k), 1)

    def step(self, w, h):
        """W; None where the step is refused, for a reason that `status` tells."""
        try:
            self.model.start(w.copy(), h=h).step()
        except RunError as refusal:
            self.status = refusal.status
            return None
        return self.model.w.copy()

    def pull(self, m):
        """b_i = sum_j k_j m_j/(4 pi (1 - m_i.m_j)) over the bonds of i."""
        size = 1 / (4 * REAL(np.pi) * (1 - (m[self.i] * m[self.j]).sum(axis=1)))
        b = np.zeros_like(m)
        np.add.at(b, self.i, (self.k[self.j] * size)[:, None] * m[self.j])
        np.add.at(b, self.j, (self.k[self.i] * size)[:, None] * m[self.i])
        return b

    def residual(self, w, W, h):
        """max |W - w - h m x b(m)|, m = (w + W)/|w + W|, in extended precision."""
        m = w.astype(REAL) + W.astype(REAL)
        m /= np.sqrt((m * m).sum(axis=1))[:, None]
        return float(np.abs(W.astype(REAL) - w - h * np.cross(m, self.pull(m))).max())

    def solves(self, w, W, h, dice):
        noise = [self.residual(w, W * (1 + ULP * dice.choice([-1, 1], W.shape)), h) for _ in range(4)]
        return self.residual(w, W, h) <= ULPS * max(*noise, ULP)


def bonds(nx, ny):
    """The two sites of each nearest-neighbour bond; site x + nx*y."""
    x, y = np.meshgrid(np.arange(nx), np.arange(ny), indexing="ij")
    here = (x + nx * y).ravel()
    return np.tile(here, 2), np.concatenate([((x + 1) % nx + nx * y).ravel(), (x + nx * ((y + 1) % ny)).ravel()])


def unit(w):
    return w / np.linalg.norm(w, axis=1)[:, None]


def pair(a):
    return np.array([[np.sin(a), 0, np.cos(a)], [-np.sin(a), 0, np.cos(a)]])


def ring(n, a):
    angle = 2 * np.pi * np.arange(n) / n
    return np.stack([np.sin(a) * np.cos(angle), np.sin(a) * np.sin(angle), np.full(n, np.cos(a))], axis=1)


def fold(a):
    """The largest h of an equal pair at half-angle a: sin(phi) = h/(4 pi sin a tan a) = 1."""
    return 4 * np.pi * np.sin(a) * np.tan(a)


@pytest.mark.parametrize("angles", [4, pytest.param(18, marks=long)])
@pytest.mark.parametrize("solver", ["auto", "newton", "rotation", "plain"])
def test_a_pair_beyond_its_fold_is_refused_and_before_it_is_not(solver, angles):
    """30 steps beyond the fold an angle, from half-angles of 1e-3 on; among them those where both midpoints collapse."""
    system, dice = System([1, 1], solver), np.random.default_rng(1)
    for a in np.geomspace(1e-3, 1.2, angles):
        w, end = pair(a), fold(a)
        beyond = [*np.linspace(1.0001, 1.2, 10), *np.geomspace(1.3, 1000, 20)]
        assert [part for part in beyond if system.step(w, part * end) is not None] == []
        for part in (0.01, 0.3, 0.7, 0.9, 0.99, 0.999, 0.9999):
            W = system.step(w, part * end)
            assert W is not None and system.solves(w, W, part * end, dice), (a, part)


@pytest.mark.parametrize("n, trials", [(3, 2), *(pytest.param(n, 6, marks=long) for n in (3, 4, 6))])
def test_all_solvers_take_the_same_steps(n, trials):
    """Random vortices of both signs, some close together: what one solver takes the others take, to the same W."""
    dice = np.random.default_rng(n)
    taken = refused = 0
    for trial in range(trials):
        k = dice.choice([1, -1, 0.5, 2], size=n)
        systems = [System(k, solver) for solver in SOLVERS]
        for _ in range(20):
            w = unit(dice.normal(size=(n, 3)) + np.array([0, 0, dice.choice([0, 5])]))
            h = 10 ** dice.uniform(-2.5, 1.5)
            found = [s.step(w, h) for s in systems]
            assert len({W is None for W in found}) == 1
            if found[0] is None:
                refused += 1
                continue
            taken += 1
            assert all(systems[0].solves(w, W, h, dice) for W in found)
            assert max(np.abs(W - found[0]).max() for W in found) < 1e-9
    assert taken > 1.5 * trials and refused > 1.5 * trials


@long
@pytest.mark.parametrize("bent", [0, 1e-3])
@pytest.mark.parametrize("n, a", [(5, 0.1), (8, 0.5), (12, 1.0)])
def test_a_ring_ends_at_the_same_step_for_all_solvers(n, a, bent):
    """Also where the ring, exactly symmetric, goes on as a solution beyond the first singular J."""
    dice = np.random.default_rng(3)
    w = unit(ring(n, a) + bent * dice.normal(size=(n, 3)))
    systems = {solver: System(np.ones(n), solver) for solver in SOLVERS}
    low, high = 1e-6, 1e2
    while high > (1 + 1e-7) * low:
        h = np.sqrt(low * high)
        low, high = (low, h) if systems["newton"].step(w, h) is None else (h, high)
    for system in systems.values():
        assert all(system.step(w, part * high) is None for part in np.linspace(1.001, 3, 15))
        for part in np.linspace(0.05, 0.999, 8):
            W = system.step(w, part * low)
            assert W is not None and system.solves(w, W, part * low, dice)


def with_pair(w, i, j, a):
    """The states w with sites i and j made a pair at half-angle a about the z axis."""
    w = w.copy()
    w[[i, j]] = pair(a)
    return w


@pytest.mark.long
@pytest.mark.parametrize("solver", ["rotation", "plain"])
def test_a_lattice_of_log_bonds(solver):
    """A close pair on a bond ends the step near its own fold; random states in steps of every size."""
    dice, size = np.random.default_rng(5), (6, 5)
    system, judge = System(np.ones(30), solver, size), System(np.ones(30), "rotation" if solver == "plain" else "plain", size)
    spread = unit(dice.normal(size=(30, 3)) - np.array([0, 0, 1.5]))
    w = with_pair(spread, 7, 8, 0.02)
    assert all(system.step(w, part * fold(0.02)) is None for part in (1.1, 1.5, 3, 10, 100, 1000))
    for part in (0.1, 0.5, 0.9):
        W = system.step(w, part * fold(0.02))
        assert W is not None and system.solves(w, W, part * fold(0.02), dice)
    for _ in range(60):
        w, h = unit(dice.normal(size=(30, 3))), 10 ** dice.uniform(-3, 2)
        W, other = system.step(w, h), judge.step(w, h)
        assert (W is None) == (other is None)
        assert W is None or (system.solves(w, W, h, dice) and np.abs(W - other).max() < 1e-9)
        assert W is None or np.abs((W - w).sum(axis=0)).max() < 1e-12


@pytest.mark.long
@pytest.mark.parametrize("solver", ["auto", "plain"])
def test_many_vortices(solver):
    """301, for which `auto` takes sweeps: a close pair among them ends the step near its own fold."""
    dice = np.random.default_rng(6)
    far = unit(dice.normal(size=(1500, 3)))
    system = System(np.ones(301), solver)
    w = with_pair(far[far[:, 2] < 0.9][:301], 0, 1, 2e-4)
    for part in (1.2, 10, 1000):
        assert system.step(w, part * fold(2e-4)) is None
    for part in (0.1, 0.5, 0.8):
        W = system.step(w, part * fold(2e-4))
        assert W is not None and system.solves(w, W, part * fold(2e-4), dice)
