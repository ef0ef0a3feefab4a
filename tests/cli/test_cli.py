"""The command: what it prints where, its exit codes, and that no error shows a traceback."""
import json
import os
import pty
import re
import shlex
import signal
import subprocess
import sys
import time
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
import smidgen
import smidgen.errors
from support.pages import blocks, python, sh
from smidgen.cli.options import assignment, whole
from smidgen.cli.parser import make_parser

TOP = "free_rigid_body"
SUBCOMMANDS = ["new", "check", "gen", "build", "run", "validate", "plot", "snapshot", "spectrum", "list"]


@pytest.fixture
def chain(tmp_path, command):
    """A new spec, as a user begins."""
    assert command("new", "spins").returncode == 0
    return tmp_path / "spins.toml"


# Help

@pytest.mark.quick
def test_help_names_every_command(command):
    said = command("--help")
    assert said.returncode == 0 and "exit codes" in said.stdout
    for name in SUBCOMMANDS:
        assert re.search(rf"^    {name} ", said.stdout, re.MULTILINE), name


@pytest.mark.quick
@pytest.mark.parametrize("name", SUBCOMMANDS)
def test_every_command_has_examples(command, name):
    said = command(name, "--help")
    assert said.returncode == 0 and f"smidgen {name} " in said.stdout.split("examples:")[1] + " "


@pytest.mark.quick
def test_the_examples_of_the_help_parse():
    parser = make_parser()
    for name in SUBCOMMANDS:
        sub = parser._subparsers._group_actions[0].choices[name]
        for line in sub.epilog.splitlines()[1:]:
            words = shlex.split(re.split(r"\s{2,}", line.strip())[0])
            assert words[:2] == ["smidgen", name]
            parser.parse_args(words[1:])


@pytest.mark.quick
def test_version(command):
    assert command("--version").stdout.strip() == f"smidgen {smidgen.__version__}"


# new, check, list

def test_new_check_and_run(chain, command, tmp_path):
    assert command("check", chain.name).stdout.startswith("spins.toml: good.")
    said = command("run", chain.name, "--out", "a.npz")
    assert said.returncode == 0 and "1000 of 1000 steps" in said.stdout and not said.stderr
    assert smidgen.load_result(tmp_path / "a.npz").meta["spec"] == "spins"


def test_a_new_spec_is_valid_in_every_sense(chain, command):
    said = command("validate", chain.name)
    assert said.returncode == 0, said.stdout


@pytest.mark.quick
def test_new_from_a_shipped_spec(command, tmp_path):
    assert command("new", "mine", "--from", TOP).returncode == 0
    assert smidgen.load(str(tmp_path / "mine.toml")).name == "mine"


@pytest.mark.quick
@pytest.mark.parametrize("name", ["a-b", "1a", "../a", "", "a b", "é"])
def test_new_refuses_what_is_no_name(command, name):
    assert command("new", name).returncode == 2


@pytest.mark.quick
def test_new_never_overwrites(chain, command):
    before = chain.read_text()
    said = command("new", "spins", "--from", TOP)
    assert said.returncode == 2 and "already exists" in said.stderr and chain.read_text() == before


@pytest.mark.quick
def test_list(command, root):
    found = json.loads(command("list", "--json").stdout)
    assert {f["name"] for f in found} == {p.stem for folder in ("specs", "specs/scenes") for p in (root / folder).glob("*.toml")}
    text = command("list").stdout
    for one in found:
        assert one["name"] in text and one["title"] in text and one["runs"]


@pytest.mark.quick
def test_check_reports_all_specs(chain, command, tmp_path):
    bad = tmp_path / "bad.toml"
    bad.write_text(chain.read_text().replace("dot(w[i], w[j])", "dot(w[i], v[j])"))
    said = command("check", "bad.toml", "spins.toml", "missing.toml", TOP)
    assert said.returncode == 3 and said.stdout.count("good.") == 2
    assert re.search(r"bad\.toml:\d+:\d+: error", said.stderr) and "missing.toml" in said.stderr
    reports = json.loads(command("check", "bad.toml", "spins.toml", "--json").stdout)
    assert [r["ok"] for r in reports] == [False, True]
    assert reports[0]["error"]["diagnostics"][0]["line"] > 1


# gen, build

