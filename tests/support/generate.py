"""A program: generate the C of the specs given, in order, and print a digest of each file.

    python generate.py METHOD SPEC.toml ..
"""
import hashlib
import json
import sys

import smidgen
from smidgen.compile.emit.emit import generate
from smidgen.compile.select import select


def digests(method, paths):
    """{'name/file': sha256} of the generated files."""
    found = {}
    for path in paths:
        files = generate(select(smidgen.load(path)), method=method)
        for name, text in files.items():
            found[f"{name}"] = hashlib.sha256(text.encode()).hexdigest()
    return found


if __name__ == "__main__":
    print(json.dumps(digests(sys.argv[1], sys.argv[2:])))
