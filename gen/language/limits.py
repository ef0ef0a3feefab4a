"""Every limit of the spec language and of the files that are read, in one place.

Each is an integer or a float with a line that says what it bounds; `docs/spec.md` lists
them all, and the tests try each at its edge. `LIMITS` maps each name to its meaning.
"""
from __future__ import annotations

LIMITS: dict[str, str] = {}


def _limit(name: str, value, meaning: str):
    LIMITS[name] = meaning
    return value


ERRORS = _limit("ERRORS", 10, "errors reported at once")
FILE_BYTES = _limit("FILE_BYTES", 1 << 20, "bytes of a spec file")
BASES = _limit("BASES", 16, "depth of the chain of bases of a scene")
TABLE_BYTES = _limit("TABLE_BYTES", 1 << 26, "bytes of a graph or start file that a spec names")
META = _limit("META", 1 << 27, "characters of the metadata of a result, and of the state stored in a .csv file")
CSV_COLUMNS = _limit("CSV_COLUMNS", 30_000, "columns of a result in a .csv")
LINE = _limit("LINE", 4096, "characters of a line of a spec")
STRING = _limit("STRING", 4096, "characters of a formula, a title or another string")
TEXT = _limit("TEXT", 200, "characters of a title, a meaning or a unit")
NESTING = _limit("NESTING", 32, "nesting of TOML tables and lists")
DEPTH = _limit("DEPTH", 50, "nesting of parentheses, signs and powers in a formula")
TREE = _limit("TREE", 120, "nesting of operations after expansion; k for a sum of k terms")
NODES = _limit("NODES", 4000, "operations and operands of a formula after expansion")
DERIVATIVES = _limit("DERIVATIVES", 50_000, "operations of an energy with its first and second derivatives")
UNIT = _limit("UNIT", 80, "characters of a number with its unit")
UNIT_FACTORS = _limit("UNIT_FACTORS", 8, "factors of a unit")
UNIT_EXPONENT = _limit("UNIT_EXPONENT", 12, "absolute value of the exponent of a unit")
IDENTIFIER = _limit("IDENTIFIER", 40, "characters of a name")
ARGUMENTS = _limit("ARGUMENTS", 8, "arguments of a named formula")
PARAMETERS = _limit("PARAMETERS", 200, "parameters")
FAMILIES = _limit("FAMILIES", 20, "families in [space]")
FORMULAS = _limit("FORMULAS", 200, "named formulas")
EFFECTS = _limit("EFFECTS", 100, "effects")
OBSERVABLES = _limit("OBSERVABLES", 100, "observables")
STARTS = _limit("STARTS", 100, "starts")
RUNS = _limit("RUNS", 100, "runs")
LATTICES = _limit("LATTICES", 20, "declared lattices")
GRAPHS = _limit("GRAPHS", 20, "declared graphs")
DIMENSIONS = _limit("DIMENSIONS", 4, "directions of a lattice")
CELL = _limit("CELL", 64, "sites of a lattice cell")
BONDS = _limit("BONDS", 256, "members of one bond list")
LOOKED_AT = _limit("LOOKED_AT", 20_000_000, "pairs of sites examined to find a shell of neighbours")
REACH = _limit("REACH", 1000, "cells that a bond's offset spans in one direction")
BOUND = _limit("BOUND", 4, "indices bound by one `over`")
SITES = _limit("SITES", 100_000_000, "sites of a model")
EDGES = _limit("EDGES", 1_000_000, "edges of a graph file")
COLUMNS = _limit("COLUMNS", 16, "weight columns of a graph file")
LIST = _limit("LIST", 10_000, "entries of a list written in a spec")
MEMBERS = _limit("MEMBERS", 10_000_000, "members of an ensemble")
CELLS = _limit("CELLS", 1_000_000, "cells of a sweep")
ARRAY = _limit("ARRAY", 10_000_000, "entries of all array parameters together")
HARMONICS = _limit("HARMONICS", 10, "degree of spherical harmonics")
EXPONENT = _limit("EXPONENT", 64, "absolute value of a constant exponent")
INTEGER = _limit("INTEGER", 2 ** 53, "absolute value of an integer")
LARGEST = _limit("LARGEST", 1e150, "absolute value of a number")
SMALLEST = _limit("SMALLEST", 1e-300, "absolute value of a number that is not zero")
STEPS = _limit("STEPS", 10 ** 15, "steps of a run")
EVERY = _limit("EVERY", 10 ** 12, "steps between two outputs")
SHORTEST = _limit("SHORTEST", 1e-150, "largest component of a vector of R^3 or of a Nambu factor that is not 0")
SPHERE = _limit("SPHERE", 1e-12, "relative distance of a start from its sphere")
MULTIPLE = _limit("MULTIPLE", 1e-12, "relative distance of a duration from a multiple of h")
