"""Coverage-guided fuzzing of the reader with atheris (libFuzzer): inputs that reach new code are kept.

    python -m fuzz.guided CORPUS [more corpora] [-max_total_time=60] [libFuzzer's other options]

atheris is no requirement of the tests: `make fuzz` installs it (tests/fuzz/requirements.txt).
"""
import sys

import atheris

with atheris.instrument_imports(include=["smidgen.read", "smidgen.expr", "smidgen.spec", "smidgen.evaluate"]):
    from fuzz.judge import judge_bytes


def main():
    atheris.Setup(sys.argv, lambda data: judge_bytes(data) and None)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
