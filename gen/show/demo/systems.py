"""One line of the table: a spec compiled, run, compared with the witness, drawn."""
from __future__ import annotations

import dataclasses
import time
from pathlib import Path

import numpy as np

from ...check.validate import validate
from ...errors import SmidgenError
from ...read.shipped import load_spec
from ...run.record.conserved import conserved_axes, momentum_of
from ...run.run import run
from ...run.settings import model_of, settle
from ...run.step.evaluated import kappas
from ..plot.draw import outputs_for, plot, write_page
from ..plot.facts import conserved_energy, with_facts
from ..plot.gallery import Picture
from ..plot.pictures import draw_player, suitable

KEPT = 1e-11            # change of a conserved momentum or Casimir, in units of its parts


@dataclasses.dataclass(frozen=True)
class Outcome:
    """What became of one system. nan: nothing is conserved there, see the note."""
    system: str
    method: str = ""
    steps: int = 0
    energy: float = np.nan
    momentum: float = np.nan
    casimir: float = np.nan
    agreement: float = np.nan
    bound: str = ""             # of the agreement
    order: float = np.nan
    seconds: float = np.nan
    note: str = ""
    passed: bool = False
    pictures: tuple[Picture, ...] = ()


def system(name: str, out: Path) -> Outcome:
    """Compile, run, validate and draw a shipped spec; what fails is a failed line.

    name: of the spec, whose first run is taken and drawn, or `spec:run`.
    """
    try:
        return checked(name, out)
    except SmidgenError as error:
        return Outcome(name, note=f"{type(error).__name__}: {' '.join(str(error).split())[:300]}")


def checked(name: str, out: Path) -> Outcome:
    """The line of `name`. Raises what a stage raises."""
    word, _, chosen = name.partition(":")
    spec = load_spec(word)
    began = time.perf_counter()
    settings = settle(spec, chosen or None, what=outputs_for(spec))
    model = model_of(spec, settings)
    result = with_facts(run(spec, settings.run, what=settings.what, every=every(settings, model)))
    seconds = time.perf_counter() - began
    started(model, result)
    faults, notes = losses(model, spec, result)
    report = validate(spec, settings.run)
    faults += [f"{x.check}: {x.measured:.2e}, bound {x.bound}" for x in report.lines if not x.passed]
    measured, bound = agreement(report)
    return Outcome(name, settings.method, settings.steps, energy_error(result), momentum_error(model, spec, result), casimir_error(result),
                   measured, bound, order(report), seconds, "; ".join(faults or notes), not faults,
                   () if chosen else drawn(name, spec, result, out))


def every(settings, model) -> int:
    """Steps between outputs: one for small runs, so that players move smoothly."""
    return 1 if settings.steps * model.sites <= 200_000 else settings.every


def agreement(report) -> tuple[float, str]:
    """(largest difference from the witness's own steps of the same method, its bound)."""
    found = [(x.measured, x.bound) for x in report.lines if x.check.endswith("steps")]
    return found[0] if found else (np.nan, "")


def order(report) -> float:
    """The order of convergence; nan where errors are round-off already, so that no order can be seen."""
    return next((x.measured for x in report.lines if x.check.startswith("order") and ".." in x.bound), np.nan)


# -- what is conserved ---------------------------------------------------------------------

def energy_error(result) -> float:
    """max |H - H_0| over the outputs, H without what tracers feel; nan when H depends on t."""
    energy, _ = conserved_energy(result)
    return np.nan if energy is None or result.meta["driven"] else float(np.abs(energy - energy[0]).max())


def casimir_error(result) -> float:
    """Largest change of a Casimir, relative to the largest of them or 1."""
    values = np.asarray(result.values["casimirs"], float)
    return float(np.abs(values - values[0]).max() / max(1.0, np.abs(values[0]).max()))


def momentum_error(model, spec, result) -> float:
    """Largest change of the total momentum in the directions in which it is conserved; nan without one."""
    axes = conserved_axes(model)
    if not len(axes):
        return np.nan
    total = momentum_of(result.values, spec) @ axes.T
    return float(np.abs(total - total[0]).max())


def started(model, result):
    """The model at the run's last state, so that its field can be asked for."""
    return model.start(np.array(result.final, float), h=result.meta["h"])


def losses(model, spec, result):
    """(faults, notes): conserved numbers that were lost; what is not conserved, and why."""
    faults, notes = [], []
    if not casimir_error(result) <= KEPT:
        faults.append(f"Casimirs change by {casimir_error(result):.1e}")
    error = momentum_error(model, spec, result)
    parts = np.abs(kappas(spec, model.parameters)).sum()
    if error > KEPT * max(1.0, parts):
        faults.append(f"momentum changes by {error:.1e}")
    if result.meta["driven"]:
        notes.append("energy not conserved")
    if result.meta["unconserved"]:
        notes.append("energy without the tracers")
    return faults, notes + axes_note(model, spec)


def axes_note(model, spec) -> list[str]:
    """Which components of the momentum are conserved, when not all are."""
    axes = conserved_axes(model)
    if len(axes) == 3 or any(f.kind == "nambu" for f in spec.families):
        return []
    names = ", ".join(direction(axis) for axis in axes)
    return [f"momentum conserved along {names} only" if names else "momentum not conserved"]


def direction(axis) -> str:
    """x, y or z, or the components of a unit vector."""
    k = int(np.argmax(np.abs(axis)))
    return "xyz"[k] if abs(axis[k]) > 1 - 1e-9 else f"({', '.join(f'{a:.3g}' for a in axis)})"


# -- pictures ------------------------------------------------------------------------------

PLAYED = ("irreversible_rigid_body", "point_vortices", "heisenberg_chain", "two_bodies",
          "vortex_tracers", "test_particles", "vortex_manifold", "nambu_a38")


def drawn(name: str, spec, result, out: Path) -> tuple[Picture, ...]:
    """The picture that suits the result, and a player for some."""
    path = plot(result, out=out / f"system_{name}.svg")
    size = "broad" if suitable(result, False) == "chain" else "small"
    player = write_page(draw_player(result, start=0.3), out / f"player_{name}.html") if name in PLAYED else None
    return (Picture(f"system_{name}", path, spec.title or name, caption(result), size, "systems", player=player),)


def caption(result) -> str:
    """Run, method, step and duration."""
    meta, unit = result.meta, (result.meta.get("units") or {}).get("time", "")
    return (f"Run '{meta['run']}' of {meta['spec']}: {meta['method'].replace('-', ' ')}, "
            f"h = {meta['h']:.4g}{' ' * bool(unit) + unit}, {meta['done']} steps.")
