// The 3D view: camera, lights, ground; draws when something has changed, and only then.
import { AmbientLight, Box3, Color, DirectionalLight, DoubleSide, HemisphereLight, PerspectiveCamera, Raycaster, Scene, Vector3, WebGLRenderer } from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { grid } from './measures.js';
import { colours, onThemeChange } from './theme.js';

export const kMany = 20000; // parts that a machine without a graphics card draws in a blink
const kFilled = 0.94; // of the view by what is framed
const kAngle = 40; // of the view, in degrees
const kGapAngle = 5; // at a gap: nearly parallel rays, so that surfaces before and behind it do not cover it
const tangent = (degrees) => Math.tan((degrees * Math.PI) / 360);

export class Stage {
  // Throws where the browser has no WebGL 2. `many`: so much to draw that edges are not smoothed.
  constructor(place, many) {
    this.place = place;
    this.renderer = new WebGLRenderer({ antialias: !many });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.canvas = this.renderer.domElement;
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute('aria-label', 'The scene. Drag to turn, right button or two fingers to move, wheel or pinch to zoom, click for what it is.');
    place.append(this.canvas);
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(kAngle, 1, 0.01, 1000);
    this.camera.up.set(0, 0, 1);
    this.light = new DirectionalLight(0xffffff, 1.6);
    this.scene.add(this.camera, new HemisphereLight(0xffffff, 0x8a8a90, 1.3), new AmbientLight(0xffffff, 0.35));
    this.camera.add(this.light);
    this.light.position.set(-0.6, 0.9, 0.4);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.zoomToCursor = true;
    this.controls.addEventListener('change', () => this.draw());
    new ResizeObserver(() => this.resize()).observe(place);
    onThemeChange(() => this.draw());
    this.asked = false;
    this.frames = 0;
    this.many = many;
    this.large = [];
    this.overlays = []; // update() of each follows every drawing
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.place;
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  // Instances beyond the first kMany of a mesh wait until nothing has changed for a while.
  draw(whole = false) {
    this.whole = whole || !this.many;
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      const { whole: all } = this;
      this.scene.background = new Color(colours().scene);
      for (const instances of this.large) instances.mesh.count = all ? instances.entries.length : kMany;
      this.renderer.render(this.scene, this.camera);
      this.overlays.forEach((overlay) => overlay.update());
      if (++this.frames === 1) requestAnimationFrame((now) => { this.drawn = now; });
      clearTimeout(this.settling);
      if (!all) this.settling = setTimeout(() => this.draw(true), 700);
    });
  }
  // `instances`: nearest first.
  addLarge(instances) {
    if (instances.entries.length > kMany) this.large.push(instances);
  }

  // Looks at a box, as near as all its corners allow, from a direction or from where it looked before.
  frame(box, direction = null) {
    const centre = box.getCenter(new Vector3());
    const from = (direction ?? this.camera.position.clone().sub(this.controls.target)).clone().normalize();
    const right = new Vector3().crossVectors(this.camera.up, from).normalize();
    const up = new Vector3().crossVectors(from, right);
    this.camera.fov = kAngle;
    const tall = tangent(kAngle) * kFilled;
    const wide = tall * this.camera.aspect;
    let distance = 0.02;
    for (const x of [box.min.x, box.max.x]) for (const y of [box.min.y, box.max.y]) for (const z of [box.min.z, box.max.z]) {
      const corner = new Vector3(x, y, z).sub(centre);
      const sideways = Math.max(Math.abs(corner.dot(right)) / wide, Math.abs(corner.dot(up)) / tall);
      distance = Math.max(distance, sideways + corner.dot(from));
    }
    this.camera.near = distance / 200;
    this.camera.far = distance * 100;
    this.camera.position.copy(centre).addScaledVector(from, distance);
    this.camera.updateProjectionMatrix();
    this.controls.target.copy(centre);
    this.controls.update();
    this.draw();
  }

  get looksAtGap() {
    return this.camera.fov < kAngle;
  }
  // How large the view is at a distance, relative to that of the usual angle.
  get spread() {
    return tangent(this.camera.fov) / tangent(kAngle);
  }

  // Looks at the middle of two points, across the line between them, from where least is in the way. What is nearer than the points is cut away.
  lookBetween(a, b, targets) {
    const middle = a.clone().add(b).multiplyScalar(0.5);
    const gap = a.distanceTo(b) > 0 ? Math.max(a.distanceTo(b), 1e-5) : 1e-3;
    const along = a.distanceTo(b) > 0 ? b.clone().sub(a).normalize() : new Vector3(0, 0, 1);
    const side = new Vector3().crossVectors(along, Math.abs(along.z) < 0.9 ? this.camera.up : new Vector3(1, 0, 0)).normalize();
    const other = new Vector3().crossVectors(along, side);
    // How far away the camera would be with the usual angle: near enough that the dots at its ends are smaller than the gap.
    const away = Math.max(Math.min(Math.max(7 * gap, Math.min(0.03, 25 * gap)), 0.6), 2 * gap);
    this.camera.fov = kGapAngle;
    const distance = away / this.spread;
    const ray = new Raycaster();
    let best = -1;
    let from = side;
    for (let i = 0; i < 24; ++i) {
      const angle = (i * Math.PI) / 12;
      const way = side.clone().multiplyScalar(Math.cos(angle)).addScaledVector(other, Math.sin(angle));
      ray.set(middle, way);
      const free = Math.min(ray.intersectObjects(targets.filter((t) => t.visible), false)[0]?.distance ?? Infinity, 10 * away);
      // Rather from above than from below.
      const worth = free * (1 + 0.2 * way.z);
      if (worth > best) [best, from] = [worth, way];
    }
    this.camera.near = Math.min(distance - 0.5 * away, Math.max(distance - best, distance / 200));
    this.camera.far = 1e4 * away;
    this.camera.position.copy(middle).addScaledVector(from, distance);
    this.camera.updateProjectionMatrix();
    this.controls.target.copy(middle);
    this.controls.update();
    this.draw();
  }

  // The bodies that hide two points and what is around them from the camera, from inside as well.
  hiding(a, b, targets, bodyOf) {
    const { camera } = this;
    const middle = a.clone().add(b).multiplyScalar(0.5);
    const size = 0.5 * camera.position.distanceTo(middle) * tangent(camera.fov);
    camera.updateMatrixWorld();
    const [right, up] = [0, 1].map((k) => new Vector3().setFromMatrixColumn(camera.matrixWorld, k).multiplyScalar(size));
    const ray = new Raycaster();
    const bodies = new Set();
    const sides = targets.map((t) => t.material.side);
    targets.forEach((t) => { t.material.side = DoubleSide; });
    for (const x of [-1, 0, 1]) for (const y of [-1, 0, 1]) {
      const from = middle.clone().addScaledVector(right, x).addScaledVector(up, y);
      const way = camera.position.clone().sub(from);
      ray.set(from, way.clone().normalize());
      ray.far = way.length() - camera.near;
      for (const hit of ray.intersectObjects(targets.filter((t) => t.visible), false)) bodies.add(bodyOf(hit));
    }
    targets.forEach((t, i) => { t.material.side = sides[i]; });
    return bodies;
  }

  // Where the camera is, what it looks at, what it cuts away, and its angle: nine numbers.
  view() {
    const { camera, controls } = this;
    return [...camera.position.toArray(), ...controls.target.toArray(), camera.near, camera.far, camera.fov];
  }
  setView([x, y, z, tx, ty, tz, near, far, fov = kAngle]) {
    if (!(near > 0 && far > near && fov > 0 && fov <= kAngle)) return;
    Object.assign(this.camera, { near, far, fov });
    this.camera.position.set(x, y, z);
    this.camera.updateProjectionMatrix();
    this.controls.target.set(tx, ty, tz);
    this.controls.update();
    this.draw();
  }

  // Turns around what the camera looks at [rad], and goes to a share of the distance from it.
  turn(around, upward, share = 1) {
    const { camera, controls } = this;
    const away = camera.position.clone().sub(controls.target);
    const length = away.length();
    const angle = Math.atan2(away.y, away.x) + around;
    const tilt = Math.min(Math.max(Math.acos(away.z / length) - upward, 0.01), Math.PI - 0.01);
    away.set(Math.sin(tilt) * Math.cos(angle), Math.sin(tilt) * Math.sin(angle), Math.cos(tilt));
    camera.position.copy(controls.target).addScaledVector(away, share * length);
    controls.update();
    controls.dispatchEvent({ type: 'end' });
    this.draw();
  }

  // For who reads the pixels in the same task.
  renderNow() {
    this.scene.background = new Color(colours().scene);
    this.renderer.render(this.scene, this.camera);
  }

  // A grid where a half-space ends, with squares of a side of `square` [m].
  addPlane(matrix, extent, square) {
    const holder = new Scene();
    holder.matrixAutoUpdate = false;
    holder.matrix.copy(matrix);
    holder.add(grid(extent, square));
    this.scene.add(holder);
    return holder;
  }
}

// Grows a box by balls, given in world coordinates.
export function boxOfBalls(balls) {
  const box = new Box3();
  for (const { center, radius } of balls) box.union(new Box3().setFromCenterAndSize(center, new Vector3(2 * radius, 2 * radius, 2 * radius)));
  return box;
}
