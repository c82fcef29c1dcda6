// Every solution of an arm that `urdf-ik compile` wrote, by the solvers of urdf-ik as WebAssembly. The types, units and
// errors are in urdf_ik.d.ts.

const STATUS = ['complete', 'incomplete', 'clustered', 'continuum'];
const FORMAT = 'urdf-ik compiled arm', VERSION = 1, AGAIN = 'urdf-ik compile writes one';
const compiled = new Map();

export async function load(source, {wasm = new URL('urdf_ik.wasm', import.meta.url)} = {}) {
  const text = await textOf(source);
  return new Arm(text, document_(text), await instance(wasm));
}

class Arm {
  #wasm; #handle; #at;

  constructor(text, data, wasm) {
    this.#wasm = wasm;
    const bytes = new TextEncoder().encode(text), at = wasm.malloc(bytes.length);
    new Uint8Array(wasm.memory.buffer, at, bytes.length).set(bytes);
    this.#handle = wasm.urdf_ik_parse(at, bytes.length, 0, 0);
    wasm.free(at);
    const {name, base, tip, family, branches, urdf} = data;
    const joints = data.joints.map(numbered), parameters = data.parameters.map(numbered);
    Object.assign(this, {name, base, tip, family, joints, branches, parameters, urdfSha256: urdf.sha256});
    const n = joints.length, B = branches.length;
    const take = count => wasm.malloc(8 * count);
    this.#at = {T: take(16), q: take(n * B), flags: take(B), near: take(n), free: take(parameters.length), J: take(6 * n)};
    Object.freeze(this);
  }

  ik(T, {near, redundancy} = {}) {
    const wasm = this.#wasm, at = this.#at, n = this.joints.length, B = this.branches.length;
    this.#put(at.T, pose(T), 16, 'T');
    if (near !== undefined) this.#put(at.near, near, n, 'near');
    if (redundancy !== undefined) this.#put(at.free, list(redundancy), this.parameters.length, 'redundancy');
    const bad = wasm.urdf_ik_solve(this.#handle, at.T, 1, at.q, at.flags, near === undefined ? 0 : at.near,
      redundancy === undefined ? 0 : at.free);
    if (bad >= 0) throw new RangeError('T is no pose: its rotation is not orthonormal, or its last row is not 0 0 0 1');
    const flags = new Uint8Array(wasm.memory.buffer, at.flags, B), q = this.#seen(at.q, n * B), solutions = [];
    for (let c = 0; c < B; ++c) {
      if (!(flags[c] & 1)) continue;
      solutions.push({q: Array.from(q.subarray(c * n, (c + 1) * n)), branch: this.branches[c], column: c, singular: (flags[c] & 30) !== 0});
    }
    return {status: STATUS[flags[0] >> 5 & 3], solutions};
  }

