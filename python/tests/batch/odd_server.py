"""A server whose conversions misbehave as the path of the job says."""

import ctypes
import json
import os
import signal
import sys
import time

from trimtess.batch import server


def work(job: dict) -> dict:
    kind, _, amount = job["path"].partition(" ")
    if kind == "sleep":
        time.sleep(float(amount))
    elif kind == "allocate":
        held = bytearray(int(amount))
        held[::4096] = b"x" * len(held[::4096])
    elif kind == "abort":
        # As an allocator of a compiled language does.
        ctypes.CDLL(None).write(2, b"memory allocation of 64 bytes failed\n", 37)
        os.abort()
    elif kind == "die":
        print("a last word", file=sys.stderr, flush=True)
        os.kill(os.getpid(), signal.Signals[amount])
    elif kind == "raise":
        raise RuntimeError("a fault of the program")
    elif kind == "long":
        return {"status": "whole", "message": "x" * int(amount)}
    elif kind == "print":
        print("this is no answer")
    elif kind == "environment":
        return {"status": "whole", "message": json.dumps(dict(os.environ))}
    return {"status": "whole", "pid": os.getpid()}


if __name__ == "__main__":
    answers = os.dup(1)
    server.serve(server.Jobs(0), answers, work)
