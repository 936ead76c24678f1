"""Seeded variations of STEP files: moved, renamed and broken copies. The same seed makes the same bytes."""

from __future__ import annotations

import pathlib
import random
import re
from typing import Callable, List, Sequence

#: A point with three coordinates. Images of edges in parameters have two and must stay.
NUMBER = rb"[-+0-9.Ee]+"
POINT = re.compile(
    rb"(CARTESIAN_POINT\s*\(\s*'[^']*'\s*,\s*\()\s*(%s)\s*,\s*(%s)\s*,\s*(%s)\s*(\)\s*\))" % ((NUMBER,) * 3)
)

#: A product's identifier and name.
PRODUCT = re.compile(rb"(\bPRODUCT\s*\(\s*')([^']*)(')")


def moved(data: bytes, chance: random.Random) -> bytes:
    """The model moved by a few millimetres along each axis."""
    by = [round(chance.uniform(-5.0, 5.0), 3) for _ in range(3)]

    def move(match: "re.Match[bytes]") -> bytes:
        places = [repr(float(match[axis + 2]) + by[axis]).upper().encode() for axis in range(3)]
        return match[1] + b",".join(places) + match[5]

    return POINT.sub(move, data)


def renamed(data: bytes, chance: random.Random) -> bytes:
    """The same model under other names."""
    suffix = b"-%08x" % chance.getrandbits(32)
    return PRODUCT.sub(lambda match: match[1] + match[2] + suffix + match[3], data) + b"/*%s*/\n" % suffix


def cut(data: bytes, chance: random.Random) -> bytes:
    """The start of the file."""
    return data[: chance.randrange(len(data))]


def scrambled(data: bytes, chance: random.Random) -> bytes:
    """The file with other bytes at a few places."""
    changed = bytearray(data)
    for _ in range(chance.randrange(1, 40)):
        changed[chance.randrange(len(changed))] = chance.randrange(256)
    return bytes(changed)


def renumbered(data: bytes, chance: random.Random) -> bytes:
    """The file with a few references that lead elsewhere."""
    numbers = [match.span() for match in re.finditer(rb"#\d+", data)]
    if not numbers:
        return cut(data, chance)
    changed = bytearray(data)
    for start, end in sorted(chance.sample(numbers, min(8, len(numbers))), reverse=True):
        changed[start:end] = b"#%d" % chance.randrange(1, len(numbers))
    return bytes(changed)


def no_step(_data: bytes, chance: random.Random) -> bytes:
    """Something else: nothing, noise, or text."""
    return chance.choice(
        [b"", chance.randbytes(chance.randrange(1, 5000)), b"solid ascii\nendsolid ascii\n", b"\0" * 999]
    )


SOUND: List[Callable[[bytes, random.Random], bytes]] = [moved, moved, renamed]
BROKEN: List[Callable[[bytes, random.Random], bytes]] = [cut, scrambled, renumbered, no_step]


def write(originals: Sequence[pathlib.Path], folder: pathlib.Path, count: int, seed: int, broken: float) -> None:
    """Writes `count` variations to a folder, a share of them broken. Small originals are taken more often."""
    folder.mkdir(parents=True, exist_ok=True)
    chance = random.Random(seed)
    ordered = sorted(originals)
    weights = [1.0 / (100_000 + path.stat().st_size) for path in ordered]
    for number in range(count):
        original = chance.choices(ordered, weights)[0]
        kinds = BROKEN if chance.random() < broken else SOUND
        kind = chance.choice(kinds)
        name = f"{number:05}-{kind.__name__}-{original.stem}.step"
        (folder / name).write_bytes(kind(original.read_bytes(), chance))
