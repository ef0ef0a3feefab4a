r"""Sites that are pinned or absent

A spin between two pinned spins p_1 and p_2 moves in their constant field B = -J (p_1 + p_2). The midpoint method rotates it about B by 2 arctan(h |B|/(2 rho)), where rho is the length of its
midpoint, and conserves |w| and w.B. A spin whose neighbours are all absent has no field. The bonds of absent sites have no effect, however strong they are.
"""
import numpy as np

import smidgen
from smidgen.errors import SmidgenError

from .case import Row, below, case
from .geometry import largest

TEXT = """[model]
name = "held_spins"
[space]
w = {{ sphere = 5 }}
[parameters]
J = {J}
[effects.bonds]
over = "bond(i, j) of chain(5, open)"
energy = "-J*dot(w[i], w[j]) - 0.2*log(2.0 - 2*dot(w[i], w[j]))*{log}"
[effects.held]
over = "site(i) of w"
{held}
[starts.a]
random = 4
[runs.a]
start = "a"
h = 0.1
steps = 10
"""


def held(condition, J=1.0, log=0):
    return smidgen.load_text(TEXT.format(held=condition, J=J, log=log))


def moved(spec, h, steps, method="spherical-midpoint"):
    """(the start, the end)."""
    one = smidgen.build(spec, method=method).start("a", h=h)
    w = one.w.copy()
    return w, one.steps(steps).w.copy()


@case("isolated and pinned neighbours")
def neighbours():
    """Spins beside pinned and beside absent sites are tested with bonds of every strength and steps of every size."""
    for J, h in ((1.0, 0.1), (1e-12, 1.0), (1.0, 100.0), (1e6, 1e-3), (-1e6, 1.0)):
        w, W = moved(held('pinned = "mod(i, 2) == 0"', J), h, 100)
        B = np.array([w[k - 1] + w[k + 1] for k in (1, 3)])
        yield Row(f"J = {J:g}, h = {h:g}: pinned spins after 100 steps", "the same bits", "the same bits" if np.array_equal(W[::2], w[::2]) else "others", np.array_equal(W[::2], w[::2]))
        yield below(f"J = {J:g}, h = {h:g}: change of w.(p1 + p2) between them", largest(np.sum(W[1::2] * B, axis=1) - np.sum(w[1::2] * B, axis=1)), 2e-14)
        yield below(f"J = {J:g}, h = {h:g}: change of |w|", largest(np.linalg.norm(W, axis=1) - 1), 2e-15)
    for J in (1.0, 1e12, 1e100):
        w, W = moved(held('absent = "mod(i, 2) == 1"', J), 1.0, 100)
        yield Row(f"J = {J:g}: spins whose neighbours are absent", "the same bits", "the same bits" if np.array_equal(W[::2], w[::2]) else "others", np.array_equal(W[::2], w[::2]))
    w, W = moved(held('absent = "i < 4"', 1.0, 1), 0.5, 100, "dop853")
    yield Row("the last spin beside an absent one, by a bond with a logarithm", "the same bits", "the same bits" if np.array_equal(W[4], w[4]) else "others", np.array_equal(W[4], w[4]))


@case("everything absent, everything pinned")
def everything():
    """A model without any site is refused, with a reason. If all sites are pinned, the state does not change, whatever the step."""
    try:
        held('absent = "i < 5"')
        said = "no error"
    except SmidgenError as error:
        said = error.diagnostics[0].cause
    yield Row("all five absent", "every site is absent", said, said.startswith("every site is absent"))
    for method in ("spherical-midpoint", "classical-midpoint", "gauss-4", "dop853", "spherical-midpoint-4"):
        w, W = moved(held('pinned = "i < 5"', 1e6), 10.0, 50, method)
        yield Row(f"all five pinned, {method}, J = 1e6, h = 10", "the same bits", "the same bits" if np.array_equal(W, w) else "others", np.array_equal(W, w))
