// Obstacles that deform: vertices at frames, linear between two of them.
import { BufferAttribute, DoubleSide, Matrix4, Mesh, MeshLambertMaterial } from 'three';
import { Poses } from './motion.js';
import { kRanks, meshGeometry, setRank } from './shapes.js';

export class Deforming {
  constructor(page, frames) {
    this.body = frames.body;
    this.times = frames.times;
    this.low = frames.low;
    this.step = frames.step;
    this.numbers = page.array(frames.positions);
    this.size = this.numbers.length / this.times.length;
    this.vertices = new Float32Array(this.size);
    const geometry = meshGeometry(this.vertices, page.array(frames.triangles));
    this.attribute = geometry.getAttribute('position');
    this.mesh = new Mesh(geometry, new MeshLambertMaterial({ flatShading: true, side: DoubleSide }));
    setRank(this.mesh.material, kRanks.deforming);
    this.mesh.frustumCulled = false;
    this.mesh.matrixAutoUpdate = false;
    this.mesh.matrix.copy(new Poses(page.array(frames.pose)).matrix(0, new Matrix4()));
    this.mesh.userData.body = this.body;
    this.setTime(this.times[0]);
  }
  setTime(time) {
    let after = this.times.findIndex((t) => t >= time);
    if (after < 0) after = this.times.length - 1;
    const before = Math.max(after - 1, 0);
    const span = this.times[after] - this.times[before];
    const share = span > 0 ? Math.max((time - this.times[before]) / span, 0) : 0;
    for (let i = 0; i < this.size; ++i) {
      const a = this.numbers[before * this.size + i];
      const b = this.numbers[after * this.size + i];
      this.vertices[i] = this.low[i % 3] + this.step * (a + share * (b - a));
    }
    this.attribute.needsUpdate = true;
    this.mesh.geometry.boundingSphere = null;
  }
}
