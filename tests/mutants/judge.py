"""Do the tests notice? They run in the copy of the tree, the cheapest and sharpest first, to the first failure."""
import json
import os
import re
import resource
import signal
import subprocess
import sys
from pathlib import Path

from .plant import Tree

# Tests of what lies beside the step (reading, running, drawing, packing), and dear ones that ask again what others ask.
BESIDE = re.compile(r"^tests/(build|cli|covered|effects|frozen|fuzz|hard|language|linking|model|mutants|read|show|test_stages)"
                    r"|test_(advice|bound_threads|contracts|determinism|distributed|doctor|explain|floors|format|full_disk|huge_pages|hundred_kills|includes|late_messages"
                    r"|paper_numbers|plan|ranks|received|resume|rules|run|sections|spectrum|spin_waves|start|stop|verify|waves|witness)(_\w*)?\.py")
RUNTIME = re.compile(r"test_(edges_of_runtime|runtime|krylov|band|sparse|follow|wide|unit|shown)")     # of the headers alone
# In this order; tests that fit no line come last, and before all the runtime's, for a fault there.
STAGES = (r"test_agreement.*(rigid_body|two_bodies|product|nambu_a3[48]|unusual|graph|moser)",
          r"test_(effort|newton|second_solution|states)", r"test_(agreement|properties|branch|statuses|hard_cases)",
          r"test_(symplectic|tangent)", r"test_(hard|round_off|certificate|verify|unusual)",
          r"runs?_clean", r"test_(validate|user_specs|advice)", r"")
SHARP = 3       # stages that are run before the quick tier
# Before these: the tests that were made for faults of a kind, or for what a file does.
MADE_FOR = {"rows": r"test_row(s|_wave|_blocks)|statuses", "method": r"test_(comparators|splittings|compositions|lengths)|edges_of_steps", "branch": r"second_solution|branch|statuses|eigenvalue|pivots|decoupled|bad_steps", "jacobian": r"test_effort|test_tangent",
            "time": r"middle_of_the_step|forced|pulse|kicked", "tolerance": r"test_tolerance|round_off|hard_cases|statuses|effort|decayed|bad_steps|digits",
            "wrap": r"lattice|chain|honeycomb|glass|graph|corners|band|triangular",
            **{f"smg_{word}": made for words, made in (
                ("one_stage slopes angles cf4 heun depondt isospectral geodesic exponential rattle explicit", r"test_(comparators|noise)|edges_of_steps"), ("axis", r"test_splittings"), ("sublattice", r"test_(splittings|sublattice)"),
                ("pair_", r"test_(splittings|pair_rows)"), ("turn_", r"test_(sublattice|pair)_rows"),
                ("compos stage_pred suzuki ss kl", r"test_compositions"), ("gauss", r"test_gauss"), ("dop853", r"test_dop853"),
                ("dormand field_", r"test_(dormand_prince|field_rows)"), ("respond own_response", r"test_(response|damping|torque)"),
                ("thermal random", r"test_noise"), ("parameters set_state", r"test_(parameters|set_state|shared_model)"), ("outputs", r"test_nearness|outputs"),
                ("extrapolation right_side", r"test_(extrapolation|dop853)"), ("lane_batch lane_sphere lane_dop853 lane_extrapolation tableau_template dop853_template", r"test_ensemble"), ("lengths", r"test_lengths|comparators")) for word in words.split()},
            "runtime/lattice/smg_row": r"test_row(s|_wave)", "runtime/lattice/smg_row_tangent.h": r"test_rows_tangent", "runtime/lattice/smg_few": r"test_few", "runtime/lattice/smg_alone": r"test_tracers_in_lanes", "runtime/newton/smg_rest": r"test_(rows|few|gauss_rows)",
            "runtime/core/smg_fixed": r"test_(comparators|gauss)", "runtime/newton/smg_matrix": r"band|sparse|dense|newton|krylov",
            "runtime/newton/smg_krylov": r"krylov", "runtime/newton/smg_predictor": r"effort|few|predict", "runtime/members/smg_ensemble": r"test_ensemble",
            "runtime/core/smg_lane": r"test_(lanes|rows|few|gauss)",
            "runtime/method/midpoint/smg_tangent.h": r"test_tangent|test_lyapunov", "runtime/core/smg_extended.h": r"wide|round_off|extended",
            "runtime/core/smg_saved.h": r"test_(checkpoint|resume|substeps)", "runtime/lattice/smg_sweep.h": r"lattice|chain|sweep|glass|bad_steps.*cubic",
            "runtime/newton/smg_alone.h": r"product|tracers|local|decoupled", "runtime/method/midpoint/smg_single_sphere.h": r"rigid_body|solo|top", "runtime/method/midpoint/smg_sphere_template.h": r"rigid_body|solo|top|test_ensemble",
            "runtime/newton/smg_newton.h": r"chain|vortices|graph|newton", "runtime/newton/smg_coupled.h": r"edges_of_steps|test_agreement", "runtime/core/smg_state.h": r"test_interface|energy|momentum",
            "runtime/newton/smg_midpoint.h": r"nambu|extended|classical|a3|field", "templates/abi.c.j2": r"test_interface|abi|observable", "templates/ensemble": r"test_ensemble",
            "runtime/core/smg_site.h": r"units|frame", "runtime/newton/smg_follow.h": r"follow|curve", "runtime/newton/smg_band.h": r"band|branch", "runtime/newton/smg_sparse.h": r"sparse|branch",
            "runtime/newton/smg_dense.h": r"dense|branch", "runtime/core/smg_spin.h": r"spin", "runtime/core/smg_wide": r"wide"}
