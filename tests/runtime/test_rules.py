"""Every rule once: the table of docs/architecture.md names the headers that state a rule, and no other header does."""
import re
from pathlib import Path

import pytest
from support.headers import ROOT, code, headers

pytestmark = pytest.mark.quick
NAMED = re.compile(r"((?:`\w+`(?:, | and )?)+) (?:of|in) ((?:`[\w/]+\.h`(?:, | and )?)+)")
# rule -> what tells that a header states it
TOLD_BY = {
    "stagnation": r"\bSMG_STILL\b(?! \* SMG_EPS \* size <= SMG_BLIND)|\bnow >= SMG_SLOWED|rate >= SMG_SLOWED",
    "tolerance": r"tolerance \* s->scale",
    "predictor": r"\{3, -3|3, 3, 3, 3, -3|smg_stage_weights\[s->stage\]",
    "choice of its degree": r"-= row\[j \+ 1\]|s->misses\[l\] \+=",
    "history": r"\bsmg_save_(?:history|rows)\(const smg_state \*s, smg_real \*\w+(?:, smg_real \*\w+)?\) \{",
    "compensated sum": r"- \(sum - |- \(W\.x - |_sub\((?:y|f->y), smg_vec_sub\(|\(smg_wide\)sum - ",
    "rollback": r"\bsmg_give_back\(|s->unturned, n3\)|newton_steps = newton_steps",
}


def rows() -> dict:
    """rule -> (where it stands, where it is stated again, the count that is given)."""
    text = (ROOT / "docs" / "architecture.md").read_text().split("## Every rule once")[1].split("\n## ")[0]
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines() if line.startswith("|")][2:]
    return {rule.split(":")[0]: (stands, again, int(now)) for rule, stands, again, _, now in cells}


def named(text: str) -> dict:
    """header -> the names that the text says are in it."""
    found = {}
    for names, files in NAMED.findall(text):
        for file in re.findall(r"[\w/]+\.h", files):
            found.setdefault(Path(file).name, set()).update(re.findall(r"`(\w+)`", names))
    return found


ROWS = rows()
TEXTS = {path.name: code(path.read_text()) for path in headers()}


def test_the_table_has_the_rules():
    assert {*ROWS} >= {*TOLD_BY, "branch", "end against drift"}


@pytest.mark.parametrize("rule", ROWS)
def test_what_is_named_is_there(rule):
    stands, again, count = ROWS[rule]
    places = named(f"{stands} {again}")
    assert named(stands) and len(places) == count
    assert [(file, name) for file, names in places.items() for name in names if not re.search(rf"\b{name}\b", TEXTS[file])] == []


@pytest.mark.parametrize("rule", TOLD_BY)
def test_no_other_header_states_it(rule):
    stands, again, _ = ROWS[rule]
    told = {file for file, text in TEXTS.items() if re.search(TOLD_BY[rule], text)}
    assert told and told <= {*named(f"{stands} {again}")}


def test_a_second_statement_is_seen():
    assert re.search(TOLD_BY["tolerance"], "if (x <= s->tolerance * s->scale) return 1;") and not re.search(TOLD_BY["tolerance"], "return smg_tolerated(s, x);")
    assert named("`smg_a`, `smg_b` of `core/smg_x.h`; `smg_c` in `smg_y.h` and `smg_z.h`") == {"smg_x.h": {"smg_a", "smg_b"}, "smg_y.h": {"smg_c"}, "smg_z.h": {"smg_c"}}
