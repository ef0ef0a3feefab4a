"""Which headers a text includes, by the macros of a model."""
import pytest
import smidgen
from smidgen.compile.emit.emit import generate
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


def test_a_text_for_several_kinds_of_numbers_is_put_in_for_each():
    """smg_triple_template.h, once for scalars and once for lanes; headers with a guard once."""
    text = generate(smidgen.load("heisenberg_chain"), amalgamate=True)["heisenberg_chain.c"]
    assert text.count("void smg_cross(smg_number *c") == 2 and text.count("#ifndef SMG_LANES_H") == 1


@pytest.mark.parametrize("macros, wanted", [({}, []), ({"SMG_C": 1}, ["c.h"]), ({"SMG_A": 1}, ["a.h"]), ({"SMG_A": 1, "SMG_C": 1}, ["a.h", "c.h"])])
def test_of_several_macros_the_first_may_decide(macros, wanted):
    """SMG_B may be one that a header defines."""
    assert included('#if SMG_A && SMG_B\n#include "a.h"\n#elif SMG_C\n#include "c.h"\n#endif\n', macros) == wanted
    assert included('#if SMG_A && SMG_B || SMG_D\n#include "a.h"\n#endif\n', macros) == ["a.h"]


def test_sweeps_from_site_to_site_are_in_the_single_file():
    """And none of those by rows, without a lattice."""
    text = generate(smidgen.load("point_vortices"), solver="rotation", amalgamate=True)["point_vortices.c"]
    assert text.count("static smg_status smg_sweeps(") == 1 and "SMG_ROW_BEYOND_H" not in text
