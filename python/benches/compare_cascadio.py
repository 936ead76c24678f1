"""trimtess next to cascadio (OpenCASCADE, trimesh's loader of STEP) on a folder of files, in turn.

usage: python compare_cascadio.py FOLDER... [--chord-rel 1e-3] [--angle 20] [--rounds 3] [--judge "python3 JUDGE.py"]
                                  [--out rows.jsonl]

For each file both convert STEP to a GLB, with the same chord (millimetres) and angle, each in the same process, file
after file, best of the rounds. Then both files are read by trimesh and compared: triangles; parts (meshes of the GLB)
that are closed, edge uses cancelling over positions compared bit by bit. With --judge, a program that is called as
`JUDGE MESH MODEL --tol MM --scale S` and prints JSON measures both against the exact surfaces: the GLB of cascadio,
which keeps +Z up, in metres, and a PLY of trimtess, whose GLB has +Y up as glTF asks for.

Needs cascadio and trimesh.
"""

import argparse
import json
import pathlib
import shlex
import subprocess
import sys
import tempfile
import time

import cascadio
import numpy as np
import trimesh

import trimtess


def ours(file: pathlib.Path, out: pathlib.Path, chord_rel: float, angle: float) -> "tuple[float, float]":
    """Seconds, and the chord tolerance in millimetres."""
    start = time.perf_counter()
    mesh = trimtess.read(file).prepare().tessellate(chord_rel=chord_rel, angle=angle)
    mesh.save(out)
    seconds = time.perf_counter() - start
    mesh.save(out.with_suffix(".ply"))
    return seconds, mesh.chord


def theirs(file: pathlib.Path, out: pathlib.Path, chord: float, angle: float) -> float:
    """Seconds."""
    start = time.perf_counter()
    status = cascadio.step_to_glb(str(file), str(out), tol_linear=chord, tol_angular=np.radians(angle))
    if status != 0 or not out.exists():
        raise RuntimeError(f"status {status}")
    return time.perf_counter() - start


def balanced(vertices: np.ndarray, faces: np.ndarray) -> bool:
    """Whether as many triangles use each edge one way as the other, over positions compared bit by bit."""
    _, welded = np.unique(vertices, axis=0, return_inverse=True)
    corners = welded.reshape(-1)[faces]
    a, b, c = corners.T
    corners = corners[(a != b) & (b != c) & (c != a)]
    uses = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    edges, index = np.unique(np.sort(uses, axis=1), axis=0, return_inverse=True)
    sums = np.bincount(index.reshape(-1), np.where(uses[:, 0] < uses[:, 1], 1, -1), len(edges))
    return not sums.any()


def facts(path: pathlib.Path) -> dict:
    """What a GLB holds. Lines and points are left out."""
    scene = trimesh.load(path, process=False, force="scene")
    meshes = {name: mesh for name, mesh in scene.geometry.items() if isinstance(mesh, trimesh.Trimesh)}
    placed = [scene.graph[node][1] for node in scene.graph.nodes_geometry]
    # Primitives of one mesh share its name up to a number that trimesh adds: weld them before judging.
    of_node: "dict[str, list]" = {}
    for node in scene.graph.nodes_geometry:
        transform, name = scene.graph[node]
        if name in meshes:
            of_node.setdefault(str(transform.tolist()), []).append(meshes[name])
    closed = 0
    for group in of_node.values():
        offsets = np.cumsum([0] + [len(mesh.vertices) for mesh in group[:-1]])
        vertices = np.concatenate([np.asarray(mesh.vertices, np.float32) for mesh in group])
        faces = np.concatenate([np.asarray(mesh.faces) + offset for mesh, offset in zip(group, offsets)])
        closed += balanced(vertices, faces)
    triangles = sum(len(meshes[name].faces) for name in placed if name in meshes)
    return {"triangles": triangles, "bodies": len(of_node), "closed": closed}


def judged(judge: "list[str]", mesh: pathlib.Path, model: pathlib.Path, chord: float) -> dict:
    scale = "1000" if mesh.suffix == ".glb" else "1"
    command = [*judge, str(mesh), str(model), "--tol", str(chord), "--scale", scale]
    told = subprocess.run(command, capture_output=True, text=True, check=False, timeout=1800)
    if told.returncode != 0:
        return {"judge": told.stderr.strip().splitlines()[-1:] or ["no words"]}
    row = json.loads(told.stdout.strip().splitlines()[-1])
    worst = max(row["mesh_to_surface_p999_over_tol"], row["surface_to_mesh_p999_over_tol"])
    return {"deviation": worst, "unbalanced_edges": row["unbalanced_edges"]}


def compare(file: pathlib.Path, options: argparse.Namespace, folder: pathlib.Path) -> dict:
    row: dict = {"file": file.name, "trimtess": {"seconds": []}, "cascadio": {"seconds": []}}
    out = {name: folder / f"{name}.glb" for name in ("trimtess", "cascadio")}
    chord = None
    for _ in range(options.rounds):
        for name, path in out.items():
            path.unlink(missing_ok=True)
            try:
                if name == "trimtess":
                    seconds, chord = ours(file, path, options.chord_rel, options.angle)
                elif chord:
                    seconds = theirs(file, path, chord, options.angle)
                else:
                    raise RuntimeError("no chord")
                row[name]["seconds"].append(seconds)
            except Exception as error:  # one file must not end the comparison
                row[name]["error"] = f"{type(error).__name__}: {error}"
    for name, path in out.items():
        if row[name]["seconds"] and path.exists():
            row[name].update(facts(path))
            if options.judge and chord:
                measured = path.with_suffix(".ply") if name == "trimtess" else path
                row[name].update(judged(shlex.split(options.judge), measured, file, chord))
        row[name]["seconds"] = min(row[name]["seconds"], default=None)
    return row


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", type=pathlib.Path)
    parser.add_argument("--chord-rel", type=float, default=1e-3)
    parser.add_argument("--angle", type=float, default=20)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--judge")
    parser.add_argument("--out", type=pathlib.Path)
    options = parser.parse_args()
    files = sorted(f for folder in options.folders for f in folder.iterdir() if f.suffix.lower() in (".step", ".stp"))
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for file in files:
            row = compare(file, options, pathlib.Path(folder))
            rows.append(row)
            print(json.dumps(row), file=sys.stderr, flush=True)
            if options.out:
                options.out.write_text("".join(json.dumps(row) + "\n" for row in rows))
    both = [row for row in rows if all(row[name]["seconds"] for name in ("trimtess", "cascadio"))]
    print(f"{len(rows)} files, {len(both)} converted by both")
    for name in ("trimtess", "cascadio"):
        keys = ("seconds", "triangles", "bodies", "closed")
        total = {key: sum(row[name].get(key, 0) for row in both) for key in keys}
        measured = [row[name]["deviation"] for row in both if "deviation" in row[name]]
        within = sum(deviation <= 1.05 for deviation in measured)
        print(
            f"{name}: {total['seconds']:.2f} s, {total['triangles']} triangles, "
            f"{total['closed']} of {total['bodies']} bodies closed, "
            f"99.9 % of samples within the chord in {within} of {len(measured)} files"
        )


if __name__ == "__main__":
    main()
