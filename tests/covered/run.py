"""`make coverage`: run the tests with counters in the C, and write docs/coverage.md."""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

HERE = Path(__file__).resolve().parent
if __name__ == "__main__":
    sys.path.insert(0, str(HERE.parent))

from covered.gather import counts  # noqa: E402
from mutants.report import code, table  # noqa: E402

ROOT = HERE.parent.parent
LEAST = 0.99
# The tests of the headers, and of steps that come to their edges, as few files as take all branches that any takes; without other
# compilers and copies with faults.
RUN = re.compile(r"/runtime/test_(band|edges_of_\w+|follow|krylov|lanes|newton_at_large_steps|row_(blocks|wave)|rows"
                 r"|rows_(absent|beyond|by_site|classical|composed|families|far|growing|held|in_time|radii|tangent|torques)|runtime|shown|sparse|states_without_memory|tracers_in_lanes|units)\.py"
                 r"|/run/test_(checkpoint|ensemble|interface|nearness|parameters|set_state|shared_model|spoilt_states|statuses|tolerance)\.py"
                 r"|/laws/test_(accepted_steps|bad_steps|damping|held|noise|noise_edges|parallel_spins|response|second_solution)\.py"
                 r"|/method/test_(comparators|compositions|dop853_header|field_rows|gauss_header|gauss_rows|pair_rows|splittings)\.py"
                 r"|/method/test_(sublattice_rows|tangent)\.py|/language/test_draws\.py")
# Those of which tests that are slow take more.
SLOW = re.compile(r"test_(bad_steps|compositions|dop853_header|draws|edges_of_\w+|ensemble|field_rows|gauss_header|gauss_rows|held|interface|lanes|noise|noise_edges|pair_rows|parallel_spins|parameters"
                  r"|response|row_blocks|row_wave|rows|rows_composed|rows_tangent|runtime|set_state|shared_model|spoilt_states|states_without_memory|statuses|tangent|tolerance)\.py")
DESELECTED = "not ranks_refuse and not mutants and not meanwhile and not clang and not g++"


def measure(place: Path) -> tuple[dict, str]:
    """(counts of all headers, the last lines of pytest). Raises RuntimeError when tests do not run."""
    data, shims = place / "data", place / "bin"
    shims.mkdir()
    for name in ("gcc", "cc"):
        shutil.copy(HERE / "shim.sh", shims / name)
    env = {**os.environ, "REAL_GCC": shutil.which("gcc"), "GCOV_PREFIX": str(data), "OPENBLAS_NUM_THREADS": "1",
           "PATH": f"{shims}:{os.environ['PATH']}", "CC": ""}
    files = sorted(str(p.relative_to(ROOT)) for p in (ROOT / "tests").rglob("test_*.py") if RUN.search(str(p)))
    last = [run(place, env, "not long and not slow", files), run(place, env, "slow and not long", [f for f in files if SLOW.search(f)])]
    return counts(data, ROOT / "runtime"), "\n".join(last)


def run(place: Path, env: dict, marks: str, files: list) -> str:
    """The last line of pytest. Each run has a folder of its own: a program at the path of an earlier one would replace its counts."""
    said = subprocess.run([sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-m", marks, "-k", DESELECTED,
                           f"--basetemp={place / marks.replace(' ', '-')}", *files], cwd=ROOT, env=env, capture_output=True, text=True)
    if said.returncode not in (0, 1):
        raise RuntimeError(said.stdout[-3000:] + said.stderr[-1000:])
    return said.stdout.strip().splitlines()[-1]


def missing(header: str, taken: dict) -> list:
    """(line number, its text, how many of its branches were taken, of how many), for each line that lacks some."""
    text = next((ROOT / "runtime").rglob(header)).read_text().split("\n")
    return [(n, text[n - 1].strip(), sum(c > 0 for c in b), len(b)) for n, b in sorted(taken.items()) if b and 0 in b]


def reasons() -> dict:
    return {entry["code"]: entry["reason"] for entry in tomllib.loads((HERE / "reasons.toml").read_text()).get("branch", [])}


def reason_of(line: str, known: dict) -> str | None:
    """That of a statement of which it is a line, or of the line itself."""
    return next((reason for code, reason in known.items() if line in code), None)


def rows(found: dict) -> list:
    """(header, taken, branches, per cent) of every header of the runtime; one that nothing includes has no branch."""
    table_rows = []
    for header in sorted(p.name for p in (ROOT / "runtime").rglob("*.h")):
        branches = [c for b in found.get(header, {}).values() for c in b]
        taken = sum(c > 0 for c in branches)
        table_rows.append((header, taken, len(branches), f"{100 * taken / len(branches):.1f}" if branches else
                           "no branch" if header in found else "not compiled"))
    return table_rows


def page(found: dict) -> tuple[str, float, list]:
    """(docs/coverage.md, part of the branches taken, lines without a reason)."""
    per_header = rows(found)
    taken, total = (sum(r[k] for r in per_header) for k in (1, 2))
    lacking = [(h, *m) for h in sorted(found) for m in missing(h, found[h])]
    known = reasons()
    why = {line: reason for _, _, line, _, _ in lacking if (reason := reason_of(line, known))}
    text = [
        "# Branch coverage of the runtime\n",
        "`make coverage` writes this page. It uses gcov to count the branches taken in all generated models and test programs that the tests build, "
        "and sums the counts by header, line and branch. Where the last column is empty, it is not known why the branch was not reached.\n",
        f"**{100 * taken / total:.1f} %** of {total} branches are taken.\n",
        table(("header", "taken", "branches", "%"), [*per_header, ("all", taken, total, f"{100 * taken / total:.1f}")]) + "\n",
        "## Branches that no test takes\n",
        table(("header", "code", "taken", "reason"),
              [(h, code(line), f"{a} of {b}", why.get(line, "")) for h, _, line, a, b in lacking]) + "\n"]
    return "\n".join(text), taken / total, [line for _, _, line, _, _ in lacking if line not in why]


def main() -> int:
    with tempfile.TemporaryDirectory(prefix="coverage-") as place:
        found, last = measure(Path(place))
    text, part, bare = page(found)
    (ROOT / "docs/coverage.md").write_text(text)
    print(text, last, sep="\n")
    if bare:
        print("no reason in tests/covered/reasons.toml:", *bare, sep="\n  ")
    return int(part < LEAST or bool(bare))


if __name__ == "__main__":
    sys.exit(main())
