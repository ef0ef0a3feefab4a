"""Methods that ask for the right-hand side alone, on lattices by rows (runtime/method/explicit/smg_field_rows.h): the step, the bits, and what a failure says."""
import numpy as np
import pytest
import smidgen
from smidgen.compile.emit.emit import generate
from support.going_on import one_by_one, restored
from support.strict import MODES, compile_all
from support.widths import same_in_lanes
from test_rows import SPECS as QUADRATIC, EXCHANGE, lattice
from test_rows_any_formula import SPECS as ANY
from test_rows_by_site import SOME, close
from test_rows_held import SOME as HELD
from test_rows_in_time import SPECS as IN_TIME

METHODS = ("dop853", "dop853-projected", "dormand-prince-8", "extrapolation-12")
SPECS = {"odd ring": QUADRATIC["ring of 17"], "second neighbours": QUADRATIC["further neighbours of 12"], "open cubic": QUADRATIC["open cubic"], "any formula": ANY["blocks"],
         "in time": IN_TIME["open square"], "damped": IN_TIME["damped"], "by site": SOME, "other spheres": QUADRATIC["other spheres"], "long rows": QUADRATIC["ring of 601"]}
QUICK = (("in time", "dop853"), ("damped", "extrapolation-12"), ("by site", "dop853-projected"))
NEAR = {"dop853": 1e-12, "dop853-projected": 1e-12}         # sizes of internal steps differ by what round-off does to errors
STRONG = lattice("strong", "chain(n, periodic)", 18, "n", EXCHANGE.replace("-0.7", "1e150"))


@pytest.mark.parametrize("name, method", [pytest.param(n, m, marks=() if (n, m) in QUICK else pytest.mark.long) for n in SPECS for m in METHODS])
def test_rows_take_the_step(name, method):
    """Against the witness, which knows no rows, from a time that is not 0."""
    spec = SPECS[name]
    assert "SMG_ROW_FIELDS" in generate(spec, method)[f"{spec.name}.c"]
    assert close(spec, method, steps=2) <= NEAR.get(method, 4e-15)


@pytest.mark.parametrize("method", [METHODS[0], *(pytest.param(m, marks=pytest.mark.long) for m in METHODS[1:])])
def test_the_same_bits_for_any_number_of_lanes(monkeypatch, method):
    def built(lanes):
        monkeypatch.setenv("CC", f"gcc -Wno-psabi -DSMG_LANES={lanes}")
        return smidgen.build(SPECS["by site"], method=method)
    assert same_in_lanes(built, (2, 4, 8))


@pytest.mark.parametrize("method", ["dop853", "extrapolation-12"])
def test_one_by_one_at_once_or_restored(method):
    model = smidgen.build(SPECS["in time"], method=method)
    assert one_by_one(model) and restored(model)


@pytest.mark.parametrize("method", METHODS)
def test_what_is_no_number_is_refused_and_leaves_the_state(method):
    model = smidgen.build(STRONG, method=method).start("random", h=1e200)
    saved, w = model.save(), model.w.copy()
    with pytest.raises(smidgen.RunError) as caught:
        model.steps(2)
    assert caught.value.status == 4 and 0 <= caught.value.site < 18
    assert np.array_equal(model.save(), saved) and np.array_equal(model.w, w)


def test_too_long_a_step_names_the_site_with_the_largest_error():
    """One spin in a field that turns it too often; the others stand in none."""
    spec = lattice("fast", "chain(n, periodic)", 17, "n", EXCHANGE + '[effects.field]\nover = "site(i) of w"\nenergy = "1e7*if(i > 15, 1, 0)*w[i].z"\n')
    model = smidgen.build(spec, method="dop853").start("random", h=1.0)
    saved = model.save()
    with pytest.raises(smidgen.RunError) as caught:
        model.step()
    assert caught.value.status == 1 and caught.value.site == 16 and np.array_equal(model.save(), saved)


def test_a_field_that_ends_within_a_step_names_a_site_near_its_own():
    """Twelve stages carry what is no number as many sites away."""
    spec = lattice("ending", "chain(n, periodic)", 66, "n", EXCHANGE + '[effects.field]\nover = "site(i) of w"\nenergy = "if(i == 40, sqrt(2.5 - t), 1)*w[i].z"\n')
    model = smidgen.build(spec, method="dop853").start("random", h=1.0).steps(2)
    saved = model.save()
    with pytest.raises(smidgen.RunError) as caught:
        model.step()
    assert caught.value.status == 4 and abs(caught.value.site - 40) <= 12 and np.array_equal(model.save(), saved)


def test_sites_that_stand_still_stay_to_the_bit():
    for method in METHODS[1:3]:
        model = smidgen.build(HELD, method=method).start("random", h=0.1)
        w = model.w.copy()
        still = (model.steps(3).w == w).all(axis=1)
        assert 0 < still.sum() < len(w)


@pytest.mark.parametrize("compiler, mode", MODES)
def test_clean_c(tmp_path, compiler, mode):
    spec = SPECS["by site"]
    for file, text in generate(spec, method="dop853-projected", amalgamate=True).items():
        (tmp_path / file).write_text(text)
    assert not compile_all(tmp_path, [f"{spec.name}.c"], compiler, "-Wno-psabi", how=mode)
