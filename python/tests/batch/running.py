"""Runs the program as a user does."""

from __future__ import annotations

import subprocess
import sys
from typing import List


def command(*arguments: object) -> List[str]:
    return [sys.executable, "-m", "trimtess.batch", *map(str, arguments)]


def batch(*arguments: object, **options) -> "subprocess.CompletedProcess[str]":
    """Runs `trimtess-batch`."""
    return subprocess.run(command(*arguments), capture_output=True, text=True, timeout=600, **options)
