"""Why the steps of a lattice go site by site, and not by rows."""
from __future__ import annotations

from ...compile.assemble.model import Model
from ...compile.plan.plan import choose
from ...errors import SmidgenError
from ...language.spec import Lattice, Spec


def why_by_site(scene: Spec, method: str) -> str:
    """The end of a sentence, or "" where they go in lanes, or there is no lattice."""
    if not any(isinstance(e.over, Lattice) for e in scene.energies):
        return ""
    try:
        return Model(scene, choose(scene, method, "auto")).by_site
    except SmidgenError:
        return ""
