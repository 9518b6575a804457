// The texts beside the scene: what came out, what is selected, layers, joints, pairs left out.
import { distanceText, element, shapeText } from './words.js';
import { advice } from './summary.js';
import { joints as jointColours } from './theme.js';

const kListed = 500; // objects of a list: more make a page slow

export class Panel {
  constructor(app) {
    this.app = app;
    const { data } = app;
    this.selection = element('div', { id: 'selection' });
    this.jointValues = data.joints.map(() => element('td', { className: 'number' }));
    this.root = element('aside', { id: 'panel' },
      this.section('Result', true, ...this.result()),
      ...(data.warnings.length > 0 ? [this.section(`Warnings (${data.warnings.length})`, data.warnings.length <= 3, element('ul', { id: 'warnings' }, ...data.warnings.map((text) => element('li', { text }))))] : []),
      ...(app.stage ? [this.section('Selected', true, this.selection)] : []),
      ...(app.stage ? [this.section('Layers', true, ...this.layers())] : []),
      this.section(`Objects (${data.bodies.length})`, false, this.objects()),
      this.section(`Joints (${data.joints.length})`, data.joints.length <= 8, this.joints()),
      this.section(`Pairs not checked (${data.dropped_count})`, false, ...this.dropped()),
      this.section('Keys', false, ...keys()));
    this.select(-1);
  }
  section(title, open, ...children) {
    return element('details', { open }, element('summary', { text: title }), ...children);
  }

  result() {
    const { data } = this.app;
    const notes = data.notes.map((note) => element('p', { text: note }));
    const [fewest, most] = data.pair_count;
    const pairs = fewest === most ? `${most} ${most === 1 ? 'pair of parts is' : 'pairs of parts are'} checked` : `${fewest} to ${most} pairs of parts are checked, by step`;
    const count = `${data.bodies.length} bodies in ${data.parts.count} parts, ${pairs}`;
    const error = data.triangles > 0 ? `; meshes are shown to within ${(data.mesh_error * 1e3).toPrecision(2)} mm` : '';
    const steps = data.steps.map((step) => element('button', { className: 'link', text: `${step.begin.toFixed(2)} s: ${step.name} (${step.kind})`, onclick: () => { this.app.pause(); this.app.seek(step.begin); } }));
    const widen = advice(this.app);
    const drawn = this.app.visualNote ? [element('p', { id: 'visual-note', text: this.app.visualNote })] : [];
    return [...this.least(), ...(widen ? [element('p', { id: 'advice' }, widen[0], element('span', { className: 'whole', text: widen[1] }), '.')] : []), ...this.compared(), ...notes, ...this.blocked(), ...drawn, ...steps, element('p', { className: 'soft', text: `${(data.source || data.name).replaceAll('/', '/\u200b')}: ${count}${error}.` })];
  }

  // The least clearances, which also go there.
  least() {
    const { app } = this;
    return [['world', 'the world'], ['self', 'itself']].flatMap(([choice, what]) => {
      const moment = app.near.least(choice);
      const near = moment >= 0 ? app.near.at(moment, choice) : null;
      if (!near || app.motion.duration === 0) return [];
      const text = `nearest to ${what}: ${distanceText(near)}, ${app.data.bodies[near.a]} and ${app.data.bodies[near.b]}, ${app.motion.times[moment].toFixed(2)} s`;
      return [element('button', { className: 'link', id: `least-${choice}`, text, onclick: () => { app.choose(choice); app.seekLeast(); } })];
    });
  }

  // The pairs that blocked the search; a click marks both bodies.
  blocked() {
    const { app } = this;
    const rows = app.data.blocked.map(({ names, bodies, edges }) => {
      const text = `${names[0]} \u2013 ${names[1]}: ${edges} edge${edges === 1 ? '' : 's'}`;
      return element('li', {}, app.stage ? element('button', { className: 'link', text, onclick: () => app.mark(bodies) }) : text);
    });
    return rows.length > 0 ? [element('h4', { text: 'What blocked the search' }), element('ul', { id: 'blocked' }, ...rows)] : [];
  }

  // The other path's figures beside the first one's.
  compared() {
    const { app } = this;
    const { compared } = app;
    if (!compared) return [];
    const rows = [['verdict', app.data.verdict, compared.verdict], ['time', `${app.motion.duration.toFixed(2)} s`, `${compared.motion.duration.toFixed(2)} s`]];
    for (const [choice, what] of [['world', 'from the world'], ['self', 'from itself']]) {
      const moment = app.near.least(choice);
      const other = compared.least(choice);
      if (moment < 0 && !other) continue;
      rows.push([what, moment < 0 ? 'nothing near' : distanceText(app.near.at(moment, choice)), other ? distanceText(other.near) : 'nothing near']);
    }
    // Names of files break after their signs.
    const name = (label) => element('th', {}, ...label.split(/(?<=[._-])/).flatMap((part) => [part, element('wbr')]));
    const mark = name(compared.label);
    mark.classList.add('compared');
    return [element('table', { id: 'compared' }, element('thead', {}, element('tr', {}, element('th', {}), name(compared.mine), mark)),
      element('tbody', {}, ...rows.map(([what, a, b]) => element('tr', {}, element('td', { text: what }), element('td', { text: a }), element('td', { text: b })))))];
  }

