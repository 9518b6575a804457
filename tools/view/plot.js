// The plots below the scene: clearance and joints over time, and the line that shows where one is.
import { colours, joints as jointColours, onThemeChange } from './theme.js';

const kLeft = 46, kRight = 10, kTop = 24, kBottom = 20;

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
    new ResizeObserver(() => this.paint()).observe(canvas);
    onThemeChange(() => this.paint());
    const seek = (event) => {
      const box = canvas.getBoundingClientRect();
      const share = (event.clientX - box.left - kLeft) / Math.max(box.width - kLeft - kRight, 1);
      app.seek(app.motion.begin + Math.min(Math.max(share, 0), 1) * app.motion.duration);
    };
    canvas.addEventListener('pointerdown', (event) => { canvas.setPointerCapture(event.pointerId); app.pause(); seek(event); });
    canvas.addEventListener('pointermove', (event) => { if (canvas.hasPointerCapture(event.pointerId)) seek(event); });
  }
  x(time) {
    const { begin, duration } = this.app.motion;
    return kLeft + (duration > 0 ? (time - begin) / duration : 0.5) * (this.width - kLeft - kRight);
  }
  y(value) {
    return kTop + (1 - (value - this.low) / (this.high - this.low)) * (this.height - kTop - kBottom);
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
    for (const value of ticks(this.low, this.high, 4)) {
      const y = Math.round(this.y(value)) + 0.5;
      this.stroke([[kLeft, y], [this.width - kRight, y]]);
      c.fillText(format(value), kLeft - 6, y);
    }
    c.textBaseline = 'top';
    const { begin, duration } = this.app.motion;
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
    this.stroke([[x, kTop - 4], [x, this.height - kBottom]]);
  }
}

export class ClearancePlot extends Plot {
  constructor(canvas, app) {
    super(canvas, app);
    const { data } = app;
    this.measured = data.closest.map((c) => (c ? c.lower * 1e3 : null));
    this.proven = data.proven.map((p) => (p === null ? null : p * 1e3));
    this.margin = data.margin === null ? null : data.margin * 1e3;
    this.keep = data.keep === null ? null : data.keep * 1e3;
    const values = [...this.measured, ...this.proven, this.margin, this.keep].filter((v) => v !== null && Number.isFinite(v));
    this.low = Math.min(0, ...values);
    // Names of steps stand above the curves.
    this.high = Math.max(this.low + 1, ...values) * (data.steps.length > 0 ? 1.3 : 1.06);
    this.empty = values.length === 0;
  }
  paint() {
    if (this.canvas.clientWidth === 0) return;
    this.begin();
    const { c, colours: colour, app } = this;
    this.axes(this.width > 400 ? 'clearance [mm]' : 'mm', (v) => `${+v.toFixed(6)}`);
    this.legend(this.width > 400 ? 92 : 28);
    if (this.empty) {
      c.fillStyle = colour.soft;
      c.textAlign = 'center';
      c.fillText('nothing is near', this.width / 2, this.height / 2);
    }
    const times = app.motion.times;
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
    this.curve();
    for (const [value, dash] of [[this.margin, [6, 4]], [this.keep, [2, 3]]]) {
      if (value === null) continue;
      c.strokeStyle = colour.margin;
      c.lineWidth = 1.4;
      this.stroke([[kLeft, this.y(value)], [this.width - kRight, this.y(value)]], dash);
    }
    this.decisions();
    this.steps();
    this.cursor();
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
      this.stroke([[x, kTop], [x, this.height - kBottom]]);
      if (end > begin && next - x > c.measureText(name).width + 6) c.fillText(name, x + 3, kTop + 2);
    }
  }
  curve() {
    const { c, colours: colour, app } = this;
    c.strokeStyle = colour.measured;
    c.lineWidth = 1.1;
    c.beginPath();
    let down = false;
    let least = -1;
    this.measured.forEach((value, i) => {
      if (value === null) { down = false; return; }
      const [x, y] = [this.x(app.motion.times[i]), this.y(value)];
      if (down) c.lineTo(x, y);
      else c.moveTo(x, y);
      down = true;
      if (least < 0 || value < this.measured[least]) least = i;
    });
    c.stroke();
    if (least < 0) return;
    c.fillStyle = colour.nearest;
    c.beginPath();
    c.arc(this.x(app.motion.times[least]), this.y(this.measured[least]), 3.5, 0, 2 * Math.PI);
    c.fill();
  }
  legend(from) {
    const { c, colours: colour } = this;
    const entries = [['proven', colour.proven, []], ['at moments', colour.measured, []], ['margin', colour.margin, [4, 3]], ['least', colour.nearest, null]];
    if (this.keep !== null) entries.splice(3, 0, ['kept from the world', colour.margin, [2, 3]]);
    c.textBaseline = 'top';
    c.textAlign = 'left';
    let x = this.width - kRight - entries.reduce((sum, [name]) => sum + c.measureText(name).width + 30, 0);
    if (x < from) return;
    for (const [name, colourOf, dash] of entries) {
      c.strokeStyle = c.fillStyle = colourOf;
      c.lineWidth = 2;
      if (dash) this.stroke([[x, 8], [x + 16, 8]], dash);
      else { c.beginPath(); c.arc(x + 10, 8, 3.5, 0, 2 * Math.PI); c.fill(); }
      c.fillStyle = colour.soft;
      c.fillText(name, x + 20, 2);
      x += c.measureText(name).width + 30;
    }
  }
  // New plans, waits and evasions of an execution, along the bottom.
  decisions() {
    const { c, app } = this;
    app.data.decisions.forEach(([time, decision], i) => {
      if (!decisionColour(decision)) return;
      const next = app.data.decisions[i + 1]?.[0] ?? app.motion.begin + app.motion.duration;
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
  paint() {
    if (this.canvas.clientWidth === 0) return;
    this.begin();
    const { c, app } = this;
    this.axes('joints, between their limits', (v) => (v === 0 ? 'lower' : v === 1 ? 'upper' : ''));
    const n = app.data.joints.length;
    c.lineWidth = 1.4;
    this.ranges.forEach(([low, high], j) => {
      c.strokeStyle = jointColours[j % jointColours.length];
      this.stroke(app.motion.times.map((time, m) => [this.x(time), this.y((app.positions[m * n + j] - low) / (high - low))]), jointDash(j));
    });
    this.cursor();
  }
}

export const jointDash = (j) => [[], [7, 3], [2, 3]][Math.floor(j / jointColours.length) % 3];
