// The page: reads its data, makes the scene and the texts, and keeps both at one time.
import { Matrix4, Vector3 } from 'three';
import { Address } from './address.js';
import { Compared } from './compared.js';
import { Controls } from './controls.js';
import { Deforming } from './deforming.js';
import { Arrow, Balls, MovingFrames, NearestLine, Outline, Search, Trail, frames, wayOut } from './figures.js';
import { Labels, ScaleBar, lengthText, squareFor, worldGrid } from './measures.js';
import { Motion, Poses } from './motion.js';
import { Nearness } from './nearness.js';
import { Panel } from './panel.js';
import { bodyOfHit, picks } from './picking.js';
import { ClearancePlot, JointPlot, decisionColour } from './plot.js';
import { Recorder } from './recorder.js';
import { Parts, kRanks } from './shapes.js';
import { Stage, boxOfBalls, kMany } from './stage.js';
import { headline, remedy } from './summary.js';
import { Swept } from './swept.js';
import { colours, onThemeChange } from './theme.js';
import { unpack } from './unpack.js';
import { Visual } from './visual.js';
import { distanceText, element, provenText } from './words.js';

const kGhosts = 7; // copies of the robot along the path
const kNear = 2; // things that lie within so many times the robot's reach are in the first view

// Whether two places of a body are one on the screen.
const isNear = (a, b) => a.elements.every((x, i) => Math.abs(x - b.elements[i]) < 1e-4);

class App {
  constructor(page) {
    this.data = page.document;
    this.page = page;
    this.parts = new Parts(page);
    this.motion = new Motion(page);
    this.near = new Nearness(page);
    this.positions = page.array(this.data.positions);
    this.bodyClearance = page.array(this.data.body_clearance);
    this.leastClearance = page.array(this.data.least_clearance);
    this.leastMoment = page.array(this.data.least_moment);
    this.time = this.motion.begin;
    this.moment = 0;
    this.speed = 1;
    this.playing = false;
    this.selected = -1;
    this.layers = [];
    this.moving = new Set(this.data.moving);
    this.driven = new Set(this.data.driven);
    this.held = new Set(this.data.held);
    this.colliding = new Set();
    this.marked = new Set(); // bodies that were chosen in a list
    this.links = new Set(this.data.links);
    this.deforming = [];
    this.seeThrough = []; // instances of bodies that would cover the gap
    this.given = new Map(this.data.colors.map(([body, colour]) => [body, `#${colour.map((share) => Math.round(255 * share).toString(16).padStart(2, '0')).join('')}`]));
    this.compared = this.data.compared ? new Compared(page, this.data) : null;
    const visual = this.data.visual ? new Visual(page) : null;
    this.visualNote = visual?.text();
    this.visual = visual?.parts.count > 0 ? visual : null;
    this.end = Math.max(this.motion.begin + this.motion.duration, this.compared?.end ?? -Infinity);
    this.deformable = new Set(this.data.frames.map((f) => f.body));
    for (let i = 0; i < this.parts.count; ++i) if (this.parts.kind[i] === 'deformable') this.deformable.add(this.parts.body[i]);
    this.rankWorld();
    this.groups = { robot: [], base: [], driven: [], world: [] };
    this.build();
  }

