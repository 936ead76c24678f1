"""Type stubs: complete, equal to what is there, and enough to check a program."""

import importlib.util
import pathlib
import subprocess
import sys

import pytest

if importlib.util.find_spec("mypy") is None:
    pytest.skip("mypy is not installed", allow_module_level=True)


#: Says which libraries of the batch have no types.
CONFIG = pathlib.Path(__file__).resolve().parents[1] / "pyproject.toml"


def run(*command):
    return subprocess.run([sys.executable, "-m", *command], capture_output=True, text=True, check=False)


def test_stubs_equal_the_compiled_module():
    told = run("mypy.stubtest", "trimtess._trimtess")
    assert told.returncode == 0, told.stdout + told.stderr


def test_the_package_passes_mypy():
    told = run("mypy", "--strict", "-m", "trimtess", "-m", "trimtess.errors")
    assert told.returncode == 0, told.stdout + told.stderr


def test_the_batch_passes_mypy():
    pytest.importorskip("ray", reason="the extra `batch` is not installed")
    told = run("mypy", "--strict", "--config-file", str(CONFIG), "-p", "trimtess.batch")
    assert told.returncode == 0, told.stdout + told.stderr


def test_wrong_programs_do_not_pass(tmp_path: pathlib.Path):
    right = tmp_path / "right.py"
    right.write_text(
        "import numpy as np\nimport numpy.typing as npt\nimport trimtess\n"
        "def area(path: str) -> float:\n"
        "    mesh = trimtess.read(path).prepare().tessellate(chord_rel=1e-3, angle=20, workers=2)\n"
        "    points: npt.NDArray[np.float64] = mesh.positions\n"
        "    return mesh.check().area + float(points.sum())\n"
    )
    told = run("mypy", "--strict", str(right))
    assert told.returncode == 0, told.stdout + told.stderr
    wrong = tmp_path / "wrong.py"
    wrong.write_text("import trimtess\ntrimtess.read(3).prepare().tessellate(chordal=1).positions.x\n")
    told = run("mypy", "--strict", str(wrong))
    assert told.returncode == 1 and "chordal" in told.stdout and "incompatible type" in told.stdout