@pytest.mark.quick
def test_gen_writes_what_it_prints(chain, command, tmp_path):
    said = command("gen", "spins.toml", "--out", "c")
    files = [tmp_path / line for line in said.stdout.splitlines()]
    assert set(files) == set((tmp_path / "c").iterdir()) and "solver" in said.stderr
    assert {"spins.h", "spins.c", "smidgen.h"} <= {f.name for f in files}


def test_what_is_not_called_for_leaves_nothing(chain, command, tmp_path):
    command("gen", "spins.toml", "--effects", "exchange", "--out", "c")
    text = (tmp_path / "c" / "spins.c").read_text() + (tmp_path / "c" / "spins.h").read_text()
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
    assert "exchange" in text and not re.search(r"\bB\b|effect_field|energy_field", text)


def test_build_prints_a_library(command):
    said = command("build", TOP)
    assert said.returncode == 0 and said.stdout.strip().endswith(".so")
    assert "solver" in said.stderr
    told = json.loads(command("build", TOP, "--json").stdout)
    assert told["files"] == [said.stdout.strip()] and "reason" in told["chosen"]


def test_a_failing_compiler(command, tmp_path):
    fake = tmp_path / "cc"
    fake.write_text("#!/bin/sh\n[ \"$1\" = --version ] || { echo 'x.c:1: error: no' >&2; exit 1; }\n")
    fake.chmod(0o755)
    said = command("build", TOP, env={**os.environ, "CC": str(fake)})
    assert said.returncode == 7 and "error: no" in said.stderr and "Traceback" not in said.stderr
    said = command("build", TOP, env={**os.environ, "CC": "no-such-cc"})
    assert said.returncode == 6 and "no-such-cc" in said.stderr


def test_gen_into_a_file(command, tmp_path):
    (tmp_path / "file").write_text("")
    assert command("gen", TOP, "--out", "file/c").returncode == 8


# run

def test_choices_reach_the_run(command, tmp_path):
    said = command("run", TOP, "demo", "--set", "I2=1.5", "--set", "I3=3", "--h", "pi/(64*I1)", "--time",
                   "pi", "--every", "8", "--method", "classical-midpoint", "--solver", "newton",
                   "--what", "states,casimirs", "--out", "a.csv")
    assert said.returncode == 0, said.stderr
    result = smidgen.load_result(tmp_path / "a.csv")
    assert result.meta["parameters"] == {"I1": 1.0, "I2": 1.5, "I3": 3.0}
    assert result.meta["method"] == "classical-midpoint" and result.meta["steps"] == 64
    assert result.step.tolist() == list(range(0, 65, 8)) and set(result.values) == {"casimirs"}


def test_the_json_summary(command):
    told = json.loads(command("run", TOP, "--json").stdout)
    assert told["status"] == "complete" and told["exit_code"] == 0 and told["done"] == told["steps"]
    assert told["errors"]["energy"] < 1e-14 and told["chosen"]


def test_a_table_on_stdout(command):
    said = command("run", TOP, "--steps", "3", "--what", "energy", "--out", "-")
    rows = [line for line in said.stdout.splitlines() if not line.startswith("#")]
    assert rows[0] == "step,t,energy,energy.rotation" and len(rows) == 5
    assert max(map(len, said.stdout.splitlines())) < 200        # neither the whole last state nor all choices
    assert "3 of 3 steps" in said.stderr


@pytest.mark.parametrize("suffix", ["csv", "npz", "h5"])
def test_repeat(command, tmp_path, suffix):
    """From the file alone, in another folder, the spec being gone."""
    command("new", "mine", "--from", TOP)
    command("run", "mine.toml", "--set", "I3=5", "--steps", "50", "--out", f"a.{suffix}")
    (tmp_path / "mine.toml").unlink()
    said = command("run", "--repeat", f"a.{suffix}", "--out", f"b.{suffix}")
    assert said.returncode == 0, said.stderr
    assert (tmp_path / f"a.{suffix}").read_bytes() == (tmp_path / f"b.{suffix}").read_bytes()


def test_a_start_from_a_file(command, tmp_path):
    (tmp_path / "w.csv").write_text("0.6,0,0.8\n")
    assert command("run", TOP, "--start", "w.csv", "--out", "a.npz").returncode == 0
    np.testing.assert_array_equal(smidgen.load_result(tmp_path / "a.npz").w["w"][0], [[0.6, 0, 0.8]])
    np.save(tmp_path / "w.npy", np.array([[0.0, 0.6, 0.8]]))
    assert command("run", TOP, "--start", "w.npy", "--out", "b.npz").returncode == 0
    assert command("run", TOP, "--start", "none.csv").returncode == 2


