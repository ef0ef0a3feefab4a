"""The witness: the numbers of a spec by an independent interpreter, for comparison.

It takes the same resolved `Spec` as the compiler and shares nothing else with it: the
terms are interpreted in C in extended precision with automatic differentiation, the step
equation is solved by GSL's Newton method, and the flow is integrated by GSL's odeiv2.

    one = Witness(spec, parameters={"n": 20})
    w = initial_state(spec, "wave", parameters={"n": 20})
    one.energy(w), one.field(w), one.step(w, t=0.0, h=0.1)
"""
from __future__ import annotations

import ctypes
import functools

import numpy as np

from ...effects.damping import Damping
from ...effects.energy import Energy
from ...effects.held import Held
from ...effects.torque import Torque
from ...errors import RunError, UsageError
from ...language.evaluate import evaluate
from ...language.expr import Op
from ...language.spec import Spec, Term
from ...run.step.evaluated import Evaluated
from . import collocation, compositions, dormand_prince, extrapolation, lie, native, rattle, splittings, thermal
from .program import compile_term, moved_sites


def reference(witness, w, t: float, h: float):
    """The flow by GSL, to which methods with step control come within their tolerance."""
    return witness.flow(w, t, [t + h], tol=1e-14)[0]


EQUATIONS = {"spherical-midpoint": 0, "classical-midpoint": 1, "moser-veselov": 2}      # of midpoints, solved in C
# methods by numpy: name -> function(witness, w, t, h), None where it fails; WITHIN: with the noise of the step after h
STEPPERS = {**{name: reference for name in ("dop853", "dop853-projected")},
            **{f"gauss-{2 * s}": functools.partial(collocation.step, s=s) for s in range(1, 9)},
            "extrapolation-12": functools.partial(extrapolation.step, rows=6), "dormand-prince-8": dormand_prince.step, "axis-splitting": splittings.axes, "sublattice-rotations": splittings.sublattices,
            "pair-rotations": splittings.pairs, "cf4": lie.cf4, **(WITHIN := {"heun": lie.heun, "depondt-mertens": lie.depondt_mertens}), "isospectral-midpoint": lie.isospectral, "geodesic-midpoint": lie.geodesic,
            "exponential-midpoint": lie.exponential, "rattle": rattle.step,
            **{f"{base}-{scheme}": functools.partial(compositions.step, base=base, scheme=scheme)
               for base in (*EQUATIONS, "axis-splitting", "sublattice-rotations", "pair-rotations") for scheme in compositions.HALVES}}
METHODS = (*EQUATIONS, *STEPPERS)
INTEGRATORS = {"rk8pd": 0, "bsimp": 1, "msbdf": 2}
LARGEST_DENSE = 1000    # sites: the Newton matrix of 3*sites unknowns is dense

MEANING = {
    1: "did not converge", 2: "the step equation has no solution here",
    4: "a value is not finite", 5: "an array has no such entry",
    6: "the state lies on the leaf C = 0", 7: "the Newton matrix is singular",
    8: "there is not enough memory",
}


