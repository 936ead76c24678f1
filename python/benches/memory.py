"""Peak memory of a large mesh, before and after numpy reads all of it.

usage: python memory.py FILE.step [--chord-rel 1e-8] [--angle 0.3] [--workers 0]
"""

import argparse
import resource

import numpy as np

import trimtess

COLUMNS = ["positions", "normals", "uv", "triangles", "face_ids"]


def peak() -> float:
    """Peak resident memory of this process, MiB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def now() -> float:
    """Resident memory of this process, MiB."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize() / 2**20


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file")
    parser.add_argument("--chord-rel", type=float, default=1e-8)
    parser.add_argument("--angle", type=float, default=0.3)
    parser.add_argument("--workers", type=int, default=0)
    options = parser.parse_args()
    prepared = trimtess.read(options.file).prepare()
    print(f"prepared: {now():.0f} MiB, peak {peak():.0f} MiB")
    mesh = prepared.tessellate(chord_rel=options.chord_rel, angle=options.angle, workers=options.workers)
    parts = [getattr(part, name) for part in mesh.parts for name in COLUMNS]
    size = sum(array.nbytes for array in parts) / 2**20
    print(f"{mesh}: {size:.0f} MiB in arrays; {now():.0f} MiB resident, peak {peak():.0f} MiB")
    sums = [float(array.sum(dtype=np.float64)) for array in parts]
    arrays = [getattr(mesh, name) for name in COLUMNS] if len(mesh.instances) == 1 else []
    sums += [float(array[-1].sum()) for array in arrays]
    print(f"read by numpy: {now():.0f} MiB resident, peak {peak():.0f} MiB (checksum {sum(sums):.6e})")


if __name__ == "__main__":
    main()