  build() {
    document.title = `${this.data.name} \u2013 Leeway`;
    this.view = element('div', { id: 'view' });
    this.nearestText = element('div', { id: 'nearest', role: 'status' });
    const button = (id, text, title, onclick) => element('button', { id, text, title, onclick });
    this.view.append(element('div', { id: 'looks' },
      button('look-least', 'Least', 'where the room is least (M)', () => this.seekLeast()),
      button('look-gap', 'Gap', 'look at the gap (G)', () => this.lookAtGap()),
      button('look-all', 'All', 'see all of it (F)', () => this.lookAtAll()),
      button('save', 'PNG', 'save a picture (P)', () => this.recorder.savePicture()),
      button('record', 'Video', 'save a video of the motion (V)', () => this.recorder.toggle()),
      button('link', 'Link', 'copy a link to this time and view; open it beside this file', () => this.copyLink())));
    try {
      this.stage = new Stage(this.view, this.parts.count > kMany);
      this.buildScene();
    } catch (error) {
      console.warn(error);
      this.stage = null;
      this.view.append(element('p', { id: 'no-webgl', text: 'The scene needs WebGL 2, which this browser does not offer. The plots and the numbers are here all the same.' }));
    }
    this.recorder = new Recorder(this);
    this.controls = new Controls(this);
    this.panel = new Panel(this);
    const still = this.motion.duration === 0;
    const plot = (id, label) => element('canvas', { className: 'plot', id, role: 'img', 'aria-label': label });
    const plots = [plot('clearance-plot', 'clearance over time'), plot('joint-plot', 'joints over time')];
    const verdict = element('span', { id: 'verdict', className: this.data.good ? 'good' : 'bad', text: this.data.verdict });
    document.body.append(
      element('header', {}, element('h1', { text: this.data.name }), verdict,
        element('button', { id: 'headline', className: 'link', text: headline(this), title: 'go there', onclick: () => { this.choose(this.near.certificate); this.seekLeast(); } })),
      this.nearestText,
      this.view,
      element('footer', { hidden: still }, this.controls.root, element('div', { id: 'plots' }, ...plots)),
      this.panel.root);
    document.body.classList.toggle('still', still);
    this.plots = still ? [] : [new ClearancePlot(plots[0], this), new JointPlot(plots[1], this)];
    this.stage?.resize();
    if (this.stage) this.stage.frame(this.box, this.viewpoint);
    onThemeChange(() => this.paint());
    this.seek(this.time);
    this.address = new Address(this);
    this.address.restore();
    this.stage?.controls.addEventListener('end', () => { this.showGap(); this.address.changed(); });
  }

  // Small bodies before large ones: what lies on a table in its plane is seen.
  rankWorld() {
    const size = new Map();
    for (let i = 0; i < this.parts.count; ++i) {
      const radius = this.parts.ballOf(i)[3];
      const body = this.parts.body[i];
      if (!this.moving.has(body)) size.set(body, Math.max(size.get(body) ?? 0, radius < 0 ? Infinity : radius));
    }
    const order = [...size.keys()].sort((a, b) => size.get(a) - size.get(b));
    this.rank = new Map(order.map((body, i) => [body, kRanks.world + (order.length <= kRanks.worlds ? i : i % kRanks.worlds)]));
    // Colours in the order of the problem, so that neighbours there differ.
    this.palette = new Map(this.data.bodies.map((_, body) => body).filter((body) => !this.links.has(body) && (!this.moving.has(body) || this.held.has(body) || this.driven.has(body))).map((body, i) => [body, i]));
  }
  rankOf(part) {
    return this.rank.get(this.parts.body[part]) ?? kRanks.robot + (this.held.has(this.parts.body[part]) ? 1 : 0);
  }

  partsOf(body) {
    const list = [];
    for (let i = 0; i < this.parts.count; ++i) if (this.parts.body[i] === body) list.push(i);
    return list;
  }

  colourOf(part) {
    return this.colourOfBody(this.parts.body[part]);
  }
  colourOfBody(body) {
    const c = colours();
    if (body === this.selected || this.marked.has(body)) return c.selected;
    if (this.colliding.has(body)) return c.collision;
    return this.plainColour(body);
  }
  // A body's colour while nothing is said about it.
  plainColour(body) {
    const c = colours();
    if (this.given.has(body)) return this.given.get(body);
    if (this.held.has(body) && this.isHeld(body)) return c.held;
    if (this.moving.has(body) && !this.held.has(body) && !this.driven.has(body)) return c.robot;
    if (this.links.has(body)) return c.base;
    if (this.deformable.has(body)) return c.deforming;
    return c.worlds[(this.palette.get(body) ?? body) % c.worlds.length];
  }
  // Whether the robot holds an object at this time. Steps take hold of it and let it go; what no step names is held all the time.
  isHeld(body) {
    const events = this.data.steps.filter((step) => step.object === this.data.bodies[body]);
    if (events.length === 0) return true;
    const past = events.filter((step) => step.begin <= this.time);
    return past.length > 0 ? past[past.length - 1].kind === 'attach' : events[0].kind === 'detach';
  }
  // The bodies of pairs that are not farther apart than their margin at this time.
  findColliding() {
    const found = new Set();
    const add = (near) => { if (near && near.lower !== null && near.lower <= near.margin) found.add(near.a).add(near.b); };
    for (const choice of ['world', 'self', ...this.near.pairs.keys()]) add(this.near.at(this.moment, `${choice}`));
    return found;
  }

