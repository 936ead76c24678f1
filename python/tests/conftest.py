"""What the tests share: prepared models, the program."""

import os
import pathlib
import signal
import subprocess

import pytest
from files import LARGE, ROOT, SMALL

import trimtess


@pytest.fixture(scope="session")
def prepared() -> trimtess.Prepared:
    """A model of two parts: a cube and a cylinder."""
    return trimtess.read(SMALL).prepare()


@pytest.fixture(scope="session")
def large() -> trimtess.Prepared:
    """A model of one part with some hundred faces."""
    return trimtess.read(LARGE).prepare()


@pytest.fixture
def interruptible():
    """SIGINT raises KeyboardInterrupt, which it does not in what a shell runs in the background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


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
