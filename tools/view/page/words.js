// Numbers and elements. Whatever comes from a user's files goes through textContent: it is text, never markup.

// A bound: rounded down, so that what is shown is true, too.
export function millimetres(metres) {
  if (metres === null || !Number.isFinite(metres)) return '\u2013';
  return (Math.floor(metres * 1e5) / 100).toFixed(2);
}

// A value: the number that both ends of its interval round to. As clearanceText() of the command has it, in the same digits.
const kNarrow = 2e-6; // m
export function figure({ lower, upper }) {
  const rounded = (metres) => (Math.round(metres * 1e5) / 100 + 0).toFixed(2);
  if (lower !== null && upper !== null && (upper - lower <= kNarrow || rounded(lower) === rounded(upper))) return `${rounded(lower)} mm`;
  const up = (Math.ceil(upper * 1e5) / 100).toFixed(2);
  if (upper === null) return lower === null ? 'not known' : `at least ${millimetres(lower)} mm`;
  return lower === null ? `at most ${up} mm` : `between ${millimetres(lower)} and ${up} mm`;
}

// A bound that is proven around a moment. If it is the lower end of what was measured there, both have the same figure.
export function provenText(bound, closest) {
  if (closest.lower !== null && bound >= closest.lower) return distanceText(closest);
  return bound < 0 ? `at most ${(Math.ceil(-bound * 1e5) / 100).toFixed(2)} mm deep` : `at least ${millimetres(bound)} mm`;
}

export function distanceText(closest) {
  if (!closest) return 'nothing near';
  if (closest.upper !== null && closest.upper <= 0) return `${figure({ lower: -closest.upper, upper: closest.lower === null ? null : -closest.lower })} deep`;
  return figure(closest);
}

export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) made.addEventListener(name.slice(2), value);
    else if (name === 'text') made.textContent = value;
    else if (name in made && name !== 'list') made[name] = value;
    else made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
}

const kSizes = {
  sphere: ([r]) => `radius ${cm(r)}`,
  capsule: ([r, h]) => `radius ${cm(r)}, length ${cm(2 * h)}`,
  cylinder: ([r, h]) => `radius ${cm(r)}, length ${cm(2 * h)}`,
  cone: ([r, h]) => `radius ${cm(r)}, height ${cm(2 * h)}`,
  box: ([x, y, z]) => `${cm(2 * x)} \u00d7 ${cm(2 * y)} \u00d7 ${cm(2 * z)}`,
  ellipsoid: ([x, y, z]) => `semi-axes ${cm(x)}, ${cm(y)}, ${cm(z)}`,
};
const cm = (metres) => `${+(metres * 100).toPrecision(4)} cm`;

export function shapeText(kind, size) {
  return kSizes[kind] ? `${kind}, ${kSizes[kind](size)}` : kind;
}
