"""Meshes written by trimtess, read back by trimesh and the glTF validator, and compared with the reports.

For each file as it is, moved by 1 to 1e7 mm, and scaled by 1e-3 and 1e3, in each format:
* the report's number of triangles is that which trimesh (and the validator, of a GLB) reads,
* edges of what was read cancel, position by position, where those of the mesh do,
* positions in STL and OBJ are those in PLY, and boxes of GLB those of PLY, within the rounding that is reported.
"""

import argparse
import collections
import json
import multiprocessing
import os
import pathlib
import subprocess
import sys
import tempfile
import warnings

import numpy
import trimesh

import variants

FORMATS = ["ply", "obj", "stl", "glb"]
MOVES = [1.0, 1e3, 1e5, 1e7]
SCALES = [-1, 1]


class Fault(Exception):
    """Something that must not be."""


def run(program: str, *args: str) -> tuple[int, dict | None, str]:
    done = subprocess.run([program, *args, "--json"], capture_output=True, text=True, timeout=600)
    return done.returncode, json.loads(done.stdout) if done.stdout else None, done.stderr


def read(path: pathlib.Path) -> list[tuple[numpy.ndarray, numpy.ndarray]]:
    """Corners of triangles (n, 3, 3) as stored, and the matrix that places them."""
    with warnings.catch_warnings():
        # Files without colours.
        warnings.simplefilter("ignore")
        loaded = trimesh.load(str(path), process=False, maintain_order=True)
    if isinstance(loaded, trimesh.Trimesh):
        return [(numpy.asarray(loaded.vertices)[loaded.faces], numpy.eye(4))]
    found = []
    for node in loaded.graph.nodes_geometry:
        matrix, name = loaded.graph[node]
        geometry = loaded.geometry[name]
        if isinstance(geometry, trimesh.Trimesh):
            found.append((numpy.asarray(geometry.vertices)[geometry.faces], numpy.asarray(matrix)))
    return found


def unbalanced(pieces: list[tuple[numpy.ndarray, numpy.ndarray]]) -> int:
    """Edges whose directed uses do not cancel. Pieces under one matrix are one part."""
    total = 0
    parts = collections.defaultdict(list)
    for corners, matrix in pieces:
        parts[matrix.tobytes()].append(corners)
    for part in parts.values():
        corners = numpy.concatenate(part)
        _, ids = numpy.unique(corners.reshape(-1, 3) + 0.0, axis=0, return_inverse=True)
        ids = ids.reshape(-1, 3)
        edges = numpy.concatenate([ids[:, [0, 1]], ids[:, [1, 2]], ids[:, [2, 0]]])
        forward = edges[:, 0] < edges[:, 1]
        _, keys = numpy.unique(numpy.sort(edges, axis=1), axis=0, return_inverse=True)
        sums = numpy.bincount(keys.reshape(-1), weights=numpy.where(forward, 1, -1))
        total += int(numpy.count_nonzero(sums))
    return total


def in_millimetres(pieces: list[tuple[numpy.ndarray, numpy.ndarray]], is_glb: bool) -> numpy.ndarray:
    """All corners, +Z up."""
    placed = [corners.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3] for corners, matrix in pieces]
    points = numpy.concatenate(placed) if placed else numpy.zeros((0, 3))
    return numpy.stack([points[:, 0], -points[:, 2], points[:, 1]], axis=1) * 1e3 if is_glb else points


