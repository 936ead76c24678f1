"""What determines an output, and its hash."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from typing import Any, Dict, Optional, Tuple

#: An object as JSON has it: jobs, outcomes, rows and heads, which cross processes.
Json = Dict[str, Any]

#: Version of results and of the catalogue. Raise it when their layout or meaning changes.
LAYOUT = 1

MESHES = ("glb", "ply", "obj", "stl")
FORMATS = (*MESHES, "png")


@dataclasses.dataclass(frozen=True)
class Options:
    """Options that change outputs. Limits and numbers of cores do not."""

    #: Largest distance between mesh and surface, millimetres. Exclusive with `chord_rel`.
    chord: Optional[float] = None
    #: The same as a fraction of the diagonal of the model.
    chord_rel: Optional[float] = 1e-3
    #: Largest angle by which the normal turns across a cell, degrees.
    angle: float = 20.0
    #: Longest cell diagonal and edge segment, millimetres.
    max_edge: Optional[float] = None
    #: Output formats, sorted.
    formats: Tuple[str, ...] = ("glb",)
    #: Width and height of a picture, pixels. Counts only if `formats` has `png`.
    size: Tuple[int, int] = (800, 600)
    #: Move the centre of the scene to the origin.
    recenter: bool = False
    #: Read supplemental geometry too.
    supplemental: bool = False

    def canonical(self) -> Json:
        """The options that count, as JSON data. Equal for options that make equal outputs."""
        data: Json = dataclasses.asdict(self)
        data["formats"] = sorted(set(self.formats))
        data["size"] = list(self.size) if "png" in self.formats else None
        return data

    @classmethod
    def from_canonical(cls, data: Json) -> "Options":
        size = tuple(data["size"]) if data["size"] else cls.size
        return cls(**{**data, "formats": tuple(data["formats"]), "size": size})

    def tolerance(self) -> Json:
        """Arguments of `Prepared.tessellate`."""
        return {"chord": self.chord, "chord_rel": self.chord_rel, "angle": self.angle, "max_edge": self.max_edge}


def result_key(sha256: str, options: Json, version: str) -> str:
    """Name of the result of an input: 64 hex digits.

    `sha256`: of the input, in hex. `options`: from `Options.canonical`. `version`: of trimtess.
    """
    text = json.dumps([LAYOUT, version, options, sha256], sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()
