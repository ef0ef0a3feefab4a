"""Saved states and checkpoints in extended precision: the bytes beside a number, which hold nothing of it, are 0."""
import numpy as np
import pytest
import smidgen
from smidgen.run.files.checkpoint import Folder

pytestmark = pytest.mark.skipif(np.dtype(np.longdouble).itemsize != 16 or np.finfo(np.longdouble).nmant != 63, reason="long double has no bytes beside its number")


def beside(numbers) -> bytes:
    return np.frombuffer(numbers.tobytes(), np.uint8).reshape(-1, 16)[:, 10:].tobytes()


def test_a_saved_state_has_the_bytes_of_its_numbers():
    top = smidgen.build("free_rigid_body", real="long double").start(h=0.1).steps(7)
    first = top.save()
    junk = np.full(len(first), 255, np.uint8).repeat(16)       # memory that the next one may get
    del junk
    again = top.save()
    assert beside(first).strip(b"\0") == beside(again).strip(b"\0") == b"" and first.tobytes() == again.tobytes()
    assert np.array_equal(top.restore(again).save(), first)


def test_checkpoints_of_the_same_run_are_the_same_bytes(tmp_path, monkeypatch):
    """In memory that is full of something else wherever numpy leaves it as it is."""
    written, put, empty = [[], []], Folder.put, np.empty
    for byte in (0, 255):
        def noted(self, kind, number, facts, arrays, found=written[byte % 2]):
            found.extend((kind, number, array.tobytes()) for array in arrays.values() if kind == "state")
            put(self, kind, number, facts, arrays)
        monkeypatch.setattr(Folder, "put", noted)
        monkeypatch.setattr(np, "empty", lambda shape, dtype=float, byte=byte, **more: filled(empty(shape, dtype, **more), byte))
        smidgen.run("free_rigid_body", real="long double", steps=20, checkpoint=10, out=tmp_path / f"{byte}.npz")
    assert len(written[0]) > 1 and written[0] == written[1]


def filled(array, byte: int):
    if array.dtype.kind in "fiu" and array.flags.c_contiguous:
        array.reshape(-1).view(np.uint8)[:] = byte
    return array
