"""Values, sizes, strengths and starts of a spec; formulas with numpy."""
import numpy as np
import pytest

from smidgen.errors import UsageError
from smidgen.language.evaluate import evaluate, integer
from smidgen.language.expr import DRAWS, SIGNATURES, Elem, Idx, Num, Op, Par, Spin, Time
from smidgen.language.spec import Family, FamilyStart, Parameter, Spec, Start
from smidgen.run.step.evaluated import casimir_matrices, kappas, parameter_values, radii, sizes
from smidgen.run.step.start import initial_state

pytestmark = pytest.mark.quick
I = Idx("i")


def spec(kind="sphere", start=("random", 7), normalise=False, radius=Num(2.0), path="", **more):
    """n sites of strengths gamma[i] and one start."""
    parameters = (Parameter("n", "int", 3), Parameter("J", "real", 0.5),
                  Parameter("gamma", "array", (1.0, -2.0, 3.0), size=Par("n")))
    family = Family("w", kind, Par("n"), Elem("gamma", I),
                    radius if kind == "sphere" else None, **more)
    return Spec("s", "s", parameters, (family,), (), path=str(path),
                starts=(Start("a", (FamilyStart("w", *start, normalise),)),))


X, V = np.array([0.3, -0.7, 1.9]), np.array([1.1, 0.4, -0.2])
PLAIN = {       # operator -> the same with numpy, for arguments 0.6 and 0.4, or X and V
    "+": np.add, "-": np.subtract, "neg": np.negative, "*": np.multiply, "/": np.divide,
    "^": np.power, "vec": lambda *a: np.array(a), "x": lambda a: a[0], "y": lambda a: a[1],
    "z": lambda a: a[2], "dot": np.dot, "cross": np.cross, "norm": np.linalg.norm,
    "triple": lambda a, b, c: np.linalg.det([a, b, c]), "asin": np.arcsin, "acos": np.arccos,
    "atan": np.arctan, "abs": np.abs, "atan2": np.arctan2, "mod": np.mod, "min": min,
    "max": max, "if": lambda c, a, b: a if c else b,
    "<": np.less, "<=": np.less_equal, ">": np.greater, ">=": np.greater_equal,
    "==": np.equal, "!=": np.not_equal, "and": np.logical_and, "or": np.logical_or,
    "not": np.logical_not, "kept": lambda a: a,
}
CASES = [(op, kinds) for op, signatures in SIGNATURES.items() for kinds, _ in signatures if op not in DRAWS]


@pytest.mark.parametrize("op, kinds", CASES)
def test_every_operator(op, kinds):
    env = {"spins": {"w": [X, V, X + V]}}
    trees = {"s": [Num(0.6), Num(0.4), Num(-0.3)], "v": [Spin("w", k) for k in range(3)],
             "b": [Op("<", (Num(0), Num(1))), Op(">", (Num(0), Num(1)))]}
    numbers = {"s": [0.6, 0.4, -0.3], "v": [X, V, X + V], "b": [True, False]}
    arguments = tuple(trees[k][n] for n, k in enumerate(kinds))
    expected = PLAIN.get(op) or getattr(np, op)
    got = evaluate(Op(op, arguments), env)
    assert np.allclose(got, expected(*(numbers[k][n] for n, k in enumerate(kinds))), atol=1e-15)


def test_index_arrays_give_one_value_a_site():
    e = Op("vec", (I, Op("*", (Par("J"), Elem("gamma", I))), Time()))
    got = evaluate(e, {"i": np.arange(3), "J": 2.0, "gamma": [1.0, 5.0, 7.0], "t": 9.0})
    assert got.tolist() == [[0, 2, 9], [1, 10, 9], [2, 14, 9]]


def test_only_the_chosen_branch_is_evaluated():
    outside = Elem("gamma", Num(99))
    e = Op("if", (Op("<", (I, Num(5))), Num(1.0), outside))
    assert evaluate(e, {"i": 0, "gamma": [1.0]}) == 1.0


def test_entries_outside_an_array_are_refused():
    with pytest.raises(UsageError, match="entries 0 to 1"):
        evaluate(Elem("gamma", Num(2)), {"gamma": [1.0, 2.0]})


@pytest.mark.parametrize("value", [0.5, float("nan"), 2.0**60])
def test_integer_formulas_must_be_integers(value):
    with pytest.raises(UsageError, match="integer"):
        integer(Num(value), {})


def test_values_are_defaults_and_overrides_and_idempotent():
    s = spec()
    values = parameter_values(s, {"J": 2})
    assert (values["n"], values["J"], values["gamma"].tolist()) == (3, 2.0, [1, -2, 3])
    again = parameter_values(s, values)
    assert again["J"] == 2.0 and again["gamma"].tolist() == [1, -2, 3]


