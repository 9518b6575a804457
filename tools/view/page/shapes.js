// Geometries, each made once, and the parts of bodies as instances of them.
import { BoxGeometry, BufferAttribute, BufferGeometry, Color, ConeGeometry, CylinderGeometry, DoubleSide, InstancedBufferAttribute, InstancedMesh, Matrix4, MeshLambertMaterial, SphereGeometry } from 'three';
import { Poses } from './motion.js';

const kManyBalls = 1000; // above this, spheres are drawn with fewer triangles

// The engine's shapes have z as their axis, three.js's have y.
const upright = (geometry) => geometry.rotateX(Math.PI / 2);

const kUnit = {
  box: () => new BoxGeometry(2, 2, 2),
  sphere: () => upright(new SphereGeometry(1, 28, 18)),
  ball: () => upright(new SphereGeometry(1, 12, 8)), // of a cloud, which has thousands
  cylinder: () => upright(new CylinderGeometry(1, 1, 2, 32)),
  tube: () => upright(new CylinderGeometry(1, 1, 2, 32, 1, true)),
  cone: () => upright(new ConeGeometry(1, 2, 32)),
};

// What a part is drawn with: [geometry, scale, shift along z] each.
function pieces(kind, [x, y, z], mesh) {
  switch (kind) {
    case 'sphere': return [['sphere', [x, x, x], 0]];
    case 'ellipsoid': return [['sphere', [x, y, z], 0]];
    case 'box': return [['box', [x, y, z], 0]];
    case 'cylinder': return [['cylinder', [x, x, y], 0]];
    case 'cone': return [['cone', [x, x, y], 0]];
    case 'capsule': return [['tube', [x, x, y], 0], ['sphere', [x, x, x], y], ['sphere', [x, x, x], -y]];
    case 'half-space': return [];
    default: return [[mesh, [1, 1, 1], 0]];
  }
}

// Faces of two bodies in one plane would flicker. So what has a higher rank is drawn a little farther away from the camera, along each ray, where it
// covers the same pixels: by a share of the distance, for faces that are seen edgewise, and by some steps of the depth buffer, for what is far away.
export const kRanks = { robot: 0, deforming: 2, world: 3, worlds: 24, plane: 28, swept: 60, ghost: 120 };
const kStep = 4e-5; // of the distance, a rank

export function setRank(material, rank = null) {
  material.onBeforeCompile = (shader) => {
    const value = rank === null ? 'rank' : rank.toFixed(1);
    shader.vertexShader = (rank === null ? 'attribute float rank;\n' : '') + shader.vertexShader.replace('#include <project_vertex>',
      `#include <project_vertex>\nmvPosition.xyz *= 1.0 + ${kStep} * ${value};\ngl_Position = projectionMatrix * mvPosition;\ngl_Position.z += 8e-7 * ${value} * gl_Position.w;`);
  };
  material.customProgramCacheKey = () => `rank ${rank}`;
}

export class Parts {
  constructor(page, parts = page.document.parts) {
    const { document: data, array } = page;
    this.count = parts.count;
    this.body = array(parts.body);
    this.mesh = array(parts.mesh);
    this.kind = Array.from(array(parts.kind), (k) => data.kinds[k]);
    this.size = array(parts.size);
    this.ball = array(parts.ball);
    this.poses = new Poses(array(parts.pose));
    this.names = new Map(parts.names);
    this.page = page;
    this.hidden = new Set(); // bodies that are not drawn
    this.geometries = new Map();
  }
  sizeOf(i) {
    return [this.size[i], this.size[this.count + i], this.size[2 * this.count + i]];
  }
  ballOf(i) {
    return [0, 1, 2, 3].map((k) => this.ball[k * this.count + i]);
  }
  matrixOf(i) {
    return this.poses.matrix(i, new Matrix4());
  }

  geometry(key) {
    if (!this.geometries.has(key)) this.geometries.set(key, typeof key === 'string' ? kUnit[key]() : this.meshGeometry(key));
    return this.geometries.get(key);
  }
  meshGeometry(index) {
    const mesh = this.page.document.meshes[index];
    return meshGeometry(positions(this.page.array(mesh.vertices), mesh.low, mesh.step), this.page.array(mesh.triangles));
  }

  // The geometries of parts, one by one, in the frame of their body.
  drawn(list) {
    return this.instances(list, () => '#fff').flatMap((i) => i.entries.map(({ local }) => ({ geometry: i.mesh.geometry, local })));
  }
  // The parts of a list as instances: [{geometry key, part, local matrix in the frame of the part's body}].
  instances(list, colourOf, options) {
    const byGeometry = new Map();
    const scale = new Matrix4();
    const shift = new Matrix4();
    for (const part of list) {
      for (const [key, size, z] of pieces(this.kind[part], this.sizeOf(part), this.mesh[part])) {
        const local = this.matrixOf(part).multiply(shift.makeTranslation(0, 0, z)).multiply(scale.makeScale(...size.map((s) => Math.max(s, 1e-6))));
        if (!byGeometry.has(key)) byGeometry.set(key, []);
        byGeometry.get(key).push({ part, local });
      }
    }
    return [...byGeometry].map(([key, entries]) => new Instances(this, key === 'sphere' && entries.length > kManyBalls ? 'ball' : key, entries, colourOf, options));
  }
}

// All instances of one geometry in a group of parts.
class Instances {
  constructor(parts, key, entries, colourOf, { opacity = 1, rankOf = () => 0, always = false } = {}) {
    this.parts = parts;
    this.always = always; // also bodies that are hidden
    this.entries = entries;
    this.colourOf = colourOf;
    const material = new MeshLambertMaterial({ flatShading: typeof key !== 'string', side: typeof key === 'string' ? 0 : DoubleSide });
    material.transparent = opacity < 1;
    material.opacity = opacity;
    material.depthWrite = opacity >= 1;
    setRank(material);
    // The numbers of the geometry are shared, the ranks are not.
    const geometry = new BufferGeometry();
    const shared = parts.geometry(key);
    geometry.setIndex(shared.index);
    for (const [name, attribute] of Object.entries(shared.attributes)) geometry.setAttribute(name, attribute);
    geometry.setAttribute('rank', new InstancedBufferAttribute(Float32Array.from(entries, ({ part }) => rankOf(part)), 1));
    this.mesh = new InstancedMesh(geometry, material, entries.length);
    this.mesh.frustumCulled = false;
    this.mesh.userData.instances = this;
    this.place(new Map());
    this.paint();
  }
  place(matrices) {
    const [world, nowhere] = [new Matrix4(), new Matrix4().makeScale(0, 0, 0)];
    this.entries.forEach(({ part, local }, i) => {
      const body = matrices.get(this.parts.body[part]);
      this.mesh.setMatrixAt(i, !this.always && this.parts.hidden.has(this.parts.body[part]) ? nowhere : body ? world.multiplyMatrices(body, local) : local);
    });
    this.mesh.instanceMatrix.needsUpdate = true;
    this.mesh.boundingSphere = null;
  }
  paint() {
    const colour = new Color();
    this.entries.forEach(({ part }, i) => this.mesh.setColorAt(i, colour.set(this.colourOf(part))));
    this.mesh.instanceColor.needsUpdate = true;
  }
}

export function positions(numbers, low, step) {
  const all = new Float32Array(numbers.length);
  for (let i = 0; i < numbers.length; ++i) all[i] = low[i % 3] + step * numbers[i];
  return all;
}

export function meshGeometry(vertices, triangles) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(vertices, 3));
  geometry.setIndex(new BufferAttribute(triangles, 1));
  return geometry;
}
