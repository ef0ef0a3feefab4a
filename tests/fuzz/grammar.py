"""Strategies for hypothesis: formulas and whole documents of the spec language, valid and almost valid."""
from hypothesis import strategies as st

NAMES = ("w[i]", "w[j]", "w[0]", "v", "B", "u[i]", "p[j]")
SCALARS = ("J", "n", "i", "t", "pi", "gamma[i]", "gamma[n - 1]", "omega", "K", "undeclared", "e", "__class__")
NUMBERS = ("0", "1", "2.5", ".5", "1e-3", "1e150", "1e151", "9" * 30, "1e-400", "0x10", "1_000", "07", "1e", "1..2", "\u0663")
FUNCTIONS = ("sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "abs", "floor", "f", "Sin")
PAIRS = ("min", "max", "mod", "atan2", "g")
JUNK = ("(", ")", "[", "]", ",", ".", "..", "^", "**", "*", "/", "+", "-", "<", "==", "=", "!", "and", "or", "not", "if", "of",
        ".x", ".w", "'", "\\", "#", ";", "$", "@", "\u00b2", "\u2212", "\u202e", "\u0301", "\ufeff", "\x00", "\t", "\n", "  ",
        "lambda", "import os", "{0}", "%s", "\U0001f600")


def vectors():
    return st.recursive(st.sampled_from(NAMES) | numbers_of(3).map("vec({})".format),
                        lambda inner: st.tuples(inner, inner).map("cross({0[0]}, {0[1]})".format)
                        | st.tuples(inner, inner).map("({0[0]} + {0[1]})".format)
                        | inner.map("2*{}".format), max_leaves=4)


def numbers_of(count):
    return st.lists(st.sampled_from(SCALARS[:8] + NUMBERS[:5]), min_size=count, max_size=count).map(", ".join)


def formulas():
    """Mostly well-formed formulas of the context that `spec_around` gives."""
    leaves = (st.sampled_from(SCALARS[:8]) | st.sampled_from(NUMBERS[:5]) | st.sampled_from(SCALARS + NUMBERS)
              | st.tuples(vectors(), st.sampled_from(["x", "y", "z"])).map("{0[0]}.{0[1]}".format)
              | st.tuples(vectors(), vectors()).map("dot({0[0]}, {0[1]})".format)
              | vectors().map("norm({})".format))
    return st.recursive(leaves, grown, max_leaves=12)


def grown(inner):
    two = st.tuples(inner, inner)
    return (st.tuples(inner, st.sampled_from("+-*/^"), inner).map("{0[0]} {0[1]} {0[2]}".format)
            | st.tuples(st.sampled_from(FUNCTIONS), inner).map("{0[0]}({0[1]})".format)
            | st.tuples(st.sampled_from(PAIRS), two).map("{0[0]}({0[1][0]}, {0[1][1]})".format)
            | inner.map("({})".format) | inner.map("-{}".format) | inner.map("({})^2".format)
            | st.tuples(inner, inner, inner).map("if({0[0]} < {0[1]}, {0[1]}, {0[2]})".format)
            | st.tuples(inner, inner).map("if(not {0[0]} == 1 or {0[1]} >= 2 and t < 1, {0[0]}, {0[1]})".format))


@st.composite
def almost(draw, texts):
    """A text with some pieces lost, doubled, exchanged or put in."""
    text = draw(texts)
    for _ in range(draw(st.integers(0, 3))):
        a = draw(st.integers(0, len(text)))
        b = min(len(text), a + draw(st.integers(0, 6)))
        text = text[:a] + draw(st.sampled_from(JUNK + ("", text[a:b] * 2, text[b:b + 5]))) + text[b:]
    return text


DEEP = ("(" * 60 + "1" + ")" * 60, "-" * 200 + "1", "1" + "^1" * 70, "1" + " + 1" * 300, "sin(" * 52 + "1" + ")" * 52,
        "f(" * 30 + "J" + ")" * 30, "g(g(1, 2), g(3, 4))" + "*2" * 100, "w[i" + "]" * 40, "x" * 3000, "if(" * 40 + "1", "not " * 60)


def any_formula():
    return formulas() | almost(formulas()) | st.sampled_from(DEEP) | st.text(max_size=40)


def quoted(text):
    """A TOML string of the text."""
    keep = "".join(c if c >= " " and c != "\x7f" else f"\\u{ord(c):04x}" for c in text.replace("\\", "\\\\").replace('"', '\\"'))
    return f'"{"".join("?" if 0xd800 <= ord(c) < 0xe000 else c for c in keep)}"'


CONTEXT = """[model]
name = "fuzzed"
[space]
w = {{ sphere = "n" }}
v = {{ r3 = 1 }}
[parameters]
n = 4
J = 1.0
K = {{ default = 0.3, fixed = true }}
gamma = {{ default = 1.0, size = "n" }}
B = {{ default = [0.0, 0.0, 1.0], vector = true }}
[formulas]
omega = "2*pi/J"
"f(a)" = "a*a + J"
"g(a, b)" = "a - b"
[effects.one]
over = {over}
energy = {energy}
"""
OVERS = ("site(i) of w", "pair(i, j) of w", "bond(i, j) of chain(n, periodic) on w", "bond(i, j) of square(2, n - 2, open) on w",
         "each(i of w, j of v)", "site(i) of v", "bond(i, j, k) of chain(n, open) on w", "edge(i, j) of g")


@st.composite
def spec_around(draw):
    """A whole spec around one formula."""
    over = draw(st.sampled_from(OVERS) | almost(st.sampled_from(OVERS)))
    return CONTEXT.format(over=quoted(over), energy=quoted(draw(any_formula())))


KEYS = ("name", "title", "orientation", "sphere", "r3", "nambu", "kappa", "radius", "tracer", "C", "default", "meaning", "unit",
        "size", "vector", "fixed", "over", "energy", "value", "theta", "phi", "vectors", "x", "y", "z", "random", "normalise",
        "start", "h", "time", "steps", "method", "effects", "set", "solver", "output", "every", "what", "period", "boundary",
        "sites", "bonds", "from", "to", "offset", "at", "file", "a", "n", "w", "J", "f(a)", "", "\u00e9", "x" * 50, "int", "t", "i")
VALUES = ("1", "0", "-1", "4", "1.0", "0.0", "1e400", "inf", "nan", "-0.0", "9223372036854775808", "10" * 30, "true", "[]", "{}",
          "[1, 2, 3]", "[[1, 0, 0], [0, 1, 0]]", "[[[[[]]]]]", '"n"', '"m"', '""', '"w"', "1979-05-27", '"spherical-midpoint"',
          '"site(i) of w"', '["energy", "states"]', '"periodic"', '"../x"', '"\\u0000"', '"\\U0010ffff"', "'''a\nb'''",
          "{ sphere = 2 }", "{ sphere = 2, kappa = [1, -1] }", '{ nambu = 1, C = "dot(w, w)/2" }', '{ default = 2, meaning = "x" }',
          '{ default = 1.0, size = "n" }', '{ every = 2, what = ["energy"] }', "[{ offset = [1] }]", '{ J = 2.0 }', "0o7", "1__0")
TABLES = ("model", "space", "parameters", "formulas", "effects", "observables", "starts", "runs", "lattices", "graphs", "effects.one",
          "effects.two", "starts.s", "starts.s.w", "runs.r", "lattices.l", "graphs.g", "observables.o", "nothing", "model.name", "a.b.c",
          '"quoted"', "effects.'for'", "\u00fc", "effects.", "starts.s.s.s")


@st.composite
def entries(draw):
    value = draw(st.sampled_from(VALUES) | any_formula().map(quoted))
    key = draw(st.sampled_from(KEYS))
    plain = key.isascii() and key.isalnum()
    return f"{key if plain else quoted(key)} = {value}"


@st.composite
def documents(draw):
    """Tables of entries of all kinds, at the right place or not, at times twice; some text may be damaged."""
    parts = []
    for name in draw(st.lists(st.sampled_from(TABLES), max_size=6)):
        double = draw(st.integers(0, 9)) == 0
        parts.append(f"[[{name}]]" if double else f"[{name}]")
        parts += draw(st.lists(entries(), max_size=4))
    body = "\n".join(parts)
    return draw(st.sampled_from(["", CONTEXT.format(over='"site(i) of w"', energy='"J*w[i].z"')])) + body + "\n"


@st.composite
def edited(draw, texts):
    """A whole spec with lines lost, doubled, exchanged or overwritten by an entry."""
    lines = draw(st.sampled_from(texts)).split("\n")
    for _ in range(draw(st.integers(1, 3))):
        k = draw(st.integers(0, len(lines) - 1))
        how = draw(st.integers(0, 4))
        if how == 0:
            del lines[k:k + draw(st.integers(1, 3))]
        elif how == 1:
            lines.insert(k, draw(st.sampled_from(lines)))
        elif how == 2:
            lines[k] = draw(entries())
        elif how == 3:
            lines[k] = draw(almost(st.just(lines[k])))
        else:
            lines.insert(k, "[" + draw(st.sampled_from(TABLES)) + "]")
        lines = lines or [""]
    return "\n".join(lines)
