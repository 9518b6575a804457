// The page in one sentence: how much is proven, where it is tightest and between what; and what would widen that place.
import { Vector3 } from 'three';
import { distanceText } from './words.js';

const kEnds = 3; // that are not valid and are named

// The place of the choice that the page begins with; null: nothing is near.
function tightest(app) {
  const choice = app.near.certificate;
  const moment = app.near.least(choice);
  const near = moment >= 0 ? app.near.at(moment, choice) : null;
  return near && { moment, near, choice };
}

// Why the start or a goal is not valid.
function endText({ data }, { name, fault, closest }) {
  if (fault) return fault;
  return `${name}: ${data.bodies[closest.a]} and ${data.bodies[closest.b]}, ${distanceText(closest)}${closest.upper > 0 ? ', nearer than the margin' : ''}`;
}
// Names the start and the first goals that are not valid.
function endsText(app) {
  const invalid = app.data.ends.filter(({ valid, fault, closest }) => !valid && (fault || closest));
  return [...invalid.slice(0, kEnds).map((end) => endText(app, end)), ...(invalid.length > kEnds ? [`${invalid.length - kEnds} more are not valid`] : [])].join('; ');
}

function searchText({ verdict, blocked: [most] }) {
  if (verdict !== 'no path found') return '';
  return `${most ? `most edges were blocked by ${most.names[0]} and ${most.names[1]}; ` : ''}that no path was found does not prove that there is none`;
}

export function headline(app) {
  const { data, motion } = app;
  if (motion.duration === 0) return searchText(data) || (data.good ? '' : endsText(app));
  const place = tightest(app);
  const executed = data.decisions.length > 0;
  // An execution that was stopped, or whose time is up, is proven as far as it went.
  const isProven = executed ? data.decisions.every(([, decision]) => decision !== 'unsafe') : data.good;
  const where = executed ? `in every step${isProven && !data.good ? ' that was taken' : ''}` : `on the whole path${data.obstacles}`;
  const proven = `${isProven ? '' : 'not '}proven ${where}`;
  if (!place) return `${proven}; nothing else is near`;
  const { near, moment } = place;
  if (near.upper <= near.margin && !isProven) {
    const ends = executed ? '' : endsText(app);
    return `refuted: ${data.bodies[near.a]} and ${data.bodies[near.b]}, ${distanceText(near)} (margin ${+(near.margin * 1e3).toFixed(3)} mm), at ${motion.times[moment].toFixed(2)} s${ends ? `; ${ends}` : ''}`;
  }
  const what = (executed ? data.measured_throughout : data.good) ? 'least clearance' : 'nearest where it was measured';
  return `${proven}; ${what} ${distanceText(near)} (margin ${+(near.margin * 1e3).toFixed(3)} mm): ${data.bodies[near.a]} and ${data.bodies[near.b]}, at ${motion.times[moment].toFixed(2)} s`;
}

// A direction in words: an axis where it is nearly one, else its three parts.
function directionText(way) {
  const axis = ['x', 'y', 'z'].find((k) => Math.abs(way[k]) > 0.98);
  if (axis) return `${way[axis] > 0 ? '+' : '\u2212'}${axis}`;
  return `(${way.toArray().map((part) => (Math.round(100 * part) / 100 + 0).toFixed(2).replace('-', '\u2212')).join(', ')})`;
}

// Whether an obstacle of an execution moves by a motion of its own, or deforms.
const movesItself = (app, body) => app.data.decisions.length > 0 && (app.driven.has(body) || app.deformable.has(body));

// The direction in which an object of the world would have to move for the tightest place to get wider, to first order, and from where: {object, moment,
// from, way}. null: no object that stands is part of it.
export function remedy(app) {
  const { motion } = app;
  const place = tightest(app);
  if (!place || motion.duration === 0) return null;
  const { near, moment } = place;
  const matrices = motion.matricesAt(moment);
  const [a, b] = [[near.a, near.point_a], [near.b, near.point_b]].map(([body, point]) => motion.toWorld(body, point, matrices));
  const object = [near.b, near.a].find((body) => !app.links.has(body) && !app.held.has(body) && !movesItself(app, body));
  const way = new Vector3().subVectors(b, a);
  if (object === undefined || !(near.upper > 0) || way.length() < 1e-6) return null;
  way.normalize();
  if (object === near.a) way.negate();
  return { object, moment, from: object === near.a ? a : b, way };
}

// How the tightest place gets wider: that direction, and the objective that keeps away (of plans without steps). [words, option of the command]; null:
// nothing to say.
export function advice(app) {
  const { data, motion } = app;
  const { near } = tightest(app) ?? {};
  if (!near || motion.duration === 0) return null;
  const isSelf = [near.a, near.b].every((body) => app.links.has(body) || app.held.has(body));
  const executed = data.decisions.length > 0;
  const mover = [near.b, near.a].find((body) => movesItself(app, body));
  if (mover !== undefined) return [`The tightest place is beside ${data.bodies[mover]}, which moves by itself: with a larger margin for it the robot keeps farther away, or waits`, ''];
  const [start, ...goals] = data.ends;
  const canPlan = start.valid && (goals.length === 0 || goals.some(({ valid }) => valid)) && !data.constrained && !executed;
  const option = data.widest || data.steps.length > 0 || !canPlan ? '' : isSelf ? 'objective: {clearance: {of: all}}' : '--objective clearance';
  const found = remedy(app);
  const arrow = found && app.stage ? ` (the arrow at ${motion.times[found.moment].toFixed(2)} s)` : '';
  const move = found ? `move ${data.bodies[found.object]} along ${directionText(found.way)} of the world${arrow}` : '';
  if (!move && !option) {
    const held = [near.b, near.a].find((body) => app.held.has(body));
    if (held === undefined) return isSelf ? ['The tightest place is between parts of the robot: no object that moves makes it wider', ''] : null;
    return [`The tightest place is where the robot takes hold of ${data.bodies[held]}, carries it or lets it go`, ''];
  }
  return [`To widen the tightest place: ${move}${move && option ? ', or ' : ''}${option ? 'plan with ' : ''}`, option];
}
