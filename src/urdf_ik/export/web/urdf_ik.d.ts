/** Lengths are m, angles rad, joint vectors base to tip, poses 4x4 of the tip link in the base link, row by row. */

export interface Joint {
  name: string;
  type: 'revolute' | 'continuous' | 'prismatic';
  /** Limits; infinite where there are none. */
  lower: number;
  upper: number;
  /** Greatest speed by the URDF; infinite where it gives none. */
  velocity: number;
  /** How far the images of a value are apart; 0: it has none. */
  turn: number;
}

/** A redundancy parameter: what a pose leaves free. */
export interface Parameter {
  kind: 'swivel' | 'locked joint' | 'free axis';
  name: string;
  unit: string;
  lower: number;
  upper: number;
  default: number;
}

export interface Solution {
  /** Joint vector; angles are in (-pi, pi]. */
  q: number[];
  /** The name of its branch. */
  branch: string;
  /** Its place among `Arm.branches`. */
  column: number;
  singular: boolean;
}

/**
 * complete: every solution is there, once. clustered: every solution is counted, and some that are nearer to each other
 * than rounding stand as one. continuum: a curve of solutions keeps the pose, and representatives of it are there.
 * incomplete: solutions may be missing.
 */
export type Status = 'complete' | 'clustered' | 'continuum' | 'incomplete';

export interface Answer {
  status: Status;
  solutions: Solution[];
}

type Numbers = ArrayLike<number>;
/** Sixteen numbers row by row, or four rows. */
export type Pose = Numbers | readonly Numbers[];

export interface Choices {
  /** On a continuum, free joints take values near this joint vector. */
  near?: Numbers;
  /** Value or values of the redundancy parameters; default: those of the arm. */
  redundancy?: number | Numbers;
}

export class Arm {
  private constructor();
  readonly name: string;
  readonly base: string;
  readonly tip: string;
  readonly family: string;
  readonly joints: readonly Joint[];
  readonly branches: readonly string[];
  readonly parameters: readonly Parameter[];
  /** Of the URDF that it was compiled from. */
  readonly urdfSha256: string;

  /** All solutions of a pose. Throws a TypeError for what is not sixteen numbers, a RangeError for what is no pose. */
  ik(T: Pose, choices?: Choices): Answer;
  /** The pose of a joint vector: sixteen numbers. */
  fk(q: Numbers): number[];
  /** The Jacobian (6, joints) row by row, linear rows above angular ones. */
  jacobian(q: Numbers): number[];
  /** The values of the redundancy parameters for which `ik` gives the joint vector q. */
  redundancyOf(q: Numbers, T?: Pose): number[];
  /** The first `most` images of a joint vector inside the joint limits, whole turns away, fewest turns first. */
  turns(q: Numbers, most?: number): number[][];
  /** Whether the arm was compiled from this text of a URDF. */
  compiledFrom(urdf: string | ArrayBuffer): boolean;
}

export interface Options {
  /** The solvers: a URL, bytes, or a compiled module. Default: urdf_ik.wasm beside this module. */
  wasm?: URL | ArrayBuffer | Uint8Array | WebAssembly.Module;
}

/**
 * The arm of a compiled arm: the URL of its file, its text, or the value that JSON.parse made of it. Throws an Error
 * that says what is wrong in it.
 */
export function load(source: URL | string | object, options?: Options): Promise<Arm>;
