// A STEP file in three.js: drag to turn, wheel to zoom, click a face to hear of it.
import * as THREE from "/node_modules/three/build/three.module.js";
import * as trimtess from "/trimtess.js";

const canvas = document.querySelector("canvas");
const renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
const camera = new THREE.PerspectiveCamera(35, 1, 0.01, 10);
const [scene, model] = [new THREE.Scene(), new THREE.Group()];
scene.background = new THREE.Color(0xe8ecf1);
scene.add(model, new THREE.HemisphereLight(0xffffff, 0x777788, 3));
camera.position.z = 2;

function draw() {
  renderer.setSize(canvas.clientWidth, canvas.clientHeight, false);
  camera.aspect = canvas.clientWidth / canvas.clientHeight;
  camera.updateProjectionMatrix();
  renderer.render(scene, camera);
}

async function show(bytes) {
  const prepared = await trimtess.read(bytes);
  const mesh = await prepared.tessellate({ chordRel: 1e-3, angle: 20 });
  prepared.close();
  const geometries = mesh.parts.map(({ positions, normals, indices }) => new THREE.BufferGeometry()
    .setAttribute("position", new THREE.BufferAttribute(positions, 3))
    .setAttribute("normal", new THREE.BufferAttribute(normals, 3))
    .setIndex(new THREE.BufferAttribute(indices, 1)));
  const placed = new THREE.Group();
  for (const { part, transform } of mesh.instances) {
    const solid = new THREE.Mesh(geometries[part], new THREE.MeshStandardMaterial({ color: 0x8fa6c0 }));
    solid.applyMatrix4(new THREE.Matrix4().fromArray(transform));
    solid.userData = mesh.parts[part];
    placed.add(solid);
  }
  const box = new THREE.Box3().setFromObject(placed);
  const scale = 1 / box.getSize(new THREE.Vector3()).length();
  placed.scale.setScalar(scale);
  placed.position.copy(box.getCenter(new THREE.Vector3())).multiplyScalar(-scale);
  model.clear().add(placed);
  model.rotation.set(-1, 0, 0.6);
  draw();
}

canvas.onclick = ({ offsetX, offsetY }) => {
  const pointer = new THREE.Vector2(offsetX / canvas.clientWidth * 2 - 1, 1 - offsetY / canvas.clientHeight * 2);
  const ray = new THREE.Raycaster();
  ray.setFromCamera(pointer, camera);
  const [hit] = ray.intersectObject(model);
  const text = hit ? `face ${hit.object.userData.faces[hit.faceIndex]} of ${hit.object.userData.name}` : "nothing there";
  document.querySelector("output").value = text;
};
canvas.onpointermove = ({ buttons, movementX, movementY }) => {
  if (buttons !== 1) return;
  model.rotation.z += movementX / 200;
  model.rotation.x += movementY / 200;
  draw();
};
canvas.onwheel = ({ deltaY }) => { camera.position.z *= Math.exp(deltaY / 600); draw(); };
document.querySelector("input").onchange = async ({ target }) => show(new Uint8Array(await target.files[0].arrayBuffer()));
onresize = draw;
draw();
