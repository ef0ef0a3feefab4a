"""The statuses of steps, and what is said of a step that failed. Numbers, names and meanings are those of runtime/core/smidgen.h."""
from __future__ import annotations

import enum
import math
import re

from ...resources import runtime_header


def numbers_of(header: str) -> dict:
    """name -> number of smg_status, without `SMG_`."""
    listed = header[header.index("typedef enum smg_status {"):header.index("} smg_status;")]
    return {name: int(number) for name, number in re.findall(r"SMG_(\w+) = (\d+)", listed)}


def meanings_of(header: str) -> list[str]:
    """What smg_message says, by number."""
    return re.findall(r'"([^"]*)"', re.search(r"text\[\] = \{(.*?)\};", header, re.DOTALL)[1])


HEADER = runtime_header("smidgen.h").read_text(encoding="utf-8")
Status = enum.IntEnum("Status", numbers_of(HEADER))
# number -> (name, what happened) of those that are failures
STATUS = {int(one): (one.name.lower().replace("_", " "), meanings_of(HEADER)[one]) for one in Status if one != Status.OK}
RESCUED = (Status.NO_CONVERGENCE, Status.NO_SOLUTION, Status.WRONG_BRANCH, Status.SINGULAR)     # where a smaller step may help
REFUSED = 100       # a status above: not of a step
NO_MEMORY = ("no memory", "there is not enough memory")


def infinite_energies(columns, values) -> list[str]:
    """The effects whose energy is not finite, of values named by `columns`."""
    return [name.removeprefix("energy.") for name, value in zip(columns, values) if name.startswith("energy.") and not math.isfinite(value)]


def what(status: int, infinite, count: int) -> str:
    """What happened in a step that failed after `count` others; infinite: effects whose energy is not finite before it."""
    name, meaning = STATUS.get(status, NO_MEMORY)
    if infinite:
        return f"the energy is not finite {'here' if count else 'at the start'}: effect {' and '.join(map(repr, infinite))}"
    return meaning if status == Status.NOT_FINITE else f"{name}: {meaning}"


def why(found: dict) -> str:
    """What a failed step reports: sites, residual, iterations, h times the local rate."""
    sites = [str(found[k]) for k in ("site", "partner") if found[k] >= 0]
    where = f" at site {sites[0]}" if len(sites) == 1 else f" at sites {' and '.join(sites)}" if sites else ""
    return (f"{where} (residual {found['residual']:.3g} after {found['iterations']} iterations, "
            f"h times the local rate {found['rate']:.3g})")


def advice(status: int, found: dict, h: float, midpoint: bool) -> str:
    """What to try after a step that failed; `smidgen advise` knows midpoint methods."""
    if status == Status.NO_SOLUTION and 0 < found["reached"] <= 1:
        return (f"; from this state, with H at t + h/2, steps exist up to |h| = {abs(h) * found['reached']:.6g}: "
                "take a smaller one")
    if status not in RESCUED:
        return ""
    return "; try a smaller step, such as h/2" + ", or the one that `smidgen advise` recommends" * midpoint
