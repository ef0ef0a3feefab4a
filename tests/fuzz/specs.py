"""Whole random specs through everything: reader, generator, four strict compilers, sanitizers, restore, witness.

    python -m fuzz.specs --count 2000 --seed 0 --jobs 2     # continues where it stopped
    python -m fuzz.specs --scenes --count 1000              # scenes, which build on other files and use pieces
    python -m fuzz.specs --rows --count 1000                # lattices that must go by rows, alone
    python -m fuzz.specs --spec FILE                        # one saved text again

One line a spec goes to out/fuzz/specs.csv; a table closes the run. What is found lies in out/fuzz/specs/SEED: the whole
text, the smallest one with the same fault, and what was said. The exit status is 1 then. Each spec has a process of its
own; one that takes more than SECONDS of processor time for a stage, LONGER of them, or too much memory, is ended and is a fault.
"""
from __future__ import annotations

import argparse
import collections
import csv
import hashlib
import multiprocessing
import os
import random
import re
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
from multiprocessing.connection import wait
from pathlib import Path

import smidgen
from smidgen.build.binary import generator_digest
from smidgen.check.witness import Witness

from .by_rows import row_text
from .invent import files_of
from .layouts import spec_text
from .scenes import scene_text
from .smaller import smaller
from .through import SECONDS, Fault, through

OUT = Path(__file__).parents[2] / "out" / "fuzz"
HOUR, MEMORY = 600, 4 << 30     # seconds by the clock and bytes that no spec takes
LONGER = {"witness": 4}         # times SECONDS: a composition of many stages on hundreds of sites, twice
COLUMNS = ("seed", "code", "verdict", "stage", "seconds", "layout", "sites", "method", "solver", "features", "program", "library", "judged", "kinds", "said")
KINDS = {"sphere": r"sphere =", "r3": r"r3 =", "nambu": r"nambu =", "tracer": r"tracer = true", "families": r"\[starts\.s\.",
         "single site": r"(sphere|r3|nambu) = 1\b", "count of one": r'"one"', "count run": r'(sphere|r3|nambu) = "[nm2]', "kappa(i)": r'kappa = ".*\bi\b',
         "radius(i)": r'radius = ".*\bi\b', "array": r"size =", "array fixed": r"size =.*fixed", "vector fixed": r"vector = true, fixed",
         "a[i + 1]": r"\[\w+ \+ 1\]", "a[2*i]": r"\[2\*\w+\]", "a[2*i + 1]": r"\[2\*\w+ \+ 1\]", "a[i + j]": r"\[\w+ \+ [a-z]\w*\]",
         "a[n - 1 - i]": r"\[n - 1 - ", "site": r"site\(", "pair": r"pair\(", "each": r"each\(", "chain": r"chain\(", "square": r"square\(\w+, \w+, [op]",
         "cubic": r"cubic\(", "declared": r"\[lattices", "3 or 4 sites": r"at = \[\[", "graph": r"\[graphs", "periodic": r"periodic",
         "open": r"\bopen\b", "if": r"if\(", "mod": r"mod\(", "floor": r"floor\(", "min": r"min\(", "max": r"max\(", "abs": r"abs\(",
         "damping": r"\ndamping =", "kT": r"\nkT =", "torque": r"\ntorque =", "pinned": r"\npinned =", "absent": r"\nabsent =", "random of sites": r"(uniform|normal)\(\d+, [^,]*\)", "random of bonds": r"(uniform|normal)\(6, \w+, \w+\)", "time": r"\bt[)* +^/,]", "observable": r"\[observables", "orientation -1": r"orientation = -1", "start file": r"file = \"start",
         "start random": r"\nrandom =", "start angles": r"\ntheta", "start vectors": r"\nvectors", "start formula": r"\nx = ",
         "set": r"\nset =", "set sizes": r"set = .*\bn =", "set array": r"set = .*(gamma|delta|rho) =", "effects of a run": r"\neffects =",
         "layout": r"# layout: (few|rows|blocks|wave|single)"}


