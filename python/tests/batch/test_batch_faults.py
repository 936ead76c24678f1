"""Runs that are killed, run out of disk or meet poison end with the rows and outputs of a run without faults."""

import json
import os
import pathlib
import random
import shutil
import sys
import time
from typing import Set

import pytest

from trimtess.batch.catalogue import read

from . import chaos, variations
from .running import batch

#: Number of files of the long test, which this variable turns on: 2000 take ten minutes on two cores.
MANY = int(os.environ.get("TRIMTESS_BATCH_MANY", "0"))


@pytest.fixture
def ray_folders() -> Set[str]:
    """Folders of Ray that are not those of the test."""
    return chaos.ray_folders()


@pytest.fixture(scope="module")
def archive(tmp_path_factory, data) -> pathlib.Path:
    """Variations of the small files, a tenth of them broken, and the same file under two names."""
    folder = tmp_path_factory.mktemp("archive")
    variations.write(list(data.glob("*.step")), folder, 120, seed=5, broken=0.1)
    shutil.copy(data / "nist_ctc05.step", folder / "twin1.step")
    shutil.copy(data / "nist_ctc05.step", folder / "twin2.step")
    return folder


@pytest.fixture(scope="module")
def reference(archive, tmp_path_factory) -> pathlib.Path:
    """The output of a run without faults."""
    out = tmp_path_factory.mktemp("reference") / "out"
    done = batch("convert", archive, "--out", out, "--cores", 2)
    assert done.returncode == 3, done.stderr
    return out


def test_variations_are_what_they_say(archive, reference):
    status = {pathlib.Path(row["path"]).name: row["status"] for row in chaos.rows(reference)}
    assert len(status) == 122
    sound = {status[name] for name in status if "moved" in name or "renamed" in name}
    assert sound <= {"whole", "partial"}
    assert {status[name] for name in status if "no_step" in name} == {"refused"}


def test_variations_depend_on_their_seed_alone(data, tmp_path):
    for name, seed in [("a", 1), ("b", 1), ("c", 2)]:
        variations.write([data / "red_cube_blue_cylinder.step"], tmp_path / name, 12, seed, broken=0.5)
    contents = [{path.name: path.read_bytes() for path in (tmp_path / name).iterdir()} for name in "abc"]
    assert contents[0] == contents[1] != contents[2]


def test_two_names_of_one_content_share_a_result(reference):
    twins = [row for row in chaos.rows(reference) if "twin" in row["path"]]
    assert len(twins) == 2 and twins[0]["outputs"] == twins[1]["outputs"]
    chaos.compare(reference, reference)


def test_killed_workers_and_drivers_lose_nothing(archive, reference, tmp_path, ray_folders):
    out = tmp_path / "out"
    chance = random.Random(11)
    killed = chaos.run_under_fire([archive, "--cores", 2], out, chance, driver_kills=2, pause=1.0, life=30)
    assert killed["driver"] == 2 and killed["Ray worker"] + killed["server or conversion"] > 0
    chaos.compare(reference, out)
    assert chaos.leftovers(out, ray_folders) == []


def test_a_run_that_is_killed_as_it_makes_its_folder_leaves_none(data, tmp_path, ray_folders):
    """The next run knows the folder, because its name was noted before it was made."""
    out = tmp_path / "out"
    arguments = ["convert", str(data / "red_cube_blue_cylinder.step"), "--out", str(out), "-q", "--cores", "1"]
    script = f"""
import os, sys
from trimtess.batch import cli, cluster
make = os.mkdir
def make_and_die(path, mode=0o777, **options):
    make(path, mode, **options)
    if cluster.FOLDER in str(path):
        os.kill(os.getpid(), 9)
os.mkdir = make_and_die
sys.exit(cli.main({arguments!r}))
"""
    assert chaos.subprocess.run([sys.executable, "-c", script]).returncode == -9
    assert chaos.ray_folders() - ray_folders != set()
    assert batch(*arguments).returncode == 0
    assert chaos.leftovers(out, ray_folders) == []


