"use strict";
(function () {
  const data = JSON.parse(document.getElementById("data").textContent);
  const el = (id) => document.getElementById(id);

  // ---- data: positions as 16-bit integers, one (frames, count, 3) block for each family ----
  function bytes(text) {
    const raw = atob(text), out = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i++) out[i] = raw.charCodeAt(i);
    return out.buffer;
  }
  const times = new Float64Array(bytes(data.t));
  const frames = times.length;
  const errors = data.error === null ? null : new Float64Array(bytes(data.error));
  const families = data.families.map((f) => ({
    ...f, w: new Int16Array(bytes(f.w)), bonds: new Int32Array(bytes(f.bonds)), shown: true,
  }));
  const backdrop = data.backdrop.map((b) => new Float32Array(bytes(b)));
  const reach = data.reach;                 // greatest |w|: the unit of the picture

  function at(family, frame, site, out) {   // linear between frames, kept at its own length
    const k = Math.min(Math.floor(frame), frames - 1), s = frame - k;
    const a = (k * family.count + site) * 3, b = k + 1 < frames ? a + 3 * family.count : a;
    let la = 0, lb = 0, lm = 0;
    for (let i = 0; i < 3; i++) {
      const p = family.w[a + i], q = family.w[b + i];
      out[i] = p + s * (q - p);
      la += p * p; lb += q * q; lm += out[i] * out[i];
    }
    const want = Math.sqrt(la) * (1 - s) + Math.sqrt(lb) * s, scale = data.quantum / reach;
    const grow = data.ball && s > 0 && lm > 0 ? want / Math.sqrt(lm) : 1;
    for (let i = 0; i < 3; i++) out[i] *= scale * grow;
    return out;
  }

  // ---- the view: rotation matrix rows right, up, towards the viewer ----
  let turn = null, zoom = 1;
  function look(azimuth, elevation) {
    const a = azimuth * Math.PI / 180, e = elevation * Math.PI / 180;
    const ca = Math.cos(a), sa = Math.sin(a), ce = Math.cos(e), se = Math.sin(e);
    turn = [[-sa, ca, 0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]];
  }
  const first = data.view;
  function reset() { look(first[0], first[1]); zoom = 1; }
  function times3(m, v) {
    return [0, 1, 2].map((i) => m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2]);
  }
  function drag(dx, dy) {                   // turn about the screen's up and right axes
    const ca = Math.cos(dx), sa = Math.sin(dx), cb = Math.cos(dy), sb = Math.sin(dy);
    const yaw = [[ca, 0, sa], [0, 1, 0], [-sa, 0, ca]];
    const pitch = [[1, 0, 0], [0, cb, -sb], [0, sb, cb]];
    const cols = [0, 1, 2].map((j) => times3(pitch, times3(yaw, turn.map((r) => r[j]))));
    turn = [0, 1, 2].map((i) => cols.map((c) => c[i]));
  }

  // ---- canvases ----
  const scene = el("scene"), strip = el("errors");
  const g = scene.getContext("2d"), e = strip.getContext("2d");
  const PAPER = [760, 520, 112];            // width, height of the scene and of the strip on paper
  let width = 0, height = 0, cx = 0, cy = 0, unit = 1, band = { width: 0, height: 0 }, printing = false;
  function fit(canvas, context, wide, high) {
    const ratio = window.devicePixelRatio || 1;
    canvas.width = Math.max(1, Math.round(wide * ratio));
    canvas.height = Math.max(1, Math.round(high * ratio));
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    return context;
  }
  function resize() {
    const box = scene.getBoundingClientRect(), below = strip.getBoundingClientRect();
    if (printing || matchMedia("print").matches) return toPaper();
    if (box.width * box.height > 0) size(box.width, box.height, below.width, below.height);     // else hidden
  }
  function size(wide, high, stripWide, stripHigh) {
    width = wide; height = high; cx = width / 2; cy = height / 2;
    band = { width: stripWide, height: stripHigh };
    fit(scene, g, width, height); fit(strip, e, stripWide, stripHigh);
    draw();
  }
  // On paper the canvases are pictures of a size of their own: a frame that was never on the screen has none yet.
  function toPaper() { if (width !== PAPER[0] || height !== PAPER[1]) size(PAPER[0], PAPER[1], PAPER[0], PAPER[2]); }
  addEventListener("beforeprint", () => { printing = true; toPaper(); });
  addEventListener("afterprint", () => { printing = false; resize(); });
  function place(v) {
    const p = times3(turn, v);
    return [cx + unit * p[0], cy - unit * p[1], p[2]];
  }

  // ---- light and dark: the ball is light in both, and colours are made for it; leaves stand on a light sheet ----
  const night = matchMedia("(prefers-color-scheme: dark)");
  const LIGHT = { ink: "#2b3138", soft: "#5b6570", line: "#e3e6ea", halo: "#ffffff" };
  const DARK = { ink: "#e8ecf1", soft: "#a5b0bc", line: "#303030", halo: "#161616" };
  const dark = () => night.matches && !printing && !matchMedia("print").matches;
  const inks = () => dark() ? DARK : LIGHT;
  function pale(color) {                    // halfway to white, for a line on a dark ground
    const part = (k) => Math.round((parseInt(color.slice(k, k + 2), 16) + 255) / 2);
    return `rgb(${part(1)},${part(3)},${part(5)})`;
  }
  night.addEventListener("change", () => draw());

  // ---- drawing ----
  function ball() {
    for (const r of [...data.radii].reverse()) {          // the largest first: the others on it
      const s = unit * r / reach, big = r === data.radii[data.radii.length - 1];
      g.beginPath(); g.arc(cx, cy, s, 0, 2 * Math.PI);
      if (big) {
        const light = g.createRadialGradient(cx - 0.42 * s, cy - 0.5 * s, 0.05 * s, cx, cy, 1.05 * s);
        light.addColorStop(0, "#fcfdff"); light.addColorStop(0.55, "#eceff4");
        light.addColorStop(1, "#d3d8e0");
        g.fillStyle = light; g.fill();
      } else {
        g.strokeStyle = "rgba(90,100,112,.45)"; g.lineWidth = 1; g.setLineDash([3, 3]); g.stroke();
        g.setLineDash([]);
      }
    }
  }
  function polyline(points, step, style, wide, front) {
    g.strokeStyle = style; g.lineWidth = wide; g.beginPath();
    let open = false;
    for (let i = 0; i + 2 < points.length; i += step) {
      const p = place([points[i] / reach, points[i + 1] / reach, points[i + 2] / reach]);
      const on = !data.ball || (p[2] >= 0) === front;
      if (on) { if (open) g.lineTo(p[0], p[1]); else g.moveTo(p[0], p[1]); }
      open = on;
    }
    g.stroke();
  }
  function axes(front) {
    const names = ["x", "y", "z"], from = data.ball ? data.radii[data.radii.length - 1] / reach : 0;
    g.font = "italic 13px system-ui, sans-serif"; g.textAlign = "center"; g.textBaseline = "middle";
    for (let k = 0; k < 3; k++) {
      const v = [0, 0, 0]; v[k] = 1;
      const tip = place(v.map((c) => 1.17 * c)), foot = place(v.map((c) => from * c));
      if ((tip[2] >= 0) !== front) continue;
      const inside = !front && data.ball && Math.hypot(tip[0] - cx, tip[1] - cy) < from * unit;
      g.globalAlpha = inside ? 0.25 : 0.85;
      const ink = data.ball ? inks() : LIGHT;
      g.beginPath(); g.moveTo(foot[0], foot[1]); g.lineTo(tip[0], tip[1]);
      g.strokeStyle = ink.halo; g.lineWidth = 3; g.stroke();
      g.strokeStyle = ink.ink; g.lineWidth = 1; g.stroke();
      const label = place(v.map((c) => 1.25 * c));
      g.strokeStyle = ink.halo; g.lineWidth = 3; g.strokeText(names[k], label[0], label[1]);
      g.fillStyle = ink.ink; g.fillText(names[k], label[0], label[1]);
      g.globalAlpha = 1;
    }
  }
  function color(f, site) { return f.colors[Math.floor(site * f.colors.length / f.count)]; }
  function line(f) { return f.colors[f.colors.length >> 1]; }       // of its bonds
  function radius(f) { return f.count > 200 ? 1.6 : f.count > 12 ? 3 : 5.5; }
  function trailed(f) { return Math.min(f.count, 200); }            // sites with a trail, evenly chosen
  function disc(c, p, f, site) {
    c.fillStyle = color(f, site);
    c.beginPath(); c.arc(p[0], p[1], radius(f), 0, 2 * Math.PI); c.fill();
    if (radius(f) > 3) { c.strokeStyle = "#fff"; c.lineWidth = 1.2; c.stroke(); }
  }
  function trails(front) {
    const long = trailLength();
    if (long === 0) return;
    const from = Math.max(0, now - long), v = [0, 0, 0];
    for (const f of families) {
      if (!f.shown) continue;
      const many = trailed(f);
      const pieces = Math.max(2, Math.min(Math.ceil((now - from) * f.fine), Math.floor(24000 / many)));
      for (let pick = 0; pick < many; pick++) {
        const site = Math.floor(pick * f.count / many);
        g.strokeStyle = color(f, site); g.lineWidth = f.count > 12 ? 0.9 : 1.5;
        let last = null, bin = -1;
        for (let i = 0; i <= pieces; i++) {
          const s = i / pieces, p = place(at(f, from + s * (now - from), site, v));
          const b = long === Infinity ? 3 : Math.floor(s * 3.999);
          const on = !data.ball || (p[2] >= 0) === front;
          if (b !== bin || !on || last === null) {
            if (bin >= 0) g.stroke();
            g.globalAlpha = (data.ball && !front ? 0.16 : 0.28 + 0.18 * b) * (f.count > 12 ? 0.6 : 1);
            g.beginPath(); bin = b;
            if (last !== null) g.moveTo(last[0], last[1]); else g.moveTo(p[0], p[1]);
          }
          if (on) g.lineTo(p[0], p[1]); else if (last !== null) g.moveTo(p[0], p[1]);
          last = on ? p : null;
        }
        if (bin >= 0) g.stroke();
      }
    }
    g.globalAlpha = 1;
  }
  function spins(front) {
    const v = [0, 0, 0];
    for (const f of families) {
      if (!f.shown) continue;
      const spots = [];
      for (let site = 0; site < f.count; site++) spots.push(place(at(f, now, site, v)));
      if (f.bonds.length) {
        g.lineWidth = 1.1; g.strokeStyle = line(f); g.globalAlpha = front ? 0.75 : 0.14;
        g.beginPath();
        for (let b = 0; b < f.bonds.length; b += 2) {
          const p = spots[f.bonds[b]], q = spots[f.bonds[b + 1]];
          if ((p[2] + q[2] >= 0) === front) { g.moveTo(p[0], p[1]); g.lineTo(q[0], q[1]); }
        }
        g.stroke();
      }
      spots.forEach((p, site) => {
        const seen = !data.ball || p[2] >= 0;
        if (seen !== front) return;
        g.globalAlpha = seen ? 1 : 0.28;
        disc(g, p, f, site);
      });
    }
    g.globalAlpha = 1;
  }
  function draw() {
    unit = 0.39 * Math.min(width, height) * zoom;
    g.clearRect(0, 0, width, height);
    const sheet = !data.ball && dark();
    el("stage").classList.toggle("sheet", sheet);
    if (sheet) { g.fillStyle = "#eef1f5"; g.fillRect(0, 0, width, height); }
    axes(false);
    if (data.ball) ball();
    for (const b of backdrop) polyline(b, 3, data.ball ? "rgba(90,100,112,.13)" : "rgba(90,100,112,.28)", 0.8, false);
    trails(false); spins(false);
    if (data.ball) {
      for (const b of backdrop) polyline(b, 3, "rgba(90,100,112,.30)", 0.8, true);
    }
    axes(true);
    if (data.ball) { trails(true); spins(true); } else { spins(true); }
    const k = Math.min(Math.round(now), frames - 1), s = now - Math.floor(now);
    const a = times[Math.floor(now)], b = times[Math.min(Math.floor(now) + 1, frames - 1)];
    el("clock").textContent = "t = " + (a + s * (b - a)).toPrecision(6) +
      (errors ? "    H \u2212 H\u2080 = " + show(errors[k]) : "");
    el("note").textContent = untrailed();
    drawStrip();
  }
  function untrailed() {                    // what to say where only some sites have trails
    const seen = families.filter((f) => f.shown), sum = (list) => list.reduce((a, b) => a + b, 0);
    const some = sum(seen.map(trailed)), all = sum(seen.map((f) => f.count));
    return trailLength() > 0 && some < all ? `trails of ${some} of ${all} sites shown` : "";
  }

  // ---- the strip of the energy error ----
  const left = 74, right = 12, top = 16, bottom = 22;
  function show(x) {
    if (!(Math.abs(x) > 0)) return "0";
    const exponent = Math.floor(Math.log10(Math.abs(x)));
    if (exponent >= -3 && exponent < 4) return String(+x.toPrecision(3)).replace("-", "\u2212");
    return x.toExponential(1).replace(/-/g, "\u2212").replace("e+", "e");
  }
  function drawStrip() {
    if (!errors) return;
    const w = band.width, h = band.height;
    const span = times[frames - 1] - times[0] || 1;
    const X = (t) => left + (w - left - right) * (t - times[0]) / span;
    const low = data.low, high = data.high, Y = (y) => top + (h - top - bottom) * (high - y) / (high - low);
    e.clearRect(0, 0, w, h);
    e.font = "11.5px system-ui, sans-serif"; e.textBaseline = "middle"; e.textAlign = "right";
    const marks = [high, low];
    if (low < 0 && high > 0 && Math.abs(Y(0) - top) > 12 && Math.abs(Y(0) - h + bottom) > 12) marks.push(0);
    for (const y of marks) {
      e.strokeStyle = inks().line; e.lineWidth = 1;
      e.beginPath(); e.moveTo(left, Y(y)); e.lineTo(w - right, Y(y)); e.stroke();
      e.fillStyle = inks().soft; e.fillText(show(y), left - 7, Y(y));
    }
    e.textAlign = "left"; e.fillText("energy H \u2212 H\u2080 (" + (data.note ? data.note + ", " : "") + "model units)", left, 7);
    e.textAlign = "center";
    e.fillText(show(times[0]), left, h - 9); e.fillText("time t (model units)", (left + w - right) / 2, h - 9);
    e.textAlign = "right"; e.fillText(show(times[frames - 1]), w - right, h - 9);
    e.strokeStyle = dark() ? pale(data.color) : data.color; e.lineWidth = 1.1; e.beginPath();
    for (let k = 0; k < frames; k++) {
      if (!isFinite(errors[k])) continue;
      const x = X(times[k]), y = Y(errors[k]);
      if (k === 0) e.moveTo(x, y); else e.lineTo(x, y);
    }
    e.stroke();
    const k = Math.floor(now), s = now - k, next = Math.min(k + 1, frames - 1);
    const t = times[k] + s * (times[next] - times[k]);
    e.strokeStyle = inks().ink; e.beginPath(); e.moveTo(X(t), top - 2); e.lineTo(X(t), h - bottom + 2); e.stroke();
    e.fillStyle = inks().ink; e.beginPath();
    e.arc(X(t), Y(errors[Math.min(Math.round(now), frames - 1)]), 3.2, 0, 2 * Math.PI); e.fill();
  }

  // ---- time ----
  let now = 0, playing = false, before = 0;
  const speeds = [["\u00bc\u00d7", 0.25], ["\u00bd\u00d7", 0.5], ["1\u00d7", 1], ["2\u00d7", 2], ["4\u00d7", 4]];
  const lengths = [["none", 0], ["short", 0.03], ["medium", 0.12], ["whole", Infinity]];
  function choices(select, list, chosen) {
    list.forEach(([name], i) => {
      const option = document.createElement("option");
      option.textContent = name; option.value = i; option.selected = i === chosen;
      select.appendChild(option);
    });
  }
  choices(el("speed"), speeds, 2);
  choices(el("trail"), lengths, data.trail);
  function trailLength() {
    const share = lengths[el("trail").value][1];
    return share === Infinity ? Infinity : share * (frames - 1);
  }
  function go(frame) {
    now = Math.min(Math.max(frame, 0), frames - 1);
    el("slider").value = frames > 1 ? Math.round(1000 * now / (frames - 1)) : 0;
    draw();
  }
  function play(on) {
    playing = on && frames > 1;
    if (playing && now >= frames - 1) now = 0;
    el("play").textContent = playing ? "Pause" : "Play";
    before = 0;
    if (playing) requestAnimationFrame(tick);
  }
  function tick(stamp) {
    if (!playing) return;
    const passed = before ? (stamp - before) / 1000 : 0;
    before = stamp;
    go(now + passed * speeds[el("speed").value][1] * (frames - 1) / data.seconds);
    if (now >= frames - 1) play(false); else requestAnimationFrame(tick);
  }
  el("play").addEventListener("click", () => play(!playing));
  el("slider").addEventListener("input", (event) => { play(false); go(event.target.value / 1000 * (frames - 1)); });
  el("trail").addEventListener("change", draw);
  el("reset").addEventListener("click", () => { reset(); draw(); });

  // ---- hands: drag, wheel, pinch, keys ----
  const held = new Map();
  let armed = false;                        // does the wheel zoom without Ctrl? not until a click here
  scene.addEventListener("pointerdown", (event) => {
    armed = true;
    scene.setPointerCapture(event.pointerId);
    held.set(event.pointerId, [event.clientX, event.clientY]);
  });
  scene.addEventListener("pointermove", (event) => {
    const was = held.get(event.pointerId);
    if (!was) return;
    const is = [event.clientX, event.clientY];
    if (held.size === 1) drag((is[0] - was[0]) / unit, (is[1] - was[1]) / unit);
    else if (held.size === 2) {
      const other = [...held].find(([id]) => id !== event.pointerId)[1];
      const far = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]);
      zoom = Math.min(Math.max(zoom * far(is) / Math.max(far(was), 1), 0.4), 12);
    }
    held.set(event.pointerId, is);
    draw();
  });
  const release = (event) => held.delete(event.pointerId);
  scene.addEventListener("pointerup", release);
  scene.addEventListener("pointercancel", release);
  scene.addEventListener("focus", () => { armed = armed || scene.matches(":focus-visible"); });   // by Tab, or by the click itself
  for (const end of ["blur", "pointerleave"]) scene.addEventListener(end, () => { armed = false; });
  let hint = 0;
  function tell() {
    el("hint").classList.add("told");
    clearTimeout(hint);
    hint = setTimeout(() => el("hint").classList.remove("told"), 1200);
  }
  scene.addEventListener("wheel", (event) => {
    if (!armed && !event.ctrlKey && !event.metaKey) { tell(); return; }     // the page scrolls
    event.preventDefault();
    zoom = Math.min(Math.max(zoom * Math.exp(-event.deltaY / 600), 0.4), 12);
    draw();
  }, { passive: false });
  function seek(event) {
    const box = strip.getBoundingClientRect();
    const share = (event.clientX - box.left - left) / (box.width - left - right);
    const t = times[0] + share * (times[frames - 1] - times[0]);
    let k = 0;
    while (k + 1 < frames && Math.abs(times[k + 1] - t) <= Math.abs(times[k] - t)) k++;
    play(false); go(k);
  }
  strip.addEventListener("pointerdown", (event) => { strip.setPointerCapture(event.pointerId); seek(event); });
  strip.addEventListener("pointermove", (event) => { if (event.buttons) seek(event); });
  const own = {                             // keys that a focused control needs for itself
    SELECT: /./, BUTTON: /^( |Enter)$/, INPUT: /^(Arrow|Page|Home|End)/,
  };
  let byHand = false;                       // what was pressed last: a pointer or a key?
  document.addEventListener("pointerdown", () => { byHand = true; }, true);
  for (const kind of ["click", "change"]) {
    el("player").addEventListener(kind, (event) => {    // a control that was clicked gives the keys back
      if (byHand && (kind === "change" || event.target.closest("button"))) scene.focus({ preventScroll: true });
    });
  }
  document.addEventListener("keydown", (event) => {
    byHand = false;
    const needed = own[event.target.tagName];
    if ((needed && needed.test(event.key)) || event.ctrlKey || event.metaKey || event.altKey) return;
    const step = event.shiftKey ? 10 : 1, nudge = 0.08;
    const keys = {
      " ": () => play(!playing), ".": () => go(now + step), ",": () => go(now - step),
      ArrowLeft: () => { drag(-nudge, 0); draw(); }, ArrowRight: () => { drag(nudge, 0); draw(); },
      ArrowUp: () => { drag(0, -nudge); draw(); }, ArrowDown: () => { drag(0, nudge); draw(); },
    };
    if (keys[event.key]) { event.preventDefault(); keys[event.key](); }
  });

  // ---- start ----
  el("title").textContent = data.title;
  el("facts").textContent = data.facts;
  if (!errors) el("strip").classList.add("none");
  function sample(f, sites) {               // markers as they are drawn, on the line of their bonds
    const canvas = document.createElement("canvas"), wide = 14, size = wide * sites.length;
    canvas.style.width = size + "px"; canvas.style.height = wide + "px";
    const c = fit(canvas, canvas.getContext("2d"), size, wide);
    if (f.bonds.length) {
      c.strokeStyle = line(f); c.lineWidth = 1.1;
      c.beginPath(); c.moveTo(0, wide / 2); c.lineTo(size, wide / 2); c.stroke();
    }
    sites.forEach((site, k) => disc(c, [wide * (k + 0.5), wide / 2], f, site));
    return canvas;
  }
  function text(words) {
    const made = document.createElement("span");
    made.textContent = words;
    return made;
  }
  function keys(f) {                        // few sites: a marker and a number each; many: five shades
    const last = f.count - 1, all = [...Array(Math.min(f.count, 8)).keys()];
    if (f.count === 1) return [sample(f, [0]), text(f.name)];
    if (f.count <= 8) return [text(f.name), ...all.flatMap((i) => [sample(f, [i]), text(String(i))])];
    return [text(f.name), text("0"), sample(f, [0, 0.25, 0.5, 0.75, 1].map((s) => Math.round(s * last))), text(String(last))];
  }
  for (const f of families) {
    const item = document.createElement("li"), button = document.createElement("button");
    button.type = "button"; button.title = "Show or hide " + f.name + ", by number of the site";
    button.setAttribute("aria-pressed", "true");
    button.append(...keys(f));
    button.addEventListener("click", () => {
      f.shown = !f.shown; button.setAttribute("aria-pressed", String(f.shown)); draw();
    });
    item.append(button); el("legend").append(item);
  }
  reset();
  now = data.start * (frames - 1);
  new ResizeObserver(resize).observe(el("stage"));
  resize();
  go(now);
  if (data.autoplay && !matchMedia("(prefers-reduced-motion: reduce)").matches) play(true);
})();
