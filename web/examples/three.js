// A page of three.js that shows a STEP file: drag to turn, wheel to zoom, click a face to hear of it. What is of STEP
// is in step.js.
import * as THREE from "/node_modules/three/build/three.module.js";
import { faceOf, load } from "./step.js";

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
  const at = new THREE.Vector2((offsetX / canvas.clientWidth) * 2 - 1, 1 - (offsetY / canvas.clientHeight) * 2);
  const ray = new THREE.Raycaster();
  ray.setFromCamera(at, camera);
  const [hit] = ray.intersectObject(world);
  document.querySelector("output").value = hit ? faceOf(hit) : "nothing there";
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
