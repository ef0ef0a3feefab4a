"""Which part of a run a process was in when it died: told in memory that its parent shares."""
import mmap
import os
import signal
import time
from importlib import import_module


START, COMPUTING, WRITING, RESULT, ENDED = range(5)
NAMES = ("start", "computing", "checkpoint writing", "putting the result together")
RUN = vars(import_module("smidgen.run.run"))


class Phases:
    """The phase of a child and how often it has entered each; `watch` is called in the child."""

    def __init__(self):
        self.shared = mmap.mmap(-1, 1 + ENDED + 1)
        self.moves = []

    @property
    def now(self):
        return self.shared[0]

    def entries(self, phase):
        return self.shared[1 + phase]

    def enter(self, phase):
        self.moves.append((time.perf_counter(), phase))
        self.shared[1 + phase] = min(255, self.shared[1 + phase] + 1)
        self.shared[0] = phase

    def watch(self):
        """From here on this process tells its phase."""
        self.enter(START)
        self.tell("advance", COMPUTING, COMPUTING)
        self.tell("_save", WRITING, COMPUTING)
        self.tell("_finish", RESULT, ENDED)

    def tell(self, name, inside, after):
        real = RUN[name]

        def told(*args, **more):
            final = self.now == RESULT          # the last state belongs to the result
            self.enter(RESULT if final else inside)
            found = real(*args, **more)
            self.enter(RESULT if final else after)
            return found
        RUN[name] = told


def killed_in(phase, entry, seconds, act):
    """Fork, act() in the child, kill -9 `seconds` after it has entered `phase` for the entry-th time.
    (status of its end, the phase it was in)."""
    phases = Phases()
    child = os.fork()
    if child == 0:
        phases.watch()
        try:
            act()
        except BaseException:
            os._exit(99)
        os._exit(0)
    done = 0
    while not done and phases.entries(phase) < entry:
        time.sleep(1e-4)
        done, status = os.waitpid(child, os.WNOHANG)
    if not done:
        time.sleep(seconds)
        os.kill(child, signal.SIGKILL)          # a child that has ended waits as a zombie
        _, status = os.waitpid(child, 0)
    return os.waitstatus_to_exitcode(status), phases.now


def durations(act):
    """(entries, mean seconds) of each phase of act(), run to its end in this process."""
    phases, saved = Phases(), dict(RUN)
    try:
        phases.watch()
        act()
    finally:
        RUN.update({name: saved[name] for name in ("advance", "_save", "_finish")})
    spent = [[] for _ in NAMES]
    for (begin, phase), (end, _) in zip(phases.moves, phases.moves[1:]):
        spent[phase].append(end - begin)
    return [(len(times), sum(times) / len(times)) for times in spent]
