"""Time of the processor, which other programs of the machine do not lengthen."""
from __future__ import annotations

import os


def processor_seconds() -> float:
    """Seconds that the processor has worked for this process, all its threads, and the children that it has waited for (a
    compiler, say), in user code and in the system: what lies between two calls is the work of both. In ticks of the system,
    0.01 s as a rule: for work that takes many of them. A run of a model is timed by `time.thread_time`."""
    return sum(os.times()[:4])
