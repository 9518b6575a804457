// Numbers and elements. Whatever comes from a user's files goes through textContent: it is text, never markup.

// Lower bounds are rounded down, so that what is shown is true, too.
export function millimetres(metres) {
  if (metres === null || !Number.isFinite(metres)) return '\u2013';
  return (Math.floor(metres * 1e5) / 100).toFixed(2);
}

export function distanceText(closest) {
  if (!closest) return 'nothing near';
  if (closest.upper !== null && closest.upper <= 0) return `${millimetres(-closest.upper)} mm deep`;
  return `${millimetres(closest.lower)} mm`;
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
