// The picture: camera, light, grid, the arm with its ghosts, and the target's handles.
import * as THREE from 'three';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';
import {TransformControls} from 'three/addons/controls/TransformControls.js';
import {Robot, matrix, rows, shapes} from './robot.js';

const TURN = new THREE.Matrix4().makeRotationX(-Math.PI / 2);  // z upwards

export class View {
  #waits = false;

  constructor(place, scene, colours, dragged) {
    this.place = place;
    this.renderer = new THREE.WebGLRenderer({antialias: true});
    place.append(this.renderer.domElement);
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color('#f4f5f7');
    this.world = new THREE.Group();
    this.world.applyMatrix4(TURN);
    this.scene.add(this.world, new THREE.HemisphereLight('#ffffff', '#8888a0', 2.2));
    const sun = new THREE.DirectionalLight('#ffffff', 1.6);
    sun.position.set(2, 4, 3);
    const size = scene.size;
    this.scene.add(sun, new THREE.GridHelper(4 * size, 20, '#c0c4cc', '#dde0e6'));
    const bodies = shapes(scene);
    this.robot = new Robot(scene, bodies);
    const moving = bodies.filter(body => scene.moving.includes(body.link));
    this.ghosts = colours.map(colour => new Robot(scene, moving, colour));
    this.world.add(this.robot.root, ...this.ghosts.map(ghost => ghost.root));

    this.camera = new THREE.PerspectiveCamera(40, 1, 0.01 * size, 50 * size);
    this.camera.position.set(1.7 * size, 1.5 * size, 2.1 * size);
    this.orbit = new OrbitControls(this.camera, this.renderer.domElement);
    this.orbit.target.set(0, 0.4 * size, 0);
    this.orbit.update();
    this.orbit.addEventListener('change', () => this.draw());

    this.target = new THREE.Group();
    this.target.add(new THREE.AxesHelper(0.2 * size));
    this.world.add(this.target);
    this.handles = new TransformControls(this.camera, this.renderer.domElement);
    this.handles.attach(this.target);
    this.handles.setSpace('local');
    this.handles.setSize(0.8);
    this.scene.add(this.handles.getHelper());
    this.handles.addEventListener('dragging-changed', event => { this.orbit.enabled = !event.value; });
    this.handles.addEventListener('objectChange', () => {
      this.target.updateMatrix();
      dragged(rows(this.target.matrix));
    });
    this.handles.addEventListener('change', () => this.draw());
    new ResizeObserver(() => this.#fit()).observe(place);
    this.#fit();
  }

  // q: the arm's joint vector; solutions: what is drawn as ghosts; T: the target, if it is to be moved.
  show(q, solutions, T) {
    this.robot.move(q);
    this.ghosts.forEach(ghost => { ghost.root.visible = false; });
    for (const {column, q: at} of solutions) {
      this.ghosts[column].root.visible = true;
      this.ghosts[column].move(at);
    }
    if (T) matrix(T).decompose(this.target.position, this.target.quaternion, this.target.scale);
    this.draw();
  }

  // Draws once for all that changes before the browser's next frame.
  draw() {
    if (this.#waits) return;
    this.#waits = true;
    requestAnimationFrame(() => {
      this.#waits = false;
      this.renderer.render(this.scene, this.camera);
      this.frames = (this.frames ?? 0) + 1;
    });
  }

  #fit() {
    const {clientWidth: width, clientHeight: height} = this.place;
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(globalThis.devicePixelRatio, 2));
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }
}
