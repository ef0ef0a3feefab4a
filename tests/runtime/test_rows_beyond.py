"""Steps of lattices by rows beyond the bound: by which certificate, up to which h, and with which solution."""
import numpy as np
import pytest
import smidgen
from support.filters import feed, make  # noqa: F401
from support.runtime_faults import Fault, plant

# steps that follow their branch report a thousand iterations more
FOLLOWED = (("smg_row_follow.h", "  if (!smg_begin_path(s, h, a, path)) return 0;", "  a->passes += 1000 * SMG_COLOURS;\n  if (!smg_begin_path(s, h, a, path)) return 0;"),)
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
AGAIN = Fault("", "smg_row_beyond.h", "  smg_turn_beyond(s, h, a);\n  return smg_solve_beyond", "  a->passes += 10000 * SMG_COLOURS;\n  smg_turn_beyond(s, h, a);\n  return smg_solve_beyond", (), more=FOLLOWED)


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
SHORT = Fault("", "smg_row_follow.h", "#define SMG_PATH_SWEEPS 6000", "#define SMG_PATH_SWEEPS 40", ())
FEWER = Fault("", "smg_row_follow.h", "#define SMG_PATH_SWEEPS 6000", "#define SMG_PATH_SWEEPS 600", ())
UNRELAXED = Fault("", "smg_row_settle.h", "#define SMG_RELAXED (smg_real)0.8", "#define SMG_RELAXED (smg_real)0.999", (), more=(("smg_row_follow.h", "#define SMG_RELAXED_LEAST (smg_real)0.25", "#define SMG_RELAXED_LEAST (smg_real)2"),))
EAGER = Fault("", "smg_row_settle.h", "  if (a->sweep.passes < 2 * SMG_COLOURS || a->ratio >= 1) return SMG_MAX;", "  if (a->sweep.passes < SMG_COLOURS) return SMG_MAX;", ())


def by_rows(model) -> bool:
    """Newton's method reports its own iterations, at most some twenty."""
    return model.step().report()["iterations"] > 25


@pytest.mark.long
@pytest.mark.parametrize("h, fault, expected", [(1.4, None, True), (1.4, FEWER, False), (0.673, None, True), (0.673, SHORT, False), (1.05, None, True), (1.4, UNRELAXED, False), (1.05, EAGER, False)])
def test_sweeps_that_settle_slowly_go_on_at_the_end_of_the_path(h, fault, expected, monkeypatch, tmp_path):
    if fault:
        plant(monkeypatch, tmp_path, fault)
    angle = 2 * np.pi * np.arange(512) / 8
    w = np.stack([np.cos(angle), np.sin(angle), 0.3 + 0 * angle], axis=1) + 0.02 * np.random.default_rng(2).standard_normal((512, 3))
    model = smidgen.build(smidgen.load_text(SPIRAL))
    assert by_rows(model.start(w / np.linalg.norm(w, axis=1)[:, None], h=h)) == expected


ROUGH = Fault("", "smg_row_follow.h", "    if (failed > 1 && !smg_refine_point(s, h, a, path)) return 0;\n", "    (void)(smg_refine_point, failed);\n", ())
ALIKE = Fault("", "smg_row_follow.h", "#define SMG_RELAXED_LEAST (smg_real)0.25", "#define SMG_RELAXED_LEAST (smg_real)2", ())


@pytest.mark.parametrize("fault", [None, pytest.param(ROUGH, marks=pytest.mark.long)])
def test_branches_are_followed_by_rows_nearly_to_their_ends(fault, monkeypatch, tmp_path):
    """Where points of the path are refined; the solution is that of Newton's method."""
    spec = smidgen.load_text(SPIRAL + "[starts.s]\nrandom = 1\n")
    model = smidgen.build(spec)
    plant(monkeypatch, tmp_path, fault or SHORT)
    other, ways = smidgen.build(spec), []
    for seed in (0, 2, 3, 7, 9):
        assert by_rows(model.start("s", seed=seed, h=0.65))
        ways.append(by_rows(other.start("s", seed=seed, h=0.65)))
        assert np.abs(model.w - other.w).max() < 1e-12
    assert not all(ways)


WAVES = """[starts.waves]
theta = "1 + 0.5*sin(0.3*i)"
phi = "0.7*i"
"""


@pytest.mark.parametrize("fault", [None, pytest.param(ALIKE, marks=pytest.mark.long)])
def test_sweeps_that_do_not_settle_are_relaxed_more(fault, monkeypatch, tmp_path):
    if fault:
        plant(monkeypatch, tmp_path, fault)
    spec = smidgen.load_text(SPIRAL.replace("n*n*n", "n*n").replace("cubic(n, n, n,", "square(n, n,").replace("n = 8", "n = 16") + WAVES)
    assert by_rows(smidgen.build(spec).start("waves", h=1.05)) == (fault is None)


@pytest.mark.parametrize("flat", [True, False])
def test_where_the_slope_is_small_rho_is_found_by_its_root(flat, make):
    """rho^2 solves x^2 + (k - 1) x - d^2 = 0, k = |g|^2, d = g.w; a correction from a rho with 2 (2x + k - 1) < 1 may lead anywhere."""
    rng = np.random.default_rng(5)
    w, g = (v / np.linalg.norm(v, axis=1)[:, None] for v in rng.standard_normal((2, 400, 3)))
    g *= rng.uniform(0.5, 1.3, 400)[:, None]
    before = rng.uniform(0.05, 1, 400)
    found = feed(make("gcc-sanitized", "rho"), [flat, 400], np.column_stack([w, g, before, 0 * w[:, :2]]))
    below, d = 1 - (g * g).sum(axis=1), (g * w).sum(axis=1)
    exact = np.sqrt((below + np.hypot(below, 2 * d)) / 2)
    steep = 4 * before**2 - 2 * below < 1
    assert 100 < steep.sum() < 300 and (np.abs(found - exact)[steep] < 1e-12).all() == flat


@pytest.mark.parametrize("tolerance", [1e-4, pytest.param(1e-8, marks=pytest.mark.long), pytest.param(1e-12, marks=pytest.mark.long)])
def test_a_tolerance_saves_sweeps_and_is_met(tolerance):
    """Where sweeps converge slowly, too; one that took a slow rate for a fast one would end where the residual is too large, and leave the step to Newton's method."""
    model, found = smidgen.build(smidgen.load_text(SPIRAL + "[starts.s]\nrandom = 1\n")), []
    angle = 2 * np.pi * np.arange(512) / 8
    w = np.stack([np.cos(angle), np.sin(angle), 0.3 + 0 * angle], axis=1) + 0.02 * np.random.default_rng(2).standard_normal((512, 3))
    for allowed in (None, tolerance):
        model.start(w / np.linalg.norm(w, axis=1)[:, None], h=0.75, tolerance=allowed)
        found.append((model.step().report()["iterations"], model.w.copy()))
    assert 25 < found[1][0] < found[0][0] and np.abs(found[1][1] - found[0][1]).max() <= tolerance
