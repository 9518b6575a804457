// Sizes and names in the scene: a scale bar, the grid and axes of the world, labels.
import { AxesHelper, GridHelper, Group, Vector3 } from 'three';
import { kRanks, setRank } from './shapes.js';
import { colours, onThemeChange } from './theme.js';
import { element } from './words.js';

const kBar = 120; // px at most
const kLabels = 60; // drawn at once: more cannot be read
const kSquares = 24; // of a grid along its side, at most

// The largest of 1, 2, 5 times a power of ten that is not above a length.
export function roundLength(length) {
  const power = 10 ** Math.floor(Math.log10(length));
  return [5, 2, 1].map((digit) => digit * power).find((round) => round <= length * (1 + 1e-9));
}
export function lengthText(metres) {
  if (metres < 0.01) return `${+(metres * 1e3).toPrecision(3)} mm`;
  return metres < 1 ? `${+(metres * 100).toPrecision(3)} cm` : `${+metres.toPrecision(3)} m`;
}

// A bar on the screen with its length at the depth of what the camera looks at.
export class ScaleBar {
  constructor(stage) {
    this.stage = stage;
    this.bar = element('span', { className: 'bar' });
    this.text = element('span', {});
    this.root = element('div', { id: 'scale-bar', title: 'at the depth of what the camera looks at' }, this.bar, this.text);
  }
  // Metres and pixels of the bar.
  measure() {
    const { camera, controls, place } = this.stage;
    const depth = controls.target.clone().sub(camera.position).dot(camera.getWorldDirection(new Vector3()));
    const metres = (2 * Math.tan((camera.fov * Math.PI) / 360) * Math.max(depth, camera.near)) / Math.max(place.clientHeight, 1);
    const length = roundLength(kBar * metres);
    return { length, pixels: length / metres };
  }
  update() {
    const { length, pixels } = this.measure();
    this.bar.style.width = `${pixels.toFixed(1)}px`;
    this.text.textContent = lengthText(length);
  }
}

// Lines of a grid in the plane z = 0 of its frame, as far as `extent` from the middle. `square`: the side of its squares [m].
export function grid(extent, square) {
  const half = Math.ceil(extent / square);
  const make = () => new GridHelper(2 * half * square, 2 * half, colours().grid, colours().grid);
  const lines = make();
  lines.rotation.x = Math.PI / 2;
  lines.material.transparent = true;
  lines.material.opacity = 0.6;
  setRank(lines.material, kRanks.plane);
  onThemeChange(() => { lines.geometry.dispose(); lines.geometry = make().geometry; });
  return lines;
}
export function squareFor(extent) {
  const least = (2 * extent) / kSquares;
  const below = roundLength(least);
  return below >= least ? below : roundLength(2.5 * below);
}

// The world's axes (x red, y green, z blue) and a grid in its plane z = 0.
export function worldGrid(box) {
  const extent = 0.75 * box.getSize(new Vector3()).length();
  const square = squareFor(extent);
  const centre = box.getCenter(new Vector3());
  const lines = grid(extent, square);
  lines.position.set(Math.round(centre.x / square) * square, Math.round(centre.y / square) * square, 0);
  const axes = new AxesHelper(2 * square);
  axes.material.depthTest = false;
  axes.renderOrder = 8;
  const group = new Group();
  group.add(lines, axes);
  return { group, square };
}

// Names beside things. `things`: [{name, place(to)}], most wanted first; place() gives a point in the world, or null while the thing is not shown.
export class Labels {
  constructor(stage, things) {
    this.stage = stage;
    this.things = things.slice(0, 2000);
    this.root = element('div', { id: 'labels', hidden: true });
    this.spans = [];
  }
  show(on) {
    this.root.hidden = !on;
    this.update();
  }
  update() {
    if (this.root.hidden) return;
    const { clientWidth: width, clientHeight: height } = this.stage.place;
    const { camera } = this.stage;
    camera.updateMatrixWorld();
    const taken = [];
    const point = new Vector3();
    let used = 0;
    for (const thing of this.things) {
      if (used === kLabels) break;
      if (!thing.place(point)) continue;
      point.project(camera);
      if (Math.abs(point.x) > 1 || Math.abs(point.y) > 1 || point.z < -1 || point.z > 1) continue;
      const x = (0.5 + 0.5 * point.x) * width;
      const y = (0.5 - 0.5 * point.y) * height;
      const wide = 7 * Math.min(thing.name.length, 28) + 8;
      // A label that would lie on another one is left out.
      if (taken.some(([a, b, w]) => Math.abs(b - y) < 18 && x < a + w && a < x + wide)) continue;
      taken.push([x, y, wide]);
      const span = this.spans[used] ?? this.root.appendChild(element('span', {}));
      this.spans[used++] = span;
      span.textContent = thing.name;
      span.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
      span.hidden = false;
    }
    this.spans.slice(used).forEach((span) => { span.hidden = true; });
    this.shown = used;
  }
}
