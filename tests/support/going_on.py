"""A trajectory goes on with the same bits, whatever stands between its steps."""
import numpy as np


def restored(model) -> bool:
    """Saved after 7 steps, restored over another one."""
    saved, whole = model.start("random", h=0.1).steps(7).save(), model.steps(9).save()
    return np.array_equal(model.start("random", h=0.03).restore(saved).steps(9).save(), whole)


def one_by_one(model, steps=16) -> bool:
    """A call for each step, or one for all."""
    whole = model.start("random", h=0.1).steps(steps).save()
    model.start("random", h=0.1)
    for _ in range(steps):
        model.steps(1)
    return np.array_equal(model.save(), whole)
