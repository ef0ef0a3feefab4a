"""Which room of gen/ imports which, read from the import statements, those inside functions too.

    make imports                                # the picture in docs/architecture.md, drawn anew
    python tests/support/imports.py             # the same picture, printed
    python tests/support/imports.py --all       # each room with all that it imports

A room is a folder of gen/; the modules that lie in gen/ itself are the room `shared`, but for
`__init__`, `__main__` and the public modules `lattice` and `lyapunov`, which are on top of all. FLOORS says which room lies above which.
"""
from __future__ import annotations

import ast
import graphlib
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
GEN, DOCUMENT = ROOT / "gen", ROOT / "docs/architecture.md"
BEGIN, END = "<!-- imports: made by `make imports` -->\n", "<!-- end of imports -->\n"
TOP, PUBLIC = "smidgen", ("lattice", "lyapunov")
FLOORS = (      # from the ground up
    ("shared",), ("language",), ("effects",), ("read",), ("compile", "model"),
    ("compile/derive",), ("compile/lower", "compile/plan"), ("compile/assemble",), ("compile/emit",), ("build",),
    ("run/step",), ("run/files",), ("run/fields",), ("run/record",), ("run",), ("run/distributed", "run/many"),
    ("analyse", "analyse/symmetry"), ("analyse/advice",),
    ("check/witness", "cost/measure"), ("check", "cost/peers"), ("check/verify", "cost"),
    ("show/plot",), ("show",), ("show/demo",), ("cli",), (TOP,))
FLOOR = {room: number for number, floor in enumerate(FLOORS) for room in floor}


def modules(root: Path = GEN) -> dict:
    """module, as the tuple of its parts below `root` -> its path."""
    return {p.relative_to(root).with_suffix("").parts: p for p in sorted(root.rglob("*.py")) if "__pycache__" not in p.parts}


def imports(known: dict) -> dict:
    """module -> the set of modules of `known` that it imports, by relative imports."""
    return {here: {module for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.ImportFrom) and node.level
                   for module in targets(here, node, known)} - {here} for here, path in known.items()}


def targets(here: tuple, node: ast.ImportFrom, known: dict):
    """The modules that one statement `from .. import ..` in `here` takes names from; a name may be a module itself."""
    package = here[:-1]
    base = (*package[:len(package) - node.level + 1], *(node.module.split(".") if node.module else ()))
    for name in node.names:
        found = next((m for m in ((*base, name.name), (*base, name.name, "__init__"), base, (*base, "__init__")) if m in known), None)
        if found is None:
            raise LookupError(f"{'/'.join(here)}, line {node.lineno}: what is {'.'.join((*base, name.name))}?")
        yield found


def room_of(module: tuple) -> str:
    return "/".join(module[:-1]) or (TOP if module[0].startswith("__") or module[0] in PUBLIC else "shared")


def rooms(arrows: dict) -> dict:
    """room -> the set of other rooms that its modules import."""
    found = {}
    for here, there in arrows.items():
        found.setdefault(room_of(here), set()).update(room_of(m) for m in there)
    return {room: there - {room} for room, there in found.items()}


def upward(arrows: dict) -> list[str]:
    """Imports from a room on the same floor or above, and rooms that FLOORS does not have."""
    strange = [f"no floor for {room}: FLOORS of tests/support/imports.py" for room in arrows if room not in FLOOR]
    return strange + [f"{room} -> {other}" for room, there in arrows.items() for other in sorted(there)
                      if room in FLOOR and other in FLOOR and FLOOR[other] >= FLOOR[room]]


def circle(arrows: dict) -> list:
    """The nodes along one circle of arrows, or none."""
    try:
        graphlib.TopologicalSorter(arrows).prepare()
    except graphlib.CycleError as found:
        return found.args[1]
    return []


def reachable(arrows: dict, start) -> set:
    found, waiting = set(), [start]
    while waiting:
        node = waiting.pop()
        if node not in found:
            found.add(node)
            waiting += arrows[node]
    return found


def reduced(arrows: dict) -> dict:
    """Only arrows that no way over other rooms stands for."""
    beyond = {room: set().union(*(reachable(arrows, other) - {other} for other in there)) for room, there in arrows.items()}
    return {room: there - beyond[room] for room, there in arrows.items()}


def picture(arrows: dict) -> str:
    """Mermaid, the top floor first."""
    drawn = reduced(arrows)
    lines = [f"    {room} --> {other}" for floor in reversed(FLOORS) for room in floor
             for other in sorted(drawn.get(room, ()), key=lambda other: (-FLOOR[other], other))]
    return "\n".join(["```mermaid", "flowchart TD", *lines, "```", ""])


def written(text: str, drawn: str) -> str:
    """The document with the picture between its marks."""
    before, _, rest = text.partition(BEGIN)
    return before + BEGIN + drawn + END + rest.partition(END)[2]


def main(asked: list[str]) -> None:
    arrows = rooms(imports(modules()))
    if "--write" in asked:
        DOCUMENT.write_text(written(DOCUMENT.read_text(), picture(arrows)))
    elif "--all" in asked:
        for room in sorted(arrows, key=lambda r: FLOOR.get(r, len(FLOORS))):
            print(f"{room}: {', '.join(sorted(arrows[room]))}")
    else:
        print(picture(arrows), end="")


if __name__ == "__main__":
    main(sys.argv[1:])
