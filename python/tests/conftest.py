"""What the tests share: input files, a prepared model, the program."""

import os
import pathlib
import subprocess
import sys

import pytest

import trimtess

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


@pytest.fixture(scope="session")
def prepared() -> trimtess.Prepared:
    """A model of two parts: a cube and a cylinder."""
    return trimtess.read(SMALL).prepare()


@pytest.fixture(scope="session")
def large() -> trimtess.Prepared:
    """A model of one part with some hundred faces."""
    return trimtess.read(LARGE).prepare()


@pytest.fixture(scope="session")
def program() -> pathlib.Path:
    """The program `trimtess`, built if $TRIMTESS_PROGRAM does not name it."""
    named = os.environ.get("TRIMTESS_PROGRAM")
    if named:
        return pathlib.Path(named)
    build = ["cargo", "build", "--release", "--locked", "--package", "trimtess-cli", "--no-default-features"]
    subprocess.run(build, cwd=ROOT, check=True)
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    return target / "release" / "trimtess"