def test_what_a_killed_run_made_is_not_made_again(archive, reference, tmp_path, ray_folders):
    out = tmp_path / "out"
    running = chaos.subprocess.Popen(chaos.command("convert", archive, "--out", out, "-q", "--cores", 1))
    while chaos.count_results(out) < 10:
        assert running.poll() is None
        time.sleep(0.02)
    running.kill()
    running.wait()
    time.sleep(2.0)
    before, recorded = chaos.made(out), len(chaos.rows(out))
    assert len(before) > recorded, "results without rows are what is to be tested"
    assert batch("convert", archive, "--out", out).returncode == 3
    after = chaos.made(out)
    assert {name: after[name] for name in before} == before
    chaos.compare(reference, out)
    assert chaos.leftovers(out, ray_folders) == []


def test_a_full_disk_stops_the_run_and_costs_nothing(archive, reference, tmp_path, ray_folders):
    if not chaos.can_mount():
        pytest.skip("no name space with a file system of its own: unshare is missing or not allowed")
    out = tmp_path / "out"
    done = chaos.run_on_small_disk([archive, "--cores", 2], out, "2m")
    assert done.returncode == 1, done.stderr
    assert done.stderr.count("\n") == 1 and "No space left on device; free some space and run the same" in done.stderr
    before = chaos.made(out)
    assert chaos.leftovers(out, ray_folders) == [] and 0 < len(before) < len(chaos.made(reference))
    assert batch("convert", archive, "--out", out).returncode == 3
    assert {name: chaos.made(out)[name] for name in before} == before
    chaos.compare(reference, out)


def test_attacks_cost_their_own_rows(shared, tmp_path, ray_folders):
    out = tmp_path / "out"
    done = batch("convert", shared / "attack", "--out", out, "--time-limit", 60, "--max-memory", 2048)
    assert done.returncode == 3, done.stderr
    assert (
        len(read(out)[1]) == len(list((shared / "attack").glob("*.step"))) and chaos.leftovers(out, ray_folders) == []
    )


@pytest.mark.skipif(not MANY, reason="TRIMTESS_BATCH_MANY is not set to a number of files")
def test_an_archive_survives_kills_and_a_full_disk(shared, tmp_path, ray_folders):
    """The corpus, its variations, a tenth broken, and all attacks."""
    folder = tmp_path / "in"
    originals = [path for name in ("corpus", "corpus-closed") for path in sorted((shared / name).glob("*.st*p"))]
    attacks = sorted((shared / "attack").glob("*.step"))
    variations.write(originals, folder, MANY - len(originals) - len(attacks), seed=14, broken=0.1)
    inputs = [folder, shared / "corpus", shared / "corpus-closed", shared / "attack"]
    options = [*inputs, "--cores", 2, "--time-limit", 60]
    times, start = {}, time.monotonic()
    assert batch("convert", *options, "--out", tmp_path / "reference").returncode == 3
    times["without faults"] = time.monotonic() - start
    out = tmp_path / "out"
    if chaos.can_mount():
        done = chaos.run_on_small_disk(options, out, "100m")
        assert done.returncode == 1 and "No space left on device" in done.stderr
    recorded, start = len(chaos.rows(out)) if out.exists() else 0, time.monotonic()
    killed = chaos.run_under_fire(options, out, random.Random(14), driver_kills=4, pause=1.0, life=300)
    times["under fire"] = time.monotonic() - start
    assert killed["driver"] == 4
    chaos.compare(tmp_path / "reference", out)
    assert len(chaos.rows(out)) == MANY and chaos.leftovers(out, ray_folders) == []
    told = {"files": MANY, "rows before the disk was full": recorded, "killed": dict(killed), "seconds": times}
    print(json.dumps(told))
