// The robot's visual shapes. They move with its links, and are drawn only: nothing is measured or proven about them.
import { Motion } from './motion.js';
import { Parts } from './shapes.js';
import { colours, onThemeChange } from './theme.js';
import { element } from './words.js';

export class Visual {
  constructor(page) {
    const { times, visual } = page.document;
    this.data = visual;
    this.parts = new Parts(page, visual.parts);
    this.motion = new Motion({ document: { times, poses: visual.poses, moving: visual.moving }, array: page.array });
    this.label = element('div', { id: 'visual-label', text: 'light grey: visual shapes, not what is proven' });
  }
  addTo(scene) {
    const all = [...Array(this.parts.count).keys()];
    this.instances = this.parts.instances(all, () => colours().visual, {});
    this.meshes = this.instances.map((i) => i.mesh);
    // A click on one selects the link.
    this.instances.forEach((i) => { i.mesh.userData.bodyOf = (part) => this.data.bodies[this.parts.body[part]]; });
    this.meshes.forEach((mesh) => scene.add(mesh));
    onThemeChange(() => this.instances.forEach((i) => i.paint()));
  }
  show(on) {
    this.meshes.forEach((mesh) => { mesh.visible = on; });
    this.label.hidden = !on || this.parts.count === 0;
  }
  setTime(time) {
    this.motion.setTime(time);
    this.instances.forEach((i) => i.place(this.motion.matrices));
  }
  // A sentence for the panel.
  text() {
    const { left_out: leftOut, error } = this.data;
    if (this.parts.count === 0) return 'The robot has no visual shapes that can be drawn.';
    const lacking = leftOut > 0 ? `; ${leftOut} could not be read and ${leftOut === 1 ? 'is' : 'are'} left out` : '';
    return `Visual shapes of the robot are drawn for the eye: nothing is proven about them. Their meshes are shown to within ${(error * 1e3).toPrecision(2)} mm${lacking}.`;
  }
}
