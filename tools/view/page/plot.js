// The plots below the scene: clearance and joints over time, and the line that shows where one is.
import { colours, joints as jointColours, onThemeChange } from './theme.js';
import { distanceText, provenText } from './words.js';

const kLeft = 46, kRight = 10, kTitle = 24, kRow = 14, kBottom = 20, kNameRows = 4;

// About `count` round numbers between two ends.
function ticks(low, high, count) {
  const rough = (high - low) / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((s) => s * power).find((s) => s >= rough) ?? rough;
  const all = [];
  for (let x = Math.ceil(low / step - 1e-9) * step; x <= high + 1e-9 * step; x += step) all.push(Math.abs(x) < 1e-12 ? 0 : x);
  return all;
}

class Plot {
  constructor(canvas, app) {
    this.canvas = canvas;
    this.app = app;
    this.top = kTitle;
    new ResizeObserver(() => this.paint()).observe(canvas);
    onThemeChange(() => this.paint());
    const seek = (event) => {
      const box = canvas.getBoundingClientRect();
      const share = (event.clientX - box.left - kLeft) / Math.max(box.width - kLeft - kRight, 1);
      app.seek(app.motion.begin + Math.min(Math.max(share, 0), 1) * (app.end - app.motion.begin));
    };
    canvas.addEventListener('pointerdown', (event) => { canvas.setPointerCapture(event.pointerId); app.pause(); seek(event); });
    canvas.addEventListener('pointermove', (event) => {
      if (canvas.hasPointerCapture(event.pointerId)) seek(event);
      const box = canvas.getBoundingClientRect();
      this.hover = event.pointerType === 'touch' ? null : [event.clientX - box.left, event.clientY - box.top];
      this.paint();
    });
    canvas.addEventListener('pointerleave', () => { this.hover = null; this.paint(); });
  }
  // A box of values beside the pointer: `lines(moment, y)` of [text, colour].
  tell(lines) {
    if (!this.hover) return;
    const { c, app } = this;
    const share = (this.hover[0] - kLeft) / Math.max(this.width - kLeft - kRight, 1);
    if (share < 0 || share > 1) return;
    const moment = app.motion.momentNear(app.motion.begin + share * (app.end - app.motion.begin));
    const at = this.x(app.motion.times[moment]);
    const all = [[`${app.motion.times[moment].toFixed(3)} s`, this.colours.ink], ...lines(moment, this.hover[1])];
    c.strokeStyle = this.colours.soft;
    c.lineWidth = 1;
    this.stroke([[at, this.top - 4], [at, this.height - kBottom]], [2, 2]);
    const width = Math.max(...all.map(([text]) => c.measureText(text).width)) + 12;
    const x = at + width + 8 > this.width ? Math.max(at - width - 8, 0) : at + 8;
    c.fillStyle = this.colours.page;
    c.globalAlpha = 0.92;
    c.fillRect(x, this.top, width, 15 * all.length + 6);
    c.globalAlpha = 1;
    c.strokeRect(x + 0.5, this.top + 0.5, width, 15 * all.length + 6);
    c.textAlign = 'left';
    c.textBaseline = 'top';
    all.forEach(([text, colour], i) => { c.fillStyle = colour; c.fillText(text, x + 6, this.top + 5 + 15 * i); });
  }
  x(time) {
    const { begin } = this.app.motion;
    const duration = this.app.end - begin;
    return kLeft + (duration > 0 ? (time - begin) / duration : 0.5) * (this.width - kLeft - kRight);
  }
  // A plot's own scale: numbers to numbers, rising.
  scaled(value) {
    return value;
  }
  y(value) {
    const [low, high] = [this.scaled(this.low), this.scaled(this.high)];
    return this.top + (1 - (this.scaled(value) - low) / (high - low)) * (this.height - this.top - kBottom);
  }
  rows() {
    return ticks(this.low, this.high, 4);
  }
  begin() {
    const ratio = window.devicePixelRatio || 1;
    this.width = this.canvas.clientWidth;
    this.height = this.canvas.clientHeight;
    this.canvas.width = Math.round(this.width * ratio);
    this.canvas.height = Math.round(this.height * ratio);
    const c = this.canvas.getContext('2d');
    c.scale(ratio, ratio);
    c.font = '11px system-ui, sans-serif';
    c.lineJoin = 'round';
    this.c = c;
    this.colours = colours();
  }
  axes(label, format) {
    const { c, colours: colour } = this;
    c.strokeStyle = colour.line;
    c.fillStyle = colour.soft;
    c.lineWidth = 1;
    c.textAlign = 'right';
    c.textBaseline = 'middle';
    for (const value of this.rows()) {
      const y = Math.round(this.y(value)) + 0.5;
      this.stroke([[kLeft, y], [this.width - kRight, y]]);
      c.fillText(format(value), kLeft - 6, y);
    }
    c.textBaseline = 'top';
    const { begin } = this.app.motion;
    const duration = this.app.end - begin;
    if (duration > 0) {
      for (const time of ticks(begin, begin + duration, Math.max(this.width / 90, 2))) {
        c.textAlign = time === begin ? 'left' : this.x(time) > this.width - 24 ? 'right' : 'center';
        c.fillText(`${+time.toFixed(3)} s`, this.x(time), this.height - kBottom + 6);
      }
    }
    c.textAlign = 'left';
    c.fillStyle = colour.ink;
    c.fillText(label, 4, 2);
  }
  stroke(points, dash = []) {
    const { c } = this;
    c.setLineDash(dash);
    c.beginPath();
    points.forEach(([x, y], i) => (i === 0 ? c.moveTo(x, y) : c.lineTo(x, y)));
    c.stroke();
    c.setLineDash([]);
  }
  cursor() {
    const { c } = this;
    c.strokeStyle = this.colours.ink;
    c.lineWidth = 1.5;
    const x = this.x(this.app.time);
    this.stroke([[x, this.top - 4], [x, this.height - kBottom]]);
  }
}

