// What is drawn over the bodies: the nearest pair, trails, the way out of a collision, the search, coarse bounds.
import { AxesHelper, BufferAttribute, BufferGeometry, Color, ConeGeometry, CylinderGeometry, EdgesGeometry, Group, InstancedMesh, Line, LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshBasicMaterial, SphereGeometry, Vector3 } from 'three';
import { Poses } from './motion.js';
import { positions } from './shapes.js';
import { colours } from './theme.js';

// A line with a thickness in the world that is the same on the screen, and a ball at each end; drawn over everything.
export class NearestLine {
  constructor(stage) {
    this.stage = stage;
    // A light edge parts it from bodies in collision, which are red, too.
    this.group = new Group();
    const [edge, line] = [colours().edge, colours().nearest].map((color, order) => {
      const material = new MeshBasicMaterial({ color, depthTest: false, transparent: true });
      const tube = new Mesh(new CylinderGeometry(1, 1, 1, 12), material);
      const ends = [0, 1].map(() => new Mesh(new SphereGeometry(1, 16, 12), material));
      [tube, ...ends].forEach((m) => { m.renderOrder = 10 + order; m.frustumCulled = false; });
      this.group.add(tube, ...ends);
      return { material, tube, ends };
    });
    Object.assign(this, line, { edge });
    this.points = null;
  }
  set(a, b) {
    this.points = a ? [a, b] : null;
    this.group.visible = a !== null;
    this.update();
  }
  // Also when the camera has moved.
  update() {
    if (!this.points) return;
    const [a, b] = this.points;
    this.material.color.set(colours().nearest);
    // From near by, thinner than the gap; from afar a mark of where it is.
    const away = this.stage.camera.position.distanceTo(a) * this.stage.spread;
    const gap = a.distanceTo(b);
    const size = gap > 0.03 * away ? Math.min(away * 0.0022, gap * 0.06) : away * 0.0022;
    const along = b.clone().sub(a);
    const length = along.length();
    if (length > 0) along.divideScalar(length);
    else along.set(0, 1, 0);
    for (const [{ tube, ends }, wider] of [[this, 0], [this.edge, 0.7 * size]]) {
      tube.position.addVectors(a, b).multiplyScalar(0.5);
      tube.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), along);
      tube.scale.set(size + wider, length, size + wider);
      [a, b].forEach((p, i) => { ends[i].position.copy(p); ends[i].scale.setScalar(2.6 * size + wider); });
    }
  }
}

// The edges of what the robot holds, seen while it holds it.
export class Outline {
  constructor(parts, body) {
    this.body = body;
    this.group = new Group();
    this.group.matrixAutoUpdate = false;
    const list = [];
    for (let i = 0; i < parts.count; ++i) if (parts.body[i] === body) list.push(i);
    for (const { geometry, local } of parts.drawn(list)) {
      const lines = new LineSegments(new EdgesGeometry(geometry, 35), new LineBasicMaterial({ color: colours().outline }));
      lines.matrixAutoUpdate = false;
      lines.matrix.copy(local);
      lines.frustumCulled = false;
      this.group.add(lines);
    }
  }
  place(matrices, isHeld) {
    this.group.visible = isHeld;
    this.group.children.forEach((lines) => lines.material.color.set(colours().outline));
    if (matrices.has(this.body)) this.group.matrix.copy(matrices.get(this.body));
    this.group.matrixWorldNeedsUpdate = true;
  }
}

export class Trail {
  constructor() {
    this.line = new Line(new BufferGeometry(), new LineBasicMaterial({ color: colours().trail, depthTest: false, transparent: true }));
    this.line.renderOrder = 9;
    this.line.frustumCulled = false;
  }
  // The centre of a body's first part through all moments.
  set(motion, parts, body) {
    const part = parts.body.indexOf(body);
    if (part < 0 || !motion.matrices.has(body)) return;
    const centre = new Vector3(...parts.ballOf(part)).applyMatrix4(parts.matrixOf(part));
    const points = motion.times.map((_, moment) => centre.clone().applyMatrix4(motion.matricesAt(moment).get(body)));
    this.line.geometry.dispose();
    this.line.geometry = new BufferGeometry().setFromPoints(points);
  }
}

