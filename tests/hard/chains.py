r"""Chains: stiff, large, and spin waves

*Spin waves.* H = -J sum w_i.w_{i+1} - K sum z_i^2 - B sum z_i, strength kappa: about w = e_z the field is
-(1/kappa)(2 J cos k u, 2 J + 2 K + B), so u = x + i y rotates with kappa omega = 2 J (1 - cos k) + 2 K + B, without damping.
At any polar angle theta the helix u_j = sin(theta) exp(i k j), z_j = cos(theta) rotates rigidly with

    kappa omega(z) = (2 J (1 - cos k) + 2 K) z + B.

By symmetry a step rotates it by an angle phi. Its midpoint has the height z/rho, rho^2 = 1 - sin^2(theta) sin^2(phi/2), and the length
of the increment gives

    tan(phi/2) = (h/(2 rho)) omega(z/rho);      theta -> 0:    tan(phi/2) = h omega/2.

*Stiff chains.* This is the Landau-Lifshitz equation on n points with h/ds^2 = 16. Fixed-point iteration does not converge there, but Newton's method does.
"""
import json
import subprocess
import sys
from math import atan, cos, pi, sin

import mpmath as mp
import numpy as np
from support.systems import load as shipped

import smidgen
from smidgen.check.witness import Witness

from .case import EPS, Row, attempt, below, between, case, near, same, same_bits, status_of, typed
from .geometry import build, largest, load, polar, turns

N = 24


def helix(k, theta):
    """u_j = sin(theta) exp(i k j)."""
    return polar(theta, k * np.arange(N))


def omega(k, z, J, K, B, kappa):
    """Rate of the helix at height z."""
    return ((2 * J * (1 - cos(k)) + 2 * K) * z + B) / kappa


def discrete(h, k, theta, *values):
    """phi of the step of a helix."""
    z, r2 = mp.cos(theta), mp.sin(theta)**2
    rho = lambda phi: mp.sqrt(1 - r2 * mp.sin(phi / 2)**2)
    law = lambda phi: mp.sin(phi / 2) - mp.cos(phi / 2) * h / (2 * rho(phi)) * omega(k, z / rho(phi), *values)
    return mp.findroot(law, (mp.mpf(0), mp.pi), solver="anderson", tol=1e-40)


