"""CAD files (trimmed NURBS, STEP) to watertight triangle meshes as numpy arrays.

>>> import trimtess
>>> mesh = trimtess.read("part.step").prepare().tessellate(chord_rel=1e-3, angle=20)
>>> mesh.positions.shape, mesh.triangles.shape
>>> mesh.save("part.glb")

Lengths are millimetres and angles degrees. Everything that takes time releases the interpreter's lock, calls
``progress`` about 20 times a second, and ends with ``KeyboardInterrupt`` on Ctrl-C.
"""

from ._trimtess import (
    Attributes,
    Check,
    Deviation,
    Diagnostic,
    Edge,
    Face,
    Flat,
    Frame,
    Instance,
    Mesh,
    MeshPart,
    Model,
    Part,
    PartCheck,
    Prepared,
    Saved,
    Session,
    Spread,
    Tile,
    View,
    __version__,
    read,
)
from .errors import (
    Error,
    FormatError,
    InternalError,
    LimitError,
    NoAdapterError,
    RangeError,
    ReadError,
    RenderError,
    RoundingError,
    SaveError,
    TessellateError,
)

__all__ = [
    "Attributes",
    "Check",
    "Deviation",
    "Diagnostic",
    "Edge",
    "Error",
    "Face",
    "Flat",
    "FormatError",
    "Frame",
    "Instance",
    "InternalError",
    "LimitError",
    "Mesh",
    "MeshPart",
    "Model",
    "NoAdapterError",
    "Part",
    "PartCheck",
    "Prepared",
    "RangeError",
    "ReadError",
    "RenderError",
    "RoundingError",
    "SaveError",
    "Saved",
    "Session",
    "Spread",
    "TessellateError",
    "Tile",
    "View",
    "__version__",
    "read",
]
