"""Rows are there once and whole, whenever a run is killed."""

import os
import pathlib
import subprocess
import sys

import pytest

import trimtess
from trimtess.batch import catalogue as catalogues
from trimtess.batch.catalogue import Catalogue, row
from trimtess.batch.errors import BatchError, DiskFull
from trimtess.batch.options import Options
from trimtess.batch.store import Store

OPTIONS = Options().canonical()


def rows(*names: str, status: str = "whole"):
    extra = {"attempts": 1, "host": "here", "run": "r", "memory_limit": 5}
    outcome = {"status": status, "diagnostics": {"a": 2}, "started": 1.5, "finished": 2.0, "seconds": {"read": 0.25}}
    return [row(f"/{name}", 10, "stamp", outcome, extra) for name in names]


def paths(out: pathlib.Path):
    return sorted(catalogues.read(out)[1]["path"].to_pylist())


def test_rows_are_appended_and_read_back(tmp_path):
    for names in (["a", "b"], ["c"]):
        with Catalogue.open(tmp_path, OPTIONS) as catalogue:
            catalogue.append(rows(*names))
            catalogue.append([])
    head, table = catalogues.read(tmp_path)
    assert head == {"layout": 1, "version": trimtess.__version__, "options": OPTIONS}
    first = table.to_pylist()[0]
    assert len(table) == 3 and first["seconds"] == 0.5 and first["seconds_read"] == 0.25
    assert first["diagnostics"] == [("a", 2)] and first["finished"].timestamp() == 2.0
    assert catalogues.read(tmp_path / "catalogue")[1].equals(table)


def test_readers_of_parquet_see_the_rows_alone(tmp_path):
    dataset = pytest.importorskip("pyarrow.dataset")
    with Catalogue.open(tmp_path, OPTIONS) as catalogue:
        catalogue.append(rows("a"))
        catalogue.append(rows("b"))
        assert dataset.dataset(tmp_path / "catalogue").to_table().num_rows == 2


def test_removed_rows_are_gone_and_others_stay(tmp_path):
    with Catalogue.open(tmp_path, OPTIONS) as catalogue:
        catalogue.append(rows("a", "b"))
        catalogue.append(rows("c"))
        catalogue.append(rows("d"))
        catalogue.remove({"/b", "/c"})
        assert paths(tmp_path) == ["/a", "/d"]
        catalogue.append(rows("b"))
    assert paths(tmp_path) == ["/a", "/b", "/d"]


def test_a_second_run_is_refused_while_the_first_holds_the_lock(tmp_path):
    with Catalogue.open(tmp_path, OPTIONS) as catalogue:
        catalogue.note({"pid": 12, "host": "there"})
        with pytest.raises(BatchError, match=r"in use by another run \(process 12 on there\)"):
            Catalogue.open(tmp_path, OPTIONS)
    with Catalogue.open(tmp_path, OPTIONS) as catalogue:
        assert catalogue.killed == {}


def test_a_killed_run_leaves_its_lock_free_and_its_note(tmp_path):
    script = f"""
import os, pathlib
from trimtess.batch.catalogue import Catalogue
with Catalogue.open(pathlib.Path({str(tmp_path)!r}), {OPTIONS!r}) as catalogue:
    catalogue.note({{"ray": "/tmp/x"}})
    pathlib.Path(catalogue.folder, ".rows-00000001.parquet.part").write_text("half")
    os.kill(os.getpid(), 9)
"""
    assert subprocess.run([sys.executable, "-c", script]).returncode == -9
    assert paths(tmp_path) == []
    with Catalogue.open(tmp_path, OPTIONS) as catalogue:
        assert catalogue.killed == {"ray": "/tmp/x"}
        assert not [name for name in os.listdir(catalogue.folder) if name.endswith(".part")]


