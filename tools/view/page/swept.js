// The volume that the robot sweeps: its shapes at many moments, drawn as one see-through body.
import { Matrix4 } from 'three';
import { kRanks } from './shapes.js';
import { colours } from './theme.js';

const kTriangles = 1.5e6; // drawn for it, at most
const kLeast = 12; // moments

export class Swept {
  constructor(parts, motion, list) {
    const single = parts.instances(list, () => '#fff', {});
    const triangles = single.reduce((sum, i) => sum + (i.entries.length * (i.mesh.geometry.index ?? i.mesh.geometry.attributes.position).count) / 3, 0);
    const most = Math.max(Math.floor(kTriangles / Math.max(triangles, 1)), kLeast);
    const every = Math.max(Math.ceil(motion.times.length / most), 1);
    this.moments = [];
    for (let m = 0; m < motion.times.length; m += every) this.moments.push(m);
    if (this.moments[this.moments.length - 1] !== motion.times.length - 1) this.moments.push(motion.times.length - 1);
    const matrices = this.moments.map((m) => motion.matricesAt(m));
    // Depths first, colours then: of what lies behind itself, the nearest surface alone is seen.
    this.meshes = [false, true].flatMap((coloured) => list.flatMap((part) => parts.instances(this.moments.map(() => part), () => colours().swept, { opacity: 0.35, rankOf: () => kRanks.swept }).map((i) => {
      const world = new Matrix4();
      const each = i.entries.length / matrices.length; // a capsule has two balls
      i.entries.forEach(({ local }, k) => i.mesh.setMatrixAt(k, world.multiplyMatrices(matrices[Math.floor(k / each)].get(parts.body[part]), local)));
      i.mesh.instanceMatrix.needsUpdate = true;
      i.mesh.material.colorWrite = coloured;
      i.mesh.material.depthWrite = !coloured;
      i.mesh.renderOrder = coloured ? 2 : 1;
      return i.mesh;
    })));
  }
}
