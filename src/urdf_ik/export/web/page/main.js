// Starts the page: the arm of its data, the picture and the panel, and what ties them together.
import {load} from '../urdf_ik.js';
import {Panel} from './panel.js';
import {State} from './state.js';
import {fromHash, poseOf} from './text.js';
import {View} from './view.js';

const data = name => document.getElementById(`urdf-ik-${name}`).textContent;

async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text.trim()), c => c.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip')));
}

async function start() {
  const wasm = await (await unpacked(data('wasm'))).arrayBuffer();
  const arm = await load(data('arm'), {wasm});
  const scene = await (await unpacked(data('scene'))).json();
  const {colours} = scene, page = document.getElementById('urdf-ik');
  const inside = element => page.appendChild(Object.assign(document.createElement('div'), {id: element}));
  const picture = inside('picture'), place = inside('panel');

  const attempt = (does, what) => {
    try {
      does();
      panel.tell('');
    } catch (error) {
      panel.tell(`${what}: ${error.message}`);
    }
  };
  const panel = new Panel(place, arm, colours, {
    moveJoint: (j, value) => state.moveJoints(state.q.with(j, value)),
    setRedundancy: (k, value) => state.setRedundancy(k, value),
    choose: column => state.choose(column),
    typed: text => attempt(() => state.moveTarget(poseOf(text)), 'no pose'),
    mode: name => view.handles.setMode(name),
  });
  const view = new View(picture, scene, colours, T => attempt(() => state.moveTarget(T, 'handles'), 'no pose'));
  const state = new State(arm, scene.start, () => {});
  const show = (shown, what) => {
    view.show(shown.q, shown.solutions.filter(each => each.column !== shown.chosen), what === 'handles' ? null : shown.T);
    panel.show(shown);
  };
  state.changed = show;
  const follow = () => attempt(() => {
    const found = fromHash(location.hash, arm.joints.length, arm.parameters.length);
    if (found?.q) state.moveJoints(found.q);
    if (found?.r) state.redundancy = found.r;
    // Where the arm stands at the target, its joint vector keeps its digits.
    if (found?.T?.some((value, i) => Math.abs(value - state.T[i]) > 1e-9)) state.moveTarget([...found.T, 0, 0, 0, 1]);
  }, 'the link');
  show(state);
  follow();
  addEventListener('hashchange', follow);
  addEventListener('dragover', event => event.preventDefault());
  addEventListener('drop', event => dropped(event, arm, panel));
  globalThis.urdfIk = {arm, state, view};
  document.documentElement.dataset.ready = String(performance.now());
}

// A URDF that is dropped onto the page: whether it is the one that the page was made from.
async function dropped(event, arm, panel) {
  event.preventDefault();
  const file = event.dataTransfer?.files[0];
  if (!file) return;
  const same = arm.compiledFrom(await file.arrayBuffer());
  panel.tell(same ? `${file.name} is the URDF that this page was made from`
    : `${file.name} is not the URDF that this page was made from: urdf-ik export --html writes the page anew`);
}

start().catch(error => {
  document.getElementById('urdf-ik').replaceChildren(
    Object.assign(document.createElement('p'), {id: 'refused', textContent: `This page cannot be shown: ${error.message}`}));
});
