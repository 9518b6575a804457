// The part of the page's address behind #: a time, a choice, the selected body and a camera, so that a link shows what someone saw.
//   #t=1.25&choice=self&body=can&camera=X,Y,Z,TX,TY,TZ,NEAR,FAR,ANGLE

const digits = (x) => `${+x.toPrecision(7)}`;

export class Address {
  constructor(app) {
    this.app = app;
    this.written = '';
    window.addEventListener('hashchange', () => { if (location.hash !== this.written) this.restore(); });
  }
  text() {
    const { app } = this;
    const parts = new URLSearchParams();
    parts.set('t', digits(app.time));
    if (app.near.choice !== app.near.certificate) parts.set('choice', app.near.choice);
    if (app.selected >= 0) parts.set('body', app.data.bodies[app.selected]);
    if (app.stage) parts.set('camera', app.stage.view().map(digits).join(','));
    return `#${parts.toString().replaceAll('%2C', ',')}`;
  }
  // Parts that cannot be read are left out: the page then shows its usual view.
  restore() {
    const { app } = this;
    const parts = new URLSearchParams(location.hash.slice(1));
    const choice = parts.get('choice');
    if (choice !== null && app.near.choices().some(([value]) => value === choice)) app.choose(choice);
    const time = parseFloat(parts.get('t') ?? '');
    if (Number.isFinite(time)) { app.pause(); app.seek(time); }
    const body = app.data.bodies.indexOf(parts.get('body') ?? '');
    if (body >= 0) app.select(body);
    const view = (parts.get('camera') ?? '').split(',').map(Number);
    if ((view.length === 8 || view.length === 9) && view.every(Number.isFinite)) app.stage?.setView(view);
    app.showGap();
  }
  // Soon, and once for many changes: browsers limit how often.
  changed() {
    clearTimeout(this.waiting);
    this.waiting = setTimeout(() => this.write(), 400);
  }
  write() {
    if (this.app.playing) return;
    clearTimeout(this.waiting);
    this.written = this.text();
    try {
      history.replaceState(history.state, '', this.written);
    } catch {
      // In a frame without an address of its own.
    }
  }
}
