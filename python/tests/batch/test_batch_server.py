"""Whatever a file's process does, it costs that file alone."""

import json
import os
import pathlib
import subprocess
import sys
import time

import pytest

ODD = pathlib.Path(__file__).with_name("odd_server.py")
MIB = 1 << 20


@pytest.fixture
def server():
    process = subprocess.Popen([sys.executable, str(ODD)], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    yield process
    process.kill()
    process.wait()


def ask(server, path: str, seconds: float = 20.0, memory: int = 256 * MIB) -> dict:
    job = {"path": path, "seconds": seconds, "max_memory": memory, "workers": 1}
    server.stdin.write(json.dumps(job).encode() + b"\n")
    server.stdin.flush()
    return json.loads(server.stdout.readline())


def test_each_job_has_a_process_of_its_own(server):
    pids = {ask(server, "nothing")["pid"] for _ in range(3)}
    assert len(pids) == 3 and server.pid not in pids


def test_a_job_is_killed_after_its_time(server):
    start = time.monotonic()
    outcome = ask(server, "sleep 30", seconds=0.3)
    assert outcome["status"] == "timeout" and outcome["message"] == "took longer than 0.3 s"
    assert 0.3 <= outcome["wall"] < 5.0 and time.monotonic() - start < 5.0
    assert ask(server, "nothing")["status"] == "whole"


def test_the_system_enforces_the_memory_limit(server):
    assert ask(server, f"allocate {100 * MIB}", memory=200 * MIB)["status"] == "whole"
    outcome = ask(server, f"allocate {400 * MIB}", memory=200 * MIB)
    assert outcome["status"] == "limit" and outcome["message"] == "MemoryError"
    assert outcome["peak_memory"] < 200 * MIB


def test_an_allocator_that_aborts_is_a_limit(server):
    outcome = ask(server, "abort")
    assert outcome["status"] == "limit" and outcome["message"] == "memory allocation of 64 bytes failed"


@pytest.mark.parametrize("name", ["SIGKILL", "SIGSEGV", "SIGABRT"])
def test_a_signal_costs_one_job_and_is_named(server, name):
    outcome = ask(server, f"die {name}")
    assert outcome["status"] == "crashed" and outcome["message"] == f"killed by {name}: a last word"
    assert ask(server, "nothing")["status"] == "whole"


def test_an_exception_is_told_by_its_last_line(server):
    outcome = ask(server, "raise")
    assert outcome["status"] == "crashed"
    assert outcome["message"] == "ended with status 1: RuntimeError: a fault of the program"


def test_answers_longer_than_a_pipe_arrive_whole(server):
    assert len(ask(server, "long 3000000")["message"]) == 3_000_000


def test_what_a_job_prints_is_no_answer(server):
    assert ask(server, "print")["status"] == "whole"


def test_a_child_uses_the_threads_it_was_given(server):
    assert json.loads(ask(server, "environment")["message"])["RAYON_NUM_THREADS"] == "1"


@pytest.mark.parametrize("how", ["kill", "end of input"])
def test_the_child_ends_with_the_server(server, how):
    job = {"path": "sleep 60", "seconds": 90.0, "max_memory": 256 * MIB, "workers": 1}
    server.stdin.write(json.dumps(job).encode() + b"\n")
    server.stdin.flush()
    children = pathlib.Path(f"/proc/{server.pid}/task/{server.pid}/children")
    until = time.monotonic() + 10
    while not (child := children.read_text().split()) and time.monotonic() < until:
        time.sleep(0.01)
    if how == "kill":
        server.kill()
    else:
        server.stdin.close()
    until = time.monotonic() + 10
    while is_running(int(child[0])) and time.monotonic() < until:
        time.sleep(0.01)
    assert not is_running(int(child[0]))


def is_running(pid: int) -> bool:
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_descriptors_do_not_pile_up(server):
    folder = f"/proc/{server.pid}/fd"
    ask(server, "nothing")
    before = len(os.listdir(folder))
    for path in ["nothing", "die SIGKILL", "abort"] * 5:
        ask(server, path)
    assert len(os.listdir(folder)) == before