@pytest.mark.parametrize("values, message", [
    ({"K": 1}, "no parameter 'K'"), ({"gama": 1}, "did you mean 'gamma'"),
    ({"J": float("nan")}, "finite"), ({"J": "x"}, "one number"), ({"n": 2.5}, "integer"),
    ({"n": 4}, "list of 4 numbers, not 3"), ({"gamma": [1, 2]}, "list of 3 numbers, not 2"),
    ({"gamma": [1, 2, np.inf]}, "finite"), ({"n": 0, "gamma": []}, "at least one site"),
    ({"gamma": [1, 0, 1]}, "kappa of site 1 is 0"), ({"J": 10**400}, "finite"),
])
def test_bad_values_are_refused(values, message):
    with pytest.raises(UsageError, match=message):
        kappas(spec(), values)


def test_one_number_fills_an_array():
    assert kappas(spec(), {"gamma": 2.0, "n": 5}).tolist() == [2.0] * 5


def test_sizes_strengths_radii():
    assert sizes(spec()) == {"w": (0, 3)}
    assert kappas(spec()).tolist() == [1, -2, 3]
    assert radii(spec()).tolist() == [2, 2, 2]
    assert np.isnan(radii(spec("r3"))).all()
    assert (casimir_matrices(spec()) == np.eye(3)).all()


def test_random_starts_repeat_and_lie_on_the_sphere():
    a, b = initial_state(spec()), initial_state(spec(), "a", seed=8)
    assert np.array_equal(a, initial_state(spec(), "a", seed=7)) and not np.array_equal(a, b)
    assert np.allclose(np.linalg.norm(a, axis=1), 2, rtol=1e-15)


def test_random_starts_are_uniform():
    w = initial_state(spec(radius=Num(1.0)), parameters={"n": 40000, "gamma": 1.0})
    assert np.abs(w.mean(axis=0)).max() < 4 / np.sqrt(3 * 40000)
    assert np.abs((w.T @ w) / 40000 - np.eye(3) / 3).max() < 4 * 0.3 / np.sqrt(40000)


def test_formula_and_vector_starts():
    e = (Op("cos", (I,)), Op("sin", (I,)), Num(0))
    w = initial_state(spec(start=("formula", e), radius=Num(1.0)))
    assert np.allclose(w, [[np.cos(k), np.sin(k), 0] for k in range(3)], atol=1e-16)
    rows = ((0, 0, 2), (0, 2, 0), (0, 0, -2))
    assert initial_state(spec(start=("vectors", rows))).tolist() == [list(r) for r in rows]


@pytest.mark.parametrize("off, refused", [(0.9e-12, False), (1.1e-12, True)])
def test_off_the_sphere_is_refused_unless_normalised(off, refused):
    rows = ((0, 0, 2 * (1 + off)), (0, 2, 0), (2, 0, 0))
    if refused:
        with pytest.raises(UsageError, match="site 0 of 'w' starts at"):
            initial_state(spec(start=("vectors", rows)))
    else:
        initial_state(spec(start=("vectors", rows)))
    w = initial_state(spec(start=("vectors", rows), normalise=True))
    assert np.allclose(np.linalg.norm(w, axis=1), 2, rtol=1e-15)


@pytest.mark.parametrize("rows, message", [
    (((0, 0, 2),), r"shape \(1, 3\)"), (((0, 0, float("nan")),) * 3, "not finite at site 0"),
    (((0, 0, 0),) * 3, "off its sphere"),
])
def test_bad_vectors_are_refused(rows, message):
    with pytest.raises(UsageError, match=message):
        initial_state(spec(start=("vectors", rows)))


def test_unknown_start_names_those_there_are():
    with pytest.raises(UsageError, match="it has: a"):
        initial_state(spec(), "b")


TABLE = np.array([[0, 0, 2.0], [0, 2, 0], [2, 0, 0]])


@pytest.mark.parametrize("name, header", [("w.csv", ""), ("w.csv", "x,y,z"), ("w.npy", "")])
def test_starts_from_files(tmp_path, name, header):
    if name.endswith("npy"):
        np.save(tmp_path / name, TABLE)
    else:
        np.savetxt(tmp_path / name, TABLE, delimiter=",", header=header, comments="")
    s = spec(start=("file", name), path=tmp_path / "s.toml")
    assert np.array_equal(initial_state(s), TABLE)


def test_bad_start_files(tmp_path):
    (tmp_path / "in").mkdir()
    np.savetxt(tmp_path / "w.csv", TABLE, delimiter=",")
    np.save(tmp_path / "in" / "o.npy", np.array([{}], dtype=object), allow_pickle=True)
    (tmp_path / "in" / "bad.csv").write_text("1,2,3\n4,x,6\n")
    for name, message in [("../w.csv", "outside the folder"), ("none.csv", "cannot read"),
                          ("o.npy", "cannot read"), ("bad.csv", "cannot read")]:
        with pytest.raises(UsageError, match=message):
            initial_state(spec(start=("file", name), path=tmp_path / "in" / "s.toml"))
