"""The certificate of an integrator: yes or no to each property that it should have, with the number.

    certificate = smidgen.verify(spec, "demo")
    print(certificate.text())
    certificate.passed, certificate.to_json()

Each check lives in a file of its own, takes a `case.Case` and a `subject.Subject` and returns
rows. docs/verify.md says what is measured, and why no wrong integrator gets through.
"""
from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from ...language.spec import Spec
from ...public import public
from ...read.shipped import SpecLike, spec_or_name

if TYPE_CHECKING:
    from .certificate import Certificate


@public
@spec_or_name
def verify(spec: SpecLike, run: str | None = None, *, start: str | np.ndarray | None = None, method: str | None = None, solver: str | None = None,
           h: float | str | None = None, effects: Iterable[str] | None = None, parameters: Mapping[str, object] | None = None,
           seed: int | None = None, features: Iterable[str] = (), tier: str | int = "normal", layouts: bool = False) -> Certificate:
    """Measure the generated integrator of a run; returns a `certificate.Certificate`.

    start .. seed: as for `smidgen.run`, in place of what the run says; features: of the generated C, as for `smidgen.build`.
    tier: "quick", "normal", or a number of steps, the length of the round-off measurement.
    layouts: look at threads, wavefronts and ranks of MPI too, for which lattices by rows are compiled twice more.
    Raises UsageError for wrong names; what the integrator refuses or misses is a row that says no.
    """
    from .certificate import certify
    return certify(spec, run, tier=tier, features=features, start=start, method=method, solver=solver, h=h,
                   effects=effects, parameters=parameters, seed=seed, layouts=layouts)
