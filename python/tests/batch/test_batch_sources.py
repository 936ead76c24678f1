"""What arguments name, on this machine and in an object store."""

import os
import pathlib

import pytest

from trimtess.batch import sources
from trimtess.batch.errors import BatchError


@pytest.fixture
def tree(tmp_path: pathlib.Path) -> pathlib.Path:
    for name in ["a.step", "b.STP", "deep/er/c.p21", "deep/d.stp", "notes.txt", "e.igs"]:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(name)
    return tmp_path


def names(found, folder: pathlib.Path):
    return [source.path.replace(str(folder) + "/", "") for source in found]


def test_a_folder_is_searched_for_step_files(tree):
    assert names(sources.find([str(tree)]), tree) == ["a.step", "b.STP", "deep/d.stp", "deep/er/c.p21"]


def test_a_named_file_is_taken_whatever_its_ending(tree):
    found = sources.find([str(tree / "notes.txt")])
    assert names(found, tree) == ["notes.txt"] and found[0].size == 9


def test_globs_match_files(tree):
    assert names(sources.find([f"{tree}/**/*.stp"]), tree) == ["deep/d.stp"]
    assert names(sources.find([f"{tree}/?.step"]), tree) == ["a.step"]


def test_a_file_whose_name_looks_like_a_glob_is_that_file(tree):
    (tree / "part[1].step").write_text("x")
    assert names(sources.find([str(tree / "part[1].step")]), tree) == ["part[1].step"]


def test_links_are_followed_and_keep_their_names(tree):
    target = tree / "notes.txt"
    (tree / "link.step").symlink_to(target)
    (tree / "gone.step").symlink_to(tree / "nowhere")
    (tree / "folder.step").mkdir()
    for argument in [f"{tree}/link*.step", str(tree / "link.step")]:
        [found] = sources.find([argument])
        assert found == sources.find([str(tree / "link.step")])[0] and found.size == 9
    assert names(sources.find([str(tree)]), tree) == ["a.step", "b.STP", "deep/d.stp", "deep/er/c.p21", "link.step"]
    before = found.stamp
    os.utime(target, (1.0, 1.0))
    assert {source.stamp for source in sources.find([str(tree)]) if "link" in source.path} != {before}


def test_paths_of_a_manifest_are_texts(tree):
    (tree / "0012").write_text("x")
    (tree / "list.csv").write_text("path\n0012\n")
    assert names(sources.find([str(tree / "list.csv")]), tree) == ["0012"]


def test_relative_paths_become_absolute(tree, monkeypatch):
    monkeypatch.chdir(tree)
    assert [source.path for source in sources.find(["a.step", "file://" + str(tree / "a.step")])] == [
        str(tree / "a.step")
    ]


def test_a_file_named_twice_is_one_source(tree):
    assert len(sources.find([str(tree), str(tree / "a.step"), f"{tree}/*.step"])) == 4


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_a_manifest_lists_files_relative_to_itself(tree, ending):
    import pyarrow
    import pyarrow.csv
    import pyarrow.parquet

    table = pyarrow.table({"note": ["x", "y", "z"], "path": ["a.step", str(tree / "deep/d.stp"), "gone.step"]})
    write = pyarrow.csv.write_csv if ending == "csv" else pyarrow.parquet.write_table
    write(table, str(tree / f"list.{ending}"))
    found = sources.find([str(tree / f"list.{ending}")])
    assert names(found, tree) == ["a.step", "deep/d.stp", "gone.step"]
    assert [source.size for source in found] == [6, 10, None]


def test_a_stamp_changes_with_the_file(tree):
    before = sources.find([str(tree / "a.step")])
    (tree / "a.step").write_text("other!")
    assert sources.find([str(tree / "a.step")]) != before


@pytest.mark.parametrize(
    ("argument", "message"),
    [
        ("{tree}/gone.step", "{tree}/gone.step: no such file or folder"),
        ("{tree}/*.iges", "{tree}/*.iges: matches no file"),
        ("{tree}/empty", "{tree}/empty: has no file that ends in .stp, .step, .p21"),
        ("{tree}/empty.csv", "{tree}/empty.csv: lists no file"),
        ("{tree}/other.csv", "{tree}/other.csv: has no column named path, url, uri or file"),
        ("{tree}/bad.parquet", "{tree}/bad.parquet: "),
        ("nonsense://bucket/key", "nonsense://bucket/key: Protocol not known: nonsense"),
    ],
)
def test_an_argument_that_names_nothing_is_one_clear_line(tree, argument, message):
    (tree / "empty").mkdir()
    (tree / "empty.csv").write_text("path\n")
    (tree / "other.csv").write_text("name\na.step\n")
    (tree / "bad.parquet").write_text("no parquet")
    with pytest.raises(BatchError) as error:
        sources.find([argument.format(tree=tree)])
    assert str(error.value).startswith(message.format(tree=tree)) and "\n" not in str(error.value)


def test_an_object_store_is_listed_like_a_folder(bucket):
    bucket.pipe({"parts/a.step": b"12345", "parts/deep/b.stp": b"1", "parts/list.txt": b""})
    found = sources.find(["s3://parts"])
    assert [(source.path, source.size) for source in found] == [("s3://parts/a.step", 5), ("s3://parts/deep/b.stp", 1)]
    assert sources.find(["s3://parts/*.step"]) == found[:1]
    bucket.pipe({"parts/list.csv": b"path\ndeep/b.stp\n"})
    assert sources.find(["s3://parts/list.csv"]) == found[1:]
    bucket.pipe("parts/a.step", b"54321")
    bucket.invalidate_cache()
    assert sources.find(["s3://parts/a.step"])[0].stamp != found[0].stamp


def test_a_worker_fetches_objects_and_removes_them(bucket, tmp_path):
    from trimtess.batch import task

    bucket.pipe({"parts/a.step": b"first", "parts/b.step": b"second"})
    (tmp_path / ".tmp" / "run").mkdir(parents=True)
    bundle = {
        "patience": 9.0,
        "paths": ["s3://parts/a.step", "s3://parts/gone.step", "s3://parts/b.step"],
        "job": {"out": str(tmp_path), "run": "run"},
    }
    seen = []
    for path, local, outcome, seconds in task.fetched(bundle):
        seen.append((path, outcome and outcome["status"], None if outcome else pathlib.Path(local).read_text()))
        assert seconds > 0.0
    assert seen == [
        ("s3://parts/a.step", None, "first"),
        ("s3://parts/gone.step", "unreadable", None),
        ("s3://parts/b.step", None, "second"),
    ]
    assert list((tmp_path / ".tmp" / "run").iterdir()) == []
