// A STEP file in three.js: drag to turn, wheel to zoom, click a face to hear of it.
import * as THREE from "/node_modules/three/build/three.module.js";
import * as trimtess from "/trimtess.js";

const DEFAULT = [0.56, 0.65, 0.75];

async function load(bytes) {
  const prepared = await trimtess.read(bytes);
  const mesh = await prepared.tessellate({ chordRel: 1e-3, angle: 20 });
  prepared.close();
  const geometries = mesh.parts.map(({ positions, normals, indices }) =>
    new THREE.BufferGeometry()
      .setAttribute("position", new THREE.BufferAttribute(positions, 3))
      .setAttribute("normal", new THREE.BufferAttribute(normals, 3))
      .setIndex(new THREE.BufferAttribute(indices, 1)),
  );
  const model = new THREE.Group();
  for (const { part, transform, colour = DEFAULT } of mesh.instances) {
    const material = new THREE.MeshStandardMaterial({
      color: new THREE.Color().setRGB(...colour.slice(0, 3), THREE.SRGBColorSpace),
    });
    const solid = new THREE.Mesh(geometries[part], material);
    solid.applyMatrix4(new THREE.Matrix4().fromArray(transform));
    solid.userData = mesh.parts[part];
    model.add(solid);
  }
  return model;
}

function faceAt(x, y) {
  const ray = new THREE.Raycaster();
  ray.setFromCamera(new THREE.Vector2(x, y), camera);
  const [hit] = ray.intersectObject(world);
  return hit ? `face ${hit.object.userData.faces[hit.faceIndex]} of ${hit.object.userData.name}` : "nothing there";
}

// What any three.js page has.
const canvas = document.querySelector("canvas");
const renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
const camera = new THREE.PerspectiveCamera(35, 1, 0.01, 10);
const world = new THREE.Group();
const scene = new THREE.Scene().add(world, new THREE.HemisphereLight(0xffffff, 0x777788, 3));
scene.background = new THREE.Color(0xe8ecf1);
camera.position.z = 2;

function draw() {
  renderer.setSize(canvas.clientWidth, canvas.clientHeight, false);
  camera.aspect = canvas.clientWidth / canvas.clientHeight;
  camera.updateProjectionMatrix();
  renderer.render(scene, camera);
}

document.querySelector("input").onchange = async ({ target }) => {
  const model = await load(target.files[0]);
  const box = new THREE.Box3().setFromObject(model);
  const scale = 1 / box.getSize(new THREE.Vector3()).length();
  model.position.copy(box.getCenter(new THREE.Vector3())).negate();
  world.clear().add(model);
  world.scale.setScalar(scale);
  world.rotation.set(-1, 0, 0.6);
  draw();
};
canvas.onclick = ({ offsetX, offsetY }) => {
  const at = faceAt((offsetX / canvas.clientWidth) * 2 - 1, 1 - (offsetY / canvas.clientHeight) * 2);
  document.querySelector("output").value = at;
};
canvas.onpointermove = ({ buttons, movementX, movementY }) => {
  if (buttons !== 1) return;
  world.rotation.z += movementX / 200;
  world.rotation.x += movementY / 200;
  draw();
};
canvas.onwheel = ({ deltaY }) => {
  camera.position.z *= Math.exp(deltaY / 600);
  draw();
};
onresize = draw;
draw();
