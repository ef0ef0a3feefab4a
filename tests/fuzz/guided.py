"""Coverage-guided fuzzing of the reader with atheris (libFuzzer): inputs that reach new code are kept.

    python -m fuzz.guided CORPUS [more corpora] [-max_total_time=60] [libFuzzer's other options]

Three of four changes are those of the grammar (mutate.py), the others libFuzzer's own, of bytes.
atheris is no requirement of the tests: `make fuzz` installs it (tests/fuzz/requirements.txt).
"""
import random
import sys

import atheris

with atheris.instrument_imports(include=["smidgen.read", "smidgen.language.expr", "smidgen.language.spec", "smidgen.language.evaluate"]):
    from fuzz.judge import judge_bytes
    from fuzz.mutate import mutated

BY_GRAMMAR = 3      # of four changes


def change(data, size, seed):
    """libFuzzer's hook: `data` changed, of at most `size` bytes."""
    dice = random.Random(seed)
    return mutated(data, dice)[:size] if dice.randrange(4) < BY_GRAMMAR else atheris.Mutate(data, size)


def main():
    atheris.Setup(sys.argv, lambda data: judge_bytes(data) and None, custom_mutator=change)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
