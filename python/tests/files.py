"""Where the input files of the tests are."""

import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = ROOT / "tests" / "data"
SMALL = DATA / "red_cube_blue_cylinder.step"
LARGE = DATA / "nist_ctc05.step"
#: Public files that are not part of the repository.
SHARED = ROOT.parent / "shared"


def corpus() -> "list[pathlib.Path]":
    """The files of the corpus; says so if there are none."""
    folders = [SHARED / "corpus", SHARED / "corpus-closed"]
    files = [file for folder in folders for ending in ("st*p", "ST*P") for file in folder.glob(f"*.{ending}")]
    if not files:
        print(f"{SHARED} has no corpus: the tests on its files are left out", file=sys.stderr)
    return sorted(set(files))