  buildScene() {
    const { parts, stage, data, page } = this;
    const all = [...Array(parts.count).keys()];
    const framed = new Set(data.frames.map((f) => f.body));
    const robot = all.filter((i) => this.moving.has(parts.body[i]) && !this.driven.has(parts.body[i]));
    const driven = all.filter((i) => this.driven.has(parts.body[i]));
    const links = all.filter((i) => !this.moving.has(parts.body[i]) && this.links.has(parts.body[i]));
    const world = all.filter((i) => !this.moving.has(parts.body[i]) && !this.links.has(parts.body[i]) && !framed.has(parts.body[i]));
    const options = { rankOf: (part) => this.rankOf(part) };
    const colourOf = (part) => this.colourOf(part);
    this.box = this.findBox([...robot, ...driven], all.filter((i) => !this.moving.has(parts.body[i]) && !this.links.has(parts.body[i])));
    const centre = this.box.getCenter(new Vector3());
    const away = world.map((part) => parts.poses.position(part, new Vector3()).distanceTo(centre));
    const nearestFirst = world.map((_, i) => i).sort((i, k) => away[i] - away[k]).map((i) => world[i]);
    this.groups.robot = parts.instances(robot, colourOf, options);
    this.groups.base = parts.instances(links, colourOf, options);
    this.groups.driven = parts.instances(driven, colourOf, options);
    this.groups.world = parts.instances(nearestFirst, colourOf, options);
    this.groups.world.forEach((i) => stage.addLarge(i));
    for (const group of Object.values(this.groups)) for (const i of group) stage.scene.add(i.mesh);
    this.deforming = data.frames.map((f) => new Deforming(page, f));
    this.deforming.forEach((d) => stage.scene.add(d.mesh));
    this.planes = world.filter((i) => parts.kind[i] === 'half-space').map((i) => stage.addPlane(parts.matrixOf(i), 1.2 * this.box.getSize(new Vector3()).length(), this.planeSquare()));
    this.addGhosts(robot);
    this.addFigures(robot);
    this.addMeasures();
    const show = (things) => (on) => things.forEach((t) => { t.visible = on; });
    const layer = (name, shown, set) => { this.layers.push({ name, shown, set }); set(shown); };
    const meshes = (group) => group.map((i) => i.mesh);
    const shapes = [...meshes(this.groups.world), ...meshes(this.groups.driven), ...this.deforming.map((d) => d.mesh)];
    const checked = [...meshes(this.groups.robot), ...meshes(this.groups.base)];
    layer(this.visual ? 'robot, as it is checked' : 'robot', true, show(checked));
    if (this.visual) {
      this.visual.addTo(stage.scene);
      this.view.append(this.visual.label);
      layer('visual shapes of the robot (not what is proven)', true, (on) => {
        this.visual.show(on);
        // Checked shapes stay in sight around them.
        for (const m of checked) this.fade(m, on);
      });
    }
    if (shapes.length + this.planes.length > 0) {
      layer(this.planes.length > 0 ? `world (planes: a square is ${lengthText(this.planeSquare())})` : 'world', true, show([...shapes, ...this.planes]));
      layer('see through the world', false, (on) => {
        for (const m of shapes) this.fade(m, on);
      });
    }
    layer('nearest pair', true, (on) => { this.showNearest = on; });
    layer('start and goal', true, (on) => { this.showEnds = on; });
    if (this.placeGhosts.length > 0) layer('where objects end', true, (on) => { this.showPlaces = on; });
    if (this.motion.duration > 0) {
      layer('robot along the path', false, show(this.pathGhosts));
      layer('trail of a link', true, show([this.trail.line]));
      const swept = this.layers.length;
      layer('what the robot sweeps', false, (on) => {
        this.showSwept(robot, on);
        if (this.swept) this.layers[swept].name = `what the robot sweeps, at ${this.swept.moments.length} moments`;
      });
    }
    if (this.compared) layer(`the other path: ${this.compared.label}`, true, show(this.compared.meshes));
    if (data.searched > 0) layer(this.searchText(), !data.good, show([this.search.lines]));
    layer('balls that queries ask first', false, (on) => { this.balls.mesh.visible = on; });
    if (data.parts.pieces.length > 0) layer(`convex pieces of meshes (${data.parts.pieces.length})`, false, (on) => this.showPieces(on));
    layer(`axes of the world, grid (a square is ${lengthText(this.worldGrid.square)})`, false, (on) => { this.worldGrid.group.visible = on; });
    if (data.axes.length > 0) layer('frames of tools and constraints', data.axes.length <= 2, (on) => { this.axes.group.visible = on; });
    layer('names', false, (on) => this.labels.show(on));
    stage.controls.addEventListener('change', () => { this.nearest.update(); this.arrow?.update(); });
    picks(stage, () => this.targets(), (body) => this.select(body));
  }
  // Meshes that a ray can meet.
  targets() {
    return [...Object.values(this.groups).flatMap((group) => group.map((i) => i.mesh)), ...this.deforming.map((d) => d.mesh), ...(this.visual?.meshes ?? [])];
  }