def test_a_run_that_is_killed_while_it_writes_its_note_leaves_the_new_one(tmp_path):
    script = f"""
import os, pathlib
from trimtess.batch.catalogue import Catalogue
with Catalogue.open(pathlib.Path({str(tmp_path)!r}), {OPTIONS!r}) as catalogue:
    catalogue.note({{"ray": ["/tmp/x", "/tmp/y"]}})
    os.ftruncate = lambda *_: os.kill(os.getpid(), 9)
    catalogue.note({{"ray": []}})
"""
    assert subprocess.run([sys.executable, "-c", script]).returncode == -9
    with Catalogue.open(tmp_path, OPTIONS) as catalogue:
        assert catalogue.killed == {"ray": []}


@pytest.mark.parametrize(
    ("head", "message"),
    [
        ('{"layout": 7}', "catalogue of layout 7, this version writes layout 1"),
        ('{"layout": 1, "version": "9.9", "options": {}}', "catalogue of trimtess 9.9, this is "),
        ("{", "Expecting property name"),
    ],
)
def test_a_catalogue_of_another_version_is_refused(tmp_path, head, message):
    with Catalogue.open(tmp_path, OPTIONS):
        pass
    (tmp_path / "catalogue" / catalogues.HEAD).write_text(head)
    with pytest.raises(BatchError) as error:
        Catalogue.open(tmp_path, OPTIONS)
    assert message in str(error.value) and "\n" not in str(error.value)


def test_other_options_are_refused_and_named(tmp_path):
    with Catalogue.open(tmp_path, OPTIONS):
        pass
    with pytest.raises(BatchError, match=r"angle 20\.0 \(now 10\), formats \['glb'\] \(now \['ply'\]\)"):
        Catalogue.open(tmp_path, Options(angle=10, formats=("ply",)).canonical())


def test_a_full_disk_leaves_the_catalogue_as_it_was(tmp_path, monkeypatch):
    with Catalogue.open(tmp_path, OPTIONS) as catalogue:
        catalogue.append(rows("a"))
        monkeypatch.setattr(catalogues.os, "fsync", lambda _: (_ for _ in ()).throw(OSError(28, "No space left")))
        with pytest.raises(DiskFull, match="No space left; free some space and run the same command again"):
            catalogue.append(rows("b"))
        monkeypatch.undo()
        assert paths(tmp_path) == ["/a"] and len(os.listdir(catalogue.folder)) == 3
        catalogue.append(rows("b"))
    assert paths(tmp_path) == ["/a", "/b"]


def test_there_is_no_catalogue_in_other_folders(tmp_path):
    with pytest.raises(BatchError, match="no catalogue"):
        catalogues.read(tmp_path)
    (tmp_path / "file").write_text("")
    with pytest.raises(BatchError, match="no catalogue"):
        catalogues.read(tmp_path / "file")


def test_a_damaged_segment_is_named(tmp_path):
    with Catalogue.open(tmp_path, OPTIONS):
        (tmp_path / "catalogue" / "rows-00000001.parquet").write_bytes(b"PAR1 and no more")
        with pytest.raises(BatchError, match="rows-00000001.parquet: "):
            catalogues.read(tmp_path)


def test_a_result_appears_with_all_of_its_files_or_not_at_all(tmp_path):
    store = Store(tmp_path)
    store.start("run")
    key = "ab" * 32
    with pytest.raises(RuntimeError):
        with store.writing("run") as scratch:
            (scratch / "mesh.glb").write_bytes(b"half")
            raise RuntimeError
    assert store.find(key) is None and list(store.scratch("run").iterdir()) == []
    with store.writing("run") as scratch:
        (scratch / "mesh.glb").write_bytes(b"whole")
        store.publish(scratch, key, {"status": "whole"})
    assert store.find(key) == {"status": "whole"} and (store.folder(key) / "mesh.glb").read_bytes() == b"whole"


def test_the_first_of_two_equal_results_stays(tmp_path):
    store = Store(tmp_path)
    store.start("run")
    for number in (1, 2):
        with store.writing("run") as scratch:
            (scratch / "mesh.glb").write_bytes(b"%d" % number)
            assert store.publish(scratch, "cd" * 32, {"number": number}) == {"number": 1}
    assert (store.folder("cd" * 32) / "mesh.glb").read_bytes() == b"1"
    store.clear()
    assert sorted(os.listdir(tmp_path)) == ["objects"]
