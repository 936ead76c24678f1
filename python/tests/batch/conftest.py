"""Fixtures of the tests of the batch."""

from __future__ import annotations

import importlib.util
import pathlib
import sys
import urllib.request

import pytest

NEEDED = ("ray", "pyarrow", "fsspec", "rich", "matplotlib", "psutil")
MISSING = [name for name in NEEDED if importlib.util.find_spec(name) is None]
if MISSING:
    print(
        f"tests of the batch are left out: no {', '.join(MISSING)} (pip install 'trimtess[batch,test]')",
        file=sys.stderr,
    )
    collect_ignore_glob = ["test_*.py"]

pytest.register_assert_rewrite("batch.chaos")

ROOT = pathlib.Path(__file__).resolve().parents[3]


@pytest.fixture(scope="session")
def data() -> pathlib.Path:
    """Small STEP files that are part of the repository."""
    return ROOT / "tests" / "data"


@pytest.fixture(scope="session")
def shared() -> pathlib.Path:
    """The folder of test files next to the repository, which not every checkout has."""
    for folder in (ROOT.parent / "shared", ROOT / "shared"):
        if (folder / "corpus").is_dir():
            return folder
    pytest.skip("../shared is not there")


@pytest.fixture
def bucket(monkeypatch):
    """The file system of an object store on this machine, with a bucket `parts`. Processes started later see it."""
    pytest.importorskip("s3fs", reason="s3fs is not installed")
    server = pytest.importorskip("moto.server", reason="moto is not installed")
    import s3fs

    running = server.ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    running.start()
    host, port = running.get_host_and_port()
    # What earlier tests stored stays in this process.
    urllib.request.urlopen(urllib.request.Request(f"http://{host}:{port}/moto-api/reset", method="POST")).close()
    monkeypatch.setenv("AWS_ACCESS_KEY_ID", "testing")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "testing")
    monkeypatch.setenv("AWS_DEFAULT_REGION", "us-east-1")
    monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://{host}:{port}")
    s3fs.S3FileSystem.clear_instance_cache()
    system = s3fs.S3FileSystem()
    system.mkdir("parts")
    yield system
    running.stop()
    s3fs.S3FileSystem.clear_instance_cache()
