"""Sub-stepping: a step that fails is taken as 2^k smaller ones. Only for those who ask for it.

A map that changes its step where the state calls for it is no symplectic map of one h, so every
such step is recorded.
"""
from __future__ import annotations

from .saved import Saved, retimed

DEEPEST = 10                    # at most 2^10 parts


def substep(model) -> int | None:
    """One step of h as 2^k steps of h/2^k, for the least k from 1 on that succeeds.

    Returns k, or None when 2^10 parts fail too; the state is then as it was. The parts begin at
    the state with its carry; they count in parts from step 0, so that t0 + count*2^k * h/2^k is
    the same number as t0 + count*h and nothing of the time is lost. The increments of earlier
    steps, which only help to predict, are forgotten before and after.
    """
    before = model.save()
    head = Saved.of(before)
    for k in range(1, DEEPEST + 1):
        part = head.h / 2 ** k
        if part * 2 ** k != head.h:         # a denormal: the parts would not add up
            break
        model.restore(retimed(before, part, head.count * 2 ** k))
        if model.advance(2 ** k) == 2 ** k:
            model.restore(retimed(model.save(), head.h, head.count + 1))
            return k
    model.restore(before)
    return None
