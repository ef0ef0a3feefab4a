"""The statuses of steps, as smg_status of runtime/core/smidgen.h numbers them, and what is said of a step that failed."""
from __future__ import annotations

# number -> (name, what happened)
STATUS = {
    1: ("no convergence", "the step equation did not converge"),
    2: ("no solution", "the branch of solutions from this state ends before this step"),
    3: ("wrong branch", "the solution found is not connected to the state as h goes to 0"),
    4: ("not finite", "a value is not finite"),
    5: ("bad parameter", "a parameter or a size is out of range"),
    6: ("off manifold", "the start is off its sphere or leaf"),
    7: ("singular", "the Newton matrix is singular"),
}
REFUSED = 100       # a status above: not of a step
NO_MEMORY = ("no memory", "there is not enough memory")


def why(found: dict) -> str:
    """What a failed step reports: sites, residual, iterations, h times the local rate."""
    sites = [str(found[k]) for k in ("site", "partner") if found[k] >= 0]
    where = f" at site {sites[0]}" if len(sites) == 1 else f" at sites {' and '.join(sites)}" if sites else ""
    return (f"{where} (residual {found['residual']:.3g} after {found['iterations']} iterations, "
            f"h times the local rate {found['rate']:.3g})")


def advice(status: int, found: dict, h: float, midpoint: bool) -> str:
    """What to try after a step that failed; `smidgen advise` knows midpoint methods."""
    if status == 2 and 0 < found["reached"] <= 1:
        return (f"; from here, and with H as it is at t + h/2, steps exist up to |h| = {abs(h) * found['reached']:.6g}: "
                "take a smaller one")
    if status not in (1, 2, 3, 7):
        return ""
    return "; try a smaller step, half of it" + ", or what `smidgen advise` says" * midpoint
