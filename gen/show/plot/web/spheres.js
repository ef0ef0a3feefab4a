// The spheres at the head of the page: points that fall where a method puts them, and vortices with their trails.
"use strict";
(function () {
  const HOLD = 0.15, TURN = 0.1;            // share of a round that the whole picture stays; turn about z, radians a second
  const still = matchMedia("(prefers-reduced-motion: reduce)"), button = document.getElementById("motion");
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
  const points = (text) => new Int16Array(bytes(text));
  const all = JSON.parse(document.getElementById("spheres").textContent).map((s) => ({
    ...s, layers: s.layers.map((l) => ({ ...l, w: points(l.w) })), backdrop: s.backdrop.map(points), canvas: document.getElementById("canvas-" + s.name),
    around: s.view[0] * Math.PI / 180, up: s.view[1] * Math.PI / 180, seen: true,
  }));
  let playing = false, clock = 0, before = 0;

  function fit(s) {
    const box = s.canvas.getBoundingClientRect(), ratio = window.devicePixelRatio || 1;
    if (box.width === 0) return false;
    const size = Math.round(box.width * ratio);
    if (s.canvas.width !== size || s.canvas.height !== size) s.canvas.width = s.canvas.height = size;
    s.g = s.canvas.getContext("2d");
    s.g.setTransform(ratio, 0, 0, ratio, 0, 0);
    s.middle = box.width / 2; s.radius = 0.47 * box.width;
    const ca = Math.cos(s.around), sa = Math.sin(s.around), ce = Math.cos(s.up), se = Math.sin(s.up), k = s.radius / s.quantum;
    s.right = [-sa * k, ca * k, 0]; s.top = [-se * ca * k, -se * sa * k, ce * k]; s.near = [ce * ca, ce * sa, se];
    return true;
  }
  const along = (v, w, i) => v[0] * w[i] + v[1] * w[i + 1] + v[2] * w[i + 2];
  const x = (s, w, i) => s.middle + along(s.right, w, i), y = (s, w, i) => s.middle - along(s.top, w, i);

  function ball(s) {
    const g = s.g, m = s.middle, r = s.radius;
    const light = g.createRadialGradient(m - 0.42 * r, m - 0.5 * r, 0.05 * r, m, m, 1.05 * r);
    light.addColorStop(0, "#fcfdff"); light.addColorStop(0.55, "#eef1f5"); light.addColorStop(1, "#d3d8e0");
    g.fillStyle = light; g.beginPath(); g.arc(m, m, r, 0, 2 * Math.PI); g.fill();
  }
  function curve(s, w, front) {
    const g = s.g;
    g.beginPath();
    for (let i = 0, open = false; i < w.length; i += 3) {
      const on = (along(s.near, w, i) >= 0) === front;
      if (on && open) g.lineTo(x(s, w, i), y(s, w, i)); else if (on) g.moveTo(x(s, w, i), y(s, w, i));
      open = on;
    }
    g.stroke();
  }
  function dots(s, l, share, front) {
    const g = s.g, last = Math.round(share * (l.frames - 1)), size = l.count > 1 ? 1.5 : 2.2;
    g.globalAlpha = front ? 0.9 : 0.13;
    for (let o = 0; o < l.count; o++) {
      g.fillStyle = l.colors[o];
      for (let k = 0; k <= last; k++) {
        const i = 3 * (k * l.count + o);
        if ((along(s.near, l.w, i) >= 0) === front) g.fillRect(x(s, l.w, i) - size / 2, y(s, l.w, i) - size / 2, size, size);
      }
    }
    if (share < 1 && l.count === 1) mark(s, l, last, 0, front, 4);
  }
  function mark(s, l, k, o, front, size) {  // a site, as a disc
    const g = s.g, i = 3 * (k * l.count + o);
    if ((along(s.near, l.w, i) >= 0) !== front) return;
    g.globalAlpha = front ? 1 : 0.3; g.fillStyle = l.colors[o]; g.strokeStyle = "#fff"; g.lineWidth = 1.5;
    g.beginPath(); g.arc(x(s, l.w, i), y(s, l.w, i), size, 0, 2 * Math.PI); g.fill(); g.stroke();
  }
  function trails(s, l, share, front) {     // the frames go round and round
    const g = s.g, now = Math.round(share * (l.frames - 1)), long = Math.round(0.45 * l.frames);
    for (let o = 0; o < l.count; o++) {
      g.strokeStyle = l.colors[o]; g.lineWidth = 2.6;
      for (let k = now - long; k < now; k++) {
        const a = 3 * (((k + l.frames) % l.frames) * l.count + o), b = 3 * (((k + 1 + l.frames) % l.frames) * l.count + o);
        if ((along(s.near, l.w, a) >= 0) !== front) continue;
        g.globalAlpha = (front ? 1 : 0.2) * (k - now + long) / long;
        g.beginPath(); g.moveTo(x(s, l.w, a), y(s, l.w, a)); g.lineTo(x(s, l.w, b), y(s, l.w, b)); g.stroke();
      }
      mark(s, l, now, o, front, 6);
    }
  }
  function draw(s) {
    if (!fit(s)) return;
    const round = clock / s.seconds % 1, g = s.g, share = playing || clock ? Math.min(1, round / (1 - HOLD)) : 1;
    g.clearRect(0, 0, 2 * s.middle, 2 * s.middle);
    ball(s);
    for (const front of [false, true]) {
      g.strokeStyle = s.guide; g.lineWidth = 0.9; g.globalAlpha = front ? 0.55 : 0.12;
      for (const w of s.backdrop) curve(s, w, front);
      for (const l of s.layers) if (l.kind === "dots") dots(s, l, share, front); else trails(s, l, round, front);
    }
    g.globalAlpha = 1;
  }
  function tick(stamp) {
    if (!playing) return;
    if (stamp - before >= 30) {
      const passed = before ? Math.min(0.1, (stamp - before) / 1000) : 0;
      clock += passed; before = stamp;
      for (const s of all) { if (!s.held) s.around += TURN * passed; if (s.seen) draw(s); }
    }
    requestAnimationFrame(tick);
  }
  function play(on) {
    playing = on; before = 0;
    button.textContent = on ? "Pause" : "Play";
    if (on) requestAnimationFrame(tick); else all.forEach(draw);
  }
  function hands(s) {
    s.canvas.addEventListener("pointerdown", (e) => { s.held = [e.clientX, e.clientY]; s.canvas.setPointerCapture(e.pointerId); });
    s.canvas.addEventListener("pointermove", (e) => {
      if (!s.held) return;
      s.around -= (e.clientX - s.held[0]) / s.radius;
      s.up = Math.max(-1.5, Math.min(1.5, s.up + (e.clientY - s.held[1]) / s.radius));
      s.held = [e.clientX, e.clientY];
      draw(s);
    });
    for (const end of ["pointerup", "pointercancel"]) s.canvas.addEventListener(end, () => { s.held = null; });
  }
  document.documentElement.classList.add("moves");
  all.forEach(hands);
  button.addEventListener("click", () => play(!playing));
  const watch = new IntersectionObserver((found) => { for (const f of found) all.find((s) => s.canvas === f.target).seen = f.isIntersecting; });
  all.forEach((s) => watch.observe(s.canvas));
  addEventListener("resize", () => all.forEach(draw));
  if (!still.matches) { clock = 5; play(true); }       // so that there is something to see at once
  all.forEach(draw);
})();
