"""Steps of lattices by rows beyond the bound: by which certificate, up to which h, and with which solution."""
import numpy as np
import pytest
import smidgen
from support.runtime_faults import Fault, plant

# steps that follow their branch report a thousand iterations more
FOLLOWED = (("smg_row_follow.h", "  if (!smg_begin_path(s, h, a, path)) return 0;", "  s->report.iterations += 1000;\n  if (!smg_begin_path(s, h, a, path)) return 0;"),)
TEXT = """
[model]
name = "beyond"
[space]
w = { sphere = "4*n" }
[parameters]
n = 6
[effects.exchange]
over = "bond(i, j) of square(n, 4, periodic)"
energy = "-dot(w[i], w[j])"
[starts.a]
random = 3
"""
GENEROUS = Fault("", "smg_row_state.h", "#define SMG_ROW_SHOWN (smg_real)0.95", "#define SMG_ROW_SHOWN (smg_real)(1.3 * 0.95)", (), more=FOLLOWED)
PLAIN = Fault("", *FOLLOWED[0], ())
# and those that are swept again at the end of it, ten thousand
AGAIN = Fault("", "smg_row_beyond.h", "  smg_turn_beyond(s, h, a);\n  return smg_solve_beyond", "  s->report.iterations += 10000;\n  smg_turn_beyond(s, h, a);\n  return smg_solve_beyond", (), more=FOLLOWED)


def neighbours():
    """Of the square lattice with sides 6 and 4, all sites with theirs."""
    site = np.arange(24).reshape(4, 6)
    return np.stack([np.roll(site, step, axis).ravel() for axis in (0, 1) for step in (1, -1)], axis=1)


def spectral_radius(w, W, h):
    """Of the matrix with the entries h/2 |H_ij|/s_i, s^2 = rho^2 + (h/2 m.F)^2, at the midpoints of a step."""
    beside, mbar = neighbours(), (w + W) / 2
    rho = np.linalg.norm(mbar, axis=1)
    m = mbar / rho[:, None]
    s = np.hypot(rho, h / 2 * np.einsum("ia,ia->i", m, m[beside].sum(axis=1)))
    matrix = np.zeros((24, 24))
    np.add.at(matrix, (np.arange(24)[:, None], beside), 1)
    return np.abs(np.linalg.eigvals(h / 2 / s[:, None] * matrix)).max()


def steps(model):
    """(spectral radius, did the step follow its branch?) over h."""
    found = []
    for h in np.arange(0.4, 0.58, 0.01):
        one = model.start("a", h=h)
        w = one.w.copy()
        after = one.steps(1)
        found.append((spectral_radius(w, after.w, h), after.report()["iterations"] >= 1000))
    return found


def wrong(found):
    """Those on the wrong side of 0.95, but for the rest that the iteration for the weights leaves."""
    return [(size, followed) for size, followed in found if followed != (size > 0.95) and not 0.93 < size <= 0.95]


def test_the_certificate_ends_at_its_bound(monkeypatch, tmp_path):
    plant(monkeypatch, tmp_path, PLAIN)
    found = steps(smidgen.build(smidgen.load_text(TEXT)))
    assert not wrong(found) and {followed for _, followed in found} == {True, False}
    assert sum(0.95 < size < 1.2 for size, _ in found) > 2


@pytest.mark.parametrize("size", ["9, 7", pytest.param("6, 6", marks=pytest.mark.long)])
def test_slots_without_a_site_do_not_part_a_solution_from_its_branch(monkeypatch, tmp_path, size):
    """What sweeps have found is what the branch leads to: no step is swept again."""
    plant(monkeypatch, tmp_path, AGAIN)
    model = smidgen.build(smidgen.load_text(TEXT.replace("4*n", size.replace(", ", "*")).replace("n, 4", size)))
    iterations = [model.start("a", h=h).steps(1).report()["iterations"] for h in (0.48, 0.54, 0.6)]
    assert max(iterations) < 10000 and any(n >= 1000 for n in iterations)


@pytest.mark.long
def test_a_certificate_too_generous_by_three_tenths_is_seen(monkeypatch, tmp_path):
    plant(monkeypatch, tmp_path, GENEROUS)
    assert len(wrong(steps(smidgen.build(smidgen.load_text(TEXT))))) > 2


SPIRAL = """
[model]
name = "spiral"
[space]
w = { sphere = "n*n*n" }
[parameters]
n = 8
[effects.exchange]
over = "bond(i, j) of cubic(n, n, n, periodic)"
energy = "-dot(w[i], w[j])"
"""
SHORT = Fault("", "smg_row_follow.h", "#define SMG_PATH_SWEEPS 200", "#define SMG_PATH_SWEEPS 40", ())


@pytest.mark.long
@pytest.mark.parametrize("fault, by_rows", [(None, True), (SHORT, False)])
def test_sweeps_that_settle_slowly_go_on_at_the_end_of_the_path(fault, by_rows, monkeypatch, tmp_path):
    """Newton's method, which would take over otherwise, reports its own iterations, some ten."""
    if fault:
        plant(monkeypatch, tmp_path, fault)
    angle = 2 * np.pi * np.arange(512) / 8
    w = np.stack([np.cos(angle), np.sin(angle), 0.3 + 0 * angle], axis=1) + 0.02 * np.random.default_rng(2).standard_normal((512, 3))
    model = smidgen.build(smidgen.load_text(SPIRAL))
    one = model.start(w / np.linalg.norm(w, axis=1)[:, None], h=0.673)
    assert (one.steps(1).report()["iterations"] >= 100) == by_rows


STRAY = Fault("", "smg_row_spin.h", "#define SMG_ROW_FLAT (smg_real)1", "#define SMG_ROW_FLAT (smg_real)0", ())


@pytest.mark.parametrize("fault, by_rows", [(None, True), (STRAY, False)])
def test_corrections_do_not_lead_sweeps_astray_near_a_fold(fault, by_rows, monkeypatch, tmp_path):
    """Where 1 - |g|^2 is small rho is found by its root; without it sweeps end in Newton's method."""
    plant(monkeypatch, tmp_path, fault)
    one = smidgen.build(smidgen.load_text(SPIRAL + "[starts.s]\nrandom = 1\n")).start("s", h=0.4645).steps(1)
    assert (min(one.steps(1).report()["iterations"] for _ in range(8)) > 25) == by_rows
