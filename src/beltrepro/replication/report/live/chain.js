// The chain on the belt by the scheme of the paper's Appendix, step for step. Model units.
//
// Places are kept in the frame of the belt: there a stuck block has exactly no velocity. With the
// slip step w(t) = x(t) - x(t-dt) - u dt the printed formulas read
//     w(t+dt) = w(t) + a(t) dt^2,          x(t+dt) = x(t) + u dt + w(t+dt)
//     v_r(t+dt) dt = w(t+dt) + 5/6 a(t) dt^2 - 1/3 a(t-dt) dt^2
const DT = 0.001, DT2 = DT * DT;
const REBASE = 4096; // steps after which places on the belt are counted anew, to keep their digits

// Pull of a spring (Sec. III): linear, and exponential beyond the limit.
function pull(deformation, law) {
  const limit = law.linear_limit;
  if (deformation > limit) {
    return limit + Math.expm1(law.extension_rate * (deformation - limit)) / law.extension_rate;
  }
  if (deformation < -limit) {
    return -limit - Math.expm1(law.compression_rate * (-limit - deformation)) / law.compression_rate;
  }
  return deformation;
}

// Length of the chain at which its springs balance the kinetic friction of all blocks.
function balanceLength(blocks, ratio, law) {
  let length = 0;
  for (let count = 1; count <= blocks; count++) {
    const tension = count * ratio * law.static_friction, excess = tension - law.linear_limit;
    length += law.rest_length + (excess <= 0 ? tension
      : law.linear_limit + Math.log1p(law.extension_rate * excess) / law.extension_rate);
  }
  return length;
}

// Position of x_N at which v_N is noted when x_N falls through it: in all chains the same share of
// the balance length as in the paper's chain, to a digit.
function sectionPosition(blocks, ratio, law) {
  const share = law.section / balanceLength(law.section_chain.blocks, law.section_chain.ratio, law);
  return Math.round(10 * share * balanceLength(blocks, ratio, law)) / 10;
}

// Normal deviates: xoshiro128** by D. Blackman and S. Vigna, and the method of Box and Muller.
class Normals {
  constructor(seed) {
    let word = seed >>> 0;
    this.state = Uint32Array.from({ length: 4 }, () => { // splitmix32
      word = (word + 0x9e3779b9) >>> 0;
      let mixed = Math.imul(word ^ (word >>> 16), 0x21f0aaad);
      mixed = Math.imul(mixed ^ (mixed >>> 15), 0x735a2d97);
      return mixed ^ (mixed >>> 15);
    });
    this.kept = NaN;
  }

  uniform() { // in (0, 1], by 32 bits
    const s = this.state, turned = Math.imul(s[1], 5);
    const word = Math.imul((turned << 7) | (turned >>> 25), 9) >>> 0, shifted = s[1] << 9;
    s[2] ^= s[0];
    s[3] ^= s[1];
    s[1] ^= s[2];
    s[0] ^= s[3];
    s[2] ^= shifted;
    s[3] = (s[3] << 11) | (s[3] >>> 21);
    return (word + 1) / 4294967296;
  }

  next() {
    if (this.kept === this.kept) {
      const second = this.kept;
      this.kept = NaN;
      return second;
    }
    const length = Math.sqrt(-2 * Math.log(this.uniform())), angle = 2 * Math.PI * this.uniform();
    this.kept = length * Math.sin(angle);
    return length * Math.cos(angle);
  }
}

class Chain {
  // setup: blocks, velocity (of the belt), noise, ratio (f_s); start: positions and velocities of
  // the blocks, if they are not at rest on the belt; seed: of the noise.
  constructor(setup, law, start = {}, seed = 1) {
    const count = setup.blocks, zeros = () => new Float64Array(count);
    Object.assign(this, { count, law, setup: { ...setup }, normals: new Normals(seed), base: 0, steps: 0 });
    this.place = Float64Array.from({ length: count }, (_, i) =>
      start.positions ? start.positions[i] : (i + 1) * law.rest_length); // x - u (t - base)
    [this.slip, this.velocity, this.before, this.direction, this.tension] =
      [zeros(), zeros(), zeros(), zeros(), new Float64Array(count + 1)]; // w, v_r dt, a(t-dt) dt^2
    this.threshold = Float64Array.from({ length: count }, () => this.drawn(this.deviate()));
    if (start.velocities) this.launch(start.velocities);
  }

  get time() { return this.steps * DT; }

  x(i) { return this.place[i] + this.setup.velocity * (this.steps - this.base) * DT; }

  positions() { return Array.from(this.place, (_, i) => this.x(i)); }

  // Velocity in the laboratory.
  v(i) { return this.setup.velocity + this.velocity[i] / DT; }

  deviate() { return this.setup.noise ? this.normals.next() : 0; }

  drawn(normal) { return this.law.static_friction + this.setup.noise * normal; }

  // Pulls of all springs, if each block has gone on by `share` steps with the velocities given.
  stretch(velocities, share = 0) {
    const travel = (i) => (velocities ? share * velocities[i] * DT : 0);
    let left = 0;
    for (let i = 0; i < this.count; i++) {
      const here = this.x(i) + travel(i);
      this.tension[i] = pull(here - left - this.law.rest_length, this.law);
      left = here;
    }
  }

  force(i) { return this.tension[i + 1] - this.tension[i]; }

