"""A process that forks one process per file: no file can take down another, and none waits for imports.

`python -m trimtess.batch.server` loads `trimtess` once, prints `READY`, then reads jobs from standard input and answers
each on standard output, one JSON object per line. It ends at the end of its input, and its child with it.

`multiprocessing` has a fork server too, but imports the main module of its user into every child (here Ray's), does
not tell peak memory of a child that was killed, and leaves children behind when it is killed itself.
"""

from __future__ import annotations

import gc
import json
import os
import resource
import select
import signal
import sys
import threading
import time
import traceback
from typing import Optional

from .convert import Convert, convert
from .options import Json

#: The line before all answers: what follows is spent on jobs.
READY = b"ready\n"

#: Bytes of a child's standard error that a message is taken from.
TAIL = 4096

#: Memory for threads in addition to that for data: stacks count in full, whether they are used or not.
MEMORY_FOR_THREADS, MEMORY_PER_WORKER = 64 << 20, 32 << 20

#: What is printed when memory runs out: by Rust before it aborts, by Python, the system and C++.
NO_MEMORY = ("memory allocation of", "MemoryError", "Cannot allocate memory", "std::bad_alloc")


class Jobs:
    """Lines of standard input, readable next to other descriptors."""

    def __init__(self, descriptor: int) -> None:
        self.descriptor = descriptor
        self._bytes = b""

    def next(self) -> Optional[Json]:
        """The next job; `None` at the end of the input."""
        while b"\n" not in self._bytes:
            if not self.fill():
                return None
        line, self._bytes = self._bytes.split(b"\n", 1)
        job: Json = json.loads(line)
        return job

    def fill(self) -> bool:
        """Reads what is there. False at the end of the input."""
        block = os.read(self.descriptor, 1 << 16)
        self._bytes += block
        return bool(block)


class Child:
    """A forked process with limits, at work on one job."""

    def __init__(self, job: Json, work: Convert) -> None:
        self.job = job
        self.started = time.monotonic()
        self.timed_out = False
        self.answer = b""
        self.log = os.memfd_create("log")
        self.results, results = os.pipe()
        life, self.life = os.pipe()
        self.pid = os.fork()
        if self.pid == 0:
            os.close(self.results)
            os.close(self.life)
            become_child(job, work, results, life, self.log)
        os.close(results)
        os.close(life)
        os.set_blocking(self.results, False)
        self.exit = os.pidfd_open(self.pid)

    def wait(self, jobs: Jobs) -> bool:
        """Waits until the process ends, and kills it after its time. False if the server's input ended first."""
        deadline = self.started + self.job["seconds"]
        while True:
            remaining = None if self.timed_out else max(0.0, deadline - time.monotonic())
            ready, _, _ = select.select([self.exit, self.results, jobs.descriptor], [], [], remaining)
            if jobs.descriptor in ready and not jobs.fill():
                self.kill()
                return False
            if self.results in ready and not self.drain() and self.exit not in ready:
                # The answer is complete; only the exit is left to wait for.
                ready, _, _ = select.select([self.exit], [], [], max(0.0, deadline - time.monotonic()))
            if self.exit in ready:
                return True
            if not self.timed_out and time.monotonic() >= deadline:
                self.timed_out = True
                self.kill()

    def drain(self) -> bool:
        """Reads what the process answered so far. False at the end of the answer."""
        try:
            while block := os.read(self.results, 1 << 16):
                self.answer += block
            return False
        except BlockingIOError:
            return True

    def kill(self) -> None:
        signal.pidfd_send_signal(self.exit, signal.SIGKILL)

    def outcome(self) -> Json:
        """What became of the job. The process has ended."""
        self.drain()
        _, status, usage = os.wait4(self.pid, 0)
        tail = os.pread(self.log, TAIL, max(0, os.fstat(self.log).st_size - TAIL)).decode(errors="replace")
        for descriptor in (self.results, self.life, self.exit, self.log):
            os.close(descriptor)
        costs = {"wall": time.monotonic() - self.started}
        try:
            return {**json.loads(self.answer), **costs}
        except ValueError:
            costs["peak_memory"] = usage.ru_maxrss * 1024
        if self.timed_out:
            return {"status": "timeout", "message": f"took longer than {self.job['seconds']:g} s", **costs}
        return {**death(os.waitstatus_to_exitcode(status), tail), **costs}


def death(code: int, tail: str) -> Json:
    """Status and message of a process that ended without an answer."""
    lines = [line.strip() for line in tail.splitlines() if line.strip()]
    memory = next((line for line in lines if any(words in line for words in NO_MEMORY)), None)
    if memory is not None:
        return {"status": "limit", "message": memory}
    how = f"killed by {signal.Signals(-code).name}" if code < 0 else f"ended with status {code}"
    return {"status": "crashed", "message": f"{how}: {lines[-1]}" if lines else how}


def become_child(job: Json, work: Convert, results: int, life: int, log: int) -> None:
    """Runs a job in the forked process. Never returns."""
    code = 1
    try:
        threading.Thread(target=die_with_server, args=(life,), daemon=True).start()
        os.dup2(log, 1)
        os.dup2(log, 2)
        limit(job["max_memory"] + MEMORY_FOR_THREADS + MEMORY_PER_WORKER * job["workers"])
        os.environ["RAYON_NUM_THREADS"] = str(job["workers"])
        answer = json.dumps(work(job)).encode()
        while answer:
            answer = answer[os.write(results, answer) :]
        code = 0
    except BaseException:  # A panic of the library is a BaseException.
        traceback.print_exc()
        sys.stderr.flush()
    finally:
        os._exit(code)


def die_with_server(life: int) -> None:
    """Ends this process when the server ends, which holds the other end of the pipe."""
    os.read(life, 1)
    os._exit(1)


def limit(memory: int) -> None:
    """Limits the memory that this process can write to what it has now and `memory` bytes more. No core dumps."""
    with open("/proc/self/status") as status:
        data = next(int(line.split()[1]) * 1024 for line in status if line.startswith("VmData:"))
    resource.setrlimit(resource.RLIMIT_DATA, (data + memory, data + memory))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def serve(jobs: Jobs, answers: int, work: Convert) -> None:
    """Answers jobs until their end."""
    while (job := jobs.next()) is not None:
        child = Child(job, work)
        if not child.wait(jobs):
            return
        os.write(answers, json.dumps(child.outcome()).encode() + b"\n")


def main() -> None:
    # Ctrl-C is for the driver, which ends this process by closing its input.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threads = len(os.listdir("/proc/self/task"))
    if threads != 1:
        # A fork copies one thread alone; locks that others hold would stay locked.
        raise SystemExit(f"the server has {threads} threads after its imports and cannot fork")
    answers = os.dup(1)
    os.dup2(2, 1)
    # Pages of loaded modules stay shared with the children.
    gc.freeze()
    os.write(answers, READY)
    serve(Jobs(0), answers, convert)


if __name__ == "__main__":
    main()
