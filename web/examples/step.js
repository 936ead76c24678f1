// A STEP file as objects of three.js.
import * as THREE from "/node_modules/three/build/three.module.js";
import * as trimtess from "/trimtess.js";

export async function load(file) {
  const prepared = await trimtess.read(file);
  const { parts, instances } = await prepared.tessellate({ chordRel: 1e-3, angle: 20 });
  prepared.close();
  const geometries = parts.map(({ positions, normals, indices }) =>
    new THREE.BufferGeometry()
      .setAttribute("position", new THREE.BufferAttribute(positions, 3))
      .setAttribute("normal", new THREE.BufferAttribute(normals, 3))
      .setIndex(new THREE.BufferAttribute(indices, 1)),
  );
  const model = new THREE.Group();
  for (const { part, transform, colour = [0.56, 0.65, 0.75] } of instances) {
    const color = new THREE.Color().setRGB(...colour.slice(0, 3), THREE.SRGBColorSpace);
    const solid = new THREE.Mesh(geometries[part], new THREE.MeshStandardMaterial({ color }));
    solid.applyMatrix4(new THREE.Matrix4().fromArray(transform));
    solid.userData = parts[part];
    model.add(solid);
  }
  return model;
}

// What a ray of three.js hit, in words.
export const faceOf = ({ object, faceIndex }) => `face ${object.userData.faces[faceIndex]} of ${object.userData.name}`;
