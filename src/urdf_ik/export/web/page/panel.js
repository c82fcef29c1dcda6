// The panel beside the picture: solutions, sliders, the pose as text, what is copied.
import {hashOf, poseText} from './text.js';

const WORDS = {
  complete: 'all solutions', clustered: 'all solutions; some stand so near that they are one',
  continuum: 'a curve of solutions keeps this pose; representatives are shown', incomplete: 'some may be missing',
};

function element(tag, attributes = {}, ...parts) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) made.addEventListener(name.slice(2), value);
    else made.setAttribute(name, value);
  }
  made.append(...parts);
  return made;
}

export class Panel {
  // actions: moveJoint(j, value), setRedundancy(k, value), choose(column), typed(text), mode(name).
  constructor(place, arm, colours, actions) {
    this.arm = arm;
    this.colours = colours;
    this.actions = actions;
    this.count = element('p', {id: 'count', role: 'status'});
    this.list = element('ol', {id: 'solutions'});
    this.error = element('p', {id: 'error', role: 'alert'});
    this.pose = element('input', {id: 'pose', spellcheck: 'false', 'aria-label': 'pose', title:
      'x y z roll pitch yaw [m, rad]; or x y z and a quaternion x y z w; or a matrix by rows', onchange: () => actions.typed(this.pose.value)});
    this.sliders = arm.joints.map((joint, j) => slider(joint.name, ends(joint), joint.type === 'prismatic' ? 'm' : 'rad',
      value => actions.moveJoint(j, value)));
    this.free = arm.parameters.map((each, k) => slider(`${each.kind} ${each.name}`.trim(), ends(each), each.unit,
      value => actions.setRedundancy(k, value)));
    const copied = element('span', {id: 'copied'});
    const copy = (name, text) => element('button', {type: 'button', onclick: async () => {
      copied.textContent = (await toClipboard(text())) ? 'copied' : 'the browser allows no copy';
      setTimeout(() => { copied.textContent = ''; }, 1500);
    }}, name);
    const buttons = [copy('copy q', () => JSON.stringify(this.state.q))];
    // In a notebook's frame the page has no address of its own.
    if (location.protocol !== 'about:') buttons.push(copy('copy link', () => location.href.replace(/#.*/, '') + hashOf(this.state)));
    place.append(
      element('h1', {}, arm.name), element('p', {class: 'small'}, `${arm.base} to ${arm.tip}; ${arm.family}`), this.count, this.list,
      element('h2', {}, 'Target'), element('div', {class: 'row'}, this.pose),
      element('div', {class: 'row'}, ...['translate', 'rotate'].map(mode => element('button', {type: 'button', onclick: () => actions.mode(mode)},
        mode === 'translate' ? 'move' : 'turn')), ...buttons, copied), this.error,
      ...(this.free.length ? [element('h2', {}, 'Free'), ...this.free.map(each => each.line)] : []),
      element('h2', {}, 'Joints'), ...this.sliders.map(each => each.line));
  }

  show(state) {
    this.state = state;
    const {solutions} = state, many = solutions.length;
    this.count.textContent = many ? `${many} solution${many > 1 ? 's' : ''}: ${WORDS[state.status]}`
      : `no solution${state.status === 'complete' ? ': out of reach' : `: ${WORDS[state.status]}`}`;
    this.list.replaceChildren(...solutions.map(each => {
      const marks = [each.singular && 'singular', !each.inside && 'outside limits'].filter(Boolean);
      const dot = element('i', {style: `background:${this.colours[each.column]}`});
      const button = element('button', {type: 'button', 'aria-pressed': each.column === state.chosen, onclick: () => this.actions.choose(each.column)},
        dot, each.branch + (marks.length ? ` (${marks.join(', ')})` : ''));
      return element('li', {}, button);
    }));
    if (document.activeElement !== this.pose) this.pose.value = poseText(state.T);
    this.sliders.forEach((each, j) => each.set(state.q[j]));
    this.free.forEach((each, k) => each.set(state.redundancy[k]));
  }

  tell(text) { this.error.textContent = text; }
}

// Half a turn or a metre to each side where there is no limit.
function ends({lower, upper, type, unit}) {
  const far = type === 'prismatic' || unit === 'm' ? 1 : Math.PI;
  return [Number.isFinite(lower) ? lower : -far, Number.isFinite(upper) ? upper : far];
}

function slider(name, [lower, upper], unit, moved) {
  const shown = element('output', {});
  const input = element('input', {type: 'range', min: lower, max: upper, step: 'any', 'aria-label': name, oninput: () => moved(input.valueAsNumber)});
  const line = element('label', {class: 'slider', title: `${lower.toFixed(4)} to ${upper.toFixed(4)} ${unit}`}, element('span', {}, name), input, shown);
  return {line, set(value) {
    if (document.activeElement !== input || Math.abs(input.valueAsNumber - value) > 1e-9) input.value = value;
    shown.textContent = value.toFixed(3);
    line.classList.toggle('outside', value < lower - 1e-9 || value > upper + 1e-9);
  }};
}

async function toClipboard(text) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    const area = element('textarea', {}, text);
    document.body.append(area);
    area.select();
    const done = document.execCommand('copy');
    area.remove();
    return done;
  }
}
