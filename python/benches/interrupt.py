"""How long read, prepare and tessellate go on after Ctrl-C, and what memory that leaves.

    python python/benches/interrupt.py FILE [COUNT]

The moments are spread evenly over the time that the call takes. Signals are heard every 10 ms.
"""

import os
import signal
import sys
import threading
import time
from pathlib import Path

import trimtess


def resident():
    """Resident memory, MiB."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def interrupted(work, after):
    """Milliseconds from a signal `after` seconds to the end of the call; None if the call had ended by itself."""
    asked = []

    def ask():
        time.sleep(after)
        asked.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    asks = threading.Thread(target=ask)
    try:
        asks.start()
        work()
        ended, end = True, 0.0
    except KeyboardInterrupt:
        ended, end = False, time.monotonic()
    try:
        asks.join()
        time.sleep(0.001)
    except KeyboardInterrupt:
        asks.join()
    return None if ended else 1e3 * (end - asked[0])


def main():
    path = sys.argv[1]
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 100
    signal.signal(signal.SIGINT, signal.default_int_handler)
    model = trimtess.read(path)
    prepared = model.prepare()
    calls = {
        "read": lambda: trimtess.read(path),
        "prepare": model.prepare,
        "tessellate": lambda: prepared.tessellate(chord_rel=1e-4, angle=5),
    }
    for name, work in calls.items():
        start = time.monotonic()
        work()
        whole = time.monotonic() - start
        before = resident()
        told = [interrupted(work, whole * k / count) for k in range(count)]
        went_on = sorted((after, k / count) for k, after in enumerate(told) if after is not None)
        median, worst = (went_on[len(went_on) // 2][0], went_on[-1][0]) if went_on else (0, 0)
        print(
            f"{name}: {1e3 * whole:.0f} ms if not interrupted; goes on for {median:.1f} ms (median), {worst:.1f} (worst of "
            f"{len(went_on)}, {count - len(went_on)} had ended); memory {before:.0f} -> {resident():.0f} MiB"
        )
        print("    the worst at", ", ".join(f"{moment:.2f} ({after:.0f} ms)" for after, moment in went_on[:-9:-1]), "of its time")


main()
