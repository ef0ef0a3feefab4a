"""The numbers of the rigid bodies, to three digits: exact solution, error table, drift.

Reference: solutions in 20 digits and more, computed apart from this program; the systems are
those of McLachlan, Modin, Verdier, "A minimal-variable symplectic integrator on spheres".
"""
import importlib

import mpmath as mp
import pytest
from support import constants as order_2
from support.bodies import STEPS, TENSORS, band, drift, energy_errors, largest_error, start_length
from support.elliptic import constants, curve, period, solution
from support.systems import CLASSICAL, SHORT, SPECS, SPHERICAL, VESELOV

METHODS = (SPHERICAL, CLASSICAL, VESELOV)

# Largest error on [0, 10] at h = 2^-1, 2^-3, .. 2^-9.
ERRORS = {
    ("(1, 2, 4)", SPHERICAL): (3.10247e-3, 1.94914e-4, 1.21860e-5, 7.61642e-7, 4.76027e-8),
    ("(1, 2, 4)", CLASSICAL): (6.46716e-3, 4.06884e-4, 2.54408e-5, 1.59009e-6, 9.93809e-8),
    ("(1, 2, 4)", VESELOV): (3.44599e-2, 2.12155e-3, 1.32471e-4, 8.27892e-6, 5.17431e-7),
    ("(1, 4/3, 2)", SPHERICAL): (1.09185e-4, 6.34156e-6, 3.94463e-7, 2.46466e-8, 1.54038e-9),
    ("(1, 4/3, 2)", CLASSICAL): (3.38734e-3, 2.12578e-4, 1.32896e-5, 8.30611e-7, 5.19133e-8),
    ("(1, 4/3, 2)", VESELOV): (4.73710e-2, 2.82471e-3, 1.76037e-4, 1.10003e-5, 6.87511e-7),
}
THREE_DIGITS = 5e-4


@pytest.fixture(autouse=True)
def precision():
    with mp.workdps(30):
        yield


# -- the exact solution -------------------------------------------------------------------------

@pytest.mark.parametrize("tensor, t, digits, w", [
    ("(1, 2, 4)", 10, 24, ("-0.4503635330766926960600452", "-0.09362899305780025785077625",
                           "0.8879224626810953221192839")),
    ("(1, 2, 4)", 1000, 18, ("-0.3437451908665194926", "-0.5126071160112798211",
                             "0.7868120413229187445")),
    ("(1, 4/3, 2)", 10, 17, ("-0.441656027844468652", "0.146214872300823602",
                             "0.885189902894683824")),
])
def test_exact_solution_has_the_reference_values(tensor, t, digits, w):
    moments = (1, mp.mpf(4) / 3, 2) if "4/3" in tensor else (1, 2, 4)
    for found, known in zip(solution(moments, t), w):
        assert abs(found - mp.mpf(known)) < mp.mpf(10)**-digits


def test_exact_solution_period_and_form():
    (a, b, d), rate, m = constants((1, 2, 4))
    c, s = mp.cos(mp.mpf(11) / 10), mp.sin(mp.mpf(11) / 10)
    for found, known in ((b, mp.sqrt(3) * c), (rate, mp.sqrt(3) * s / 4), (m, 2 * (c / s)**2)):
        assert abs(found - known) < mp.mpf(10)**-27
    assert abs(period((1, 2, 4)) - mp.mpf("19.380131664385552376")) < mp.mpf(10)**-17


@pytest.mark.parametrize("tensor", TENSORS)
def test_exact_solution_solves_the_equation(tensor):
    moments = TENSORS[tensor]
    for t in (0.3, 4.7):
        rate = [mp.diff(lambda u, k=k: solution(moments, u)[k], t) for k in range(3)]
        w = solution(moments, t)
        b = [x / i for x, i in zip(w, moments)]
        cross = (w[1] * b[2] - w[2] * b[1], w[2] * b[0] - w[0] * b[2], w[0] * b[1] - w[1] * b[0])
        assert max(abs(x - y) for x, y in zip(rate, cross)) < 1e-12
    assert abs(solution(moments, 0)[1]) < 1e-30


@pytest.mark.parametrize("tensor", TENSORS)
def test_double_precision_curve_is_exact_enough(tensor):
    times = [0.125, 3.0, 7.25, 10.0]
    for row, t in zip(curve(TENSORS[tensor], times), times):
        assert max(abs(float(x) - y) for x, y in zip(solution(TENSORS[tensor], t), row)) < 1e-14


# -- the error table ----------------------------------------------------------------------------

@pytest.fixture(scope="module")
def table():
    """{(tensor, method): errors at h = 2^-1 .. 2^-9} of the generated code."""
    return {(tensor, method): [largest_error(TENSORS[tensor], method, h) for h in STEPS]
            for tensor in TENSORS for method in METHODS}


@pytest.mark.parametrize("tensor, method", ERRORS)
def test_error_table(table, tensor, method):
    assert table[tensor, method][::2] == pytest.approx(ERRORS[tensor, method], rel=THREE_DIGITS)


