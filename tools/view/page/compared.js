// Another path of the same problem, beside the first: its robot as a ghost, its curve, its figures.
import { Motion } from './motion.js';
import { Nearness } from './nearness.js';
import { kRanks } from './shapes.js';
import { colours, onThemeChange } from './theme.js';
import { distanceText, element } from './words.js';

export class Compared {
  constructor(page, data) {
    const of = { document: { ...data, ...data.compared }, array: page.array };
    this.motion = new Motion(of);
    this.near = new Nearness(of);
    this.label = data.compared.label;
    this.mine = data.label;
    this.verdict = data.compared.verdict;
    this.good = data.compared.good;
    this.end = this.motion.begin + this.motion.duration;
    this.instances = [];
    this.meshes = [];
  }
  addTo(scene, parts, robot) {
    this.instances = parts.instances(robot, () => colours().compared, { opacity: 0.45, rankOf: () => kRanks.ghost / 2 });
    this.meshes = this.instances.map((i) => i.mesh);
    this.meshes.forEach((mesh) => scene.add(mesh));
    onThemeChange(() => this.instances.forEach((i) => i.paint()));
  }
  setTime(time) {
    this.motion.setTime(Math.min(time, this.end));
    this.instances.forEach((i) => i.place(this.motion.matrices));
  }
  // Pairs are those of the first path: with one of them chosen, the other path has none.
  at(time, choice) {
    return choice === 'world' || choice === 'self' ? this.near.at(this.motion.momentNear(time), choice) : null;
  }
  lines(app, choice) {
    if (choice !== 'world' && choice !== 'self') return [];
    const line = element('span', { id: 'other-path', text: `${this.label}: ${distanceText(this.at(app.time, choice))}` });
    line.style.color = colours().compared;
    return [line];
  }
  // Its least clearances, for the panel.
  least(choice) {
    const moment = this.near.least(choice);
    return moment < 0 ? null : { near: this.near.at(moment, choice), time: this.motion.times[moment] };
  }
}
