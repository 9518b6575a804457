// Pictures and videos of the scene with what is known at the time.
import { lengthText } from './measures.js';
import { colours } from './theme.js';
import { element } from './words.js';

const kRate = 30; // frames a second
const kTypes = ['video/webm;codecs=vp9', 'video/webm;codecs=vp8', 'video/webm'];

function save(blob, name, ending) {
  const link = element('a', { href: URL.createObjectURL(blob), download: `${name.replace(/[^\p{L}\p{N}._-]+/gu, '-') || 'view'}.${ending}` });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

export class Recorder {
  constructor(app) {
    this.app = app;
    this.type = window.MediaRecorder && HTMLCanvasElement.prototype.captureStream ? kTypes.find((type) => MediaRecorder.isTypeSupported(type)) : undefined;
    this.recording = null;
  }
  get canRecord() {
    return this.type !== undefined && this.app.stage && this.app.motion.duration > 0;
  }
  // The scene and its texts on another canvas.
  draw(picture) {
    const { stage, data, nearestText, motion, controls, scaleBar } = this.app;
    const { canvas } = stage;
    stage.renderNow();
    const ratio = canvas.width / canvas.clientWidth;
    if (picture.width !== canvas.width || picture.height !== canvas.height) Object.assign(picture, { width: canvas.width, height: canvas.height });
    const c = picture.getContext('2d');
    c.setTransform(1, 0, 0, 1, 0, 0);
    c.drawImage(canvas, 0, 0);
    c.scale(ratio, ratio);
    c.textBaseline = 'top';
    const time = motion.duration > 0 ? [controls.clock.textContent] : [];
    const lines = [`${data.name}: ${data.verdict}`, ...time, ...Array.from(nearestText.children, (line) => line.textContent)];
    const font = (i) => { c.font = `${i === 0 ? 600 : 400} 14px system-ui, sans-serif`; };
    const widths = lines.map((line, i) => { font(i); return c.measureText(line).width; });
    // The scene behind texts is dimmed, as on the page.
    const ground = (...box) => { c.globalAlpha = 0.85; c.fillStyle = colours().page; c.fillRect(...box); c.globalAlpha = 1; c.fillStyle = colours().ink; };
    ground(6, 6, Math.max(...widths) + 12, 20 * lines.length + 8);
    lines.forEach((line, i) => { font(i); c.fillText(line, 12, 12 + 20 * i); });
    const { length, pixels } = scaleBar.measure();
    const bottom = canvas.clientHeight - 12;
    font(1);
    const wide = c.measureText(lengthText(length)).width;
    ground(6, bottom - 18, pixels + wide + 20, 24);
    c.strokeStyle = colours().ink;
    c.lineWidth = 1.5;
    c.beginPath();
    [[12, bottom - 6], [12, bottom], [12 + pixels, bottom], [12 + pixels, bottom - 6]].forEach((point) => c.lineTo(...point));
    c.stroke();
    c.fillText(lengthText(length), 18 + pixels, bottom - 12);
  }
  savePicture() {
    if (!this.app.stage) return;
    const picture = document.createElement('canvas');
    this.draw(picture);
    picture.toBlob((blob) => {
      save(blob, this.app.data.name, 'png');
      this.app.saved = blob.size;
    });
  }
  // Plays the path from its begin, and saves what was seen when it ends or is stopped.
  toggle() {
    const { app } = this;
    if (!this.canRecord) return;
    if (this.recording) { app.pause(); return; }
    const picture = document.createElement('canvas');
    this.draw(picture);
    const recorder = new MediaRecorder(picture.captureStream(kRate), { mimeType: this.type, videoBitsPerSecond: 8e6 });
    const parts = [];
    recorder.addEventListener('dataavailable', ({ data }) => { if (data.size > 0) parts.push(data); });
    recorder.addEventListener('stop', () => {
      const blob = new Blob(parts, { type: 'video/webm' });
      this.recording = null;
      app.controls.update();
      save(blob, app.data.name, 'webm');
      app.video = blob;
    });
    this.recording = recorder;
    recorder.start();
    app.seek(app.motion.begin);
    app.start();
    let ended = 0;
    const frame = () => {
      if (recorder.state !== 'recording') return;
      this.draw(picture);
      // The last frame stays for a third of a second.
      if (!app.playing && ++ended > kRate / 3) recorder.stop();
      else requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }
}