class Witness:
    """The system of `spec` for parameter values `values`, with the effects named.

    seed, member: of thermal noise. States are float64 arrays of shape (sites, 3). Every method raises UsageError for a
    wrong name or shape and RunError (with a status of runtime/core/smidgen.h) where the numbers
    do not exist.
    """

    def __init__(self, spec: Spec, parameters: dict | None = None, effects=None, seed: int = 0, member: int = 0):
        self.spec, self.seed, self.member, self._given = spec, seed, member, (parameters, effects)
        self.numbers = Evaluated(spec, parameters)
        self.values, self.families = self.numbers.values, self.numbers.places
        self.sites = sum(count for _, count in self.families.values())
        self.kappa = self.numbers.kappas
        self._c = native.load()
        chosen = _chosen(spec.effects, effects)
        self.absent, self.still = self._held([e for e in chosen if isinstance(e, Held)])
        self.programs = {e.name: self._program(e) for e in chosen if isinstance(e, Energy)}
        self.dampings = [d for d in chosen if isinstance(d, Damping)]
        self.torques = [self._component(e, axis) for e in chosen if isinstance(e, Torque) for axis in "xyz"]
        self.diffusion = self._diffusion()
        self.terms = {o.name: self._program(o) for o in spec.observables}
        self._system = self._whole()

    def energy(self, w, t: float = 0.0) -> float:
        """H(t, w): the sum of all effects."""
        return float(sum(self.energies(w, t).values()))

    def energies(self, w, t: float = 0.0) -> dict:
        """The energy of each effect, by name."""
        return {name: self._sum(one, w, t) for name, one in self.programs.items()}

    def observables(self, w, t: float = 0.0) -> dict:
        """The value of each observable, by name."""
        return {name: self._sum(one, w, t) for name, one in self.terms.items()}

    def field(self, w, t: float = 0.0) -> np.ndarray:
        """b = (1/kappa) dH/dw, shape (sites, 3); a tracer's effects count on tracers only."""
        return self._evaluate(self._c.witness_field, w, t)

    def turning(self, w, t: float = 0.0) -> np.ndarray:
        """R with w' = orientation * grad C(w) x R, shape (sites, 3): b, and what damping and torques add to it."""
        return self._evaluate(self._c.witness_turning, w, t)

    def damping(self, w) -> tuple[np.ndarray, np.ndarray]:
        """(a, f) of every site: b becomes f (b + (a/|w|) w x b), up to the sign of the second part."""
        alpha, share, _ = self._damped()
        return alpha * np.where(np.isnan(self.numbers.radii), np.linalg.norm(self._state(w), axis=1), 1), share

    def vector_field(self, w, t: float = 0.0) -> np.ndarray:
        """X = w' = orientation * grad C(w) x b, shape (sites, 3), with damping and torques; grad C = w on spheres."""
        return self._evaluate(self._c.witness_vector_field, w, t)

    def jacobian(self, w, t: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """(DX of shape (3*sites, 3*sites), dX/dt of shape (sites, 3))."""
        self._small()
        w, n = self._state(w), 3 * self.sites
        dx, x_dt = np.empty((n, n)), np.empty((self.sites, 3))
        _check(self._c.witness_jacobian(self._system_pointer, t, w.ctypes.data,
                                        dx.ctypes.data, x_dt.ctypes.data), "the derivative")
        return dx, x_dt

    def step(self, w, t: float, h: float, method: str = "spherical-midpoint") -> np.ndarray:
        """The state at t + h after one step of the method."""
        return self.steps(w, t, h, 1, method)[-1]

    def steps(self, w, t0: float, h: float, count: int, method: str = "spherical-midpoint",
              every: int = 1) -> np.ndarray:
        """States after 0, every, 2*every, .. steps: shape (count//every + 1, sites, 3); with the noise of kT, that of the steps from 0 on.

        The step equation is solved to the last bit and the state is kept in extended
        precision between the steps. Raises RunError with the number of steps done.
        """
        self._small()
        if self.diffusion is not None:
            return self._heated(w, t0, h, count, method, every)
        if method in STEPPERS:
            return self._stepped(w, t0, h, count, method, every)
        number = _choose("method", method, EQUATIONS)
        if count < 0 or every < 1:
            raise UsageError("the number of steps must not be negative, and outputs must be at least one step apart")
        w, done = self._state(w), ctypes.c_int64(0)
        out = np.empty((count // every + 1, self.sites, 3))
        status = self._c.witness_steps(self._system_pointer, number, w.ctypes.data, t0, h, count,
                                       every, out.ctypes.data, ctypes.byref(done))
        _check(status, f"step {done.value + 1}", done.value)
        return out

    def _heated(self, w, t0, h, count, method, every):
        """Steps of the system without noise between its two halves."""
        found, calm = [self._state(w)], Witness(self.spec.calm, *self._given)
        for k in range(count):
            w = self._kicked(calm, w, t0 + k * h, h, method, k) if method in WITHIN else self._between(calm, w, t0 + k * h, h, method, k)
            if (k + 1) % every == 0:
                found.append(w)
        return np.array(found)

    def _between(self, calm, w, t, h, method, k):
        """Step k between two halves of noise."""
        w = thermal.heat(self._state(w), self.diffusion, h, self.seed, k, 0, self.member)
        return thermal.heat(calm.step(w, t, h, method), self.diffusion, h, self.seed, k, 1, self.member)

    def _kicked(self, calm, w, t, h, method, k):
        """Step k with the noise in it."""
        kick = np.sqrt(2 * self.diffusion * h)[:, None] * thermal.normals(self.seed, k, self.sites, 0, self.member)
        w = WITHIN[method](calm, self._state(w), t, h, kick)
        _check(1 if w is None else 0, f"step {k + 1}", k)
        return w

    def _stepped(self, w, t0, h, count, method, every):
        found = [self._state(w)]
        for k in range(count):
            w = STEPPERS[method](self, w, t0 + k * h, h)
            _check(1 if w is None else 0, f"step {k + 1}", k)
            if (k + 1) % every == 0:
                found.append(w)
        return np.array(found)

    def residual(self, w, after, t: float, h: float,
                 method: str = "spherical-midpoint") -> float:
        """max |F(W - w)| of the step equation for a step w -> W = `after` taken elsewhere."""
        return float(np.abs(self.residuals([w, after], t, h, method)).max())

    def residuals(self, states, t0: float, h: float, method: str = "spherical-midpoint") -> np.ndarray:
        """F(W - w) of every step between states (count + 1, sites, 3) taken elsewhere: (count, sites, 3)."""
        number, states = _choose("method", method, EQUATIONS), np.ascontiguousarray([self._state(w) for w in states])
        out = np.empty((len(states) - 1, self.sites, 3))
        _check(self._c.witness_residuals(self._system_pointer, number, t0, h, len(out), states.ctypes.data,
                                         out.ctypes.data), "the residual")
        return out

    def equation(self, w, d, t: float, h: float, method: str = "spherical-midpoint"):
        """(F(d), F'(d)) of the step equation from w: shapes (sites, 3) and (3*sites, 3*sites)."""
        self._small()
        number, w, n = _choose("method", method, EQUATIONS), self._state(w), 3 * self.sites
        d = np.ascontiguousarray(d, dtype=float).reshape(w.shape)
        f, jacobian = np.empty((self.sites, 3)), np.empty((n, n))
        _check(self._c.witness_equation(self._system_pointer, number, t, h, w.ctypes.data, d.ctypes.data,
                                        f.ctypes.data, jacobian.ctypes.data), "the step equation")
        return f, jacobian

    def flow(self, w, t0: float, times, integrator: str = "rk8pd",
             tol: float = 1e-13) -> np.ndarray:
        """The exact solution at `times` (monotone, from t0 on): shape (len(times), sites, 3).

        integrator: "rk8pd" (explicit, order 8), "bsimp" (implicit extrapolation) or "msbdf";
        tol bounds the local error, relative to each component and to the largest one of the start.
        """
        number = _choose("integrator", integrator, INTEGRATORS)
        if number:
            self._small()
        y, times = self._state(w).copy(), np.ascontiguousarray(times, dtype=float)
        out = np.empty((len(times), self.sites, 3))
        _check(self._c.witness_flow(self._system_pointer, number, tol, t0, y.ctypes.data,
                                    times.ctypes.data, len(times), out.ctypes.data), "the flow")
        return out

    def _program(self, term):
        one = compile_term(self.spec, term, self.values, self.families, self.absent)
        instances, slots = one.site.shape
        one.struct = native.ProgramStruct(
            len(one.code), slots, one.data.shape[1], instances, *(
                a.ctypes.data for a in (one.code, one.site, one.data, one.table, one.feels)))
        return one

    def _component(self, torque, axis):
        """(the program of one component, the sites that it moves, its number)."""
        one = self._program(Term(torque.name, torque.over, Op(axis, (torque.value,))))
        return one, moved_sites(torque, self.values, self.families, self.absent), "xyz".index(axis)

    def _whole(self):
        programs = [one.struct for one in self.programs.values()]
        self._structs = (native.ProgramStruct * max(1, len(programs)))(*programs)
        self._pushes = (native.PushStruct * max(1, len(self.torques)))(*((one.struct, moved.ctypes.data, axis) for one, moved, axis in self.torques))
        radius = self.numbers.radii
        self._arrays = [np.ascontiguousarray(a, dtype=float) for a in (
            self.kappa, self.numbers.casimir_matrices,
            radius * radius / 2, *self._damped())]
        system = native.SystemStruct(
            self.sites, len(programs), len(self.torques), ctypes.addressof(self._structs), ctypes.addressof(self._pushes),
            *(a.ctypes.data for a in self._arrays), self.spec.orientation)
        self._system_pointer = ctypes.addressof(system)
        return system

    def _damped(self):
        """(alpha, what the motion is multiplied by, does damping act on torques too), each of shape (sites,)."""
        alpha, share, lag = np.zeros(self.sites), np.ones(self.sites), np.zeros(self.sites)
        for d in self.dampings:
            first, count = self.families[d.over.family]
            here = slice(first, first + count)
            alpha[here] = evaluate(d.alpha, {**self.values, d.over.index: np.arange(count)})
            share[here] = 1 / (1 + alpha[here]**2) if d.form == "gilbert" else 1
            lag[here] = d.form == "gilbert"
        alpha[self.still] = share[self.still] = 0
        return alpha, share, lag

    def _held(self, held):
        """(is each site absent, does it stay where it is), each of shape (sites,)."""
        absent, still = np.zeros(self.sites, bool), np.zeros(self.sites, bool)
        for h in held:
            first, count = self.families[h.over.family]
            here = np.broadcast_to(evaluate(h.where, {**self.values, h.over.index: np.arange(count)}), count)
            still[first:first + count] |= here
            absent[first:first + count] |= here & h.gone
        for f in (f for f in self.spec.families if f.fixed):
            still[self.families[f.name][0]:sum(self.families[f.name])] = True
        return absent, still

    def _diffusion(self):
        """D of every site, (sites,); None without noise."""
        if all(d.kT is None for d in self.dampings):
            return None
        (alpha, share, _), found = self._damped(), np.zeros(self.sites)
        for d in (d for d in self.dampings if d.kT is not None):
            first, count = self.families[d.over.family]
            here, radius = slice(first, first + count), self.numbers.radii[first:first + count]
            kT = evaluate(d.kT, {**self.values, d.over.index: np.arange(count)})
            found[here] = share[here] * alpha[here] * np.where(self.still[here], 0, kT) / (np.abs(self.kappa[here]) * np.where(np.isnan(radius), 1, radius))
        return found

    def _sum(self, one, w, t):
        w, total = self._state(w), ctypes.c_double(0)
        _check(self._c.witness_sum(ctypes.addressof(one.struct), self.sites, t, w.ctypes.data,
                                   ctypes.byref(total)), one.name)
        return total.value

    def _evaluate(self, function, w, t):
        w, out = self._state(w), np.empty((self.sites, 3))
        _check(function(self._system_pointer, t, w.ctypes.data, out.ctypes.data), "the field")
        return out

    def _state(self, w):
        array = np.ascontiguousarray(w, dtype=float)
        if array.shape != (self.sites, 3):
            raise UsageError(f"a state of {self.spec.name} has shape ({self.sites}, 3), "
                             f"not {np.shape(w)}")
        return self._put_away(array) if self.absent.any() else array

    def _put_away(self, w):
        """With absent sites where they are kept, at (0, 0, r)."""
        radius = self.numbers.radii[self.absent]
        w = w.copy()
        w[self.absent], w[self.absent, 2] = 0, np.where(np.isnan(radius), 1, radius)
        return w

    def _small(self):
        if self.sites > LARGEST_DENSE:
            raise UsageError(f"the witness uses a dense Newton matrix and takes at most {LARGEST_DENSE} "
                             f"sites, not {self.sites}; choose a smaller size")


def _chosen(terms, names):
    """The terms of these names, in the order of the spec; None means all."""
    known = [t.name for t in terms]
    for name in names or ():
        if name not in known:
            raise UsageError(f"no effect '{name}'; there are: {', '.join(known)}")
    return [t for t in terms if names is None or t.name in names]


def _choose(what, name, known):
    if name not in known:
        raise UsageError(f"no {what} '{name}'; the witness has: {', '.join(known)}")
    return known[name]


def _check(status, what, step=0):
    if status:
        raise RunError(f"witness, {what}: {MEANING.get(status, status)}", status, step)