  // Blocks in motion: w and a(t-dt) of the smooth motion through the state, to third order in dt.
  launch(velocities) {
    const forces = (share) => {
      this.stretch(velocities, share);
      return Array.from(velocities, (_, i) => this.force(i));
    };
    const [behind, now, ahead] = [-1, 0, 1].map(forces);
    for (let i = 0; i < this.count; i++) {
      const relative = velocities[i] - this.setup.velocity;
      if (relative === 0 && Math.abs(now[i]) <= this.threshold[i]) continue;
      this.direction[i] = Math.sign(relative || now[i]);
      this.velocity[i] = relative * DT;
      const a = now[i] - this.direction[i] * this.setup.ratio * this.law.static_friction;
      const rise = (ahead[i] - behind[i]) / 2;
      this.slip[i] = relative * DT + (rise / 6 - a / 2) * DT2;
      this.before[i] = (a - rise) * DT2;
    }
  }

  // One time step: forces, stick and slip, motion.
  step() {
    const { velocity: u, ratio } = this.setup;
    this.stretch();
    for (let i = 0; i < this.count; i++) {
      const force = this.force(i), normal = this.deviate();
      this.turn(i, force, normal);
      const direction = this.direction[i];
      if (direction) {
        const a = (force - direction * ratio * this.drawn(normal)) * DT2;
        this.slip[i] += a;
        this.velocity[i] = this.slip[i] + 5 / 6 * a - this.before[i] / 3;
        this.before[i] = a;
        this.place[i] += this.slip[i];
      }
    }
    this.steps++;
    if (this.steps - this.base === REBASE) {
      for (let i = 0; i < this.count; i++) this.place[i] += u * REBASE * DT;
      this.base = this.steps;
    }
  }

  // The rules of stick and slip. A stuck block keeps the threshold that it drew when it stuck.
  turn(i, force, normal) {
    const old = this.direction[i];
    if (old * this.velocity[i] > 0) return;
    const threshold = old ? this.drawn(normal) : this.threshold[i];
    const next = Math.abs(force) > threshold ? (force < 0 ? -1 : 1) : 0;
    if (next === old) return;
    this.direction[i] = next;
    this.threshold[i] = threshold;
    if (!old || !next) this.slip[i] = this.before[i] = this.velocity[i] = 0;
  }

  advance(steps) {
    for (; steps > 0; steps--) this.step();
  }
}

// Mean and standard deviation of x_N in one pass (B. P. Welford, Technometrics 4, 419, 1962), and
// r, their ratio.
class Spread {
  constructor() { this.count = this.mean = this.squares = 0; }

  add(value) {
    const off = value - this.mean;
    this.mean += off / ++this.count;
    this.squares += off * (value - this.mean);
  }

  get r() { return this.count > 1 ? Math.sqrt(this.squares / this.count) / this.mean : NaN; }
}

// What is kept of a chain in motion: samples of x_N, r after the transient, and v_N whenever x_N
// falls through the section.
class Record {
  constructor(chain, { every = 100, room = 8192, points = 4000 } = {}) {
    const { blocks, velocity, ratio } = chain.setup, balance = balanceLength(blocks, ratio, chain.law);
    Object.assign(this, { chain, every, room, points, count: 0, section: [], spread: new Spread() });
    this.samples = new Float64Array(room); // a ring
    this.level = sectionPosition(blocks, ratio, chain.law);
    // twice the time in which the belt stretches the chain to its balance, and some
    this.transient = 100 + 2 * (balance - blocks * chain.law.rest_length) / velocity;
  }

  get interval() { return this.every * DT; }

  advance(steps) {
    const { chain, every } = this, last = chain.count - 1;
    let before = chain.x(last);
    for (; steps > 0; steps--) {
      chain.step();
      const after = chain.x(last);
      if (after < this.level && before >= this.level) this.cross((this.level - after) / (before - after));
      if (chain.steps % every === 0) this.sample(after);
      before = after;
    }
  }

  cross(share) { // of the step back
    const { chain } = this, last = chain.count - 1;
    this.section.push(chain.v(last) - share * chain.before[last] / DT);
    if (this.section.length > this.points) this.section.shift();
  }

  sample(value) {
    this.samples[this.count++ % this.room] = value;
    if (this.chain.time > this.transient) this.spread.add(value);
  }

  // The last samples, the oldest first, at most so many.
  latest(most = this.room) {
    const size = Math.min(most, this.count, this.room);
    return Float64Array.from({ length: size }, (_, i) => this.samples[(this.count - size + i) % this.room]);
  }
}

// Amplitudes 2 |X| / n of samples less their mean, n a power of 2; without that of frequency 0.
function amplitudes(samples) {
  const n = samples.length, mean = samples.reduce((sum, value) => sum + value, 0) / n;
  const re = new Float64Array(n), im = new Float64Array(n);
  for (let i = 0, turned = 0; i < n; i++) { // in the order of reversed bits
    re[turned] = samples[i] - mean;
    let bit = n >> 1;
    for (; turned & bit; bit >>= 1) turned ^= bit;
    turned ^= bit;
  }
  for (let half = 1; half < n; half *= 2) {
    for (let k = 0; k < half; k++) {
      const angle = -Math.PI * k / half, c = Math.cos(angle), s = Math.sin(angle);
      for (let i = k; i < n; i += 2 * half) {
        const j = i + half, real = c * re[j] - s * im[j], other = s * re[j] + c * im[j];
        re[j] = re[i] - real;
        im[j] = im[i] - other;
        re[i] += real;
        im[i] += other;
      }
    }
  }
  return Float64Array.from({ length: n / 2 - 1 }, (_, k) => 2 * Math.hypot(re[k + 1], im[k + 1]) / n);
}

if (typeof module !== "undefined") {
  module.exports = { Chain, Record, Spread, amplitudes, balanceLength, pull, sectionPosition, DT };
}
