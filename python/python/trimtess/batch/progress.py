"""How far a run is, and when it will end."""

from __future__ import annotations

import sys
import time
from typing import Optional

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

#: Seconds between lines where standard error is no terminal.
BETWEEN_LINES = 10.0


class Meter:
    """A bar on a terminal, a line now and then elsewhere, nothing if `quiet`.

    The estimate goes by predicted seconds, not by files: large files go first.
    """

    def __init__(self, files: int, seconds: float, quiet: bool) -> None:
        console = Console(stderr=True)
        columns = (
            TextColumn("{task.fields[done]}/{task.fields[files]} files"),
            BarColumn(),
            TextColumn("{task.fields[failed]} failed"),
            TimeElapsedColumn(),
            TextColumn("left"),
            TimeRemainingColumn(),
        )
        self._lines = not quiet and not console.is_terminal
        self._last_line = time.monotonic()
        self._bar = Progress(*columns, console=console, disable=quiet or self._lines, speed_estimate_period=60)
        self._task = self._bar.add_task("", total=seconds, files=files, done=0, failed=0)
        self._bar.start()

    def advance(self, files: int, failed: int, seconds: float) -> None:
        """Counts files that got their row, and their predicted seconds."""
        task = self._bar.tasks[0]
        done, failed = task.fields["done"] + files, task.fields["failed"] + failed
        self._bar.update(self._task, advance=seconds, done=done, failed=failed)
        if self._lines and time.monotonic() - self._last_line >= BETWEEN_LINES:
            self._last_line = time.monotonic()
            left = remaining(task.elapsed, task.completed, task.total)
            print(f"{done}/{task.fields['files']} files, {failed} failed, {left} left", file=sys.stderr)

    def close(self) -> None:
        self._bar.stop()


def remaining(elapsed: Optional[float], completed: float, total: Optional[float]) -> str:
    """Time that is left at the mean speed so far, in words."""
    if not elapsed or not completed or total is None:
        return "unknown"
    seconds = max(0.0, total - completed) * elapsed / completed
    minutes, seconds = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{seconds:02}"
