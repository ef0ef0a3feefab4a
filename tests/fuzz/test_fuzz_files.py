"""Files beside a spec under random input: graphs and start tables of any bytes are read, or refused in words."""
import io

import numpy as np
import pytest
import smidgen
from fuzz.judge import check_print
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from smidgen.run.step.start import initial_state, state_table

SPEC = """[model]
name = "files"
[space]
w = { sphere = 3 }
[graphs.g]
file = "g.csv"
[effects.e]
over = "edge(i, j, K) of g"
energy = "K*dot(w[i], w[j])"
"""
PLAIN = SPEC.replace('[graphs.g]\nfile = "g.csv"\n', "").replace("edge(i, j, K) of g", "pair(i, j) of w").replace("K*", "")
MANY = settings(max_examples=200, deadline=None, suppress_health_check=list(HealthCheck))
CELLS = st.sampled_from(["0", "1", "2", "-1", "0.5", "1e400", "nan", "inf", "9" * 41, "9" * 30, "0x1", "", " ", "i", "K", "\u0663", "1_0",
                         "+1", "1.", ".5", "1e", "\x00", "#", '"1"', "\ufeff0", "1\u2028", "\x0b"]) | st.floats(-1, 1).map(repr)
TABLES = st.lists(st.lists(CELLS, min_size=1, max_size=5).map(",".join), max_size=5).map("\n".join).map(str.encode) | st.binary(max_size=60)
HEADS = st.sampled_from([b"{'descr': '<f8', 'fortran_order': False, 'shape': (3, 3), }", b"{'descr': '<f8', 'fortran_order': False, 'shape': (10**3, 3), }",
                         b"{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000, 3), }", b"{'descr': '|O', 'fortran_order': False, 'shape': (3,), }",
                         b"{'descr': '<c16', 'fortran_order': True, 'shape': (3, 3), }", b"{'descr': '<f8', 'fortran_order': False, 'shape': (-3, 3), }",
                         b"{'descr': '<U9', 'fortran_order': False, 'shape': (3, 3), }", b"{'descr': [('a', '<f8')], 'fortran_order': False, 'shape': (3,), }",
                         b"{'shape': (", b"", b"[" * 300, b"{'descr': '<f8', 'fortran_order': False, 'shape': (9223372036854775807, 9), }"])


def npy(head, body):
    """A .npy file of this head."""
    return b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head + body


def saved(save, *arrays):
    out = io.BytesIO()
    save(out, *arrays)
    return out.getvalue()


GOOD = saved(np.save, np.eye(3))
ARRAYS = (st.builds(npy, HEADS, st.binary(max_size=100)) | st.binary(max_size=60).map(lambda b: b"\x93NUMPY" + b) | st.integers(0, len(GOOD)).map(lambda k: GOOD[:k])
          | st.sampled_from([GOOD, saved(np.savez, np.eye(3)), saved(np.savez, np.eye(3))[:50], b"PK\x03\x04", b"", b"\x80\x04K\x01."])
          | st.builds(lambda k, b: GOOD[:k] + bytes([b]) + GOOD[k + 1:], st.integers(0, len(GOOD) - 1), st.integers(0, 255)))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("files")


@MANY
@given(data=TABLES)
def test_graphs(folder, data):
    (folder / "g.csv").write_bytes(data)
    (folder / "g.toml").write_text(SPEC)
    try:
        smidgen.load(folder / "g.toml")
    except smidgen.SpecError as error:
        assert {d.code for d in error.diagnostics} <= {"E501", "E503", "E504", "E505"}
        check_print(str(error))


def started(folder, name, data):
    """The start that the file holds, or the refusal."""
    (folder / name).write_bytes(data)
    (folder / "s.toml").write_text(PLAIN + f'[starts.s]\nfile = "{name}"\nnormalise = true\n')
    try:
        w = initial_state(smidgen.load(folder / "s.toml"))
        assert w.shape == (3, 3) and w.dtype == float
        np.testing.assert_allclose(np.linalg.norm(w, axis=1), 1, atol=1e-15)
    except (smidgen.SpecError, smidgen.UsageError) as refusal:
        check_print(str(refusal))
        return str(refusal)


@MANY
@given(data=TABLES)
def test_start_tables(folder, data):
    started(folder, "s.csv", data)


def given_state(folder, data, name="s.npy"):
    """The array that a file given to a run holds, or the refusal."""
    (folder / name).write_bytes(data)
    try:
        assert state_table(folder / name, name).dtype == float
    except smidgen.UsageError as refusal:
        check_print(str(refusal))
        return str(refusal)


@MANY
@given(data=ARRAYS)
def test_arrays(folder, data):
    given_state(folder, data)


@pytest.mark.filterwarnings("ignore:.*input contained no data")
@MANY
@given(data=TABLES)
def test_rows(folder, data):
    given_state(folder, data, "given.csv")


def test_good_files_are_good(folder):
    assert given_state(folder, GOOD) is None
    assert started(folder, "s.csv", b"x,y,z\n1,0,0\n0,2,0\n0,0,3\n") is None