def test_seeds(command, tmp_path):
    for name, seed in (("a", 3), ("b", 3), ("c", 4)):
        command("run", "heisenberg_chain", "random", "--seed", seed, "--steps", "2", "--every", "1",
                "--what", "states", "--out", f"{name}.npz")
    a, b, c = ((tmp_path / f"{n}.npz").read_bytes() for n in "abc")
    assert a == b and a != c


@pytest.mark.quick
@pytest.mark.parametrize("words, code, said", [
    ([], 2, "required"), (["fly"], 2, "invalid choice"),
    (["run"], 2, "no spec was given"), (["run", "rigid"], 2, "free_rigid_body|smidgen list"),
    (["run", "free_rigid_bod"], 2, "did you mean 'free_rigid_body'"),
    (["run", "missing.toml"], 3, "missing.toml"), (["run", TOP, "nothing"], 2, "demo"),
    (["run", TOP, "--set", "I1"], 2, "NAME=VALUE"), (["run", TOP, "--set", "I1=x"], 2, "error"),
    (["run", TOP, "--set", "I1=nan"], 2, "nan"),
    (["run", TOP, "--set", "I1=exp(999)"], 2, "finite|range|large"), (["run", TOP, "--h", "I7"], 2, "I1"),
    (["run", TOP, "--h", "(" * 5000], 2, "characters"), (["run", TOP, "--time", "(" * 4000], 2, "h|time"), (["run", TOP, "--set", "Q=1"], 2, "Q"),
    (["run", TOP, "--set", "I1=1e999"], 2, "1e999"),
    (["run", TOP, "--effects", "none"], 2, "none"), (["run", TOP, "--h", "0"], 2, "must not be 0"),
    (["run", TOP, "--h", "__import__('os')"], 2, "h:1:12: error"),
    (["run", TOP, "--time", "0.3"], 2, "nearest are 0.25"),
    (["run", TOP, "--steps", "1", "--time", "1"], 2, "not allowed"),
    (["run", TOP, "--steps", "-1"], 2, "non-negative"), (["run", TOP, "--steps", "1.5"], 2, "non-negative"),
    (["run", TOP, "--out", "a.txt"], 2, r"\.csv"), (["run", TOP, "--out", "no/a.csv"], 8, "No such"),
    (["run", TOP, "--what", "colour"], 2, "casimirs"), (["run", TOP, "--start", "x"], 2, "paper"),
    (["run", "--repeat", "none.h5"], 2, "none.h5"), (["run", TOP, "--repeat", "a.h5"], 2, "omit SPEC"),
    (["run", "--repeat", "a.h5", "--h", "1"], 2, "unchanged"), (["run", "--repeat", "a.h5", "--fast"], 2, "unchanged"),
    (["run", "--repeat", "a.h5", "--portable"], 2, "unchanged"), (["run", "--resume", "a.h5", "--real", "long double"], 2, "unchanged"),
    (["run", TOP, "--method", "leapfrog"], 2, "spherical-midpoint"),
    (["run", "/"], 3, "directory"), (["new", "int"], 3, "a reserved word of C"), (["check", "/dev/null"], 3, "model"), (["check", "x\x1b[31m.toml"], 3, "x"),
])
def test_wrong_words(command, words, code, said):
    done = command(*words)
    assert done.returncode == code and re.search(said, done.stderr), done.stderr
    assert "Traceback" not in done.stderr and "\x1b" not in done.stderr and done.stdout == ""


def test_a_step_that_fails(command, tmp_path):
    """lambda h = 3 for a spin at right angles to its field: no solution beyond 2."""
    (tmp_path / "spin.toml").write_text(
        '[model]\nname = "spin"\n[space]\nw = { sphere = 1 }\n[parameters]\nB = { default = 1.0 }\n'
        '[effects.field]\nenergy = "B*w.z"\n[starts.x]\nvectors = [[1, 0, 0]]\n'
        '[runs.demo]\nstart = "x"\nh = 3.0\nsteps = 5\n')
    said = command("run", "spin.toml", "--out", "a.h5")
    assert said.returncode == 4 and re.search("step 1 from t = 0: .*residual", said.stderr)
    kept = smidgen.load_result(tmp_path / "a.h5")
    assert kept.step.tolist() == [0] and kept.meta["status"].startswith("failed")
    told = json.loads(command("run", "spin.toml", "--json").stdout)
    assert told["exit_code"] == 4 and told["done"] == 0


