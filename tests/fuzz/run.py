"""All the fuzzing for a stated time: the language, whole specs, random Hamiltonians, bad steps.

    python -m fuzz.run [--minutes 10] [--seed 1]          # make fuzz MINUTES=10

A row for each part; what was found lies in out/fuzz and is printed, and the exit status is 1.
Inputs that reach new code of the reader join tests/fuzz/corpus.
"""
import argparse
import random
import subprocess
import sys
import time
from pathlib import Path

TESTS = Path(__file__).parent.parent
OUT = TESTS.parent / "out" / "fuzz"
CORPUS = TESTS / "fuzz" / "corpus"
SHARES = {"language": 0.3, "whole specs": 0.3, "random Hamiltonians": 0.2, "bad steps": 0.2}    # of the time
BATCH = 20_000          # bad steps between two looks at the clock


def python(*words, log):
    """Run `python -m ...` in tests; its exit status. What it says goes to out/fuzz/<log>."""
    with open(OUT / log, "a") as said:
        return subprocess.run([sys.executable, "-m", *map(str, words)], cwd=TESTS, stdout=said, stderr=subprocess.STDOUT).returncode


def language(seconds, seed):
    """Coverage-guided, from the corpus and the shipped specs; then the corpus takes what is new."""
    for name in ("live", "found"):
        (OUT / name).mkdir(exist_ok=True)
    (OUT / "tokens.dict").write_text(subprocess.run([sys.executable, "-m", "fuzz.tokens"], cwd=TESTS, check=True,
                                                    capture_output=True, text=True).stdout)
    bad = python("fuzz.guided", OUT / "live", CORPUS, TESTS.parent / "specs", f"-max_total_time={seconds:.0f}", f"-seed={seed}",
                 "-max_len=2000", "-timeout=20", "-rss_limit_mb=2048", f"-dict={OUT / 'tokens.dict'}",
                 f"-artifact_prefix={OUT / 'found'}/", log="language.log")
    return python("fuzz.minimise", CORPUS, OUT / "live", TESTS.parent / "specs", log="language.log") or bad


def specs(seconds, seed):
    """Random specs through compilers, sanitizers, restore and witness."""
    return python("fuzz.specs", "--seconds", seconds, "--seed", seed, "--shrink", 60, log="specs.log")


def hamiltonians(seconds, seed):
    """Generated C against the witness."""
    return python("fuzz.differential", "--seconds", seconds, "--seed", seed, log="hamiltonians.log")


def bad_steps(seconds, seed):
    """Batches of random bad starts and steps on every model."""
    end, bad = time.monotonic() + seconds, 0
    while time.monotonic() < end:
        bad |= python("fuzz.bad_steps", "--steps", BATCH, "--seed", seed, log="bad_steps.log")
        seed += 1
    return bad


PARTS = {"language": (language, "language.log"), "whole specs": (specs, "specs.log"), "random Hamiltonians": (hamiltonians, "hamiltonians.log"),
         "bad steps": (bad_steps, "bad_steps.log")}


def last_line(log):
    """What a part said last."""
    lines = (OUT / log).read_text(errors="replace").strip().splitlines()
    return lines[-1][:150] if lines else ""


def main(words=None):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=10)
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(10 ** 6))
    args = parser.parse_args(words)
    OUT.mkdir(parents=True, exist_ok=True)
    print(f"{args.minutes:g} minutes, seed {args.seed}; all that is said goes to {OUT}", flush=True)
    found = []
    for name, (part, log) in PARTS.items():
        (OUT / log).write_text("")
        if part(60 * args.minutes * SHARES[name], args.seed):
            found.append(name)
        print(f"{name:20} {'FOUND, see ' + log if name in found else 'nothing found'}: {last_line(log)}", flush=True)
    return bool(found)


if __name__ == "__main__":
    sys.exit(main())
