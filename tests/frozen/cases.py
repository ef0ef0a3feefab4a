"""Which integrators are frozen: every shipped spec and scene in the sizes that select its layouts, by every method, solver and feature that it is offered."""
from __future__ import annotations

from dataclasses import dataclass

from smidgen.compile.features import EVERYWHERE
from smidgen.methods import METHODS, SOLVERS
from smidgen.resources import scenes, shipped

# Parameters that select another layout than the defaults, or the same one with fewer sites; a spec that is not named here has its defaults alone.
SIZES = {
    "chiral_film": (),          # its layouts and methods are those of film_pulse
    "cubic_lattice": ({"nx": 4, "ny": 4, "nz": 4}, {"nx": 5, "ny": 4, "nz": 3}),
    "film_in_units": ({"n": 4},),
    "film_pulse": ({"n": 4}, {"n": 5, "kT": 0.0}),
    "heisenberg_chain": ({"n": 5}, {"n": 32}, {"n": 45}),
    "honeycomb": ({"nx": 4, "ny": 4}, {"nx": 5, "ny": 3}),
    "j1j2_chain": ({"n": 7}, {"n": 36}),
    "landau_lifshitz": ({"n": 24},),
    "pyrochlore": (),
    "point_vortices": ({}, {"n": 12, "gamma": [1.0, -0.7, 0.4] * 4}),
    "stirred_sphere": ({"m": 5},),
    "test_particles": ({"n": 5},),
    "vortex_tracers": ({"m": 5},),
}


@dataclass(frozen=True)
class Case:
    """One build. `key` names it in the table; values: of parameters, where they are not the defaults."""
    spec: str
    values: tuple
    method: str
    solver: str = "auto"
    features: tuple = ()
    real: str = "double"

    @property
    def key(self) -> str:
        values = " ".join(f"{name}={value}".replace(", ", ";").replace(",", ";") for name, value in self.values)
        return ",".join((self.spec, values, self.method, self.solver, "+".join(self.features), self.real))


def ways(method) -> list[dict]:
    """What a method is asked for beside itself: each feature, solver and precision once."""
    features = [{"features": (name,)} for name in (*method.features, *EVERYWHERE)]
    solvers = [{"solver": name} for name in SOLVERS if name in method.solvers and name != "auto"]
    return [{}, *features, *solvers, *([{"real": "long double"}] if method.stages == 1 else [])]


def cases() -> list[Case]:
    """All of them, whether or not the compiler accepts them: a refusal is frozen too."""
    return [Case(spec, tuple(values.items()), name, **way)
            for spec in (*shipped(), *scenes()) for values in SIZES.get(spec, ({},))
            for name, method in METHODS.items() for way in ways(method)]