class Validator:
    """The glTF validator as a process that answers line by line."""

    def __init__(self, tools: str) -> None:
        script = pathlib.Path(__file__).with_name("validate.js")
        environment = os.environ | {"NODE_PATH": f"{tools}/node_modules"}
        self.process = subprocess.Popen(
            ["node", str(script)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment
        )

    def judge(self, path: pathlib.Path) -> dict:
        self.process.stdin.write(f"{path}\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())


def judge_format(program: str, validator: Validator, step: pathlib.Path, extension: str, exact: dict) -> dict:
    """One file in one format. `exact` is what the PLY of this file holds, by offset."""
    path = step.with_suffix(f".{extension}")
    row = {"format": extension, "recentred": False}
    status, report, told = run(program, "tessellate", str(step), "-o", str(path), "--check")
    if status == 1 and "--recenter" in told:
        row["recentred"] = True
        status, report, told = run(program, "tessellate", str(step), "-o", str(path), "--check", "--recenter")
    if status not in (0, 3):
        raise Fault(f"status {status}: {told.strip()}")
    pieces = read(path)
    triangles = sum(len(corners) for corners, _ in pieces)
    row |= {"status": status, "triangles": triangles, "collapsed": report["collapsed_triangles"]}
    row |= {"rounding_of_chord": report["rounding_mm"] / report["chord_mm"]}
    failed = [entry["reason"] for entry in report["diagnostics"] if entry["code"] == "check-failed"]
    row["check_failed"] = failed
    row["diagonal"] = report["diagonal_mm"]
    if triangles != report["triangles"]:
        raise Fault(f"trimesh reads {triangles} triangles, the report says {report['triangles']}")
    if report["unbalanced_edges"] == 0 and (left := unbalanced(pieces)):
        raise Fault(f"{left} edges do not cancel in what trimesh reads")
    points = in_millimetres(pieces, extension == "glb") + numpy.array(report["offset_mm"])
    if extension == "glb":
        answer = validator.judge(path)
        row |= {"errors": answer["errors"], "warnings": answer["warnings"]}
        if answer["errors"] or answer["warnings"]:
            raise Fault(f"the glTF validator says {answer['told'][:3]}")
    if len(points) == 0:
        return row
    box = numpy.array([points.min(axis=0), points.max(axis=0)])
    if extension == "ply":
        exact |= {"points": points, "box": box}
        return row
    # Numbers of the reader and of the transforms, far from the origin.
    allowed = report["rounding_mm"] * (1 + 1e-6) + 4e-15 * numpy.abs(box).max()
    same_order = extension != "glb" and len(points) == len(exact["points"])
    off = numpy.abs(points - exact["points"]).max() if same_order else numpy.abs(box - exact["box"]).max()
    row["off"] = float(off)
    if off > allowed:
        raise Fault(f"a position is {off:.3e} mm off that in PLY, and rounding explains {allowed:.3e} mm")
    return row


def judge(task: tuple[str, str, str, float]) -> list[dict]:
    """One file in one variant, in all formats."""
    program, tools, name, change = task
    source = pathlib.Path(name)
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        step = pathlib.Path(folder) / "part.step"
        kind, amount = change
        head = {"file": source.name, "variant": "as it is" if kind == "as" else f"{kind} {amount:g}"}
        status, info, told = run(program, "info", name)
        if status not in (0, 3) or not info["placed_faces"]:
            return [head | {"skipped": told.strip() or "no faces"}]
        text = source.read_text(encoding="latin-1")
        if kind == "moved":
            text = variants.moved(text, amount / info["millimetres_per_unit"])
        elif kind == "scaled":
            text = variants.scaled(text, 1 if amount > 1 else -1)
        step.write_text(text, encoding="latin-1")
        validator = Validator(tools)
        exact = {}
        for extension in FORMATS:
            try:
                row = judge_format(program, validator, step, extension, exact)
                expected = info["diagonal"] * (amount if kind == "scaled" else 1.0)
                # There is no hundredth of a millimetre.
                if all(abs(row["diagonal"] / size - 1) > 1e-3 for size in (expected, 0.1 * expected)):
                    row["skipped"] = f"the diagonal is {row['diagonal']:g}, not {expected:g} mm: made wrongly"
                rows.append(head | row)
            except Fault as fault:
                rows.append(head | {"format": extension, "fault": str(fault)})
        validator.process.stdin.close()
        validator.process.wait()
    return rows


def table(rows: list[dict]) -> str:
    lines = [
        "variant | format | files | triangles | equal to the report | recentred | collapsed | status 3 | check failed"
        " | rounding/chord | validator errors, warnings",
        "|".join(["---"] * 11),
    ]
    groups = collections.defaultdict(list)
    for row in rows:
        if "skipped" not in row:
            groups[row["variant"], row["format"]].append(row)
    for (variant, extension), group in groups.items():
        sound = [row for row in group if "fault" not in row]
        total = {key: sum(row.get(key, 0) for row in sound) for key in ["triangles", "recentred", "collapsed"]}
        rounding = max((row["rounding_of_chord"] for row in sound), default=0.0)
        judged = [row for row in sound if "errors" in row]
        answer = f"{sum(r['errors'] for r in judged)}, {sum(r['warnings'] for r in judged)}" if judged else ""
        threes = sum(row["status"] == 3 for row in sound)
        failed = sum(bool(row["check_failed"]) for row in sound)
        lines.append(
            f"{variant} | {extension} | {len(group)} | {total['triangles']} | {len(sound)} | {total['recentred']} | "
            f"{total['collapsed']} | {threes} | {failed} | {rounding:.1e} | {answer}"
        )
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("--trimtess", required=True)
    parser.add_argument("--tools", required=True)
    parser.add_argument("--rows", help="write all rows as JSON")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("inputs", nargs="+")
    args = parser.parse_args()
    files = []
    for name in map(pathlib.Path, args.inputs):
        files += sorted(name.glob("*.st*p")) if name.is_dir() else [name]
    changes = [("as", 0.0)] + [("moved", by) for by in MOVES] + [("scaled", 10.0 ** (3 * steps)) for steps in SCALES]
    tasks = [(args.trimtess, args.tools, str(file), change) for change in changes for file in files]
    with multiprocessing.Pool(args.jobs) as pool:
        rows = [row for rows in pool.map(judge, tasks, chunksize=1) for row in rows]
    if args.rows:
        pathlib.Path(args.rows).write_text(json.dumps(rows, indent=1))
    for row in rows:
        for what in ["skipped", "fault"]:
            if what in row:
                print(f"{what}: {row['file']}, {row['variant']}, {row.get('format', 'all formats')}: {row[what]}")
    print(table(rows))
    faults = sum("fault" in row for row in rows)
    print(f"{len(files)} files, {len(rows)} rows, {faults} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
