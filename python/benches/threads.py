"""Two Python threads compared with one: wall time and processor time of the same work, best of several rounds.

usage: python threads.py FILE.step [--chord-rel 1e-6] [--angle 1] [--jobs 8] [--rounds 5]

Each job tessellates with one worker. The ratio of wall times is the speed-up. Where other processes take cores, the
processor time that the threads get tells more: two threads that never wait for the interpreter use two seconds of it
per second that the machine grants, and the work takes as much processor time as in one thread.
"""

import argparse
import threading
import time

import trimtess


def measure(prepared: trimtess.Prepared, arguments: dict, jobs: int, threads: int) -> "tuple[float, float]":
    """Seconds of wall time and of processor time for all jobs."""

    def work() -> None:
        for _ in range(jobs // threads):
            prepared.tessellate(workers=1, **arguments)

    crew = [threading.Thread(target=work) for _ in range(threads)]
    wall, processor = time.perf_counter(), time.process_time()
    for thread in crew:
        thread.start()
    for thread in crew:
        thread.join()
    return time.perf_counter() - wall, time.process_time() - processor


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file")
    parser.add_argument("--chord-rel", type=float, default=1e-6)
    parser.add_argument("--angle", type=float, default=1)
    parser.add_argument("--jobs", type=int, default=8)
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    prepared = trimtess.read(options.file).prepare()
    arguments = {"chord_rel": options.chord_rel, "angle": options.angle}
    print(prepared.tessellate(**arguments))
    best = {1: (float("inf"), 0.0), 2: (float("inf"), 0.0)}
    for _ in range(options.rounds):
        for threads in best:
            best[threads] = min(best[threads], measure(prepared, arguments, options.jobs, threads))
    for threads, (wall, processor) in best.items():
        print(f"{threads} threads: {wall:.3f} s, {processor:.3f} s of processors, {processor / wall:.2f} in use")
    print(f"speed-up {best[1][0] / best[2][0]:.2f}")


if __name__ == "__main__":
    main()
