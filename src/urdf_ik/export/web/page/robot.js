// The arm in the scene: links on the tree of the URDF's joints, and copies of them as ghosts.
import * as THREE from 'three';

// Rows of a pose, as the solvers give them, as three.js's matrix; and back.
export const matrix = T => new THREE.Matrix4().set(...T);
export const rows = M => Array.from(M.clone().transpose().elements);

const numbers = (Kind, text) => new Kind(Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer);

export function shapes(scene) {
  return scene.bodies.map(body => {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(numbers(Float32Array, body.vertices), 3));
    geometry.setIndex(new THREE.BufferAttribute(numbers(Uint32Array, body.faces), 1));
    return {link: body.link, geometry, colour: new THREE.Color().setRGB(...body.colour, THREE.SRGBColorSpace)};
  });
}

export class Robot {
  // colour: of a ghost; none: the links' own.
  constructor(scene, bodies, colour) {
    this.scene = scene;
    this.root = new THREE.Group();
    this.root.matrixAutoUpdate = false;
    this.links = new Map();
    const materials = new Map();
    for (const {link, geometry, colour: own} of bodies) {
      const shade = colour ?? `#${own.getHexString()}`;
      if (!materials.has(shade)) {
        materials.set(shade, new THREE.MeshLambertMaterial({color: shade, flatShading: true, side: THREE.DoubleSide,
          transparent: colour !== undefined, opacity: colour === undefined ? 1 : 0.3, depthWrite: colour === undefined}));
      }
      this.#group(link).add(new THREE.Mesh(geometry, materials.get(shade)));
    }
    if (!bodies.length) this.#addLine(colour ?? '#333333');
    this.root.add(...this.links.values());
  }

  #group(link) {
    if (!this.links.has(link)) {
      const group = new THREE.Group();
      group.matrixAutoUpdate = false;
      this.links.set(link, group);
    }
    return this.links.get(link);
  }

  // An arm without shapes is a line through the origins of its links.
  #addLine(colour) {
    this.line = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({color: colour}));
    this.line.geometry.setAttribute('position', new THREE.Float32BufferAttribute(new Float32Array(6 * this.scene.tree.length), 3));
    this.line.frustumCulled = false;
    this.root.add(this.line);
  }

  move(q) {
    const at = poses(this.scene, q);
    for (const [link, group] of this.links) {
      group.matrix.copy(at.get(link));
      group.matrixWorldNeedsUpdate = true;
    }
    if (!this.line) return;
    const places = this.line.geometry.attributes.position;
    this.scene.tree.forEach(({parent, child}, i) => [parent, child].forEach((link, k) => {
      const e = at.get(link).elements;
      places.setXYZ(2 * i + k, e[12], e[13], e[14]);
    }));
    places.needsUpdate = true;
  }
}

// The pose of every link in the base link, as Chain.link_poses has it.
function poses(scene, q) {
  const at = new Map([[scene.root, new THREE.Matrix4()]]);
  for (const joint of scene.tree) {
    const value = joint.offset + (joint.column === null ? 0 : joint.multiplier * q[joint.column]);
    const axis = new THREE.Vector3(...joint.axis);
    const motion = joint.prismatic ? new THREE.Matrix4().makeTranslation(axis.multiplyScalar(value))
      : new THREE.Matrix4().makeRotationAxis(axis, value);
    at.set(joint.child, at.get(joint.parent).clone().multiply(matrix(joint.origin)).multiply(motion));
  }
  const inverse = at.get(scene.base).clone().invert();
  for (const pose of at.values()) pose.premultiply(inverse);
  return at;
}
