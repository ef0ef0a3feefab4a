"""Instructions a step (tests/bench/instructions.py): its table has a row for every kernel, and a ratio above the limit is an error."""
import importlib
import shutil

import pytest


@pytest.fixture
def bench(monkeypatch, root):
    monkeypatch.syspath_prepend(str(root / "tests" / "bench"))
    return importlib.import_module("instructions")


@pytest.mark.quick
def test_the_table_has_a_row_for_every_kernel(bench, tmp_path):
    assert set(bench.read(bench.OUT)) == {kernel.key for kernel in bench.kernels(str(tmp_path))}


@pytest.mark.quick
def test_a_ratio_above_the_limit_is_an_error(bench, capsys):
    before = {("a", "m", "0.1", "sites"): 100.0, ("b", "m", "0.1", "sites"): 100.0}
    assert bench.compared({key: 102.0 for key in before}, before, 1.02) == 0
    assert bench.compared(before | {("b", "m", "0.1", "sites"): 102.1}, before, 1.02) == 1
    assert "the worst: 1.0210" in capsys.readouterr().out


@pytest.mark.skipif(not shutil.which("valgrind"), reason="no valgrind")
def test_twice_as_many_steps_cost_as_much_each(bench):
    short, long = (float(bench.row(bench.Kernel("free_rigid_body", steps=steps))["instructions"]) for steps in (100, 200))
    assert abs(long / short - 1) < 0.02
