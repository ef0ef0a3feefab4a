"""Random specs through everything (docs/fuzzing.md): the target itself, and a few specs of it."""
import csv
import faulthandler
import os
import random
import re
import signal
from types import SimpleNamespace

import pytest
import smidgen
from fuzz import specs, through as passage
from fuzz.differential import Mismatch
from fuzz.drawn import LEVELS, LIBRARIES, PROGRAMS, builds_of, features_of, said
from fuzz.invent import files_of
from fuzz.layouts import rows, spec_text
from fuzz.table import counted, tables
from fuzz.smaller import smaller
from fuzz.specs import KINDS, attempt, closing, many, rows_of, signature
from fuzz.through import Fault, through

from smidgen.errors import BuildError, RunError
from smidgen.compile.emit.amalgamate import inline_runtime
from smidgen.compile.emit.emit import generate
from smidgen.compile.select import select
from smidgen.compile.features import FEATURES
from smidgen.methods import METHODS, SOLVERS
from smidgen.run.settings import settle
from smidgen.run.step.status import Status

# 6: blocks, 29: few in lanes, 43: Gauss collocation; 0: a wavefront; 1047: if within min, of a vector of several factors;
# 316: sizes refused where `a && (b || c)` holds
FEW = (6, 29, 43, 0, 1047, 316)


@pytest.mark.parametrize("seed", [pytest.param(seed, marks=pytest.mark.long if seed in (0, 29) else ()) for seed in FEW])
def test_a_random_spec_goes_through(seed):
    assert through(spec_text(random.Random(seed)))["verdict"] in ("fine", "refused")


# -- planted faults are found, each at its stage ----------------------------------------------------

CHAIN = """# features: tangent
[model]
name = "random_model"
[space]
w = { sphere = "n", kappa = "gamma[i]" }
[parameters]
n = 3
J = 0.7
gamma = { default = [0.6, -0.8, 1.1], size = "n" }
[effects.e0]
over = "bond(i, j) of chain(n, open)"
energy = "-J*gamma[i]*dot(w[i], w[j])"
[effects.e1]
over = "site(i) of w"
energy = "gamma[i]*w[i].z^2*cos(t)"
[starts.s]
theta = "0.4 + 0.3*i"
phi = "2*i"
[runs.fuzz]
start = "s"
h = 0.01
steps = 10
"""
FAULTS = {
    "a size that is too large": ("model->n0 = model->p.n;", "model->n0 = model->p.n + 1;", (Fault, BuildError), "compilers|sanitizers|library"),
    "an entry beyond the array": ("k < smg_sites(c); ++k) {\n    there |=", "k <= smg_sites(c); ++k) {\n    there |=",
                                  Fault, "sanitizers"),
    "an index that nothing declares": ("{ return c->model->p.gamma[i]; }", "{ return c->model->p.gamma[j]; }", Fault, "compilers"),
    "a variable that nothing uses": ("  return h / smg_kappa(c, k);", "  int unused;\n  return h / smg_kappa(c, k);", Fault, "compilers"),
    "memory that is too small": ("return sizeof(smg_real) * smg_layout(&s, NULL);", "return sizeof(smg_real) * smg_layout(&s, NULL) - 8;", Fault, "sanitizers"),
    "what a restored state lacks": ("  smg_copy(s->compensation, lost, 3 * smg_sites(&s->c));\n", "  (void)lost;\n", Fault, "sanitizers"),
    "a sum of integers that overflows": ("  return h / smg_kappa(c, k);", "  volatile int64_t most = INT64_MAX;\n  most = most + 1;\n  return h / smg_kappa(c, k);", Fault, "sanitizers"),
    "a step that never ends": ("if (model->n0 < 1 ||", "for (volatile int k = 1; k;) {}\n  if (model->n0 < 1 ||", Fault, "sanitizers"),
    "a strength that is wrong by 1e-12": ("return h / smg_kappa(c, k)", "return h * (smg_real)1.000000000001 / smg_kappa(c, k)", Mismatch, "witness")}


@pytest.mark.parametrize("name", [n if n in list(FAULTS)[:4] else pytest.param(n, marks=pytest.mark.long) for n in FAULTS])
def test_a_planted_fault_is_found(monkeypatch, name):
    old, new, kind, where = FAULTS[name]
    stages = []

    def change(files):
        files = inline_runtime(files, "random_model")
        assert old in files["random_model.c"]
        return {**files, "random_model.c": files["random_model.c"].replace(old, new, 1)}
    monkeypatch.setattr(passage, "SECONDS", 3 if name == "a step that never ends" else 20)
    monkeypatch.setattr(passage, "COMPILERS", {c: passage.COMPILERS[c] for c in ("gcc",)})
    with pytest.raises(kind):
        through(CHAIN, stages.append, change)
    assert re.fullmatch(where, stages[-1])