  layers() {
    return this.app.layers.map((layer) => {
      const { name, shown, set } = layer;
      const box = element('input', { type: 'checkbox', checked: shown, onchange: () => { set(box.checked); words.textContent = layer.name; this.app.refresh(); } });
      const words = element('span', { text: name });
      return element('label', { className: 'layer' }, box, words);
    });
  }

  // The robot as a tree of links with what they hold, then the world. A click selects.
  objects() {
    const { data, links } = this.app;
    const children = new Map();
    data.parents.forEach((parent, body) => children.set(parent, [...(children.get(parent) ?? []), body]));
    let left = kListed;
    const list = (bodies) => element('ul', { className: 'tree' }, ...bodies.flatMap((body) => {
      if (left-- <= 0) return [];
      const name = element('button', { className: 'link', text: data.bodies[body], onclick: () => this.app.select(body) });
      const below = children.get(body) ?? [];
      return [element('li', {}, name, ...(below.length > 0 ? [list(below)] : []))];
    }));
    const roots = children.get(-1) ?? [];
    const trees = [['robot', roots.filter((body) => links.has(body))], ['world', roots.filter((body) => !links.has(body))]].filter(([, bodies]) => bodies.length > 0);
    const lists = trees.flatMap(([title, bodies]) => [element('h4', { text: title }), list(bodies)]);
    const more = data.bodies.length - Math.min(data.bodies.length, kListed);
    return element('div', { id: 'objects' }, ...lists, ...(more > 0 ? [element('p', { className: 'soft', text: `and ${more} more: click them in the scene` })] : []));
  }

  joints() {
    const rows = this.app.data.joints.map((joint, j) => {
      const mark = element('span', { className: 'mark' });
      mark.style.background = jointColours[j % jointColours.length];
      return element('tr', {}, element('td', {}, mark), element('td', { text: joint.name }), this.jointValues[j]);
    });
    return element('table', {}, element('tbody', {}, ...rows));
  }

  dropped() {
    const { data } = this.app;
    const rows = data.dropped.map(([a, b, reason]) => element('li', {}, `${a} \u2013 ${b}`, element('span', { className: 'soft', text: ` ${reason}` })));
    const more = data.dropped_count - data.dropped.length;
    return [element('ul', {}, ...rows), ...(more > 0 ? [element('p', { className: 'soft', text: `and ${more} more: see leeway info` })] : [])];
  }

  select(body) {
    const { app } = this;
    this.body = body;
    if (body < 0) {
      this.selection.replaceChildren(element('p', { className: 'soft', text: 'Click or tap a link or an object.' }));
      return;
    }
    const { data, parts } = app;
    const rows = [element('h3', { id: 'selected-name', text: data.bodies[body] })];
    const kinds = app.partsOf(body).slice(0, 6);
    for (const part of kinds) {
      const name = parts.names.get(part);
      rows.push(element('p', { text: `${name ? `${name}: ` : ''}${shapeText(parts.kind[part], parts.sizeOf(part))}` }));
    }
    this.clearanceNow = element('p', { id: 'selected-clearance' });
    rows.push(this.clearanceNow);
    const moment = app.leastMoment[body] - 1;
    if (moment >= 0) {
      const time = app.motion.times[moment];
      rows.push(element('button', { className: 'link', text: `least where it was measured ${distanceText({ lower: app.leastClearance[body], upper: app.leastClearance[body] })} at ${time.toFixed(2)} s`, onclick: () => { app.pause(); app.seek(time); } }));
    }
    if (app.motion.matrices.has(body)) rows.push(element('button', { className: 'link', text: app.search ? 'show its trail and the search' : 'show its trail', onclick: () => app.showTrail(body) }));
    this.selection.replaceChildren(...rows);
    this.update();
  }

  update() {
    const { app } = this;
    app.data.joints.forEach((joint, j) => {
      const value = app.positions[app.moment * app.data.joints.length + j];
      this.jointValues[j].textContent = `${value.toFixed(3)} ${joint.unit}`;
    });
    if (this.body < 0) return;
    const k = app.motion.bodies.indexOf(this.body);
    const closest = app.near.closest(app.moment);
    const mine = k >= 0 ? app.bodyClearance[app.moment * app.motion.bodies.length + k] : null;
    if (mine !== null) this.clearanceNow.textContent = Number.isFinite(mine) ? `clearance now ${distanceText({ lower: mine, upper: mine })}` : 'checked against nothing near';
    else if (closest && (closest.a === this.body || closest.b === this.body)) this.clearanceNow.textContent = `nearest now, ${distanceText(closest)}`;
    else this.clearanceNow.textContent = '';
  }
}

function keys() {
  const all = [['Space', 'play or pause'], ['\u2190 \u2192', 'one moment back, on'], ['Home End', 'start, end'], ['\u2212 +', 'slower, faster'], ['M', 'where the room is least'], ['G', 'look at the gap'], ['F', 'see all of it'], ['L', 'a scale that shows what is near'], ['P', 'save a picture'], ['V', 'save a video'], ['1 2 3', 'from the front, the side, above'], ['Shift \u2190 \u2192 \u2191 \u2193', 'turn the scene'], ['I O', 'nearer, farther'], ['Esc', 'select nothing']];
  return [element('dl', {}, ...all.flatMap(([key, what]) => [element('dt', { text: key }), element('dd', { text: what })]))];
}
