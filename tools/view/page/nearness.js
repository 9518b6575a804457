// The nearest pair at every moment: with the world, of the robot with itself, or a chosen pair.

export class Nearness {
  constructor(page) {
    const { document: data, array } = page;
    this.data = data;
    this.pairs = data.pairs.map((pair) => ({ ...pair, distance: array(pair.distance), points: array(pair.points) }));
    const upper = (group) => data[group][data.least[group]]?.upper ?? Infinity;
    // The certificate's least clearance is the nearer of the two. Where margins differ, another pair may be too near.
    this.choice = upper('self') < upper('world') ? 'self' : 'world';
    if (data.failing >= 0) this.choice = `${data.failing}`;
    this.certificate = this.choice;
  }
  // [value, name] of everything that can be chosen.
  choices() {
    const { bodies } = this.data;
    return [['world', 'from the world'], ['self', 'from itself'], ...this.pairs.map((pair, i) => [`${i}`, `${bodies[pair.a]} \u2013 ${bodies[pair.b]}`])];
  }
  // The nearest pair at a moment; null: nothing is near.
  at(moment, choice = this.choice) {
    if (choice === 'world' || choice === 'self') return this.data[choice][moment];
    const { a, b, margin, distance, points } = this.pairs[+choice];
    if (!Number.isFinite(distance[moment])) return null;
    const point = (first) => [0, 1, 2].map((k) => points[(first + k) * distance.length + moment]);
    return { a, b, margin, lower: distance[moment], upper: distance[moment], point_a: point(0), point_b: point(3) };
  }
  // The nearer of world and robot.
  closest(moment) {
    const { world, self } = this.data;
    return self[moment] && !(world[moment]?.upper <= self[moment].upper) ? self[moment] : world[moment];
  }
  // Whether the bounds are those of the choice, not of all pairs.
  hasOwnBound(choice = this.choice) {
    return this.data.proven[choice]?.length > 0;
  }
  // Proven on the stretch behind a moment [m]; null: nothing, undefined: a pair alone has no proof of its own.
  proven(stretch, choice = this.choice) {
    if (choice !== 'world' && choice !== 'self') return undefined;
    const { proven } = this.data;
    return (proven[choice].length > 0 ? proven[choice] : proven.all)[stretch] ?? null;
  }
  // Proven on both stretches beside a moment. Where a step ends, the moment is measured in the world of that step, and the next one has a world of its own.
  provenAt(moment, choice = this.choice) {
    const bounds = [moment - 1, moment].filter((stretch) => stretch >= 0 && stretch < this.data.proven.all.length).map((stretch) => this.proven(stretch, choice));
    if (bounds.length === 0 || bounds.includes(undefined)) return undefined;
    return bounds.includes(null) ? null : Math.min(...bounds);
  }
  // The moment at which the choice is least; -1: it is never near.
  least(choice = this.choice) {
    if (choice === 'world' || choice === 'self') return this.data.least[choice];
    const { distance } = this.pairs[+choice];
    let least = -1;
    distance.forEach((d, i) => { if (Number.isFinite(d) && (least < 0 || d < distance[least])) least = i; });
    return least;
  }
  // [margin in m, the body that has it] of the choice.
  margins(choice = this.choice) {
    return choice === 'world' || choice === 'self' ? this.data.margins[choice] : [[this.pairs[+choice].margin, '']];
  }
  values(choice = this.choice) {
    return this.data.world.map((_, i) => this.at(i, choice)?.lower ?? null);
  }
}