export class ClearancePlot extends Plot {
  constructor(canvas, app) {
    super(canvas, app);
    const { data } = app;
    const millimetres = (values) => values.map((v) => (v === null ? null : v * 1e3));
    this.groups = { world: millimetres(app.near.values('world')), self: millimetres(app.near.values('self')) };
    this.other = app.compared ? { world: millimetres(app.compared.near.values('world')), self: millimetres(app.compared.near.values('self')) } : {};
    this.keep = data.keep === null ? null : data.keep * 1e3;
    this.isNear = false; // the scale that shows what is near
    this.choose();
  }
  // The plot holds all of the chosen curve; the other one may leave it.
  choose() {
    const { near, data } = this.app;
    const millimetres = (values) => values.map((v) => (v === null ? null : v * 1e3));
    this.measured = this.groups[near.choice] ?? millimetres(near.values());
    this.proven = millimetres(data.proven.all.map((_, i) => near.proven(i) ?? null));
    this.margins = near.margins().map(([margin, of]) => [margin * 1e3, of]);
    const values = [...this.measured, ...(this.other[near.choice] ?? []), ...this.proven, ...this.margins.map(([m]) => m), ...(near.choice === 'world' ? [this.keep] : [])].filter((v) => v !== null && Number.isFinite(v));
    this.low = Math.min(0, ...values);
    // Names of steps stand above the curves.
    this.high = Math.max(this.low + 1, ...values) * (data.steps.length > 0 && !this.isNear ? 1.3 : 1.06);
    this.empty = this.measured.every((v) => v === null);
  }
  // Even in millimetres up to about the margin, then in powers.
  scaled(value) {
    return this.isNear ? Math.asinh(value / 1) : value;
  }
  rows() {
    if (!this.isNear) return super.rows();
    const all = [0];
    for (let power = 1; power < Math.max(this.high, -this.low); power *= 10) for (const x of [power, 2 * power, 5 * power]) all.push(x, -x);
    return all.filter((x) => x >= this.low && x <= this.high);
  }
  paint() {
    if (this.canvas.clientWidth === 0) return;
    this.begin();
    const { c, colours: colour, app } = this;
    this.legend(this.width > 400 ? 92 : 28);
    this.axes(this.width > 400 ? 'clearance [mm]' : 'mm', (v) => `${+v.toFixed(6)}`);
    if (this.empty) {
      c.fillStyle = colour.soft;
      c.textAlign = 'center';
      c.fillText('nothing is near', this.width / 2, this.height / 2);
    }
    const times = app.motion.times;
    c.save();
    c.beginPath();
    c.rect(kLeft - 4, this.top - 4, this.width - kLeft - kRight + 8, this.height - this.top - kBottom + 8);
    c.clip();
    c.fillStyle = colour.collision;
    c.globalAlpha = 0.22;
    for (const [from, to] of this.collisions()) c.fillRect(this.x(from) - 1, this.top, Math.max(this.x(to) - this.x(from), 2) + 1, this.height - this.top - kBottom);
    c.globalAlpha = 1;
    // The proven bound, stretch by stretch, filled: room that is certain.
    c.fillStyle = c.strokeStyle = colour.proven;
    const fill = new Path2D();
    const edge = new Path2D();
    this.proven.forEach((value, i) => {
      if (value === null) return;
      const [x, next, y] = [this.x(times[i]), this.x(times[i + 1]), this.y(value)];
      fill.rect(x, this.y(0), next - x, y - this.y(0));
      if (i === 0 || this.proven[i - 1] === null) edge.moveTo(x, y);
      else edge.lineTo(x, y);
      edge.lineTo(next, y);
    });
    c.globalAlpha = 0.18;
    c.fill(fill);
    c.globalAlpha = 1;
    c.lineWidth = 1.6;
    c.stroke(edge);
    for (const group of ['world', 'self']) if (this.groups[group] !== this.measured) this.curve(this.groups[group], this.colourOf(group), 1, [5, 3]);
    if (this.other[app.near.choice]) this.curve(this.other[app.near.choice], colour.compared, 1.6, [], app.compared.motion.times);
    this.curve(this.measured, this.colourOf(app.near.choice), 1.6);
    this.least();
    c.restore();
    const lines = [...this.margins.map(([value, of]) => [value, of, [6, 4]]), ...(this.keep !== null && app.near.choice === 'world' ? [[this.keep, '', [2, 3]]] : [])];
    c.textAlign = 'right';
    c.textBaseline = 'bottom';
    const taken = []; // by labels: [left, right, y]
    for (const [value, of, dash] of lines) {
      c.strokeStyle = c.fillStyle = colour.margin;
      c.lineWidth = 1.4;
      this.stroke([[kLeft, this.y(value)], [this.width - kRight, this.y(value)]], dash);
      if (!of) continue;
      const label = `${of}: ${+value.toFixed(3)}`;
      const [wide, y] = [c.measureText(label).width, this.y(value) - 1];
      let right = this.width - kRight - 2;
      // A label moves left if it would cover the label of a similar margin.
      for (const [from, to, other] of taken) if (Math.abs(other - y) < 12 && from < right && right - wide < to) right = from - 8;
      taken.push([right - wide, right, y]);
      c.fillText(label, right, y);
    }
    this.decisions();
    this.steps();
    this.cursor();
    this.tell((moment) => this.lines(moment));
  }
  // The stretches of time whose moments have a pair that is not farther apart than its margin.
  collisions() {
    if (this.tooNear) return this.tooNear;
    const { near, motion, data } = this.app;
    const isNear = (closest) => Boolean(closest) && closest.lower !== null && closest.lower <= closest.margin;
    this.tooNear = [];
    let last = null;
    data.world.forEach((_, i) => {
      if (!['world', 'self', ...near.pairs.keys()].some((choice) => isNear(near.at(i, `${choice}`)))) { last = null; return; }
      if (last) last[1] = motion.times[i];
      else this.tooNear.push(last = [motion.times[i], motion.times[i]]);
    });
    return this.tooNear;
  }
  colourOf(choice) {
    return { world: this.colours.measured, self: this.colours.self }[choice] ?? this.colours.goal;
  }
  // The values at a moment.
  lines(moment) {
    const { near, data, motion } = this.app;
    const text = (name, closest) => `${name} ${distanceText(closest)}${closest ? `, ${data.bodies[closest.a]} \u2013 ${data.bodies[closest.b]}` : ''}`;
    const all = [['world', 'from the world'], ['self', 'from itself']].map(([group, name]) => [text(name, near.at(moment, group)), this.colourOf(group)]);
    if (this.other[near.choice]) all.push([text(this.app.compared.label, this.app.compared.at(motion.times[moment], near.choice)), this.colours.compared]);
    if (!this.groups[near.choice]) all.unshift([text('chosen', near.at(moment)), this.colourOf(near.choice)]);
    const proven = near.provenAt(moment);
    if (near.at(moment) && proven !== undefined) all.push([proven === null ? 'not proven' : `proven${near.hasOwnBound() ? '' : ' of all pairs'} ${provenText(proven, near.at(moment))}`, this.colours.proven]);
    return all;
  }
  // Where the steps of a task begin. A name stands where its stretch has room for it.
  steps() {
    const { c, colours: colour, app } = this;
    c.strokeStyle = colour.line;
    c.fillStyle = colour.soft;
    c.lineWidth = 1;
    c.textAlign = 'left';
    c.textBaseline = 'top';
    for (const { name, begin, end } of app.data.steps) {
      const [x, next] = [Math.round(this.x(begin)) + 0.5, this.x(end)];
      this.stroke([[x, this.top], [x, this.height - kBottom]]);
      if (end > begin && next - x > c.measureText(name).width + 6) c.fillText(name, x + 3, this.top + 2);
    }
  }
  curve(values, colourOf, width, dash = [], times = this.app.motion.times) {
    const { c } = this;
    c.strokeStyle = colourOf;
    c.lineWidth = width;
    c.setLineDash(dash);
    c.beginPath();
    let down = false;
    values.forEach((value, i) => {
      if (value === null) { down = false; return; }
      const [x, y] = [this.x(times[i]), this.y(value)];
      if (down) c.lineTo(x, y);
      else c.moveTo(x, y);
      down = true;
    });
    c.stroke();
    c.setLineDash([]);
  }
  least() {
    const { c, colours: colour, app } = this;
    const least = app.near.least();
    if (least < 0 || this.measured[least] === null) return;
    c.fillStyle = colour.nearest;
    c.beginPath();
    c.arc(this.x(app.motion.times[least]), this.y(this.measured[least]), 3.5, 0, 2 * Math.PI);
    c.fill();
  }
  legend(from) {
    const { c, colours: colour } = this;
    const { choice } = this.app.near;
    const dash = (group) => (choice === group ? [] : [5, 3]);
    const entries = [['proven', colour.proven, []], ['world', this.colourOf('world'), dash('world')], ['itself', this.colourOf('self'), dash('self')], ['margin', colour.margin, [6, 4]], ['least', colour.nearest, null]];
    if (this.collisions().length > 0) entries.push(['too near', colour.collision, []]);
    for (const decision of new Set(this.app.data.decisions.map(([, of]) => of))) if (decisionColour(decision)) entries.push([decision, decisionColour(decision), []]);
    if (this.other[choice]) entries.splice(3, 0, [this.app.compared.label, colour.compared, []]);
    if (!this.groups[choice]) entries.splice(1, 0, ['pair', this.colourOf(choice), []]);
    if (this.keep !== null && choice === 'world') entries.splice(4, 0, ['kept from the world', colour.margin, [2, 3]]);
    c.textBaseline = 'top';
    c.textAlign = 'left';
    // Entries fill rows and stand at the right.
    const rows = [[]];
    const widthOf = (row) => row.reduce((sum, [name]) => sum + c.measureText(name).width + 30, 0);
    for (const entry of entries) {
      if (rows[rows.length - 1].length > 0 && from + widthOf([...rows[rows.length - 1], entry]) > this.width - kRight) rows.push([]);
      rows[rows.length - 1].push(entry);
    }
    this.top = kTitle + kRow * (rows.length - 1);
    rows.forEach((row, i) => this.legendRow(row, this.width - kRight - widthOf(row), kRow * i));
  }
  legendRow(entries, left, top) {
    const { c, colours: colour } = this;
    let x = left;
    for (const [name, colourOf, dashOf] of entries) {
      c.strokeStyle = c.fillStyle = colourOf;
      c.lineWidth = 2;
      if (dashOf) this.stroke([[x, top + 8], [x + 16, top + 8]], dashOf);
      else { c.beginPath(); c.arc(x + 10, top + 8, 3.5, 0, 2 * Math.PI); c.fill(); }
      c.fillStyle = colour.soft;
      c.fillText(name, x + 20, top + 2);
      x += c.measureText(name).width + 30;
    }
  }
  // New plans, waits and evasions of an execution, along the bottom.
  decisions() {
    const { c, app } = this;
    app.data.decisions.forEach(([time, decision], i) => {
      if (!decisionColour(decision)) return;
      const next = app.data.decisions[i + 1]?.[0] ?? app.end;
      c.fillStyle = decisionColour(decision);
      c.fillRect(this.x(time), this.height - kBottom - 4, Math.max(this.x(next) - this.x(time), 2), 4);
    });
  }
}