  searchText() {
    const { searched } = this.data;
    const { shown } = this.search;
    return `what the search found free (${shown < searched ? `the first ${shown} of ${searched}` : searched} edges; blue from the start, orange from the goals)`;
  }

  // All of the robot's motion, and what is near it.
  findBox(robot, world) {
    const balls = [];
    const add = (part, matrix) => {
      const [x, y, z, radius] = this.parts.ballOf(part);
      if (this.parts.kind[part] === 'box') {
        // Its corners: a ball around a board is much larger than the board.
        const [a, b, c] = this.parts.sizeOf(part);
        for (let i = 0; i < 8; ++i) balls.push({ center: new Vector3(i & 1 ? a : -a, i & 2 ? b : -b, i & 4 ? c : -c).applyMatrix4(matrix), radius: 0 });
      } else if (radius >= 0) balls.push({ center: new Vector3(x, y, z).applyMatrix4(matrix), radius });
    };
    const moments = this.motion.times.length;
    for (const share of [0, 0.25, 0.5, 0.75, 1]) {
      const matrices = this.motion.matricesAt(Math.round(share * (moments - 1)));
      for (const part of robot) add(part, matrices.get(this.parts.body[part]).clone().multiply(this.parts.matrixOf(part)));
    }
    this.data.ends.forEach((end) => this.endMatrices(end).forEach((matrix, body) => this.partsOf(body).forEach((part) => add(part, matrix.clone().multiply(this.parts.matrixOf(part))))));
    const box = boxOfBalls(balls);
    this.viewpoint = new Vector3(0.75, -1, 0.55);
    if (box.isEmpty()) {
      world.forEach((part) => add(part, this.parts.matrixOf(part)));
      return boxOfBalls(balls);
    }
    const centre = box.getCenter(new Vector3());
    const reach = 0.5 * box.getSize(new Vector3()).length();
    const aside = new Vector3();
    for (const part of world) {
      const [x, y, z, radius] = this.parts.ballOf(part);
      if (radius < 0) continue;
      const place = new Vector3(x, y, z).applyMatrix4(this.parts.matrixOf(part));
      const away = place.distanceTo(centre);
      if (away + radius > kNear * reach && (away - radius > 0.5 * reach || radius > 3 * reach)) continue;
      add(part, this.parts.matrixOf(part));
      aside.addScaledVector(place.sub(centre), radius / reach);
    }
    // From beside, so that neither robot nor world hides the other.
    aside.z = 0;
    if (aside.length() > 0.1 * reach) {
      aside.normalize();
      const side = aside.x >= 0 ? 1 : -1;
      this.viewpoint.set(side * aside.y - 0.35 * aside.x, -side * aside.x - 0.35 * aside.y, 0.5);
    }
    return boxOfBalls(balls);
  }

  endMatrices(end) {
    const poses = new Poses(this.page.array(end.poses));
    return new Map(end.bodies.map((body, k) => [body, poses.matrix(k, new Matrix4())]));
  }

