"""A STEP file's text -> the same part moved, or scaled."""

import re

NUMBER = r"[^(),]+"
POINT = re.compile(
    rf"(CARTESIAN_POINT\s*\(\s*'(?:[^']|'')*'\s*,\s*\()({NUMBER}),({NUMBER}),({NUMBER})(\)\s*\))"
)
LIST = re.compile(r"(COORDINATES_LIST\s*\(\s*'(?:[^']|'')*'\s*,\s*\d+\s*,\s*\()([^';]*)(\)\s*\)\s*;)")
ROW = re.compile(rf"\(({NUMBER}),({NUMBER}),({NUMBER})\)")
UNIT = re.compile(r"(SI_UNIT\s*\(\s*)(\$|\.\w+\.)(\s*,\s*\.METRE\.\s*\))")
PREFIXES = {
    -1: {".MICRO.": ".NANO.", ".MILLI.": ".MICRO.", "$": ".MILLI.", ".CENTI.": ".MICRO."},
    1: {".MICRO.": ".MILLI.", ".MILLI.": "$", "$": ".KILO.", ".CENTI.": ".DECA."},
}


def moved(text: str, by: float) -> str:
    """All points in space, moved along each axis by `by` of the file's units.

    The origins of placements are points, too: occurrences of parts move with the parts that they place.
    """

    def number(found: str) -> str:
        return repr(float(found) + by)

    def point(match: re.Match) -> str:
        head, x, y, z, tail = match.groups()
        return f"{head}{number(x)},{number(y)},{number(z)}{tail}"

    def row(match: re.Match) -> str:
        return "(" + ",".join(number(part) for part in match.groups()) + ")"

    text = POINT.sub(point, text)
    return LIST.sub(lambda match: match[1] + ROW.sub(row, match[2]) + match[3], text)


def scaled(text: str, steps: int) -> str:
    """The file in another unit, 1000 to the power of `steps` times as large. Centimetres shrink to micrometres."""

    def unit(match: re.Match) -> str:
        return match[1] + PREFIXES[steps].get(match[2].upper(), match[2]) + match[3]

    return UNIT.sub(unit, text)
