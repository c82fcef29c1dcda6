// Solves a compiled arm's poses as a user of the npm module does: node answers.mjs MODULE ARM.json < input > output.
// Input: m and whether redundancy parameters are given, as doubles; T (m, 16); the parameters (m, p). Output: a line of
// JSON, then q (m, columns, joints), NaN where there is no solution; of the first solution its pose (m, 16); and as
// bytes 1 for a solution or 3 for a singular one (m, columns), and the status (m).
import {readFileSync, writeSync} from 'node:fs';
import {pathToFileURL} from 'node:url';

const [module, file] = process.argv.slice(2);
const {load} = await import(pathToFileURL(module));
const arm = await load(pathToFileURL(file));
const given = readFileSync(0), input = new Float64Array(given.buffer.slice(given.byteOffset, given.byteOffset + given.length));
const [m, free] = input, n = arm.joints.length, B = arm.branches.length, p = arm.parameters.length;
const q = new Float64Array(m * B * n).fill(NaN), poses = new Float64Array(16 * m).fill(NaN);
const info = new Uint8Array(m * B), status = new Uint8Array(m);
const WORDS = ['complete', 'incomplete', 'clustered', 'continuum'];
const names = new Set();
for (let i = 0; i < m; ++i) {
  const values = free ? input.subarray(2 + 16 * m + p * i, 2 + 16 * m + p * (i + 1)) : undefined;
  const answer = arm.ik(input.subarray(2 + 16 * i, 18 + 16 * i), {redundancy: values});
  status[i] = WORDS.indexOf(answer.status);
  for (const each of answer.solutions) {
    q.set(each.q, (i * B + each.column) * n);
    info[i * B + each.column] = each.singular ? 3 : 1;
    if (each.branch !== arm.branches[each.column]) throw new Error('a branch has two names');
    names.add(each.branch);
  }
  if (answer.solutions.length) poses.set(arm.fk(answer.solutions[0].q), 16 * i);
}
const write = data => { for (let at = 0; at < data.length;) at += writeSync(1, data, at); };
write(Buffer.from(JSON.stringify({branches: arm.branches, joints: arm.joints.map(each => each.name)}) + '\n'));
for (const each of [q, poses, info, status]) write(new Uint8Array(each.buffer));