def test_validation_can_fail(command, monkeypatch):
    from smidgen import cli
    validate = import_module("smidgen.check.validate")
    bad = validate.Report("m", "r", "x", 0.1, 1, 1, 1.0, (validate.Line("field", 1.0, "0", False),))
    monkeypatch.setattr(validate, "validate", lambda *a, **k: bad)
    assert cli.main(["validate", TOP]) == 5


@pytest.mark.parametrize("words", [["cost", TOP, "--out", "no/a.csv"], ["cost", TOP, "--plot", "no/a.png"], ["choose", TOP, "--error", "1e-6", "--out", "no/a.toml"],
                                   ["spectrum", "heisenberg_chain", "--out", "no/a.npz"], ["spectrum", "heisenberg_chain", "--plot", "no/a.png"]])
def test_a_file_that_cannot_be_is_told_before_the_work(capsys, monkeypatch, words):
    from smidgen import cli
    for module, name in (("cost", "cost"), ("cost", "choose"), ("analyse.spectrum", "spectrum")):
        monkeypatch.setattr(import_module(f"smidgen.{module}"), name, lambda *a, **k: pytest.fail("the work was begun"))
    assert cli.main(words) == 8 and re.search("cannot write no/a.*: No such file", capsys.readouterr().err)


@pytest.mark.parametrize("words, said", [([TOP, "--set", "I1=2"], "cannot be combined with --set"), (["film_pulse"], "a single file")])
def test_what_cannot_be_added_to_a_spec_is_told_before_the_choice(capsys, monkeypatch, tmp_path, words, said):
    from smidgen import cli
    monkeypatch.setattr(import_module("smidgen.cost"), "choose", lambda *a, **k: pytest.fail("the work was begun"))
    assert cli.main(["choose", *words, "--error", "1e-6", "--out", str(tmp_path / "a.toml")]) == 2 and said in capsys.readouterr().err


@pytest.mark.parametrize("word, more", [("validate", ["--real", "long double", "--portable"]), ("verify", [])])
def test_a_check_begins_in_a_file_as_a_run_does(tmp_path, monkeypatch, word, more):
    from smidgen import cli
    (tmp_path / "a.csv").write_text("x,y,z\n0.6,0,0.8\n")
    seen = []

    def asked(spec, run, **given):
        seen.append(given)
        raise smidgen.errors.UsageError("seen")
    monkeypatch.setattr(import_module(f"smidgen.check.{word}"), word, asked)
    assert cli.main([word, TOP, "--start", str(tmp_path / "a.csv"), "--seed", "3", "--h", "0.1", *more]) == 2
    assert seen[0]["start"].tolist() == [[0.6, 0, 0.8]] and (seen[0]["seed"], seen[0]["h"]) == (3, "0.1")
    assert not more or (seen[0]["real"], seen[0]["native"]) == ("long double", False)


# Pipes, terminals, interrupts, defects

def test_a_pipe_that_closes(tmp_path):
    done = subprocess.run(f"{sys.executable} -m smidgen list | head -1", shell=True, cwd=tmp_path,
                          capture_output=True, text=True)
    assert done.returncode == 0 and "Traceback" not in done.stderr and "rror" not in done.stderr


def started(words, tmp_path, **more):
    """A long run under way."""
    child = subprocess.Popen([sys.executable, "-m", "smidgen", *words], cwd=tmp_path, text=True,
                             **more)
    until = time.monotonic() + 60
    while "model.so" not in Path(f"/proc/{child.pid}/maps").read_text() and time.monotonic() < until:
        time.sleep(0.1)
    time.sleep(1.5)
    assert child.poll() is None
    return child


