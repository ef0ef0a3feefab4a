"""Which headers a text includes, by the macros of a model."""
import pytest
from smidgen.compile.emit.includes import included

pytestmark = pytest.mark.quick
CHAIN = """#if SMG_A
#include "a.h"
#elif SMG_B
#include "b.h"
#elif !SMG_C
#include "c.h"
#else
#include "d.h"
#endif
#include "last.h"
"""


@pytest.mark.parametrize("macros, wanted", [({"SMG_A": 1}, "a"), ({"SMG_A": 1, "SMG_B": 1}, "a"), ({"SMG_B": 1}, "b"), ({}, "c"), ({"SMG_C": 2}, "d")])
def test_one_branch_of_a_chain(macros, wanted):
    assert included(CHAIN, macros) == [f"{wanted}.h", "last.h"]


def test_what_is_not_decided_counts_as_true():
    text = '#if defined(OTHER)\n#include "a.h"\n#elif SMG_B\n#include "b.h"\n#else\n#include "c.h"\n#endif\n'
    assert included(text, {"SMG_B": 1}) == ["a.h", "b.h"] and included(text, {}) == ["a.h"]
