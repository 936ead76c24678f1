"""Exceptions of trimtess, with fields. Those defined here are subclasses of :class:`Error`, and can be pickled."""

from __future__ import annotations

from typing import Any, Optional, Tuple


class Error(Exception):
    """Base of the exceptions that this package defines."""

    def __init__(self, message: str, **fields: Any) -> None:
        super().__init__(message)
        self.message = message
        self.__dict__.update(fields)

    def __str__(self) -> str:
        return self.message

    def __reduce__(self) -> Tuple[Any, ...]:
        return (_restore, (type(self), self.message, dict(self.__dict__)))


def _restore(cls: type, message: str, fields: dict[str, Any]) -> Error:
    fields = {name: value for name, value in fields.items() if name != "message"}
    error: Error = cls(message, **fields)
    return error


class _SystemError(Error, OSError):
    """An error that may be the system's: then `errno` and `strerror` are set, else they are None."""

    path: Optional[str]
    errno: Optional[int]
    strerror: Optional[str]

    def __init__(
        self,
        message: str,
        *,
        path: Optional[str] = None,
        errno: Optional[int] = None,
        strerror: Optional[str] = None,
        **fields: Any,
    ) -> None:
        super().__init__(message, path=path, **fields)
        self.errno = errno
        self.strerror = strerror
        self.filename = path

    def __reduce__(self) -> Tuple[Any, ...]:
        fields = {**self.__dict__, "errno": self.errno, "strerror": self.strerror}
        return (_restore, (type(self), self.message, fields))


class ReadError(_SystemError):
    """A file cannot be read at all."""

    #: "io": the system refused; "not-step": other content; "syntax": beyond repair; "refused": anything else.
    kind: str

    def __init__(self, message: str, *, kind: str = "refused", **fields: Any) -> None:
        super().__init__(message, kind=kind, **fields)


class LimitError(Error):
    """A limit on cost is exceeded. Nothing was made."""

    #: The keyword argument that raises the limit, as "max_memory"; None if the call has none.
    name: Optional[str]
    #: The limit.
    limit: int
    #: What is needed; None if that was not counted.
    needed: Optional[int]

    def __init__(self, message: str, *, name: Optional[str], limit: int, needed: Optional[int] = None) -> None:
        super().__init__(message, name=name, limit=limit, needed=needed)


class RangeError(Error, ValueError):
    """An argument is out of range."""

    #: The argument.
    name: str
    #: Its value, as text.
    value: str
    #: What is expected, in words.
    expected: str

    def __init__(self, message: str, *, name: str, value: str, expected: str) -> None:
        super().__init__(message, name=name, value=value, expected=expected)


class TessellateError(Error):
    """Work cannot be done: the system refuses threads, in any call, or vertices exceed 32-bit indices."""


class FormatError(Error, ValueError):
    """A path does not end in that of a format that can be written."""

    #: The ending in lower case without its dot, empty if there is none.
    extension: str

    def __init__(self, message: str, *, extension: str) -> None:
        super().__init__(message, extension=extension)


class SaveError(_SystemError):
    """A file cannot be written. A file of that name is unchanged."""


class RoundingError(SaveError):
    """Rounding to the numbers of a file's format costs more than a tenth of the chord tolerance."""

    #: Upper bound on the distance that a vertex would be moved, millimetres; None if it is beyond single precision.
    moved: Optional[float]
    #: The largest distance allowed, millimetres; None as above.
    allowed: Optional[float]
    #: The vertex, millimetres, world coordinates; None as above.
    place: Optional[Tuple[float, float, float]]
    #: Whether `recenter=True` helps.
    recenter_helps: bool

    def __init__(
        self,
        message: str,
        *,
        moved: Optional[float] = None,
        allowed: Optional[float] = None,
        place: Optional[Tuple[float, float, float]] = None,
        recenter_helps: bool = False,
        **fields: Any,
    ) -> None:
        place = None if place is None else (place[0], place[1], place[2])
        super().__init__(message, moved=moved, allowed=allowed, place=place, recenter_helps=recenter_helps, **fields)


class RenderError(Error):
    """A picture cannot be drawn: it is larger than the adapter allows, or the device fails."""


class NoAdapterError(RenderError):
    """There is no graphics adapter, not even one in software."""


class InternalError(Error):
    """A defect of this package. Please report it with the file that caused it."""
