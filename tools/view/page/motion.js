// Where bodies are at a time. Poses are known at moments; between two of them positions are linear and orientations turn evenly.
import { Matrix4, Quaternion, Vector3 } from 'three';

const one = new Vector3(1, 1, 1);

// Poses in columns: x y z qx qy qz qw, `count` numbers each.
export class Poses {
  constructor(numbers) {
    this.numbers = numbers;
    this.count = numbers.length / 7;
  }
  position(i, to) {
    const { numbers: n, count: c } = this;
    return to.set(n[i], n[c + i], n[2 * c + i]);
  }
  rotation(i, to) {
    const { numbers: n, count: c } = this;
    return to.set(n[3 * c + i], n[4 * c + i], n[5 * c + i], n[6 * c + i]).normalize();
  }
  matrix(i, to) {
    return to.compose(this.position(i, new Vector3()), this.rotation(i, new Quaternion()), one);
  }
  // Between poses i and k, at a share of the way.
  blend(i, k, share, to) {
    const p = this.position(i, new Vector3());
    const q = this.rotation(i, new Quaternion());
    if (share > 0) {
      p.lerp(this.position(k, new Vector3()), share);
      q.slerp(this.rotation(k, new Quaternion()), share);
    }
    return to.compose(p, q, one);
  }
}

export class Motion {
  constructor(page) {
    const { document: data, array } = page;
    this.times = data.times;
    this.poses = new Poses(array(data.poses));
    this.bodies = data.moving;
    this.duration = this.times[this.times.length - 1] - this.times[0];
    this.begin = this.times[0];
    // Of each moving body, now; a body that stands is where its parts say.
    this.matrices = new Map(this.bodies.map((body) => [body, new Matrix4()]));
    this.setTime(this.begin);
  }

  // The last moment at or before a time.
  momentBefore(time) {
    let low = 0;
    let high = this.times.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.times[middle] <= time) low = middle;
      else high = middle - 1;
    }
    return low;
  }
  momentNear(time) {
    const before = this.momentBefore(time);
    if (before + 1 >= this.times.length) return before;
    return time - this.times[before] <= this.times[before + 1] - time ? before : before + 1;
  }

  // The moments around a time, and the share of the way from one to the other.
  around(time) {
    const before = this.momentBefore(time);
    const after = Math.min(before + 1, this.times.length - 1);
    const span = this.times[after] - this.times[before];
    return { before, after, share: span > 0 ? Math.min((time - this.times[before]) / span, 1) : 0 };
  }
  setTime(time) {
    this.time = time;
    const { before, after, share } = this.around(time);
    this.bodies.forEach((body, k) => this.poses.blend(before * this.bodies.length + k, after * this.bodies.length + k, share, this.matrices.get(body)));
  }


  // Of the moving bodies at one moment.
  matricesAt(moment) {
    return new Map(this.bodies.map((body, k) => [body, this.poses.matrix(moment * this.bodies.length + k, new Matrix4())]));
  }

  // A point given in a body's frame (of what stands: in the world), in the world.
  toWorld(body, point, matrices = this.matrices) {
    const p = new Vector3(...point);
    const matrix = matrices.get(body);
    return matrix ? p.applyMatrix4(matrix) : p;
  }
}