// The edges that a search found free, drawn where the middle of a body goes.
export class Search {
  constructor(page, bodies) {
    const { ends, of_start, low, step, points } = page.document.search;
    this.bodies = bodies;
    this.points = positions(page.array(points), low, step);
    this.lines = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ vertexColors: true, transparent: true, opacity: 0.6 }));
    const edges = page.array(ends);
    this.shown = edges.length / 2;
    this.ofStart = page.array(of_start);
    this.lines.geometry.setIndex(new BufferAttribute(edges, 1));
    this.paint();
    this.lines.renderOrder = 1; // over the see-through robot at the start and goal
    this.lines.frustumCulled = false;
  }
  // Nodes that hang from the start have its colour, the others the goal's.
  paint() {
    const [start, goal] = [new Color(colours().start), new Color(colours().goal)];
    const all = new Float32Array(3 * this.ofStart.length);
    this.ofStart.forEach((is, i) => (is ? start : goal).toArray(all, 3 * i));
    this.lines.geometry.setAttribute('color', new BufferAttribute(all, 3));
  }
  set(body) {
    const k = this.bodies.indexOf(body);
    if (k < 0) return;
    const count = this.points.length / this.bodies.length;
    this.lines.geometry.setAttribute('position', new BufferAttribute(this.points.slice(k * count, (k + 1) * count), 3));
  }
}

// Which way is out: an arrow from the body's middle along the translation that frees it.
export function wayOut(from, translation) {
  const way = new Vector3(...translation);
  const length = Math.max(way.length(), 0.06);
  const thick = 0.05 * length;
  const material = new MeshBasicMaterial({ color: colours().trail, depthTest: false, transparent: true });
  const shaft = new Mesh(new CylinderGeometry(thick, thick, 0.7 * length, 12), material);
  shaft.position.y = 0.35 * length;
  const head = new Mesh(new ConeGeometry(3 * thick, 0.3 * length, 20), material);
  head.position.y = 0.85 * length;
  const arrow = new Group();
  arrow.add(shaft, head);
  [shaft, head].forEach((m) => { m.renderOrder = 11; });
  arrow.position.copy(from);
  arrow.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), way.normalize());
  return arrow;
}

// An arrow of one length on the screen.
export class Arrow {
  constructor(stage, from, way) {
    this.stage = stage;
    this.group = wayOut(from, way);
  }
  update() {
    this.group.scale.setScalar(0.12 * this.stage.spread * this.stage.camera.position.distanceTo(this.group.position));
  }
}

// Frames in the world, x red, y green, z blue.
export function frames(poses, size) {
  const group = new Group();
  for (let i = 0; i < poses.count; ++i) {
    const axes = new AxesHelper(size);
    axes.material.depthTest = false;
    axes.renderOrder = 9;
    axes.matrixAutoUpdate = false;
    poses.matrix(i, axes.matrix);
    group.add(axes);
  }
  return group;
}

// Frames that move: of tools, of constraints and of what these are relative to.
export class MovingFrames {
  constructor(page, size) {
    this.entries = page.document.axes.map(({ name, poses }) => ({ name, poses: new Poses(page.array(poses)) }));
    this.group = new Group();
    for (const entry of this.entries) {
      entry.axes = new AxesHelper(entry.name.endsWith(': reference') ? 0.6 * size : size);
      entry.axes.material.depthTest = false;
      entry.axes.renderOrder = 9;
      entry.axes.matrixAutoUpdate = false;
      this.group.add(entry.axes);
    }
  }
  place({ before, after, share }) {
    for (const { poses, axes } of this.entries) {
      poses.blend(before, after, share, axes.matrix);
      axes.matrixWorldNeedsUpdate = true;
    }
  }
}

// The balls that queries look at first.
export class Balls {
  constructor(parts, list) {
    this.parts = parts;
    this.list = list;
    this.mesh = new InstancedMesh(new SphereGeometry(1, 18, 10), new MeshBasicMaterial({ color: colours().proven, wireframe: true, transparent: true, opacity: 0.25 }), list.length);
    this.mesh.frustumCulled = false;
  }
  place(matrices) {
    const ball = new Matrix4();
    this.list.forEach((part, i) => {
      const [x, y, z, r] = this.parts.ballOf(part);
      const matrix = this.parts.matrixOf(part).multiply(ball.makeScale(r, r, r).setPosition(x, y, z));
      const body = matrices.get(this.parts.body[part]);
      this.mesh.setMatrixAt(i, body ? matrix.premultiply(body) : matrix);
    });
    this.mesh.instanceMatrix.needsUpdate = true;
  }
}