  fk(q) {
    this.#put(this.#at.near, q, this.joints.length, 'q');
    this.#wasm.urdf_ik_fk(this.#handle, this.#at.near, 1, this.#at.T);
    return Array.from(this.#seen(this.#at.T, 16));
  }

  jacobian(q) {
    const n = this.joints.length;
    this.#put(this.#at.near, q, n, 'q');
    this.#wasm.urdf_ik_jacobian(this.#handle, this.#at.near, 1, this.#at.J);
    return Array.from(this.#seen(this.#at.J, 6 * n));
  }

  redundancyOf(q, T = this.fk(q)) {
    this.#put(this.#at.near, q, this.joints.length, 'q');
    this.#put(this.#at.T, pose(T), 16, 'T');
    this.#wasm.urdf_ik_redundancy_of(this.#handle, this.#at.near, this.#at.T, this.#at.free);
    return Array.from(this.#seen(this.#at.free, this.parameters.length));
  }

  turns(q, most = 64) {
    const n = this.joints.length, wasm = this.#wasm;
    if (!(Number.isInteger(most) && most >= 0 && most <= 1e6)) throw new RangeError(`most = ${most}: an integer from 0 to 1000000 is needed`);
    this.#put(this.#at.near, q, n, 'q');
    const images = wasm.malloc(8 * n * most);
    const count = Math.min(most, wasm.urdf_ik_turns(this.#handle, this.#at.near, images, most));
    const found = Array.from({length: count}, (_, i) => Array.from(this.#seen(images + 8 * n * i, n)));
    wasm.free(images);
    return found;
  }

  compiledFrom(urdf) {
    const wasm = this.#wasm, bytes = typeof urdf === 'string' ? new TextEncoder().encode(urdf) : new Uint8Array(urdf);
    const at = wasm.malloc(bytes.length);
    new Uint8Array(wasm.memory.buffer, at, bytes.length).set(bytes);
    const same = wasm.urdf_ik_compiled_from(this.#handle, at, bytes.length) === 1;
    wasm.free(at);
    return same;
  }

  // The memory may have grown, so views are made for each call.
  #seen(at, count) { return new Float64Array(this.#wasm.memory.buffer, at, count); }

  #put(at, numbers, count, name) {
    if (numbers?.length !== count) throw new TypeError(`${name}: ${numbers?.length ?? typeof numbers} given, ${count} numbers are needed`);
    const to = this.#seen(at, count);
    for (let i = 0; i < count; ++i) {
      if (typeof numbers[i] !== 'number' || !Number.isFinite(numbers[i])) throw new TypeError(`${name}[${i}] is ${numbers[i]}: a finite number is needed`);
      to[i] = numbers[i];
    }
  }
}

const list = values => typeof values === 'number' ? [values] : values;
const pose = T => T?.length === 4 ? Array.from(T).flatMap(row => Array.from(row)) : T;
// JSON has no infinities: words stand for them.
const INFINITE = {inf: Infinity, '-inf': -Infinity};
const numbered = group => Object.fromEntries(Object.entries(group).map(([key, value]) => [key, INFINITE[value] ?? value]));

// The text of a URL's file, of a JSON text, or of a value that was read from one.
async function textOf(source) {
  if (source instanceof URL) {
    const answer = source.protocol === 'file:' && isNode() ? null : await fetch(source);
    if (answer && !answer.ok) throw new Error(`${source}: ${answer.status} ${answer.statusText}`);
    return answer ? answer.text() : (await import('node:fs/promises')).readFile(source, 'utf8');
  }
  return typeof source === 'string' ? source : JSON.stringify(source);
}

function document_(text) {
  let data;
  try {
    data = JSON.parse(text);
  } catch (error) {
    throw new Error(`no compiled arm: ${error.message}; ${AGAIN}`);
  }
  if (data?.format !== FORMAT) throw new Error(`no compiled arm: it has no "format": "${FORMAT}"; ${AGAIN}`);
  if (data.version !== VERSION) {
    throw new Error(`a compiled arm of version ${data.version}; this module reads version ${VERSION}; ${AGAIN} anew`);
  }
  return data;
}

const isNode = () => typeof process !== 'undefined' && process.versions?.node !== undefined;

// An instance of its own for each arm: what an arm that is refused leaves behind goes with it.
async function instance(wasm) {
  let module = wasm instanceof WebAssembly.Module ? wasm : compiled.get(String(wasm));
  if (!module) {
    module = await WebAssembly.compile(await bytesOf(wasm));
    if (wasm instanceof URL) compiled.set(String(wasm), module);
  }
  const refuse = at => {
    const bytes = new Uint8Array(exports.memory.buffer, at);
    throw new Error(`a damaged compiled arm: ${new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)))}; ${AGAIN}`);
  };
  // What the C library asks of its system: there is no environment, and nothing else is there but an end.
  const none = (...places) => {
    places.forEach(at => new DataView(exports.memory.buffer).setUint32(at, 0, true));
    return 0;
  };
  const end = () => { throw new Error('the solvers ran out of memory'); };
  const imports = WebAssembly.Module.imports(module).filter(each => each.module !== 'urdf_ik');
  const system = Object.fromEntries(imports.map(({name}) => [name, name === 'environ_sizes_get' ? none : end]));
  const {exports} = await WebAssembly.instantiate(module, {urdf_ik: {refuse}, wasi_snapshot_preview1: system});
  exports._initialize?.();
  return exports;
}

async function bytesOf(wasm) {
  if (!(wasm instanceof URL)) return wasm;
  if (wasm.protocol === 'file:' && isNode()) return (await import('node:fs/promises')).readFile(wasm);
  const answer = await fetch(wasm);
  if (!answer.ok) throw new Error(`${wasm}: ${answer.status} ${answer.statusText}`);
  return answer.arrayBuffer();
}
