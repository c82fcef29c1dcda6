// What the page shows: the arm's joint vector, the target and its solutions. It draws nothing.

const close = (a, b) => Math.abs(a - b);

export class State {
  // changed(state, what): after each change; what: 'target' while its handles move it.
  constructor(arm, start, changed) {
    this.arm = arm;
    this.changed = changed;
    this.q = start;
    this.moveJoints(start);
  }

  // The target moves; the arm follows to the nearest solution inside its limits, if there is one.
  moveTarget(T, what) {
    this.#solve(T);
    const found = nearest(this.solutions.filter(each => each.inside), this.q);
    if (found) this.q = found.image;
    this.chosen = found?.column ?? null;
    this.changed(this, what);
  }

  moveJoints(q, what) {
    this.q = Array.from(q);
    const T = this.arm.fk(this.q);
    if (this.arm.parameters.length) this.redundancy = this.arm.redundancyOf(this.q, T);
    this.#solve(T);
    this.chosen = nearest(this.solutions, this.q)?.column ?? null;
    this.changed(this, what);
  }

  setRedundancy(k, value) {
    this.redundancy[k] = value;
    this.moveTarget(this.T, 'redundancy');
  }

  choose(column) {
    const found = this.solutions.find(each => each.column === column);
    this.q = found.image;
    this.chosen = column;
    this.changed(this);
  }

  #solve(T) {
    const {status, solutions} = this.arm.ik(T, {near: this.q, redundancy: this.arm.parameters.length ? this.redundancy : undefined});
    this.T = T;
    this.status = status;
    this.solutions = solutions.map(each => {
      const images = this.arm.turns(each.q);
      const inside = images.length > 0;
      const image = inside ? nearest(images.map(q => ({q, image: q})), this.q).image : each.q;
      return {...each, inside, image};
    });
  }
}

// Of entries with an `image`, that whose image is nearest to q.
function nearest(entries, q) {
  const far = entry => Math.hypot(...entry.image.map((value, j) => close(value, q[j])));
  return entries.reduce((best, each) => (best === null || far(each) < far(best) ? each : best), null);
}
