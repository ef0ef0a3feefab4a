"""smidgen compiles Hamiltonians, written as formulas, to structure-preserving integrators.

    import smidgen
    spec = smidgen.load("top.toml")
    result = smidgen.run(spec, "demo", out="demo.h5")
    top = smidgen.build(spec).start("tilted", h=0.1)
    top.steps(100).w
"""
__version__ = "0.1.0"

from . import build as _build_module, run as _run_module        # noqa: E402,F401
from .errors import (BuildError, MissingTool, OutputError, RunError,    # noqa: E402
                     SmidgenError, SpecError, UsageError, ValidationError)
from .integrator import Integrator, build                          # noqa: E402
from .output import Result, load_result                         # noqa: E402
from .read import load, load_text                               # noqa: E402
from .run import Interrupted, repeat, run                       # noqa: E402
from .resume import resume                                      # noqa: E402
from .checkpoint import CheckpointError                         # noqa: E402
from .verify import verify                                      # noqa: E402

__all__ = ["BuildError", "CheckpointError", "Integrator", "Interrupted", "MissingTool", "OutputError", "Result",
           "RunError", "SmidgenError", "SpecError", "UsageError", "ValidationError", "advise", "build", "explain",
           "load", "load_result", "load_text", "repeat", "resume", "run", "verify"]


def __getattr__(name):
    """`explain` and `advise`, which need sympy, are imported when they are asked for."""
    if name == "explain":
        from .symmetry import explain
        return explain
    if name == "advise":
        from .advice import advise
        return advise
    raise AttributeError(f"module 'smidgen' has no attribute '{name}'")
