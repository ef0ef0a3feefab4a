"""The stable codes of all errors in specs, with one line each."""
from __future__ import annotations

CODES: dict[str, str] = {}


def _code(number: str, meaning: str) -> str:
    CODES[number] = meaning
    return number


# The file
FILE = _code("E101", "the file cannot be read")
ENCODING = _code("E102", "the file is not UTF-8")
TOML = _code("E103", "the text is not TOML")
DUPLICATE = _code("E104", "a key or table is given twice")
LIMIT = _code("E105", "a limit of the language is exceeded")
EMPTY = _code("E106", "the file is empty")
CHARACTER = _code("E107", "a character that is not allowed here")

# Keys, values, names
UNKNOWN_KEY = _code("E201", "a key that the table does not have")
MISSING = _code("E202", "a required key or section is missing")
TYPE = _code("E203", "a value of the wrong type")
NUMBER = _code("E204", "a number that is not finite or out of range")
CHOICE = _code("E205", "a value that is not one of those allowed")
IDENTIFIER = _code("E206", "a name that is not an identifier")
RESERVED = _code("E207", "a name that is reserved in C, C++ or the spec language")
CLASH = _code("E208", "a name that is already taken")
TEXT = _code("E209", "a title, meaning or unit that cannot be written as a comment")
CONFLICT = _code("E210", "two keys that exclude each other")

# Formulas
SYNTAX = _code("E301", "a formula that cannot be read")
UNKNOWN_NAME = _code("E302", "a name that is not declared")
KIND = _code("E303", "a vector where a number is needed, or the reverse")
ARITY = _code("E304", "a wrong number of arguments")
RECURSION = _code("E305", "a named formula that uses itself")
EXPONENT = _code("E306", "an exponent that is too large")
VALUE = _code("E307", "a constant that is not finite")
INDEX = _code("E308", "an index of the wrong kind or out of range")
NOT_HERE = _code("E309", "something that is not allowed here")
INTEGER = _code("E310", "a count that is not an integer formula")
BIG = _code("E311", "a formula that grows beyond the limits when expanded")

# Units
UNIT = _code("E320", "a unit that is not known")
DIMENSION = _code("E321", "quantities whose dimensions do not match")
MEASURE = _code("E322", "a quantity that needs a unit or must not have one")

# The space
CASIMIR = _code("E401", "C is not a homogeneous quadratic function")
KAPPA = _code("E402", "a strength that is zero or not finite")
COUNT = _code("E403", "a count, size or length that does not match")
RADIUS = _code("E404", "a radius that is not positive")

# Torques
NORMAL = _code("E405", "a torque that leaves the sphere")

# Index families, lattices, graphs
OVER = _code("E501", "an index family that cannot be read")
BOND = _code("E502", "a bond that does not match its lattice")
LATTICE = _code("E503", "a lattice whose number of sites is not that of the family")
PATH = _code("E504", "a file that may not be read from here")
TABLE = _code("E505", "a file that does not contain the required table")

# Starts and runs
OFF = _code("E601", "a start that is not on its sphere or leaf")
START = _code("E602", "a start that does not match the space")
METHOD = _code("E603", "a method that does not support the space")
DURATION = _code("E604", "a duration that is not a multiple of the step")
STEP = _code("E605", "a step, duration or period that is not valid")
OUTPUT = _code("E606", "an output that the spec does not have")
