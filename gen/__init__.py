"""smidgen compiles Hamiltonians, written as formulas, to structure-preserving integrators.

    import smidgen
    spec = smidgen.load("top.toml")         # or a name that `smidgen list` shows
    result = smidgen.run(spec, "demo", out="demo.h5")
    top = smidgen.build(spec).start("tilted", h=0.1)
    top.steps(100).w

What is public is imported when it is first asked for, so that the command answers at once. Where a function and a package
share a name (build, run, cost), the attribute of `smidgen` is the function, whatever is imported and when: a package does
not take its place. `from smidgen.build.binary import ...` finds the package.
"""
import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING

from .errors import (BuildError, KeywordError, MissingTool, OutputError, ReadOnlyError,
                     RunError, SmidgenError, SpecError, UsageError, ValidationError)
from .version import __version__  # noqa: F401

if TYPE_CHECKING:
    from . import lattice, lyapunov
    from .analyse.advice import advise
    from .analyse.spectrum import Spectrum, spectrum
    from .analyse.spectrum_file import load_spectrum
    from .analyse.spin_waves import SpinWaves, spin_waves
    from .analyse.symmetry import explain
    from .check.validate import validate
    from .check.verify import verify
    from .cost import Choice, Cost, choose, cost, load_cost
    from .language.spec import Spec
    from .model import Model
    from .read import load_text
    from .read.shipped import flat, load
    from .run.fields.field import load_field
    from .run.fields.snapshot import snapshot
    from .run.files.checkpoint import CheckpointError
    from .run.files.output import Result, load_result
    from .run.many.average import Average, Averages, average, load_averages
    from .run.many.ensemble import Ensemble, ensemble
    from .run.many.sweep import sweep
    from .run.resume import resume
    from .run.run import Interrupted, repeat, run
    from .run.step.integrator import Integrator, build
    from .show.plot import plot

__all__ = ["Average", "Averages", "BuildError", "CheckpointError", "Choice", "Cost", "Ensemble", "Integrator", "Interrupted", "KeywordError", "MissingTool", "Model", "OutputError",
           "ReadOnlyError", "Result", "RunError", "SmidgenError", "Spec", "SpecError", "Spectrum", "SpinWaves", "UsageError", "ValidationError",
           "advise", "average", "build", "choose", "cost", "ensemble", "explain", "flat", "lattice", "load", "load_averages", "load_cost", "load_field", "load_result", "load_spectrum", "load_text",
           "lyapunov", "plot", "repeat", "resume", "run", "snapshot", "spectrum", "spin_waves", "sweep", "validate", "verify"]

PLACES = {name: place for place, names in {      # of what is public: the module that has it
    "analyse.advice": "advise", "analyse.spectrum": "Spectrum spectrum", "analyse.spectrum_file": "load_spectrum", "analyse.spin_waves": "SpinWaves spin_waves", "analyse.symmetry": "explain",
    "check.validate": "validate", "check.verify": "verify", "cost": "Choice Cost choose cost load_cost", "language.spec": "Spec", "model": "Model", "read": "load_text",
    "read.shipped": "flat load", "run.fields.field": "load_field", "run.fields.snapshot": "snapshot", "run.files.checkpoint": "CheckpointError",
    "run.files.output": "Result load_result", "run.many.average": "Average Averages average load_averages", "run.many.ensemble": "Ensemble ensemble",
    "run.many.sweep": "sweep", "run.resume": "resume", "run.run": "Interrupted repeat run", "run.step.integrator": "Integrator build", "show.plot": "plot"}.items() for name in names.split()}
MODULES = ("lattice", "lyapunov")


def __getattr__(name):
    """What is public, imported now, with what notebooks show of it."""
    if name in MODULES:
        return import_module(f".{name}", __name__)
    if name not in PLACES:
        raise AttributeError(f"module 'smidgen' has no attribute '{name}'")
    import_module(".show.notebook", __name__)
    found = globals()[name] = getattr(import_module(f".{PLACES[name]}", __name__), name)
    return found


def __dir__():
    """All of it is there before it is imported."""
    return sorted({*globals(), *__all__})


class Package(ModuleType):
    """A package whose functions are not replaced by packages in it that have their names."""

    def __setattr__(self, name, value):
        if not (name in PLACES and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = Package
