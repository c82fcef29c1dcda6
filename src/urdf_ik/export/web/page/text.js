// Poses and joint vectors as text: what is typed, what is copied, and what a link holds.
import * as THREE from 'three';
import {rows} from './robot.js';

const numbersOf = text => {
  const words = text.replace(/[\[\](),;]/g, ' ').trim().split(/\s+/).filter(Boolean), numbers = words.map(Number);
  const bad = numbers.findIndex(each => !Number.isFinite(each));
  if (bad >= 0) throw new Error(`"${words[bad]}" is no number`);
  return numbers;
};

// Six numbers are x y z and roll pitch yaw, seven x y z and a quaternion x y z w, sixteen a matrix by rows.
export function poseOf(text) {
  const n = numbersOf(text);
  if (n.length === 16) return n;
  if (n.length !== 6 && n.length !== 7) {
    throw new Error(`${n.length} numbers: 6 are x y z roll pitch yaw, 7 x y z and a quaternion x y z w, 16 a matrix`);
  }
  const turn = new THREE.Quaternion();
  if (n.length === 7) {
    if (!(Math.abs(Math.hypot(...n.slice(3)) - 1) < 1e-3)) throw new Error('the quaternion x y z w has not the length 1');
    turn.set(...n.slice(3)).normalize();
  } else {
    turn.setFromEuler(new THREE.Euler(n[3], n[4], n[5], 'ZYX'));
  }
  return rows(new THREE.Matrix4().compose(new THREE.Vector3(...n.slice(0, 3)), turn, new THREE.Vector3(1, 1, 1)));
}

const short = value => String(Number(value.toFixed(6)) + 0);

// x y z roll pitch yaw of a pose.
export function poseText(T) {
  const angles = new THREE.Euler().setFromRotationMatrix(new THREE.Matrix4().set(...T), 'ZYX');
  return [T[3], T[7], T[11], angles.x, angles.y, angles.z].map(short).join(' ');
}

// A link's hash holds the joint vector, and the target where the arm does not reach it.
export function hashOf(state) {
  const parts = {q: state.q, T: state.T.slice(0, 12)};
  if (state.redundancy) parts.r = state.redundancy;
  return '#' + Object.entries(parts).map(([name, numbers]) => `${name}=${numbers.join(',')}`).join('&');
}

// What a hash holds, or null where it holds nothing. Throws what is wrong in it.
export function fromHash(hash, joints, parameters) {
  if (!/^#[qTr]=/.test(hash)) return null;
  const wanted = {q: joints, T: 12, r: parameters}, found = {};
  for (const part of hash.slice(1).split('&')) {
    const [name, text] = part.split('=');
    if (!(name in wanted)) throw new Error(`the link's "${name}" is unknown`);
    found[name] = numbersOf(decodeURIComponent(text ?? ''));
    if (found[name].length !== wanted[name]) {
      throw new Error(`the link's ${name} has ${found[name].length} numbers; this arm needs ${wanted[name]}`);
    }
  }
  return found;
}
