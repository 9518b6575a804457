// A click or tap on the scene: which body is there.
import { Raycaster, Vector2 } from 'three';

const kStill = 5; // px: a press that moves farther turns the view

export function picks(stage, targets, found) {
  const ray = new Raycaster();
  let down = null;
  stage.canvas.addEventListener('pointerdown', (event) => { down = [event.clientX, event.clientY]; });
  stage.canvas.addEventListener('pointerup', (event) => {
    if (!down || Math.hypot(event.clientX - down[0], event.clientY - down[1]) > kStill) return;
    const box = stage.canvas.getBoundingClientRect();
    ray.setFromCamera(new Vector2(((event.clientX - box.left) / box.width) * 2 - 1, 1 - ((event.clientY - box.top) / box.height) * 2), stage.camera);
    found(bodyAt(ray, targets()));
  });
}

function bodyAt(ray, targets) {
  const hit = ray.intersectObjects(targets.filter((t) => t.visible), false)[0];
  return hit ? bodyOfHit(hit) : -1;
}

export function bodyOfHit(hit) {
  const { instances, body, bodyOf } = hit.object.userData;
  if (!instances) return body;
  const { part } = instances.entries[hit.instanceId];
  return bodyOf ? bodyOf(part) : instances.parts.body[part];
}