SCENES = {"base": r"\nbase =", "two bases or more": r"\n# \[scene\]", "effects of a scene": r"\[scene\](\n.*)*?\neffects =", "without": r"\nwithout =", "shipped piece": r'"(spins|bodies|vortices)/',
          "own piece": r'"mine/', "table .csv": r'file = "(tables/)?\w+.csv', "table .npy": r".npy", "library": r"\n# file: library/"}


def kinds_of(text) -> list:
    """What a spec has, in its own text or in those that it builds on."""
    files = "\n".join(["", text, *files_of(text).values()])
    return [name for name, pattern in {**KINDS, **SCENES}.items() if re.search(pattern, files)]


def attempt(text, seconds=SECONDS):
    """A row of what becomes of a text, in a process of its own."""
    one = Child(text, seconds)
    while not one.ended():
        wait([one.ear], 0.5)
    return one.row


class Child:
    """A process with one spec; `row` is filled in when it has ended."""

    def __init__(self, text, seconds=SECONDS):
        self.text, self.limit, self.row = text, seconds, {"stage": "begin"}
        self.ear, mouth = multiprocessing.Pipe(duplex=False)
        self.cache = tempfile.mkdtemp(prefix="smidgen-fuzz-")
        self.process = multiprocessing.get_context("fork").Process(target=child, args=(text, mouth, self.cache))
        self.process.start()
        mouth.close()
        self.began, self.before, self.used = time.monotonic(), 0.0, 0.0

    def ended(self) -> bool:
        """Listens; ends what takes too long. True when the row is whole."""
        try:
            while self.ear.poll():
                self.hear(*self.ear.recv())
                if "verdict" in self.row:
                    return self.close()
        except EOFError:
            self.process.join()
            return self.fault(f"the process died: {self.process.exitcode}")
        self.used, memory = usage(self.process.pid) or (self.used, 0)
        if self.used - self.before > self.limit * LONGER.get(self.row["stage"], 1) or time.monotonic() - self.began > HOUR:
            return self.fault(f"hangs: {self.used - self.before:.0f} s of processor time in this stage")
        return self.fault(f"memory: {memory >> 20} MiB") if memory > MEMORY else False

    def hear(self, what, value):
        if what == "row":
            self.row.update(value)
        else:
            self.row["stage"], self.before = value, (usage(self.process.pid) or (self.used,))[0]

    def fault(self, said):
        self.row.update(verdict="fault", said=said, full=said, seconds=round(self.used, 1))
        return self.close()

    def close(self):
        if self.process.is_alive() and "full" in self.row:
            try:
                os.killpg(self.process.pid, signal.SIGKILL)
            except ProcessLookupError:
                self.process.kill()
        self.process.join()
        self.ear.close()
        shutil.rmtree(self.cache, ignore_errors=True)
        return True


