// Pictures and videos of the scene with what is known at the time.
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
    const { stage, data, nearestText } = this.app;
    const { canvas } = stage;
    stage.renderNow();
    const ratio = canvas.width / canvas.clientWidth;
    if (picture.width !== canvas.width || picture.height !== canvas.height) Object.assign(picture, { width: canvas.width, height: canvas.height });
    const c = picture.getContext('2d');
    c.setTransform(1, 0, 0, 1, 0, 0);
    c.drawImage(canvas, 0, 0);
    c.scale(ratio, ratio);
    c.fillStyle = colours().ink;
    c.textBaseline = 'top';
    const lines = [`${data.name}: ${data.verdict}`, ...Array.from(nearestText.children, (line) => line.textContent)];
    lines.forEach((line, i) => { c.font = `${i === 0 ? 600 : 400} 14px system-ui, sans-serif`; c.fillText(line, 12, 12 + 20 * i); });
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