WARM = CHAIN.replace("# features: tangent", "# features: ensemble").replace("[starts.s]", """[effects.d0]
over = "site(k) of w"
damping = "0.3"
kT = "%s"
[starts.s]""")
COLD = {"a variance that is off in the third digit": ("part - part * part / 6", "part - part * part / 7", Mismatch, "witness"),
        "both halves with the same numbers": ("SMG_USE_NOISE + 2 * turn + half", "SMG_USE_NOISE + 2 * turn + 0 * half", Mismatch, "witness"),
        "a seed that is not restored": ("  s->seed = (uint64_t)in", "  if (s->h < 0) s->seed = (uint64_t)in", Fault, "sanitizers"),
        "members with one noise": ("s->member = member;", "s->member = 0 * member;", Fault, "sanitizers")}


@pytest.mark.parametrize("kT", [0.4, pytest.param(300, marks=pytest.mark.long)])
@pytest.mark.parametrize("name", [None, *(pytest.param(n, marks=pytest.mark.long) if k else n for k, n in enumerate(COLD))])
def test_noise_is_looked_at(monkeypatch, name, kT):
    """kT = 300: several turns a step."""
    monkeypatch.setattr(passage, "COMPILERS", {c: passage.COMPILERS[c] for c in ("gcc",)})
    if name is None:
        assert through(WARM % kT)["verdict"] == "fine"
        return
    old, new, kind, where = COLD[name]
    stages = []

    def change(files):
        files = inline_runtime(files, "random_model")
        assert old in files["random_model.c"]
        return {**files, "random_model.c": files["random_model.c"].replace(old, new, 1)}
    with pytest.raises(kind):
        through(WARM % kT, stages.append, change)
    assert stages[-1] == where


def test_the_same_without_a_fault():
    found = through(CHAIN)
    assert found["verdict"] == "fine" and not found["note"] and found["solver"] == "band"


# -- the specs --------------------------------------------------------------------------------------

@pytest.mark.quick
def test_random_specs_can_be_read(tmp_path):
    """They fit at the defaults and at the values of their run."""
    for seed in range(40):
        text = spec_text(random.Random(seed))
        for name, content in files_of(text).items():
            (tmp_path / name).write_text(content)
        (tmp_path / "model.toml").write_text(text)
        spec = smidgen.load(tmp_path / "model.toml")
        s = settle(spec, "fuzz")
        select(spec, s.effects, s.parameters)


@pytest.mark.quick
def test_random_specs_are_of_every_kind():
    """In five hundred each kind occurs, often enough to be met in a thousand; all methods of one stage but splittings, solvers, features, layouts, and all pairs of
    a compiler and a level."""
    texts = [spec_text(random.Random(seed)) for seed in range(500)]
    assert [k for k, p in KINDS.items() if sum(bool(re.search(p, t)) for t in texts) < 3] == []
    assert {f for t in texts for f in features_of(t)} == set(FEATURES)
    drawn = {key: {re.search(rf'\n{key} = "(.*)"', t).group(1) for t in texts} for key in ("method", "solver")}
    assert drawn["solver"] == set(SOLVERS) and drawn["method"] <= set(METHODS) and {m.name for m in METHODS.values() if m.stages == 1 and not m.splitting} <= drawn["method"]
    assert {said(t, "layout") for t in texts} == set(passage.LAYOUTS)
    assert {tuple(builds_of(t)[0]) for t in texts} == {(c, level) for c in PROGRAMS for level in LEVELS}
    assert {tuple(builds_of(t)[1]) for t in texts} == {(c, level) for c in LIBRARIES for level in LEVELS}
    assert spec_text(random.Random(3)) == spec_text(random.Random(3))


@pytest.mark.quick
def test_lattices_of_equal_spheres_go_by_rows():
    """All of them whose midpoints are swept."""
    texts = [t for t in (rows(random.Random(seed)) for seed in range(12)) if 'method = "spherical-midpoint"' in t][:4]
    for text in texts:
        assert "define SMG_BY_ROWS 1" in generate(smidgen.load_text(text), features=features_of(text))["random_model.c"]


@pytest.mark.quick
@pytest.mark.skipif("clang" not in passage.COMPILERS, reason="no clang")
def test_gauss_by_rows_has_no_function_that_nothing_uses(tmp_path):
    spec = smidgen.load_text(CHAIN.replace(', kappa = "gamma[i]"', "").replace("gamma[i]*", "").replace("*cos(t)", ""))
    made = generate(spec, method="gauss-4")
    assert "define SMG_ROW_STAGES 1" in made["random_model.c"]
    passage.write_files(made, tmp_path)
    assert passage.compile_all(tmp_path, sorted(f for f in made if f.endswith(".c")), "clang") == ""


