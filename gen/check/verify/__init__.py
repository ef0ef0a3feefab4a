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
    """Measure what the generated integrator of a run promises, and return a `certificate.Certificate`. Other arguments are as for `run`.

    :param features: features of the C code, as for `build`.
    :param tier: "quick", "normal", or the number of steps over which round-off is measured.
    :param layouts: whether to include threads, wavefronts and MPI ranks; lattices that are processed by rows are then compiled twice more.
    :raises UsageError: for an argument that does not fit. A measurement that fails is a row of the certificate marked as failed.
    """
    from .certificate import certify
    return certify(spec, run, tier=tier, features=features, start=start, method=method, solver=solver, h=h,
                   effects=effects, parameters=parameters, seed=seed, layouts=layouts)
