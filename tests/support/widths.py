"""Builds with a number of lanes, and whether others have their bits."""
import numpy as np
import smidgen
from smidgen.check.witness import Witness


def built(monkeypatch, spec, method, lanes=4, compiler="gcc", **more):
    monkeypatch.setenv("CC", f"{compiler} -Wno-psabi -DSMG_LANES={lanes}")
    return smidgen.build(spec, method=method, **more)


def bits(model, steps=8):
    return model.start("random", h=0.2).steps(steps).save()


def same_in_lanes(build, widths) -> bool:
    """build(lanes=n): the bits of one lane in any number of them?"""
    wanted = bits(build(lanes=1))
    return all(np.array_equal(bits(build(lanes=n)), wanted) for n in widths)


def same_by_clang(build) -> bool:
    """build(lanes=n, compiler=name): those of gcc in four lanes by clang in two?"""
    return np.array_equal(bits(build(lanes=2, compiler="clang")), bits(build(lanes=4, compiler="gcc")))


def by_witness(spec, w, method, steps, h=0.2):
    """(sites, 3) after some steps of the witness."""
    found = Witness(spec).steps(w, 0.0, h, steps, method)
    return found if np.ndim(found) == 2 else found[-1]
