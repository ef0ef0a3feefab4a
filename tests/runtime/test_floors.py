"""The floors of runtime/: what a header includes lies beside it or below."""
import re

import pytest
from smidgen.resources import ROOMS, folder

pytestmark = pytest.mark.quick
RUNTIME = folder("runtime")
ROOM = {path.name: path.parent.relative_to(RUNTIME).as_posix() for path in RUNTIME.rglob("*.h")}
METHODS = ("method/midpoint", "method/gauss", "method/explicit")        # beside each other


def floor(room: str) -> int:
    return ROOMS.index(METHODS[0] if room in METHODS else room)


def upward(text: str, room: str) -> list:
    """The headers that a header of this room must not include."""
    found = [ROOM[name] for name in re.findall(r'#[ \t]*include[ \t]*"(\w+\.h)"', text)]
    return [other for other in found if floor(other) > floor(room) or floor(other) == floor(room) and other != room]


def test_every_header_has_a_floor():
    """And a name of its own: generated C includes it by that alone."""
    assert set(ROOM.values()) == set(ROOMS)
    assert len(ROOM) == len([*RUNTIME.rglob("*.h")])


@pytest.mark.parametrize("room", ROOMS)
def test_no_header_includes_one_from_above(room):
    assert {path.name: found for path in (RUNTIME / room).glob("*.h") if (found := upward(path.read_text(), room))} == {}


def test_an_include_from_above_is_seen():
    text = '#include "smg_model.h"\n#if SMG_BY_ROWS\n# include "smg_row_state.h"\n#endif\n#include "smg_cf4.h"\n'
    assert upward(text, "core") == ["lattice", "method/explicit"]
    assert upward(text, "method/gauss") == ["method/explicit"] and upward(text, "members") == []
