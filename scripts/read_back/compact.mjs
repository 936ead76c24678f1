// Compact GLBs of STEP files, and one with levels of detail, loaded by three.js and judged by the glTF validator: as many
// triangles as the report says, in each level; edges cancel mesh by mesh; and the box of all vertices is that of the plain
// file within what rounding explains. Prints the sizes. usage: node compact.mjs TRIMTESS TOOLS FILE.step... [-- ARGUMENTS OF tessellate]
import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, statSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import { pathToFileURL } from "node:url";

const [program, tools, ...rest] = process.argv.slice(2);
const end = rest.includes("--") ? rest.indexOf("--") : rest.length;
const [files, extra] = [rest.slice(0, end), rest.slice(end + 1)];
const require = createRequire(join(tools, "package.json"));
const load = (name) => import(pathToFileURL(require.resolve(name)));
globalThis.self ??= globalThis;
const THREE = await load("three");
const { GLTFLoader } = await load("three/addons/loaders/GLTFLoader.js");
const { MeshoptDecoder } = await load("three/addons/libs/meshopt_decoder.module.js");
const validator = require("gltf-validator");

const ALL = "instanced,quantized,compressed";
const FORMS = [
  ["plain", []],
  ...["instanced", "quantized", "compressed", ALL].map((how) => [how, ["--glb", how]]),
  ["3 levels", ["--levels", "3"]],
  [`${ALL}, 3 levels`, ["--glb", ALL, "--levels", "3"]],
];

/**
 * What three.js makes of a file: triangles, edges that do not cancel, and the box of all vertices; and triangles and edges
 * that do not cancel of each coarser level, whose nodes no scene has.
 */
async function loaded(path) {
  const bytes = readFileSync(path);
  const loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder);
  const { scene, parser } = await loader.parseAsync(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length), "");
  scene.updateMatrixWorld(true);
  const box = new THREE.Box3();
  let edges = new Map();
  let triangles = 0;
  const [corner, place] = [new THREE.Vector3(), new THREE.Matrix4()];
  // The primitives of a mesh are meshes of one group.
  const count = (mesh, group) => {
    const { position } = mesh.geometry.attributes;
    const index = mesh.geometry.index.array;
    const name = (k) => `${position.getX(k)} ${position.getY(k)} ${position.getZ(k)}`;
    const copies = mesh.isInstancedMesh ? mesh.count : 1;
    triangles += (copies * index.length) / 3;
    for (let k = 0; k < index.length; k++) {
      const [a, b] = [name(index[k]), name(index[k % 3 === 2 ? k - 2 : k + 1])];
      if (a !== b) {
        const [key, sign] = a < b ? [`${group} ${a} ${b}`, 1] : [`${group} ${b} ${a}`, -1];
        edges.set(key, (edges.get(key) ?? 0) + sign);
      }
    }
    for (let copy = 0; copy < copies; copy++) {
      if (mesh.isInstancedMesh) mesh.getMatrixAt(copy, place);
      else place.identity();
      place.premultiply(mesh.matrixWorld);
      for (let k = 0; k < position.count; k++) box.expandByPoint(corner.fromBufferAttribute(position, k).applyMatrix4(place));
    }
  };
  const counted = (roots) => {
    [edges, triangles] = [new Map(), 0];
    const each = (node) => node.isMesh && count(node, node.parent?.isGroup ? node.parent.uuid : node.uuid);
    roots.forEach((root) => root.traverse(each));
    return { triangles, unbalanced: [...edges.values()].filter((sum) => sum !== 0).length };
  };
  const finest = { ...counted([scene]), box: box.clone() };
  const ids = parser.json.nodes.map((node) => node.extensions?.MSFT_lod?.ids ?? []);
  const levels = [];
  for (let k = 0; ids.some((row) => row.length > k); k++) {
    const nodes = ids.filter((row) => row.length > k).map((row) => parser.getDependency("node", row[k]));
    levels.push(counted(await Promise.all(nodes)));
  }
  return { ...finest, levels };
}

let faults = 0;
const folder = mkdtempSync(join(tmpdir(), "trimtess-compact-"));
for (const file of files) {
  let plain;
  for (const [form, how] of FORMS) {
    const path = join(folder, "part.glb");
    const run = spawnSync(program, ["tessellate", file, "-o", path, "--check", "--json", ...how, ...extra], {
      encoding: "utf8",
      maxBuffer: 1 << 28,
    });
    const report = run.stdout ? JSON.parse(run.stdout) : undefined;
    const name = `${basename(file)} ${form}`;
    if (!report || ![0, 3].includes(run.status)) {
      console.log(`${name}: status ${run.status}: ${run.stderr.trim()}`);
      faults++;
      break;
    }
    const { issues } = await validator.validateBytes(new Uint8Array(readFileSync(path)), { maxIssues: 20 });
    const seen = await loaded(path);
    plain ??= { ...seen, bytes: statSync(path).size, status: run.status };
    const metres = 1e-3 * report.rounding_mm + 4e-7 * Math.max(...seen.box.max.toArray().map(Math.abs));
    const off = ["min", "max"].map((end) => seen.box[end].distanceTo(plain.box[end]));
    const wrong = [
      [run.status !== plain.status, `status ${run.status} instead of ${plain.status}`],
      [issues.numErrors > 0, `the validator: ${JSON.stringify(issues.messages[0])}`],
      [seen.triangles !== report.triangles, `${seen.triangles} triangles, the report says ${report.triangles}`],
      [
        JSON.stringify(seen.levels.map((level) => level.triangles)) !== JSON.stringify(report.levels.map((level) => level.triangles)),
        `levels of ${seen.levels.map((level) => level.triangles)} triangles, and not those of the report`,
      ],
      [
        report.levels.some((level, k) => level.unbalanced_edges === 0 && seen.levels[k]?.unbalanced > 0),
        `edges of a level do not cancel: ${seen.levels.map((level) => level.unbalanced)}`,
      ],
      [report.unbalanced_edges === 0 && seen.unbalanced > 0, `${seen.unbalanced} edges do not cancel`],
      [Math.max(...off) > 2 * metres, `the box is ${Math.max(...off)} m off, and rounding explains ${metres}`],
    ].filter(([is]) => is);
    wrong.forEach(([, what]) => console.log(`${name}: ${what}`));
    faults += wrong.length;
    const bytes = statSync(path).size;
    const share = ((100 * bytes) / plain.bytes).toFixed(1);
    console.log(
      `${name}: ${bytes} bytes, ${share} %; ${seen.triangles} triangles; rounding ${(report.rounding_mm / report.chord_mm).toExponential(1)} ` +
        `of the tolerance; validator ${issues.numErrors} errors, ${issues.numWarnings} warnings`,
    );
  }
}
rmSync(folder, { recursive: true });
console.log(`${faults} faults`);
process.exitCode = faults ? 1 : 0;