  addGhosts(robot) {
    // Behind all else in the same place.
    const ghost = (matrices, colour, opacity, red = []) => this.parts.instances(robot.filter((part) => matrices.has(this.parts.body[part])), (part) => (red.includes(this.parts.body[part]) ? colours().collision : colour), { opacity, rankOf: () => kRanks.ghost }).map((i) => {
      i.place(matrices);
      this.stage.scene.add(i.mesh);
      return i.mesh;
    });
    this.endGhosts = this.data.ends.map((end, e) => ghost(this.endMatrices(end), e === 0 ? colours().start : colours().goal, end.valid ? 0.22 : 0.5, end.valid || !end.closest ? [] : [end.closest.a, end.closest.b]));
    if (this.compared) this.compared.addTo(this.stage.scene, this.parts, robot);
    this.pathGhosts = [];
    // Objects that steps move, where they are at the end.
    this.placeGhosts = [];
    if (this.motion.duration > 0) {
      const [first, last] = [0, this.motion.times.length - 1].map((moment) => this.motion.matricesAt(moment));
      for (const body of this.held) {
        if (!this.data.steps.some((step) => step.object === this.data.bodies[body]) || isNear(first.get(body), last.get(body))) continue;
        this.placeGhosts.push({ body, matrix: last.get(body), meshes: ghost(new Map([[body, last.get(body)]]), colours().goal, 0.35) });
      }
    }
    const last = this.motion.times.length - 1;
    for (let g = 1; g <= kGhosts && this.motion.duration > 0; ++g) {
      const moment = this.motion.momentNear(this.motion.begin + (g / (kGhosts + 1)) * this.motion.duration);
      if (moment > 0 && moment < last) this.pathGhosts.push(...ghost(this.motion.matricesAt(moment), colours().robot, 0.16));
    }
  }

  addFigures(robot) {
    const { stage, data } = this;
    this.nearest = new NearestLine(stage);
    this.remedy = remedy(this);
    if (this.remedy) {
      this.arrow = new Arrow(stage, this.remedy.from, this.remedy.way);
      stage.scene.add(this.arrow.group);
    }
    this.trail = new Trail();
    this.trail.set(this.motion, this.parts, data.tip);
    this.balls = new Balls(this.parts, robot);
    this.outlines = [...this.held].map((body) => new Outline(this.parts, body));
    stage.scene.add(this.nearest.group, this.trail.line, this.balls.mesh, ...this.outlines.map((outline) => outline.group));
    if (data.searched > 0) {
      this.search = new Search(this.page, this.motion.bodies);
      this.search.set(data.tip);
      stage.scene.add(this.search.lines);
    }
    const size = 0.08 * this.box.getSize(new Vector3()).length();
    this.endFrames = data.ends.map((end) => {
      const axes = frames(new Poses(this.page.array(end.frames)), size);
      stage.scene.add(axes);
      return axes;
    });
    for (const end of data.ends) {
      if (end.valid || !end.closest) continue;
      const matrices = this.endMatrices(end);
      const [part] = this.partsOf(end.closest.a);
      const [x, y, z] = this.parts.ballOf(part);
      const centre = this.motion.toWorld(end.closest.a, new Vector3(x, y, z).applyMatrix4(this.parts.matrixOf(part)).toArray(), matrices);
      if (Math.hypot(...end.way_out) > 0) stage.scene.add(wayOut(centre, end.way_out));
    }
  }

