"""The memory of large states lies in pages of 2 MB, where the system gives them."""
import gc
from pathlib import Path

import pytest

import smidgen

SETTING = Path("/sys/kernel/mm/transparent_hugepage/enabled")


def in_large_pages() -> int:
    """Bytes of this process."""
    lines = Path("/proc/self/smaps").read_text().splitlines()
    return 1024 * sum(int(line.split()[1]) for line in lines if line.startswith("AnonHugePages:"))


def test_a_large_state_lies_in_large_pages():
    if not SETTING.exists() or "[madvise]" not in SETTING.read_text():
        pytest.skip("the system gives no large pages to those that ask for them alone")
    gc.collect()        # states of other tests, which would give theirs back in between
    before = in_large_pages()
    model = smidgen.build("cubic_lattice", parameters={"nx": 40, "ny": 40, "nz": 40}).start("random", h=0.01).steps(1)
    assert in_large_pages() - before > 4 * model.w.nbytes