@case("spin waves of a chain")
def dispersion():
    """The discrete frequency is exact at every wave number, for small and large amplitudes. It tends to that of the flow as h goes to 0, and there is no damping."""
    # broken by: a neighbour missed at the wrap, a factor 2 of K, kappa left out, a midpoint off the sphere, damping
    values = (1.0, 0.3, 0.2, 1.5)
    model = build("spin_wave", n=N, **dict(zip(("J", "K", "B", "kappa"), values)))
    for h in (0.1, 1.0):
        for theta in (1e-6, 0.6):
            worst, height = 0.0, 0.0
            for p in range(N // 2 + 1):
                k = 2 * pi * p / N
                w = helix(k, theta)
                model.start(w.copy(), h=h).step()
                worst = max(worst, largest(turns(w, model.w) - float(discrete(h, k, theta, *values))))
                height = max(height, largest(np.hypot(model.w[:, 0], model.w[:, 1]) / sin(theta) - 1))
            yield below(f"h = {h}, theta = {theta}: error of the angle of a step, largest of {N // 2 + 1} wave numbers", worst, 32 * EPS)
            yield below(f"h = {h}, theta = {theta}: change of the amplitude", height, 32 * EPS)
    for p in (1, 7, 12):
        k = 2 * pi * p / N
        w, found = helix(k, 1e-6), []
        for count in (100, 200, 400):
            model.start(w.copy(), h=0.5 / count).steps(count)
            found.append(2 * turns(w, model.w).mean())
        better = [(4 * b - a) / 3 for a, b in zip(found, found[1:])]
        yield near(f"k = 2 pi {p}/{N}: omega, from h to 0", (16 * better[1] - better[0]) / 15, omega(k, 1.0, *values), 1e-9)


@case("spin waves with a stiff easy axis")
def stiff_axis():
    """For K h up to 1e4, the angle of a helix in one step is exact, and that of a small wave is 2 atan(h omega/2)."""
    # broken by: an iteration that contracts only for K h < 1, a Newton matrix without the anisotropy
    h, k = 1.0, 2 * pi * 3 / N
    for K in (10.0, 1e2, 1e4):
        values = (1.0, K, 0.0, 1.0)
        model = build("spin_wave", n=N, J=1.0, K=K, B=0.0, kappa=1.0)
        for theta in (1e-6, 0.3, 1.0):
            w = helix(k, theta)
            error = attempt(model.start(w.copy(), h=h))
            found = turns(w, model.w) if error is None else np.full(N, np.nan)
            exact = float(discrete(h, k, theta, *values))
            yield below(f"K h = {K:g}, theta = {theta:g}: error of the angle {exact:.10f}", largest(found - exact), 64 * EPS)
        yield near(f"K h = {K:g}: angle of a small wave, as for the Cayley map", float(discrete(h, k, 1e-6, *values)), 2 * atan(h * omega(k, 1.0, *values) / 2), 1e-6)


@case("a stiff easy axis over many steps")
def stiff_axis_long():
    """With K h = 50 and 1e4 and a different angle for every spin, every step is solved, and sum z is conserved. The energy error
    is within the range of the exchange energy, 2 J n, because without exchange a step conserves every z."""
    # broken by: sweeps without Newton (no convergence), a stop that is relative to the field, damping (n K = 240000 to lose)
    for K, h, count in ((100.0, 0.5, 500), (1e4, 1.0, 500)):
        values = {"n": N, "J": 1.0, "K": K, "B": 0.0, "kappa": 1.0}
        one, interpreter, what = build("spin_wave", **values), Witness(load("spin_wave"), values), f"K h = {K * h:g}"
        i = np.arange(N)
        one.start(polar(0.7 + 0.3 * np.sin(6 * pi * i / N), 2 * pi * i / N), h=h)
        energy, spin, errors, left = one.energy(), one.w[:, 2].sum(), [], 0.0
        for n in range(count):
            before = one.w.copy()
            if attempt(one) is not None:
                break
            errors.append(abs(one.energy() - energy))
            rho = np.linalg.norm(before + one.w, axis=1).min() / 2
            left = max(left, interpreter.residual(before, one.w, n * h, h) / (EPS * (1 + 2 * h * (K + 1) / rho))) if n < 50 else left
        yield same(f"{what}: steps", one.count, count)
        yield below(f"{what}: residual of fifty steps by the interpreter, in units of round-off", left, 4)
        yield below(f"{what}: energy error", max(errors, default=np.nan), 2 * N, "2 J n")
        yield below(f"{what}: change of sum z", abs(one.w[:, 2].sum() - spin), 4 * EPS * np.sqrt(N * count))


# -- stiff exchange ---------------------------------------------------------------------------------

def stiff(steps_of_ds2, n=100):
    """The Landau-Lifshitz curve at the smooth start, h = steps_of_ds2 ds^2, solved by Newton."""
    i = np.arange(n)
    w = polar(0.7 + 0.3 * np.sin(6 * pi * i / n), 2 * pi * i / n)
    model = smidgen.build(shipped("landau_lifshitz"), parameters={"n": n}, solver="newton")
    return model.start(w, h=steps_of_ds2 * (2 * pi / n)**2)


def stiff_rows(count):
    """Iterations, energy in two halves and momentum over `count` steps."""
    model = stiff(16)
    first, spin = model.energy(), model.w.sum(axis=0)
    span = first - 100 / (2 * pi / 100)**2      # against all parallel: what there is to lose
    iterations, errors = [], []
    for _ in range(count):
        model.step()
        iterations.append(model.report()["iterations"])
        errors.append(abs((model.energy() - first) / span))
    yield below(f"most iterations in any of {count} steps", max(iterations), 6)
    yield below("energy error of the first half, relative to the energy above that of parallel spins", max(errors[:count // 2]), 0.25)
    yield below("energy error of the second half divided by that of the first", max(errors[count // 2:]) / max(errors[:count // 2]), 1.5)
    yield below("change of the total spin", largest(model.w.sum(axis=0) - spin), 4 * 16 * EPS * np.sqrt(100 * count))      # h/ds^2 products of size 1, rounded, a spin and step
    yield below("distance from the spheres", largest(np.sum(model.w**2, axis=1) - 1), 8 * EPS + EPS * np.sqrt(count))


@case("stiff chain, h/ds^2 = 16")
def stiff_chain():
    """Newton's method takes at most six iterations per step. The orbit is bounded, and the energy error has no trend."""
    # broken by: a wrong Jacobian (linear convergence: tens of iterations), a stagnation test that round-off never meets
    yield from stiff_rows(300)


@case("stiff chain, h/ds^2 = 16, long run", tier="long")
def stiff_chain_long():
    """The same holds over ten thousand steps."""
    yield from stiff_rows(10_000)


# -- no convergence ---------------------------------------------------------------------------------

@case("plain iteration where it does not contract")
def not_contracting():
    """If plain iteration is requested by name and does not contract, Newton's method with GMRES solves the step instead. The step agrees with that of Newton's method with a factored band matrix."""
    # broken by: returning the last iterate as a solution, products with another matrix than that of the step
    i = np.arange(N)
    w = polar(0.7 + 0.3 * np.sin(6 * pi * i / N), 2 * pi * i / N)
    plain, newton = (smidgen.build(load("spin_wave"), parameters={"n": N, "J": -1.0}, solver=solver).start(w.copy(), h=1.5)
                     for solver in ("plain", "newton"))
    for name, model in (("plain", plain), ("newton", newton)):
        yield Row(f"h = 1.5, {name}", "ok", status_of(attempt(model)), model.count == 1)
    yield below("difference between the two states", float(np.abs(plain.w - newton.w).max()), 1e-13)
    yield below("residual", plain.report()["residual"], 1e-14)


@case("a step far too large for a rough chain")
def too_large():
    """From the start, and after ten successful steps with their history, the step fails with a status and the state is unchanged. A new start then works."""
    # broken by: the last iterate taken for a solution, a history or a carry spoilt by the failure
    model = build("spin_wave", n=N, J=-1.0)
    w = np.random.default_rng(5).normal(size=(N, 3))
    w /= np.linalg.norm(w, axis=1)[:, None]
    error = attempt(model.start(w.copy(), h=40.0))
    yield typed("h = 40", error)
    yield same_bits("h = 40: state afterwards", model.w, w)
    whole = model.start(w.copy(), h=0.05).steps(20).w.copy()
    yield same_bits("twenty steps with h = 0.05 afterwards, twice", model.start(w.copy(), h=0.05).steps(20).w, whole)


# -- a million spins --------------------------------------------------------------------------------

PROBE = """
import json, math, sys, time
import numpy as np, smidgen
from smidgen.resources import folder
n, count = int(sys.argv[1]), int(sys.argv[2])
t = 2*np.pi*np.arange(n)/n
theta, phi = 0.7 + 0.3*np.sin(3*t), t
w = np.stack([np.sin(theta)*np.cos(phi), np.sin(theta)*np.sin(phi), np.cos(theta)], axis=1)
model = smidgen.build(smidgen.load(folder("specs") / "heisenberg_chain.toml"), parameters={"n": n})
# most memory of this program; that of getrusage begins with what the one that started it had
peak = lambda: 1024 * int(next(x for x in open("/proc/self/status") if x.startswith("VmHWM")).split()[1])
total = lambda w: np.array([math.fsum(column) for column in w.T])
spin = total(w)
model.start(w, h=0.1)
start = time.process_time()
model.steps(count)
took = time.process_time() - start
print(json.dumps({"time": took/(n*count), "peak": peak(),
                  "spin": float(np.abs(total(model.w) - spin).max()),
                  "norm": float(np.abs(np.sum(model.w**2, axis=1) - 1).max())}))
"""


def probe(n, count):
    """Seconds a spin and step, most bytes, change of the total spin, in a process of its own."""
    said = subprocess.run([sys.executable, "-c", PROBE, str(n), str(count)], capture_output=True, text=True, check=True)
    return json.loads(said.stdout)


@case("a million spins", tier="long")
def million():
    """Time and memory are proportional to n, and total spin and norms are conserved."""
    # broken by: a matrix or a table of n^2 (memory 4 times for 2 times the spins, time 10 times), a sum that loses digits with n
    count = 20
    sizes = (100_000, 10 * count), (500_000, 2 * count), (1_000_000, count)
    probe(1000, 1)                                          # generates and compiles: its memory is not that of a run
    found = [probe(n, k) for n, k in sizes]
    yield below("time per spin and step, n = 1e6 over 1e5", found[2]["time"] / found[0]["time"], 2.5)
    yield between("memory added from n = 5e5 to 1e6, over that from 1e5 to 5e5, per spin",
                  (found[2]["peak"] - found[1]["peak"]) / 5e5 / ((found[1]["peak"] - found[0]["peak"]) / 4e5), 0.67, 1.5)
    yield below("bytes added per spin", (found[2]["peak"] - found[1]["peak"]) / 5e5, 1500, "60 vectors")
    for (n, k), one in zip(sizes, found):
        yield below(f"n = {n:g}: change of the total spin", one["spin"], 8 * EPS * np.sqrt(n * k))
        yield below(f"n = {n:g}: distance from the spheres", one["norm"], 16 * EPS)
