"""A process that dies at an instant of one's choosing, and what it leaves."""
import os
import random
import signal
import time

import smidgen
from smidgen.run.files import durable, output        # noqa: F401  (loaded before the fork)

CALLS = ("fsync", "replace", "unlink", "rmdir", "mkdir")


def die():
    """As kill -9 does: nothing is flushed, nothing cleaned up."""
    os.kill(os.getpid(), signal.SIGKILL)


class Deadly:
    """Counts what a process does to the disk and kills it at operation `at`: in the middle of a
    write, before any other call. at None: only counts."""

    def __init__(self, at=None):
        self.at, self.count = at, 0
        for name in CALLS:
            setattr(os, name, self.counted(getattr(os, name)))
        self.write_all = durable._write_all
        durable._write_all = self.write

    def counted(self, call):
        def counting(*args, **more):
            self.passes()
            return call(*args, **more)
        return counting

    def write(self, out, data):
        if self.count == self.at:
            self.write_all(out, data[:len(data) // 2])
        self.passes()
        self.write_all(out, data)

    def passes(self):
        if self.count == self.at:
            die()
        self.count += 1


def forked(act) -> int:
    """Run act() in a child; the status of its end: 0, minus the signal, or 99 for an exception."""
    child = os.fork()
    if child == 0:
        try:
            code = act()
        except BaseException:
            code = 99
        os._exit(code or 0)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def killed_after(seconds, act) -> int:
    """Run act() in a child and kill -9 it after that time; its status."""
    child = os.fork()
    if child == 0:
        try:
            act()
        except BaseException:
            os._exit(99)
        os._exit(0)
    time.sleep(seconds)
    os.kill(child, signal.SIGKILL)          # a child that has ended waits as a zombie
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def instants(seed, count, longest):
    """Random times from 0 to `longest` seconds."""
    numbers = random.Random(seed)
    return [numbers.uniform(0, longest) for _ in range(count)]


def begin_or_resume(path, begin):
    """Go on with `path`, or begin it when there is no checkpoint."""
    try:
        return smidgen.resume(path)
    except smidgen.CheckpointError as problem:
        if "there is no checkpoint" not in str(problem):
            raise
        return begin(path)