@pytest.mark.parametrize("tensor, method", ERRORS)
def test_even_powers_lie_on_the_same_line(table, tensor, method):
    """Order 2: halving h divides the error by 4, within what the next term of h^4 allows."""
    errors = table[tensor, method]
    ratios = [a / b for a, b in zip(errors, errors[1:])]
    assert ratios[1:] == pytest.approx([4] * 7, rel=0.06)
    assert ratios[-3:] == pytest.approx([4] * 3, rel=1e-3)


@pytest.mark.parametrize("tensor, veselov, classical", [("(1, 2, 4)", 10.87, 2.09),
                                                        ("(1, 4/3, 2)", 446.3, 33.70)])
def test_ratios_of_the_figure(table, tensor, veselov, classical):
    """400 and 30 times smaller, as printed, belong to I = (1, 4/3, 2), not to (1, 2, 4)."""
    spherical = table[tensor, SPHERICAL][-1]
    found = [table[tensor, m][-1] / spherical for m in (VESELOV, CLASSICAL)]
    print(f"I = {tensor}: {SHORT[VESELOV]}/{SHORT[SPHERICAL]} = {found[0]:.2f}, "
          f"{SHORT[CLASSICAL]}/{SHORT[SPHERICAL]} = {found[1]:.3f}")
    assert found == pytest.approx([veselov, classical], rel=1.5e-3)


# -- the irreversible body ----------------------------------------------------------------------

def test_start_is_normalised():
    length, w = start_length()
    assert length == pytest.approx(0.99995912, abs=5e-9)
    assert w[0] @ w[0] == pytest.approx(1, abs=4e-16)


def test_energy_of_the_start():
    assert energy_errors(SPHERICAL, 0.5)[1] == pytest.approx(0.226892131797, abs=5e-13)


def test_spherical_midpoint_stays_in_its_band():
    low, high = band(20000)
    print(f"SM energy error on [0, 20000]: [{low:.4e}, {high:+.4e}]")
    assert (low, high) == pytest.approx((-2.441e-3, 1.091e-3), rel=THREE_DIGITS)


def test_classical_midpoint_drifts():
    found = drift((1000, 2000, 5000, 20000))
    print("CM energy error at 1000, 2000, 5000, 20000:", *(f"{e:+.4e}" for e in found))
    assert found == pytest.approx((3.950e-3, 1.1979e-2, 4.567e-2, 1.589e-1), rel=THREE_DIGITS)


@pytest.mark.long
def test_spherical_midpoint_stays_in_its_band_for_long():
    """Three times as long, and the band is the same to a part in ten thousand."""
    assert band(60000) == pytest.approx(band(20000), rel=1e-4)


# -- the page -----------------------------------------------------------------------------------

@pytest.fixture
def written(root, monkeypatch):
    """The program that writes docs/numbers.md."""
    monkeypatch.syspath_prepend(str(root / "tests" / "bench"))
    return importlib.import_module("paper_numbers")


def test_the_page_is_that_of_its_table(written):
    """docs/numbers.md is made of docs/numbers.csv and of nothing else."""
    assert written.page(written.read_table()) == written.PAGE.read_text()


def test_the_page_has_the_errors_of_today(written, table):
    kept = written.Table(written.read_table(), "error")
    for (tensor, method), errors in table.items():
        shown = [kept(tensor, SHORT[method], f"2^-{k}", "error") for k in range(1, 10)]
        assert shown == pytest.approx(errors, rel=THREE_DIGITS)


@pytest.mark.parametrize("name", [n if k in (0, 8) else pytest.param(n, marks=pytest.mark.long) for k, n in enumerate(order_2.HAMILTONIANS)])
def test_the_page_has_the_error_constants_of_today(written, name):
    """But where one is round-off: the exponential map of a constant field is exact."""
    kept = written.Table(written.read_table(), "constants")
    for method, error in order_2.errors(name).items():
        shown = kept(name, method, "2^-5", "error")
        assert shown == pytest.approx(error, rel=THREE_DIGITS) if shown > 1e-14 else error < 1e-14


@pytest.mark.long
@pytest.mark.parametrize("name", ["xyz", "x + z²/2"])
def test_the_page_has_the_constants_of_another_extension(written, name):
    assert written.Table(written.read_table(), "constants")(name, "RATTLE, c = 1", "2^-5", "error") == pytest.approx(order_2.with_c_1(name), rel=THREE_DIGITS)


def test_the_page_covers_every_system(written):
    """No line of the page breaks what it promises."""
    rows = written.read_table()
    agreement, defects = (written.Table(rows, name) for name in ("agreement", "defect"))
    assert agreement.systems() == SPECS
    assert {name.split(",")[0] for name in defects.systems()} == {*SPECS, "spin_in_field"}
    for row in defects.rows:
        coincides = row.method == "CM" and row.system in written.WHY
        assert row.value > 1e-8 if row.method == "CM" and not coincides else row.value < 1e-12
    for name in SPECS:
        assert agreement(name, "SM", "100", "apart") <= agreement(name, "SM", "100", "allowed")