@pytest.mark.quick
def test_the_table_counts_every_spec():
    rows = [dict(layout=where, method=method, program="g++ -O2", library="gcc -O0", verdict=verdict)
            for where, method, verdict in (("rows", "gauss-4", "fine"), ("rows", "gauss-6", "fault"), ("", "dop853", "refused"), ("rows", "gauss-4", "fine"))]
    counts = counted(rows)
    assert sum(c["specs"] for c in counts) == 4 and sum(c["fine"] for c in counts) == 2
    text = tables(counts, "abc", "seeds 0 to 3", 2)
    assert "4 specs, seeds 0 to 3: 2 passed, 1 refused" in text and "fewer steps than the program in 2 of them" in text and "1 faults" in text and "| rows | 3 |  | 3 |" in text


# -- each spec in a process of its own --------------------------------------------------------------

def forever(*_, **__):
    while True:
        pass


def crash(*_, **__):
    faulthandler.disable()      # no report of it
    os.kill(os.getpid(), signal.SIGSEGV)


def wrong(*_, **__):
    raise KeyError("ImaginaryUnit")


@pytest.mark.quick
@pytest.mark.parametrize("what, said", [(forever, "hangs"), (crash, "died: -11"), (wrong, "KeyError: .. in")])
def test_whatever_a_spec_does_is_a_row(monkeypatch, what, said):
    monkeypatch.setattr(specs, "through", what)
    row = attempt("", seconds=0.3)
    assert row["verdict"] == "fault" and row["said"].startswith(said.removesuffix(" in")) or said in row["said"]


@pytest.mark.quick
def test_a_value_that_is_not_finite_is_a_fault():
    """A step that is refused for another reason is none."""
    one = SimpleNamespace(found={"note": ""})
    passage.Passage.refused(one, "status 1 after 3 steps", 1)
    assert one.found["verdict"] == "refused"
    for refusal in (("status 4 after 0 steps", 4), (RunError("a value is not finite", Status.NOT_FINITE),)):
        with pytest.raises(Fault, match="not finite"):
            passage.Passage.refused(one, *refusal)


@pytest.mark.quick
def test_a_run_goes_on_where_it_was_stopped(monkeypatch, tmp_path):
    """Seeds with a whole row are not done again; one whose row was cut off, or of other code, is."""
    begun = []
    monkeypatch.setattr(specs, "through", lambda *a, **k: {"verdict": "fine", "note": ""})
    monkeypatch.setattr(specs, "spec_text", lambda dice: begun.append(dice) or "")
    path = tmp_path / "specs.csv"
    many(range(3), 2, path)
    path.write_bytes(path.read_bytes()[:-9])
    many(range(5), 2, path)
    assert len(begun) == 3 + 3 and sorted(int(r["seed"]) for r in rows_of(path)) == [0, 1, 2, 3, 4]
    monkeypatch.setattr(specs, "code", lambda: "other")
    many(range(5), 1, path)
    assert len(begun) == 11


@pytest.mark.quick
def test_a_fault_is_saved_and_counted(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(specs, "through", wrong)
    assert specs.main(["--count", "2", "--out", str(tmp_path / "specs.csv"), "--shrink", "0.1"])
    said = capsys.readouterr().out
    assert "2 faults" in said and "KeyError" in said
    assert (tmp_path / "specs" / "1" / "whole.toml").read_text() == spec_text(random.Random(1))
    assert "--spec" in (tmp_path / "specs" / "0" / "said.txt").read_text() and (tmp_path / "specs" / "0" / "smallest.toml").exists()
    with open(tmp_path / "specs.csv", newline="") as lines:
        assert [r["seed"] for r in csv.DictReader(lines)] == ["0", "1"]


@pytest.mark.quick
def test_what_is_saved_is_small():
    """Down to what can be read and still has the part that matters."""
    def still(text):
        try:
            return "gamma[i]*w[i]" in text and bool(smidgen.load_text(text))
        except smidgen.SmidgenError:
            return False
    least = smaller(CHAIN, still, 20)
    assert still(least) and len(least) < 200 and "e0" not in least and "runs" not in least


@pytest.mark.quick
def test_faults_of_one_cause_have_one_name():
    told = [signature(Fault(f"x.c:{k}:7: error: unused variable ‘j{k}’ [-Werror]")) for k in (1, 22)]
    assert told[0] == told[1] and "unused variable" in told[0]
    other = signature(Fault("==7==ERROR: AddressSanitizer: heap-buffer-overflow on\n #0 0x1 in random_model_check /x.c:3"))
    assert other == "AddressSanitizer: heap-buffer-overflow in random_model_check"
    assert closing([], specs.OUT)
