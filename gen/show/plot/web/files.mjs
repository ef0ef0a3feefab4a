// Out of the page: a picture (PNG) of what is seen, a video of the whole.
import { it, el } from "./state.mjs";
import { inks } from "./camera.mjs";
import { clockText, go, play } from "./clock.mjs";

const RATE = 30, PACE = 12e6;               // frames and bits a second

function compose(canvas) {                  // scene, key, title and time on one canvas
  const scene = el("scene"), c = canvas.getContext("2d"), ratio = scene.width / it.width;
  if (canvas.width !== scene.width || canvas.height !== scene.height) { canvas.width = scene.width; canvas.height = scene.height; }
  c.fillStyle = getComputedStyle(document.body).backgroundColor;
  c.fillRect(0, 0, canvas.width, canvas.height);
  if (it.view === "places") c.drawImage(el("field"), 0, 0);
  c.drawImage(scene, 0, 0);
  const key = el("key");
  if (!el("keybox").hidden) c.drawImage(key, canvas.width - key.width - 8 * ratio, canvas.height - key.height - 26 * ratio);
  c.setTransform(ratio, 0, 0, ratio, 0, 0);
  c.fillStyle = inks().ink; c.textBaseline = "top"; c.font = "600 14px system-ui, sans-serif";
  c.fillText(it.data.title, 8, 6);
  c.textBaseline = "bottom"; c.font = "12.5px system-ui, sans-serif"; c.fillText(clockText(), 8, it.height - 6);
  c.setTransform(1, 0, 0, 1, 0, 0);
}
function save(blob, ending) {
  const link = document.createElement("a"), name = it.data.title.replace(/[^\p{L}\p{N}]+/gu, "_").slice(0, 60) || "trajectory";
  link.href = URL.createObjectURL(blob); link.download = `${name}.${ending}`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
export function savePicture() {
  const canvas = document.createElement("canvas");
  it.draw();
  compose(canvas);
  canvas.toBlob((blob) => save(blob, "png"));
}
export function saveVideo() {               // from the first frame to the last, at the speed chosen
  if (it.film) { it.film.stop(); return; }
  const canvas = document.createElement("canvas"), pieces = [];
  compose(canvas);
  const kind = ["video/mp4", "video/webm"].find((k) => MediaRecorder.isTypeSupported(k));
  const recorder = new MediaRecorder(canvas.captureStream(RATE), { mimeType: kind, videoBitsPerSecond: PACE });
  recorder.ondataavailable = (event) => pieces.push(event.data);
  recorder.onstop = () => {
    it.film = null; el("video").textContent = "Video"; play(false);
    save(new Blob(pieces, { type: kind }), kind.slice(6));
  };
  it.film = { frame: () => compose(canvas), stop: () => recorder.stop() };
  el("video").textContent = "Stop video";
  recorder.start();
  go(0); play(true);
}
export function filmed() {                  // after each frame that is drawn
  if (!it.film) return;
  it.film.frame();
  if (it.now >= it.frames - 1) setTimeout(() => it.film && it.film.stop(), 200);
}
export const canFilm = () => typeof MediaRecorder !== "undefined" && !!HTMLCanvasElement.prototype.captureStream;