def usage(pid):
    """(seconds of processor time without children, bytes in memory) of a process; None when it has gone."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return None
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK"), int(fields[21]) * resource.getpagesize()


def child(text, mouth, cache):
    """In the new process: one spec, its stages and its row told to the parent."""
    os.setsid()
    os.environ["SMIDGEN_CACHE"] = os.environ["TMPDIR"] = tempfile.tempdir = cache
    stage, row = ["begin"], {}

    def tell(name):
        stage[0] = name
        mouth.send(("stage", name))
    try:
        done = through(text, tell, found=row)
        row = dict(done, stage="", said=done["note"])
    except BaseException as problem:        # whatever it is, it is what this looks for
        full = str(problem) if isinstance(problem, Fault) else traceback.format_exc()
        full += getattr(problem, "log", "")
        row.update(verdict="fault", stage=stage[0], said=signature(problem), full=full)
    spent = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    row["seconds"] = round(sum(u.ru_utime + u.ru_stime for u in spent), 1)
    mouth.send(("row", row))
    mouth.close()
    os._exit(0)


SAID = (r"ERROR: (AddressSanitizer: [\w-]+)", r"runtime error: (.*)", r"(hangs)", r"error: (.*)", r"(.+)")
FRAME = re.compile(r"#\d+ \w+ in (random_model_\w+|smg_\w+|main)")


def signature(problem) -> str:
    """What kind of fault it is: the same for the same cause, whatever the names and numbers."""
    text = str(problem) + getattr(problem, "log", "")
    found = next(m.group(1) for m in (re.search(p, text) for p in SAID) if m) if text else ""
    frame = FRAME.search(text)
    kind = "" if isinstance(problem, Fault) else f"{type(problem).__name__}: "
    where = f" in {frame.group(1)}" if frame else "" if isinstance(problem, Fault) else place(problem)
    return re.sub(r"[-+]?\d[\d.]*(e[-+]?\d+)?", "#", re.sub(r"[‘'`\[].*?[’'`\]]", "..", kind + found))[:120] + re.sub(r"\d+", "#", where)


def place(problem) -> str:
    """The last function of the program that an exception went through."""
    frames = [f for f in traceback.extract_tb(problem.__traceback__) if f"{os.sep}gen{os.sep}" in f.filename or "differential" in f.filename]
    return f" in {Path(frames[-1].filename).name} {frames[-1].name}" if frames else ""


# Many of them

def code() -> str:
    """What the verdicts depend on: the generator, the witness and this target."""
    here = Path(__file__).parent
    parts = [here / n for n in ("invent.py", "layouts.py", "by_rows.py", "scenes.py", "pieces.py", "drawn.py", "through.py", "program.py", "differential.py")] + [here.parent / "support" / "random_specs.py"]
    parts += sorted(Path(smidgen.__file__).parent.joinpath("check", "witness").glob("*"))
    return hashlib.sha256(b"".join([generator_digest().encode(), *(p.read_bytes() for p in parts if p.is_file())])).hexdigest()[:10]


def rows_of(path) -> list:
    """The rows of a file; a last one that was cut off is removed from it."""
    if not path.exists():
        return []
    whole = path.read_bytes().rpartition(b"\n")
    if whole[2]:
        path.write_bytes(whole[0] + whole[1])
    with open(path, newline="") as lines:
        return list(csv.DictReader(lines))


def many(seeds, jobs, path, until=float("inf"), draw=None):
    """Rows of the seeds that the file does not have yet are added to it, `jobs` at a time."""
    now, draw = code(), draw or spec_text
    done = {int(r["seed"]) for r in rows_of(path) if r["code"] == now}
    waiting, running = iter(k for k in seeds if k not in done), {}
    fresh = not path.exists() or not path.stat().st_size
    with open(path, "a", newline="") as out:
        table = csv.DictWriter(out, COLUMNS, extrasaction="ignore")
        if fresh:
            table.writeheader()
        try:
            while True:
                while len(running) < jobs and time.monotonic() < until and (k := next(waiting, None)) is not None:
                    text = draw(random.Random(k))
                    running[k] = Child(text)
                if not running:
                    return
                wait([c.ear for c in running.values()], 0.5)
                for k in [k for k, c in running.items() if c.ended()]:
                    one = running.pop(k)
                    row = {name: one.row.get(name, "") for name in (*COLUMNS, "full")}
                    row.update(seed=k, code=now, kinds="|".join(kinds_of(one.text)))
                    keep(row, one.text, path)
                    table.writerow({n: str(v).replace("\n", " ") for n, v in row.items()})
                    out.flush()
                    if row["verdict"] == "fault":
                        print(f"seed {k}: {row['stage']}: {row['said']}", flush=True)
        finally:
            for one in running.values():
                one.fault("stopped")


def keep(row, text, path):
    """The text of a fault and what was said."""
    if row["verdict"] != "fault":
        return
    folder = path.with_suffix("") / str(row["seed"])
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "whole.toml").write_text(text)
    (folder / "said.txt").write_text(f"{row['stage']}: {row['said']}\ncd tests && ../.venv/bin/python -m fuzz.specs --spec "
                                     f"{folder}/whole.toml\n\n{row['full']}\n")


def shrink(rows, path, seconds):
    """For the first spec of each kind of fault, the smallest text found that has it too."""
    first = {}
    for r in rows:
        if r["verdict"] == "fault":
            first.setdefault((r["stage"], r["said"]), r["seed"])
    for (stage, said), seed in first.items():
        folder = path.with_suffix("") / seed
        if (folder / "smallest.toml").exists() or not (folder / "whole.toml").exists():
            continue

        def still(text):
            row = attempt(text)
            return row["verdict"] == "fault" and row["stage"] == stage and plain(row["said"]) == plain(said)
        text = smaller((folder / "whole.toml").read_text(), still, seconds)
        (folder / "smallest.toml").write_text(text)


def plain(said) -> str:
    return re.sub(r"\d+ s of|\d+ MiB", "", str(said).replace("\n", " "))


def closing(rows, path) -> str:
    """The table that closes a run: what the specs were made of, what was refused, what was found, how many."""
    kinds = collections.Counter(k for r in rows for k in r["kinds"].split("|"))
    lines = ["specs with: " + ", ".join(f"{kinds[k]} {k}" for k in {**KINDS, **SCENES} if kinds[k])]
    for what in ("method", "solver", "features"):
        lines.append(f"{what}: " + ", ".join(f"{n} {k or 'none'}" for k, n in collections.Counter(r[what] for r in rows).most_common()))
    refused = collections.Counter(re.sub(r"[-+]?\d[\d.e+-]*", "#", r["said"])[:110] for r in rows if r["verdict"] == "refused")
    lines += [f"{n:5} refused: {why}" for why, n in refused.most_common(12)]
    faults = collections.defaultdict(list)
    for r in rows:
        if r["verdict"] == "fault":
            faults[r["stage"], r["said"]].append(r["seed"])
    lines += [f"{len(k):5} {stage}: {said} (seeds {', '.join(k[:5])}; {path.with_suffix('') / k[0]})"
              for (stage, said), k in sorted(faults.items(), key=lambda x: -len(x[1]))]
    verdicts, seconds = collections.Counter(r["verdict"] for r in rows), [float(r["seconds"] or 0) for r in rows]
    ways = collections.Counter(f"{r['layout'] or 'none'}, {r['method']}" for r in rows)
    lines.append("layout, method: " + "; ".join(f"{n} {way}" for way, n in sorted(ways.items())))
    lines.append(f"{len(rows)} specs: {verdicts['fine']} fine, {verdicts['refused']} with a refused step, {verdicts['fault']} faults of "
                 f"{len(faults)} kinds; {sum(seconds)/max(1, len(rows)):.1f} s of processor time each, {max(seconds, default=0):.0f} s the longest")
    return "\n".join(lines)


def one_again(path):
    """The stages of a saved text, and what is said of it."""
    row = attempt(Path(path).read_text())
    print("\n".join(f"{k}: {v}" for k, v in row.items()))
    return row["verdict"] == "fault"


def main(words=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seconds", type=float, help="of the clock, in place of a count")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--scenes", action="store_true", help="specs that build on others, with pieces and files (fuzz.scenes)")
    parser.add_argument("--rows", action="store_true", help="lattices that must go by rows, alone (fuzz.by_rows)")
    parser.add_argument("--out", type=Path, help="default: specs.csv, scenes.csv or rows.csv in out/fuzz")
    parser.add_argument("--shrink", type=float, default=120, help="seconds to look for a smaller text of a fault; 0: none")
    parser.add_argument("--spec", help="a saved text, alone")
    args = parser.parse_args(words)
    if args.spec:
        return one_again(args.spec)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))      # the processes of the specs end with it
    name, draw = ("scenes", scene_text) if args.scenes else ("rows", row_text) if args.rows else ("specs", spec_text)
    args.out = args.out or OUT / f"{name}.csv"
    args.out.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as cache:
        os.environ["SMIDGEN_CACHE"] = cache
        Witness(smidgen.load_text(FIRST))           # compiled here, once
        count = 10 ** 9 if args.seconds else args.count
        until = time.monotonic() + args.seconds if args.seconds else float("inf")
        many(range(args.seed, args.seed + count), args.jobs, args.out, until, draw)
        rows = [r for r in rows_of(args.out) if r["code"] == code() and args.seed <= int(r["seed"]) < args.seed + count]
        shrink(rows, args.out, args.shrink) if args.shrink else None
    print(closing(rows, args.out))
    return any(r["verdict"] == "fault" for r in rows)


FIRST = '[model]\nname = "first"\n[space]\nw = { sphere = 1 }\n[effects.e]\nenergy = "w.z"\n'

if __name__ == "__main__":
    sys.exit(main())
