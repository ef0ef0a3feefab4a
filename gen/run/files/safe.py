"""The sink of a run with checkpoints: rows become parts, and the result is put together at the end."""
from __future__ import annotations

import contextlib

from ...errors import OutputError
from .checkpoint import CheckpointError, Folder, batches
from .output import check_layout, open_sink


class SafeSink:
    """Stands in for a file's sink. `saved` is the step that a resume would go on from; checkpoint: steps between two states; folder: of a run that goes on."""

    def __init__(self, out, meta: dict, layout: dict, checkpoint: int, folder: Folder | None = None):
        self.out, self.meta, self.layout, self.folder = out, meta, layout, folder
        self.saved, self.rows = None, 0
        check_layout(out, layout)
        with self._guard():
            self.folder = folder or Folder.begin(out, meta, checkpoint)

    def go_on(self, facts: dict) -> None:
        """Be where the state with these facts was saved; what is newer goes."""
        with self._guard():
            self.saved, self.rows = facts["count"], facts["rows"]
            self.folder.forget_after(self.rows)

    def write(self, chunk: dict) -> None:
        """A part with k more rows. Raises OutputError."""
        if len(chunk["t"]):
            with self._guard():
                self.folder.put("rows", self.rows, {}, chunk)
                self.rows += len(chunk["t"])

    def save(self, count: int, state, facts: dict) -> None:
        """The rows so far and this state are safe when it returns. Raises OutputError."""
        if count == self.saved:
            return
        with self._guard():
            self.folder.put("state", count, {**facts, "count": count, "rows": self.rows}, {"state": state})
            self.saved = count
            self.folder.keep_states(count)

    def chunks(self):
        """All rows, part by part."""
        for part in self.folder.parts("rows"):
            arrays = part.read()[1]
            for name, (shape, kind) in self.layout.items():
                if name not in arrays or arrays[name].shape != (len(arrays["t"]), *shape) or arrays[name].dtype != kind:
                    raise CheckpointError(f"{part.path} contains rows of another run")
            yield {name: arrays[name] for name in self.layout}

    def close(self, meta: dict, extras: dict, capacity: int, keep: bool = False) -> None:
        """Put the result together as a run without checkpoints would have written it.

        capacity: rows a write. keep: the run is not at its end and may go on from here.
        """
        with self._guard():
            sink = open_sink(self.out, meta, self.layout, self.folder.path)
            try:
                for chunk in batches(self.chunks(), capacity):
                    sink.write(chunk)
                sink.close(meta, extras)
            except BaseException:
                sink.abandon()
                raise
            self.folder.release() if keep else self.folder.finish()

    def abandon(self) -> None:
        """What was saved stays."""
        if self.folder:
            self.folder.release()

    @contextlib.contextmanager
    def _guard(self):
        """What goes wrong while writing becomes an OutputError that says how to go on."""
        try:
            yield
        except CheckpointError:
            raise
        except (OSError, OutputError) as problem:
            self.abandon()
            said = problem if isinstance(problem, OutputError) else f"cannot write {self.out}: {problem.strerror or problem}"
            raise OutputError(f"{said}{self._way_on()}") from None

    def _way_on(self) -> str:
        if not self.folder or not self.folder.path.is_dir() or not self.folder.parts("run"):
            return ""
        return (f". The first {self.saved or 0} steps are saved in {self.folder.path}: when there is room, continue with `smidgen run --resume {self.out}`")