// What follows its path has none.
export function decisionColour(decision) {
  const c = colours();
  return { plan: c.start, wait: c.goal, evade: c.margin, unsafe: c.nearest }[decision];
}

// Joints between their limits, or between the ends of what they do where they have none.
export class JointPlot extends Plot {
  constructor(canvas, app) {
    super(canvas, app);
    this.low = 0;
    this.high = 1;
    const n = app.data.joints.length;
    this.ranges = app.data.joints.map((joint, j) => {
      if (joint.lower !== null && joint.upper !== null && joint.upper > joint.lower) return [joint.lower, joint.upper];
      let [low, high] = [Infinity, -Infinity];
      for (let m = 0; m < app.motion.times.length; ++m) {
        const value = app.positions[m * n + j];
        low = Math.min(low, value);
        high = Math.max(high, value);
      }
      return high > low ? [low, high] : [low - 1, low + 1];
    });
  }
  // Where names stand, from the right: [name, joint, right end, row]. Names that do not fit into kNameRows rows have no place.
  placeNames() {
    const { c, app } = this;
    const rows = [[]];
    let x = this.width - kRight;
    app.data.joints.forEach(({ name }, j) => {
      const width = c.measureText(name).width + 9;
      if (x - width < (rows.length === 1 ? 150 : 0) && rows[rows.length - 1].length > 0) { rows.push([]); x = this.width - kRight; }
      rows[rows.length - 1].push([name, j, width]);
      x -= width;
    });
    this.placed = rows.length > kNameRows ? [] : rows.flatMap((row, r) => {
      let right = this.width - kRight;
      return row.reverse().map(([name, j, width]) => { right -= width; return [name, j, right + width, r]; });
    });
    this.top = kTitle + kRow * (this.placed.length > 0 ? rows.length - 1 : 0);
  }
  paint() {
    if (this.canvas.clientWidth === 0) return;
    this.begin();
    const { c, app } = this;
    this.placeNames();
    this.axes('joints, between their limits', (v) => (v === 0 ? 'lower' : v === 1 ? 'upper' : ''));
    const n = app.data.joints.length;
    c.lineWidth = 1.4;
    this.ranges.forEach(([low, high], j) => {
      c.strokeStyle = jointColours[j % jointColours.length];
      this.stroke(app.motion.times.map((time, m) => [this.x(time), this.y((app.positions[m * n + j] - low) / (high - low))]), jointDash(j));
    });
    this.cursor();
    this.names();
    this.tell((moment, y) => this.line(moment, y));
  }
  // Names in the colours of the lines, as far as there is room.
  names() {
    const { c, app } = this;
    c.textAlign = 'right';
    c.textBaseline = 'top';
    for (const [name, j, x, row] of this.placed) {
      c.fillStyle = jointColours[j % jointColours.length];
      c.fillText(name, x, 2 + kRow * row);
    }
  }
  // The joint whose line is nearest to the pointer.
  line(moment, y) {
    const { app } = this;
    const n = app.data.joints.length;
    const away = ([low, high], j) => Math.abs(this.y((app.positions[moment * n + j] - low) / (high - low)) - y);
    const nearest = this.ranges.reduce((best, range, j) => (best < 0 || away(range, j) < away(this.ranges[best], best) ? j : best), -1);
    if (nearest < 0) return [];
    const { name, unit } = app.data.joints[nearest];
    return [[`${name}: ${app.positions[moment * n + nearest].toFixed(4)} ${unit}`, jointColours[nearest % jointColours.length]]];
  }
}

export const jointDash = (j) => [[], [7, 3], [2, 3]][Math.floor(j / jointColours.length) % 3];
