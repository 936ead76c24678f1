"""Errors that stop a run. Each becomes one line on standard error and an exit status."""

from __future__ import annotations

import errno
from typing import Any, Tuple

#: Exit statuses of the program.
WHOLE, CANNOT, USAGE, PARTIAL = 0, 1, 2, 3

#: Error numbers of a full disk: no space, over quota, file too large.
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


class BatchError(Exception):
    """Stops the run. The message is one line that names what to change."""

    status = CANNOT


class UsageError(BatchError):
    """The command line is wrong."""

    status = USAGE


class DiskFull(BatchError):
    """There is no room for outputs or the catalogue. What was recorded stays valid."""

    def __init__(self, folder: str, reason: str) -> None:
        super().__init__(f"{folder}: {reason}; free some space and run the same command again to continue")
        self.folder = folder
        self.reason = reason

    def __reduce__(self) -> Tuple[Any, ...]:  # Exceptions cross processes by their arguments.
        return DiskFull, (self.folder, self.reason)


class Interrupted(BatchError):
    """A signal asked the run to stop. What was recorded stays valid."""

    def __init__(self, signal: int) -> None:
        super().__init__("stopped; run the same command again to continue")
        self.status = 128 + signal