def test_two_at_once(tmp_path):
    """Both need the same build, and neither is there yet."""
    env = {**os.environ, "SMIDGEN_CACHE": str(tmp_path / "cache")}
    children = [subprocess.Popen([sys.executable, "-m", "smidgen", "run", TOP, "--out", f"{k}.csv"],
                                 cwd=tmp_path, env=env, stdout=subprocess.DEVNULL) for k in range(3)]
    assert [child.wait(timeout=300) for child in children] == [0, 0, 0]
    assert len(list((tmp_path / "cache").glob("*/built.json"))) == 1
    assert len({(tmp_path / f"{k}.csv").read_text() for k in range(3)}) == 1


LONG = ["run", TOP, "--steps", "1e12", "--every", "100000", "--out", "a.h5"]


def test_ctrl_c(tmp_path):
    child = started(LONG, tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    child.send_signal(signal.SIGINT)
    out, err = child.communicate(timeout=20)
    assert child.returncode == 130 and "status: interrupted" in out and err == ""
    kept = smidgen.load_result(tmp_path / "a.h5")
    assert kept.meta["done"] > 0 and len(kept.t) == kept.meta["done"] // 100000 + 1


def test_progress_on_a_terminal_only(tmp_path):
    ours, theirs = pty.openpty()
    child = started(LONG, tmp_path, stdout=subprocess.DEVNULL, stderr=theirs)
    os.close(theirs)
    shown = os.read(ours, 100000).decode()
    child.send_signal(signal.SIGINT)
    child.wait(timeout=20)
    os.close(ours)
    assert TOP in shown and "left" in shown


@pytest.mark.quick
def test_a_defect_names_a_log(monkeypatch, capsys):
    from smidgen import cli
    monkeypatch.setattr(cli, "guarded", lambda args: 1 / 0)
    assert cli.main(["list"]) == 1
    said = capsys.readouterr().err
    assert "bug in smidgen" in said and "ZeroDivisionError" in said and "Traceback" not in said
    assert "Traceback" in open(said.strip().rsplit(" ", 1)[1]).read()
    monkeypatch.setenv("SMIDGEN_DEBUG", "1")
    assert cli.main(["list"]) == 1 and "Traceback" in capsys.readouterr().err


# The page docs/command.md

@pytest.mark.long
def test_the_page(tmp_path):
    for script in blocks("command.md", "sh"):
        sh(script, tmp_path)
    for program in blocks("command.md", "python"):
        python(program, tmp_path)


@pytest.mark.long
def test_the_page_on_lattices(tmp_path):
    (tmp_path / "film.toml").write_text(blocks("lattices.md", "toml")[0])
    for script in blocks("lattices.md", "sh"):
        sh(script, tmp_path)
    python("\n".join(blocks("lattices.md", "python")), tmp_path)


@pytest.mark.quick
def test_the_page_knows_every_option_and_exit_code(root):
    text = (root / "docs" / "command.md").read_text()
    options = make_parser()._subparsers._group_actions[0].choices["run"]._option_string_actions
    for name in set(options) - {"-h", "--help"}:
        assert f"--{name.strip('-')}" in text, name
    for code in smidgen.errors.Exit:
        assert f"| {int(code)} |" in text


# Words to values

@pytest.mark.quick
def test_values():
    assert assignment("J=2") == ("J", 2) and assignment("J=2.0") == ("J", 2.0)
    assert assignment("B=-pi/4") == ("B", -np.pi / 4)
    assert assignment(" g = 1, 2.5,-3 ") == ("g", [1, 2.5, -3])
    assert whole("1e6") == 10 ** 6 and isinstance(whole("1e6"), int)


# Streams as a shell may leave them

def shell(line, tmp_path, **env):
    """`smidgen` stands for the command; (status of each part of the pipe, stdout, stderr)."""
    line = line.replace("smidgen", f"{sys.executable} -m smidgen")
    done = subprocess.run(["bash", "-c", f"{line}; echo ${{PIPESTATUS[@]}} > codes"], cwd=tmp_path, env={**os.environ, **env},
                          capture_output=True, timeout=100)
    return [int(c) for c in (tmp_path / "codes").read_text().split()], done.stdout, done.stderr


@pytest.mark.parametrize("line, codes, said", [
    ("smidgen list >&-", [8], b"cannot write to stdout: it is closed"),
    ("smidgen list --json >&-", [8], b"cannot write to stdout: it is closed"),
    ("smidgen list > /dev/full", [8], b"cannot write to stdout: No space"),
    ("smidgen --help > /dev/full", [8], b"cannot write to stdout: No space"),
    ("smidgen run nothing --json > /dev/full", [8], b"cannot write to stdout: No space"),
    ("smidgen list > /dev/null 2>&-", [0], b""), ("smidgen run nothing 2>&-", [2], b""), ("smidgen run nothing 2> /dev/full", [2], b""),
    ("smidgen list <&- >&- 2>&-", [8], b""), ("smidgen new good >&-", [8], b"next: smidgen check")])
def test_streams_that_are_closed_or_full(tmp_path, line, codes, said):
    found, _, err = shell(line, tmp_path)
    assert said in err and b"bug in smidgen" not in err and b"Traceback" not in err and b"Exception" not in err
    assert found == codes


@pytest.mark.parametrize("words", ["list", "--help"])
def test_a_reader_that_has_gone_ends_it_quietly(tmp_path, words):
    """The pipe has no reader when the first byte is written."""
    codes, _, err = shell(f"(sleep 0.5; exec smidgen {words}) | true", tmp_path)
    assert codes == [141, 0] and err == b""


def test_a_closed_stream_gives_its_number_to_no_file(tmp_path):
    """With stdout closed the result's file would be file 1, and whatever is printed would be in it."""
    codes, _, err = shell(f"smidgen run {TOP} --out a.h5 >&-", tmp_path)
    assert codes == [8] and b"it is closed" in err
    assert smidgen.load_result(tmp_path / "a.h5").meta["status"] == "complete"


def test_characters_that_the_stream_has_not_are_escaped(tmp_path):
    codes, out, err = shell("smidgen new x --out $'\\303\\274\\377.toml'", tmp_path, PYTHONIOENCODING="ascii")
    assert codes == [0] and out == b"\\xfc\\udcff.toml\n" and b"bug in smidgen" not in err


def test_methods_are_listed(command):
    from smidgen.methods import METHODS
    lines = command("list", "--methods").stdout.splitlines()
    assert [line.split()[0] for line in lines] == list(METHODS)
    assert json.loads(command("list", "--methods", "--json").stdout)[0]["order"] == 2


# Guesses

@pytest.mark.quick
@pytest.mark.parametrize("words, guess", [
    (["rnu"], "run"), (["lst"], "list"), (["valdate", TOP], "validate"), (["run", TOP, "--step", "5"], "--steps"),
    (["run", TOP, "--step=5"], "--steps"), (["run", TOP, "--metod", "x"], "--method"), (["list", "--jsn"], "--json"),
    (["run", TOP, "--method", "sperical-midpoint"], "spherical-midpoint"), (["run", TOP, "--solver", "newtn"], "newton")])
def test_the_nearest_word_is_guessed(words, guess, capsys):
    with pytest.raises(SystemExit) as stop:
        make_parser().parse_args(words)
    assert stop.value.code == 2 and f"did you mean '{guess}'?" in capsys.readouterr().err


@pytest.mark.quick
@pytest.mark.parametrize("words", [["xyzzy"], ["run", TOP, "--xyzzy"], ["run", TOP, "a", "b"]])
def test_nothing_near_is_not_guessed(words, capsys):
    with pytest.raises(SystemExit):
        make_parser().parse_args(words)
    assert "did you mean" not in capsys.readouterr().err


# Tables

def a_report(note):
    validate = import_module("smidgen.check.validate")         # its name in the package is the function's
    return validate.Report("m", "r", "x", 0.1, 1, 1, 1.0, (validate.Line("field", 1.0, "0", True, note),))


@pytest.mark.quick
def test_a_table_in_a_pipe_has_a_line_a_row(capsys):
    from smidgen.tables import show
    note = "word " * 60 + "end"
    show(a_report(note).table())
    for text in (capsys.readouterr().out, a_report(note).text()):
        assert note in text and len(text.splitlines()) == 6


@pytest.mark.quick
@pytest.mark.parametrize("width", [60, 200])
def test_a_table_fits_the_terminal(monkeypatch, capsys, width):
    from smidgen.tables import show
    monkeypatch.setenv("COLUMNS", str(width))
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    show(a_report("word " * 60 + "end").table())
    lines = re.sub(r"\x1b\[[0-9;]*m", "", capsys.readouterr().out).splitlines()
    assert 0.9 * width < max(map(len, lines)) <= width and len(lines) > 6