OTHER_BUILDS = re.compile(r"\[(.*-)?(clang|g\+\+|gcc-long-double)")      # the same again, by another compiler
SANITIZED = re.compile(r"runs?_clean")     # whole models, built with sanitizers
LONGEST = 25.0      # seconds: a test that takes longer is left to the other tiers


def test_files(tree: Path) -> list[str]:
    """The files of tests that are run, relative to the tree."""
    found = sorted(str(p.relative_to(tree)) for p in (tree / "tests").rglob("test_*.py"))
    return [name for name in found if not BESIDE.search(name)]


def stage(name: str) -> int:
    return next((k for k, pattern in enumerate(STAGES) if pattern and re.search(pattern, name)), STAGES.index(""))


def order_of(tests: dict, mutant) -> list[list[str]]:
    """The sharp tests; the quick tier's others and models with sanitizers; both in the order of running; of the headers only for a fault there."""
    runtime = mutant.file.startswith("runtime/") or mutant.file == "gen/compile/plan/ordering.py"
    made = re.compile("|".join(words for of, words in MADE_FOR.items() if of == mutant.kind or mutant.file.startswith(of) or Path(mutant.file).name.startswith(of)) or "(?!)")
    names = [n for n, (seconds, _) in tests.items() if seconds <= LONGEST and (runtime or not RUNTIME.search(n))]
    names.sort(key=lambda n: (not made.search(n), not RUNTIME.search(n), stage(n), tests[n][0]))
    sharp = [n for n in names if (made.search(n) or RUNTIME.search(n) or stage(n) < SHARP) and not OTHER_BUILDS.search(n)]
    return [sharp, [n for n in names if n not in set(sharp) and (tests[n][1] or SANITIZED.search(n))]]


def limited():
    """A process group of its own, and no core files."""
    os.setsid()
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def run_tests(tree: Tree, files, order, first: bool, limit: float):
    """(exit status, or None past `limit` seconds; the log's lines). `order`: {test: its limit}, None for all."""
    log, listing = tree.place / "log", tree.place / "order"
    log.write_text("")
    listing.write_text(json.dumps(order))
    words = [sys.executable, "-m", "pytest", "-q", "-p", "mutants.order", "-p", "no:cacheprovider", "-p", "no:faulthandler",
             "-p", "no:xdist", "-m", "not long", f"--basetemp={tree.place / 'tmp'}", *(["-x"] if first else []), *files]
    env = tree.environment() | {"MUTANT_LOG": str(log)} | ({} if order is None else {"MUTANT_ORDER": str(listing)})
    with open(tree.place / "said", "w") as said:
        process = subprocess.Popen(words, cwd=tree.tree, env=env, stdout=said, stderr=said, preexec_fn=limited)
        try:
            status = process.wait(limit)
        except subprocess.TimeoutExpired:
            status = None
        kill_group(process)
    return status, [json.loads(line) for line in log.read_text().splitlines()]


def kill_group(process) -> None:
    """Also what a test has started and left behind."""
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass
    process.wait()


def baseline(tree: Tree, file: str) -> dict:
    """Of a file of tests on the tree as it is: {"tests": {those that pass: (seconds, in the quick tier)}, "failing": [..]}."""
    status, lines = run_tests(tree, [file], None, first=False, limit=1500)
    if status not in (0, 1, 5):
        raise RuntimeError(f"{file} does not run on the unchanged tree:\n" + (tree.place / "said").read_text()[-3000:])
    done = {e["ends"]: e for e in lines if "ends" in e}
    failed = sorted({e["ends"] for e in lines if e.get("outcome") == "failed"})
    passed = {n: (e["seconds"], e["quick"]) for n, e in done.items() if e["outcome"] == "passed" and n not in failed}
    return {"tests": passed, "failing": failed}


def listed(tests: dict, names) -> tuple[list, dict, float]:
    """(their files, {test: seconds it may take}, seconds for all) of tests by name. `tests`: {name: (seconds, quick)}."""
    files = list(dict.fromkeys(n.partition("::")[0] for n in names))
    return files, {n: max(60.0, 20 * tests[n][0]) for n in names}, 600 + 10 * sum(tests[n][0] for n in names)


def judge(tree: Tree, tests: dict, names) -> str | None:
    """Which of the named tests notices the planted fault, and how if it did not just fail; None when all pass."""
    files, order, limit = listed(tests, names)
    return caught(tree, *run_tests(tree, files, order, first=True, limit=limit)) if names else None


def failing(tree: Tree, tests: dict, names) -> list[str]:
    """Those of the named tests that do not pass on the tree as it is; one that is no longer there does not."""
    names, gone = [n for n in names if n in tests], [n for n in names if n not in tests]
    files, order, limit = listed(tests, names)
    lines = run_tests(tree, files, order, first=False, limit=limit)[1] if names else []
    passed = {e["ends"] for e in lines if e.get("outcome") == "passed"} - {e["ends"] for e in lines if e.get("outcome") == "failed"}
    return gone + [n for n in names if n not in passed]


def caught(tree: Tree, status, lines) -> str | None:
    """The test that failed, or "test (crash)", "test (hang)"; None when all passed."""
    if status == 0:
        return None
    failed = [e["ends"] for e in lines if e.get("outcome") == "failed"]
    if failed:
        return failed[0]
    if status is not None and -status in (signal.SIGTERM, signal.SIGKILL, signal.SIGINT, signal.SIGHUP):
        raise RuntimeError("the tests were ended from outside")
    if status in (4, 5):        # no such test, or none at all
        raise RuntimeError((tree.place / "said").read_text()[-3000:])
    under_way = [e["begins"] for e in lines if "begins" in e]
    if not under_way:
        raise RuntimeError("no test has begun:\n" + (tree.place / "said").read_text()[-3000:])
    return f"{under_way[-1]} ({'crash' if status is not None and status < 0 else 'hang'})"
