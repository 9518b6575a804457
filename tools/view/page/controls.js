// Play, pause, scrub, speed, and the keyboard.
import { Vector3 } from 'three';
import { element } from './words.js';

const kTurn = Math.PI / 24; // of the camera with each key
const kSpeeds = [0.1, 0.25, 0.5, 1, 2, 4];

export class Controls {
  constructor(app) {
    this.app = app;
    const { motion } = app;
    this.play = element('button', { id: 'play', text: 'Play', onclick: () => app.toggle() });
    this.scrub = element('input', { id: 'scrub', type: 'range', min: motion.begin, max: app.end, step: 'any', value: motion.begin, 'aria-label': 'time', oninput: () => { const wanted = +this.scrub.value; app.pause(); app.seek(wanted); } });
    this.clock = element('output', { id: 'clock' });
    const rests = app.data.decisions.length === 0 && app.data.waypoints.length > 2;
    this.speed = element('select', { id: 'speed', 'aria-label': 'speed', onchange: () => { app.speed = +this.speed.value; } }, ...kSpeeds.map((s) => element('option', { value: s, text: `${s}\u00d7`, selected: s === 1 })));
    this.choice = element('select', { id: 'choice', 'aria-label': 'clearance', title: 'whose clearance is shown', onchange: () => app.choose(this.choice.value) }, ...app.near.choices().map(([value, text]) => element('option', { value, text, selected: value === app.near.choice })));
    this.scale = element('button', { id: 'scale', text: 'Near', title: 'a scale that shows what is near (L)', 'aria-pressed': 'false', onclick: () => app.changeScale() });
    this.root = element('div', { id: 'controls' }, this.play, this.scrub, this.clock, ...(rests ? [element('span', { className: 'soft whole', text: 'rests at waypoints', title: 'a trajectory that does not rest takes less time' })] : []), this.speed, this.choice, this.scale);
    const still = motion.duration === 0;
    this.root.hidden = still;
    window.addEventListener('keydown', (event) => this.key(event));
  }
  update() {
    const { app } = this;
    this.play.textContent = app.playing ? 'Pause' : 'Play';
    this.scrub.value = app.time;
    this.choice.value = app.near.choice;
    this.clock.textContent = `${app.time.toFixed(2)} / ${app.end.toFixed(2)} s`;
    if (app.recorder) {
      const record = app.view.querySelector('#record');
      record.hidden = !app.recorder.canRecord;
      record.textContent = app.recorder.recording ? 'Stop' : 'Video';
      record.setAttribute('aria-pressed', `${Boolean(app.recorder.recording)}`);
    }
  }
  faster(by) {
    const i = Math.min(Math.max(kSpeeds.indexOf(this.app.speed) + by, 0), kSpeeds.length - 1);
    this.app.speed = kSpeeds[i];
    this.speed.value = kSpeeds[i];
  }
  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches?.('select, input[type=checkbox]')) return;
    const { app } = this;
    const step = (by) => { app.pause(); app.seek(app.motion.times[Math.min(Math.max(app.moment + by, 0), app.motion.times.length - 1)]); };
    const from = (x, y, z) => app.lookAtAll(new Vector3(x, y, z));
    const turn = (...by) => () => app.stage?.turn(...by);
    const turns = { ArrowLeft: turn(-kTurn, 0), ArrowRight: turn(kTurn, 0), ArrowUp: turn(0, kTurn), ArrowDown: turn(0, -kTurn) };
    const actions = event.shiftKey && turns[event.key] ? turns : {
      ' ': () => app.toggle(),
      ArrowLeft: () => step(-1),
      ArrowRight: () => step(1),
      Home: () => step(-Infinity),
      End: () => step(Infinity),
      '+': () => this.faster(1), '=': () => this.faster(1), '-': () => this.faster(-1),
      m: () => app.seekLeast(),
      g: () => app.lookAtGap(),
      l: () => app.changeScale(),
      p: () => app.recorder.savePicture(),
      v: () => app.recorder.toggle(),
      f: () => app.lookAtAll(),
      i: turn(0, 0, 0.8), o: turn(0, 0, 1.25),
      1: () => from(0, -1, 0.05), 2: () => from(1, 0, 0.05), 3: () => from(0, -0.01, 1),
      Escape: () => app.select(-1),
    };
    const action = actions[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!action || (event.key === ' ' && event.target.matches?.('button, summary'))) return;
    event.preventDefault();
    action();
  }
}