  planeSquare() {
    return squareFor(1.2 * this.box.getSize(new Vector3()).length());
  }
  // Scale bar, grid, frames that move, and names: of the robot's last link, of frames, then of objects, those near the robot first.
  addMeasures() {
    const { stage, data, parts } = this;
    this.worldGrid = worldGrid(this.box);
    this.axes = new MovingFrames(this.page, 0.06 * this.box.getSize(new Vector3()).length());
    stage.scene.add(this.worldGrid.group, this.axes.group);
    const things = [];
    const named = (body) => {
      const part = parts.body.indexOf(body);
      if (part < 0) return;
      const [x, y, z, radius] = parts.ballOf(part);
      if (radius < 0) return; // a half-space has no middle
      const middle = new Vector3(x, y, z).applyMatrix4(parts.matrixOf(part));
      things.push({ name: data.bodies[body], place: (to) => { to.copy(middle); const matrix = this.motion.matrices.get(body); return matrix ? to.applyMatrix4(matrix) : to; } });
    };
    if (data.tip >= 0) named(data.tip);
    for (const { name, axes } of this.axes.entries) things.push({ name, place: (to) => (this.axes.group.visible ? to.setFromMatrixPosition(axes.matrix) : null) });
    const centre = this.box.getCenter(new Vector3());
    const away = (body) => { const part = parts.body.indexOf(body); return part < 0 ? Infinity : parts.poses.position(part, new Vector3()).distanceTo(centre); };
    const objects = data.bodies.map((_, body) => body).filter((body) => !this.links.has(body)).map((body) => [away(body), body]).sort(([a], [b]) => a - b);
    objects.forEach(([, body]) => named(body));
    data.moving.filter((body) => this.links.has(body) && body !== data.tip).forEach(named);
    this.labels = new Labels(stage, things);
    this.scaleBar = new ScaleBar(stage);
    this.view.append(this.scaleBar.root, this.labels.root);
    stage.overlays.push(this.scaleBar, this.labels);
  }
  // Made when it is first wanted: it is large.
  showSwept(robot, on) {
    if (on && !this.swept) {
      this.swept = new Swept(this.parts, this.motion, robot);
      this.swept.meshes.forEach((mesh) => this.stage.scene.add(mesh));
    }
    this.swept?.meshes.forEach((mesh) => { mesh.visible = on; });
    this.stage.draw();
  }

  showPieces(on) {
    const { parts, data } = this;
    if (on && !this.pieces) {
      const hues = ['#0072b2', '#e69f00', '#009e73', '#cc79a7', '#56b4e9', '#d55e00', '#b39200'];
      this.pieces = data.parts.pieces.map(([part, mesh], i) => {
        const [instances] = parts.instances([part], () => hues[i % hues.length], {});
        instances.mesh.geometry = parts.geometry(mesh);
        this.stage.scene.add(instances.mesh);
        return instances;
      });
    }
    (this.pieces ?? []).forEach((i) => { i.mesh.visible = on; });
    const cut = new Set(data.parts.pieces.map(([part]) => part));
    for (const i of Object.values(this.groups).flat()) if (i.entries.every(({ part }) => cut.has(part))) i.mesh.visible = !on;
  }

  showTrail(body) {
    this.trail.set(this.motion, this.parts, body);
    this.search?.set(body);
    this.stage?.draw();
  }

  // Gives some bodies the colour of a selection, until something is selected.
  mark(bodies) {
    this.select(-1);
    this.marked = new Set(bodies);
    this.paint();
  }
  select(body) {
    this.marked.clear();
    this.selected = body;
    this.panel.select(body);
    this.paint();
    this.address?.changed();
  }

  // Colours anew.
  paint() {
    if (!this.stage) return;
    this.painted = null;
    this.trail.line.material.color.set(colours().trail);
    this.search?.paint();
    this.refresh();
  }

