"""Results in the output folder, each whole or absent.

    OUT/objects/ab/abcd…/mesh.glb, picture.png, result.json     one result, named by its key
    OUT/catalogue/                                              see `catalogue`
    OUT/.tmp/RUN/                                               what is being written; gone after a run

A result is written under `.tmp` and renamed as a folder, so a reader sees all of its files or none.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import pathlib
import shutil
import tempfile
import time
from typing import Iterator, Optional

from .options import Json

RESULT = "result.json"


class Store:
    """The results under an output folder that every worker sees."""

    def __init__(self, out: "os.PathLike[str] | str") -> None:
        self.out = pathlib.Path(out)

    def folder(self, key: str) -> pathlib.Path:
        return self.out / "objects" / key[:2] / key

    def find(self, key: str) -> Optional[Json]:
        """The stored result, or `None`."""
        try:
            stored: Json = json.loads((self.folder(key) / RESULT).read_text())
            return stored
        except FileNotFoundError:
            return None
        except ValueError:  # Cut short, by a loss of power.
            shutil.rmtree(self.folder(key), ignore_errors=True)
            return None

    @contextlib.contextmanager
    def writing(self, run: str) -> Iterator[pathlib.Path]:
        """A new folder to write outputs to. Removed at the end unless `publish` renamed it."""
        scratch = pathlib.Path(tempfile.mkdtemp(dir=self.scratch(run)))
        try:
            yield scratch
        finally:
            shutil.rmtree(scratch, ignore_errors=True)

    def publish(self, scratch: pathlib.Path, key: str, result: Json) -> Json:
        """Gives the outputs in `scratch` their name. Returns the stored result: that of another process if it was
        first."""
        (scratch / RESULT).write_text(json.dumps(result, sort_keys=True))
        os.chmod(scratch, 0o755)
        folder = self.folder(key)
        folder.parent.mkdir(parents=True, exist_ok=True)
        try:
            os.rename(scratch, folder)
            return result
        except OSError:
            # A folder with files in it is never replaced: another worker had the same input.
            stored = self.find(key)
            if stored is None:
                raise
            return stored

    def scratch(self, run: str) -> pathlib.Path:
        return self.out / ".tmp" / run

    def start(self, run: str) -> None:
        """Makes the run's scratch folder and removes those of earlier runs. The caller holds the catalogue's lock."""
        self.clear()
        self.scratch(run).mkdir(parents=True)

    def clear(self) -> None:
        """Removes all scratch folders."""
        remove_tree(self.out / ".tmp")


def remove_tree(folder: "os.PathLike[str] | str", patience: float = 10.0) -> None:
    """Removes a folder that processes which are about to end may still write to: tries for `patience` seconds."""
    until = time.monotonic() + patience
    while os.path.exists(folder):
        shutil.rmtree(folder, ignore_errors=True)
        if not os.path.exists(folder) or time.monotonic() > until:
            return
        time.sleep(0.05)


def describe(path: pathlib.Path, relative_to: str) -> Json:
    """An output as the catalogue lists it: format, path within the output folder, bytes, SHA-256."""
    with open(path, "rb") as file:
        digest = hashlib.sha256()
        for block in iter(lambda: file.read(1 << 20), b""):
            digest.update(block)
    return {
        "format": path.suffix[1:],
        "path": f"{relative_to}/{path.name}",
        "bytes": path.stat().st_size,
        "sha256": digest.hexdigest(),
    }