  toggle() {
    if (this.playing) this.pause();
    else this.start();
  }
  start() {
    if (this.motion.duration === 0) return;
    const { end } = this;
    if (this.time >= end) this.seek(this.motion.begin);
    this.playing = true;
    let last = null;
    const step = (now) => {
      if (!this.playing) return;
      // A browser that was away does not leap.
      const passed = last === null ? 0 : Math.min((now - last) / 1e3, 0.25);
      last = now;
      this.time = Math.min(this.time + this.speed * passed, end);
      if (this.time >= end) this.playing = false;
      this.refresh();
      if (!this.playing) this.address.changed();
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }
  // Standing, the page shows a moment at which everything was measured.
  pause() {
    this.playing = false;
    this.seek(this.time);
  }
  seek(time) {
    // (A path that is compared may take longer.)
    const { motion } = time > this.motion.begin + this.motion.duration && this.compared ? this.compared : this;
    this.time = motion.times[motion.momentNear(time)];
    this.refresh();
    if (this.stage?.looksAtGap && !this.stage.many) this.showGap();
    this.address?.changed();
  }
  // Where the choice is least: with the choice that the page begins with, the certificate's place and value.
  seekLeast() {
    const least = this.near.least();
    if (least < 0) return;
    this.pause();
    this.seek(this.motion.times[least]);
  }
  choose(choice) {
    this.near.choice = choice;
    this.plots.forEach((plot) => plot.choose?.());
    this.refresh();
    this.address?.changed();
  }
  changeScale() {
    const [clearance] = this.plots;
    if (!clearance) return;
    clearance.isNear = !clearance.isNear;
    this.controls.scale.setAttribute('aria-pressed', `${clearance.isNear}`);
    clearance.choose();
    clearance.paint();
  }
  // From the open side of the nearest pair, near enough to see what parts it.
  lookAtGap() {
    const closest = this.near.at(this.moment);
    if (!this.stage || !closest) return;
    const [a, b] = [[closest.a, closest.point_a], [closest.b, closest.point_b]].map(([body, point]) => this.motion.toWorld(body, point));
    this.stage.lookBetween(a, b, this.targets());
    this.showGap();
    this.nearest.update();
    this.address.changed();
  }
  // From a direction, or from where it looked before.
  lookAtAll(direction) {
    this.stage?.frame(this.box, direction);
    this.showGap();
    this.address.changed();
  }
  // While the camera looks at the gap, bodies outside the pair that cover it are see-through.
  showGap() {
    const closest = this.near.at(this.moment);
    if (!this.stage) return;
    if (!this.stage.looksAtGap || !closest) return this.hide([]);
    const [a, b] = [[closest.a, closest.point_a], [closest.b, closest.point_b]].map(([body, point]) => this.motion.toWorld(body, point));
    const targets = [...this.targets(), ...this.seeThrough.map((i) => i.mesh)];
    this.hide([...this.stage.hiding(a, b, targets, bodyOfHit)].filter((body) => body >= 0 && body !== closest.a && body !== closest.b));
  }
  // Draws bodies see-through.
  hide(bodies) {
    const { parts, stage } = this;
    if (bodies.length === parts.hidden.size && bodies.every((body) => parts.hidden.has(body))) return;
    parts.hidden = new Set(bodies);
    if (this.visual) this.visual.parts.hidden = new Set(this.visual.data.bodies.flatMap((body, link) => (parts.hidden.has(body) ? [link] : [])));
    this.seeThrough.forEach((i) => { stage.scene.remove(i.mesh); i.mesh.dispose(); });
    const list = [...Array(parts.count).keys()].filter((part) => parts.hidden.has(parts.body[part]) && !this.deformable.has(parts.body[part]));
    this.seeThrough = parts.instances(list, (part) => this.colourOf(part), { opacity: 0.2, rankOf: (part) => this.rankOf(part), always: true });
    this.seeThrough.forEach((i) => stage.scene.add(i.mesh));
    for (const d of this.deforming) this.fade(d.mesh, parts.hidden.has(d.body));
    for (const group of [this.groups.base, this.groups.world]) group.forEach((i) => i.place(this.motion.matrices));
    this.placeScene();
  }
  fade(mesh, on) {
    Object.assign(mesh.material, { transparent: on, opacity: on ? 0.3 : 1, depthWrite: !on, needsUpdate: true });
  }
  async copyLink() {
    this.address.write();
    const button = document.getElementById('link');
    try {
      await navigator.clipboard.writeText(location.href);
      button.textContent = 'Copied';
    } catch {
      button.textContent = 'In the address'; // where the browser gives pages no clipboard
    }
    setTimeout(() => { button.textContent = 'Link'; }, 2000);
  }

  // The step in whose world the shown moment was measured: where two meet, the first of them.
  stepOfMoment() {
    const time = this.motion.times[this.moment];
    return this.data.steps.find((s) => s.end > s.begin && time <= s.end);
  }

  refresh() {
    this.moment = this.motion.momentNear(this.time);
    this.motion.setTime(this.time);
    if (this.stage) this.placeScene();
    this.showDistance();
    this.controls.update();
    this.panel.update();
    this.plots.forEach((plot) => plot.paint());
  }
  placeScene() {
    const { matrices } = this.motion;
    for (const i of [...this.groups.robot, ...this.groups.driven, ...this.seeThrough]) i.place(matrices);
    this.paintBodies();
    this.outlines.forEach((outline) => outline.place(matrices, this.isHeld(outline.body)));
    this.compared?.setTime(this.time);
    if (this.balls.mesh.visible) this.balls.place(matrices);
    // Not where the robot itself stands.
    const stands = (e) => this.data.ends[e].valid && (e === 0 ? this.time === this.motion.begin : this.time >= this.motion.begin + this.motion.duration) && this.motion.duration > 0;
    this.endGhosts.forEach((ghost, e) => ghost.forEach((mesh) => { mesh.visible = this.showEnds && !stands(e); }));
    for (const { body, matrix, meshes } of this.placeGhosts) meshes.forEach((mesh) => { mesh.visible = this.showPlaces && !isNear(matrix, matrices.get(body)); });
    this.visual?.setTime(this.time);
    (this.pieces ?? []).forEach((i) => i.mesh.visible && i.place(matrices));
    this.deforming.forEach((d) => d.setTime(this.time));
    this.endFrames.forEach((axes) => { axes.visible = this.showEnds; });
    this.axes.place(this.motion.around(this.time));
    const closest = this.near.at(this.moment);
    if (closest && this.showNearest) this.nearest.set(this.motion.toWorld(closest.a, closest.point_a), this.motion.toWorld(closest.b, closest.point_b));
    else this.nearest.set(null, null);
    if (this.arrow) {
      this.arrow.group.visible = this.showNearest && this.moment === this.remedy.moment;
      this.arrow.update();
    }
    this.stage.draw();
  }
  // When what is said by colours has changed.
  paintBodies() {
    this.colliding = this.findColliding();
    const held = [...this.held].filter((body) => this.isHeld(body));
    const said = JSON.stringify([[...this.colliding], held, this.selected, [...this.marked], colours().page]);
    if (said === this.painted) return;
    this.painted = said;
    for (const i of [...Object.values(this.groups).flat(), ...this.seeThrough]) i.paint();
    for (const d of this.deforming) d.mesh.material.color.set(this.colourOfBody(d.body));
  }
  showDistance() {
    const { data, near } = this;
    const closest = near.at(this.moment);
    const still = this.motion.duration === 0;
    const proven = this.time === this.motion.times[this.moment] ? near.provenAt(this.moment) : near.proven(Math.min(this.motion.momentBefore(this.time), data.proven.all.length - 1));
    const decision = data.decisions.filter(([time], i) => i === 0 || time <= this.time).at(-1)?.[1] ?? null;
    const name = near.choices().find(([value]) => value === near.choice)[1];
    const lines = [];
    if (still && data.shown) lines.push(element('span', { id: 'shown', text: data.shown }));
    lines.push(element('strong', { id: 'distance', text: distanceText(closest) }));
    if (closest) lines.push(element('span', { id: 'pair', text: `${data.bodies[closest.a]} \u2013 ${data.bodies[closest.b]}` }));
    if (near.choice === 'world' || near.choice === 'self') {
      const other = near.choice === 'world' ? 'self' : 'world';
      const beside = near.least(other) < 0 ? '' : `; ${other === 'world' ? 'from the world' : 'from itself'} ${distanceText(near.at(this.moment, other))}`;
      lines.push(element('span', { className: 'soft', id: 'other', text: `${still ? '' : 'now, '}${name}${beside}` }));
    }
    if (closest) lines.push(element('span', { className: 'soft', text: `margin ${+(closest.margin * 1e3).toFixed(3)} mm` }));
    if (closest && proven !== undefined) lines.push(element('span', { className: 'soft', id: 'proven', text: proven === null ? 'not proven here' : `proven here${near.hasOwnBound() ? '' : ', of all pairs'}: ${provenText(proven, closest)}` }));
    if (this.compared) lines.push(...this.compared.lines(this, near.choice));
    const step = this.stepOfMoment();
    if (step) lines.push(element('span', { id: 'step', text: `${step.name} (${step.kind})` }));
    if (decision) {
      const word = element('span', { text: decision });
      word.style.color = decisionColour(decision) ?? '';
      lines.push(word);
    }
    this.nearestText.ariaLive = this.playing ? 'off' : 'polite'; // a motion is not read aloud
    this.nearestText.replaceChildren(...lines);
    this.nearestText.classList.toggle('bad', Boolean(closest) && closest.lower <= closest.margin);
  }
}

async function main() {
  try {
    const page = await unpack(document.getElementById('leeway-data').textContent.trim());
    window.leeway = new App(page);
  } catch (error) {
    console.error(error);
    document.body.append(element('p', { id: 'failed', text: `The page cannot be shown: ${error.message}. A browser of 2023 or later is needed.` }));
  }
}

main();
