// The page: the drawing, the pointer, the keyboard, the motion; panels.js has what stands beside it.
import { app, accept, blank, change, changed, emit, later, on, recall, redo, undo } from "./state.js";
import { ask, latest, onConnection, Refused } from "./api.js";
import { Layer, View, drawMechanism } from "./view.js";
import { clone, complete, distance, inputOf, placed, rebase, turned } from "./mechanism.js";
import { csv, outline, zoneCorners, zoneOf, zoneScaled } from "./path.js";
import { nudge, removePicked, select, tools } from "./tools.js";
import { makePanels } from "./panels.js";

const $ = (id) => document.getElementById(id);
const canvas = $("canvas");
Object.assign(app, { view: new View(800, 600), frame: 0, playing: false, snap: true, stale: false, motion: null, stations: [],
  target: null, overlays: new Set(["names"]), ghosts: [], picked: null, analysis: null, tool: tools[0] });

// ---- words to the person

app.say = (text, bad) => {
  $("said").textContent = text;
  $("note").textContent = text;
  $("note").classList.toggle("quiet", !bad);
  clearTimeout(app.saying);
  app.saying = setTimeout(() => { $("note").textContent = app.fault || ""; }, 4000);
};
function fault(text) {
  app.fault = text;
  $("note").textContent = text;
}

// ---- drawing

const layers = {};
for (const name of ["grid", "photo", "zones", "below", "path", "curves", "body", "above", "handles", "rubber"])
  layers[name] = new Layer(canvas, `layer ${name}-layer`);

let due = false;
app.redraw = () => {
  if (due) return;
  due = true;
  app.work++;
  requestAnimationFrame(() => { due = false; app.work--; draw(); });
};

function drawGrid() {
  const { grid } = layers, v = app.view, s = v.step(), a = v.at(0, v.height), b = v.at(v.width, 0);
  grid.begin();
  const line = (key, c, x1, y1, x2, y2) => grid.put(key, "line", { class: c, x1, y1, x2, y2 });
  const kind = (i) => (i === 0 ? "grid axis0" : i % 5 === 0 ? "grid strong" : "grid");
  for (let i = Math.ceil(a[0] / s), n = 0; i * s <= b[0]; i++, n++) line(`x${n}`, kind(i), v.X([i * s, 0]), 0, v.X([i * s, 0]), v.height);
  for (let i = Math.ceil(a[1] / s), n = 0; i * s <= b[1]; i++, n++) line(`y${n}`, kind(i), 0, v.Y([0, i * s]), v.width, v.Y([0, i * s]));
  const bar = 5 * s * v.scale, y = v.height - 78;
  grid.put("scale", "path", { d: `M14 ${y - 4}v4h${bar.toFixed(1)}v-4`, class: "ground", "stroke-width": 1.2, opacity: 0.6 });
  grid.put("scale.text", "text", { x: 20, y: y - 6 }, `${+(5 * s).toPrecision(3)} ${app.doc.unit}`);
  grid.end();
}

function drawPhoto() {
  const { photo } = app.doc, l = layers.photo, v = app.view;
  l.begin();
  if (photo) {
    l.put("photo", "image", { href: photo.src, x: v.X([photo.x, 0]), y: v.Y([0, photo.y]), width: photo.w * v.scale,
      height: photo.h * v.scale, opacity: photo.opacity ?? 0.55, preserveAspectRatio: "none" });
  }
  l.end();
}

function drawZones() {
  const l = layers.zones, v = app.view, t = app.doc.task;
  l.begin();
  const put = (key, z, c, text) => {
    const p = zoneCorners(z), box = p === z ? null : z, x = p.map((q) => q[0]), y = p.map((q) => q[1]);
    l.put(key, "path", { class: c, d: v.line(p, true), "stroke-linejoin": "round" });
    l.put(`${key}.text`, "text", box ? { x: v.X(z) + 6, y: v.Y([0, z[3]]) + 16 }
      : { x: v.X([(Math.min(...x) + Math.max(...x)) / 2, 0]), y: v.Y([0, (Math.min(...y) + Math.max(...y)) / 2]), "text-anchor": "middle" }, text);
  };
  if (t.pivots) put("pivots", t.pivots, "box-pivots", "fixed pivots");
  t.forbidden.forEach((z, i) => put(`forbidden${i}`, z, "box-forbidden", "forbidden"));
  l.end();
}

function drawPath() {
  const l = layers.path, h = layers.handles, v = app.view, path = app.doc.path;
  l.begin();
  if (path.anchors.length > 1) l.put("path", "path", { class: "wanted", d: v.line(outline(path), path.closed && path.mode !== "curve" || path.closed) });
  if (path.mode !== "points")
    app.stations.forEach((p, i) => l.put(`s${i}`, "circle", { class: "station", cx: v.X(p).toFixed(1), cy: v.Y(p).toFixed(1), r: 2 }));
  path.anchors.forEach((p, i) => {
    l.put(`a${i}`, "circle", { class: "anchor", cx: v.X(p).toFixed(1), cy: v.Y(p).toFixed(1), r: path.anchors.length > 60 ? 3 : 5 });
    handle(h, `anchor${i}`, p, { "data-anchor": i }, `Point ${i + 1} of the path at ${places(p)}`);
  });
  l.end();
}

const places = (p) => p.map((x) => +x.toPrecision(4)).join(", ") + " " + app.doc.unit;
function handle(layer, key, p, data, label) {
  layer.put(key, "circle", { class: "handle", cx: app.view.X(p).toFixed(1), cy: app.view.Y(p).toFixed(1), r: 12, tabindex: 0, role: "button",
    "aria-label": `${label}. Arrow keys move it.`, ...data });
}

// Where a point of a link is now, and how the link is turned.
function poses() {
  const m = app.motion, k = app.doc.linkage;
  if (!app.fresh() || app.touching) return { where: (p) => p, turn: () => [1, 0], k };
  const index = new Map(m.links.map((n, i) => [n, i]));
  return { where: (p, link) => (index.has(link) ? placed(m, app.frame, index.get(link), p) : p),
    turn: (link) => (index.has(link) ? turned(m, app.frame, index.get(link)) : [1, 0]), k };
}

function drawLinkage() {
  const { curves, body, handles } = layers, v = app.view;
  curves.begin();
  body.begin();
  if (app.motion && app.doc.linkage) app.motion.curves.forEach((c, i) => {
    if (c.shown || app.overlays.has("circuits"))
      curves.put(`c${i}`, "path", { class: `curve${c.shown ? "" : " other"}`, d: v.curve(c) });
  });
  curves.g.classList.toggle("stale", app.stale);
  for (const [n, g] of app.ghosts.entries()) {
    if (!g.motion) continue;
    g.motion.curves.forEach((c, i) => c.shown && curves.put(`g${n}c${i}`, "path", { class: "curve b", d: v.curve(c) }));
    const index = new Map(g.motion.links.map((name, i) => [name, i])), f = app.motion ? app.frame / app.motion.frames * g.motion.frames : 0;
    const at = Math.min(f, g.motion.frames - 1);
    drawMechanism(body, v, g.linkage, (p, link) => placed(g.motion, at, index.get(link), p), (link) => turned(g.motion, at, index.get(link)),
      { key: `ghost${n}.`, little: true, ghost: true });
  }
  if (app.doc.linkage) {
    const { where, turn, k } = poses();
    app.posed = (p) => where(p.at, p.links ? p.links[p.kind === "p" ? 1 : 0] : p.link);
    drawMechanism(body, v, k, where, turn, { picked: app.picked, names: app.overlays.has("names") });
    if (app.tool === select) {
      const seen = [];
      for (const p of [...k.tracers, ...k.joints]) {
        if (!p.at || p.kind === "n") continue;
        const q = app.posed(p);
        if (seen.some((o) => distance(o, q) < 1e-9)) continue;
        seen.push(q);
        const ground = p.links && p.links.includes(k.ground);
        handle(handles, `point.${p.name}`, q, { "data-point": p.name }, `${p.links ? (ground ? "Pivot" : "Joint") : "Tracer"} ${p.name} at ${places(q)}`);
      }
    }
  } else app.posed = null;
  curves.end();
  body.end();
}

function draw() {
  layers.handles.begin();
  drawGrid();
  drawPhoto();
  drawZones();
  drawPath();
  drawLinkage();
  layers.handles.end();
  emit("drawn", layers);
  showPlace();
}

let rubber = null, rubberClosed = false;
app.rubber = (points, closed) => {
  rubber = points;
  rubberClosed = closed;
  layers.rubber.begin();
  if (rubber) layers.rubber.put("r", "path", { class: "rubber", d: app.view.line(rubber, rubberClosed) });
  layers.rubber.end();
};

app.fit = () => {
  const points = [...outline(app.doc.path)];
  const { where, k } = poses();
  if (k) {
    for (const p of [...k.joints, ...k.tracers]) if (p.at) points.push(where(p.at, p.links ? p.links[0] : p.link));
    for (const f of [...(k.ropes || []), ...(k.springs || [])]) if (Array.isArray(f.at) && f.links) f.at.forEach((p, i) => points.push(where(p, f.links[i])));
    for (const l of k.links)
      for (const s of l.shapes || [])
        for (const p of s.circle ? [s.circle] : s.polygon || s.segment || []) points.push(where(p, l.name));
    if (app.motion) for (const c of app.motion.curves) if (c.shown) for (let i = 0; i < c.x.length; i += 9) points.push([c.x[i], c.y[i]]);
  }
  for (const z of [app.doc.task.pivots, ...app.doc.task.forbidden]) if (z) points.push(...zoneCorners(z));
  if (app.doc.photo && !points.length) points.push([app.doc.photo.x, app.doc.photo.y], [app.doc.photo.x + app.doc.photo.w, app.doc.photo.y - app.doc.photo.h]);
  app.view.show(points);
  app.fitAgain = Boolean(k) && !app.fresh();      // the curves are not there yet
  app.redraw();
};

// ---- the motion, from the server

app.fresh = () => app.motion && !app.stale && app.motionOf === app.doc.linkage;
const got = (m, body) => {
  app.motion = m;
  app.motionOf = body.linkage;
  app.stale = false;
  app.frame = m.first;
  app.touching = false;
  fault(m.note);
  freedom(m);
  if (app.fitAgain && pointers.size === 0 && !app.touched) app.fit();
  app.redraw();
  emit("motion");
};
const failed = (error) => {
  app.stale = error instanceof Refused || app.motionOf !== app.doc.linkage;
  app.touching = false;
  if (error instanceof Refused) {
    fault(error.message);
    $("freedom").textContent = "does not move";
    $("freedom").className = "chip bad";
  }
  app.redraw();
  emit("motion");
};
const askMotion = latest("motion", got, failed);

// While something is dragged: the posture at once, the curve as fast as the server tells it.
app.touch = () => {
  app.touching = true;
  app.redraw();
  askMotion({ linkage: app.doc.linkage, points: 1000, frames: 90, draft: true });
};

function freedom(m) {
  const moves = m.frames > 1;
  $("freedom").textContent = `F = ${m.mobility}${m.input < 0 ? ", no input" : moves ? (m.loops ? ", turns" : ", to and fro") : ", stands still"}`;
  $("freedom").className = `chip ${moves ? "good" : "bad"}`;
}

app.refresh = () => {
  const k = app.doc.linkage;
  $("player").hidden = !k;
  if (!k) {
    app.motion = null;
    app.analysis = null;
    $("freedom").textContent = "";
    fault("");
    app.redraw();
    emit("motion");
    return;
  }
  if (k.joints.length) askMotion({ linkage: k, points: 1000, frames: 180, others: true });
  else {
    app.motion = null;
    $("freedom").textContent = "";
    fault("Pin a link to the ground: choose Ground and click one of its ends.");
    app.redraw();
  }
};

// The same lengths at the same input, put together the next other way.
app.assemble = async () => {
  const k = app.doc.linkage && (app.fresh() ? rebase(app.doc.linkage, app.motion, app.frame) : app.doc.linkage);
  if (!k) return;
  try {
    const o = await ask("assembly", { linkage: k });
    change("linkage", (d) => { d.linkage = rebase(k, o, 0); });
    app.frame = 0;
  } catch (error) { app.say(error.message, true); }
};

// ---- the path, from the server

const askTarget = latest("target", (t) => {
  if (app.doc.path.mode === "points" || app.doc.path.anchors.length < 2) return;      // an answer that came too late
  app.target = t;
  app.stations = t.x.map((x, i) => [x, t.y[i]]);
  emit("target");
  app.redraw();
}, (error) => { if (error instanceof Refused) app.say(error.message, true); });

function refreshPath() {
  const { path, unit } = app.doc;
  if (path.anchors.length < 2) {
    app.target = null;
    app.stations = [];
    emit("target");
  } else if (path.mode === "points") {
    app.target = { closed: path.closed, note: "" };
    app.stations = path.anchors;
    emit("target");
  } else askTarget({ text: csv(outline(path)), name: "drawing.csv", unit, force_unit: true, stations: path.stations, closed: path.closed });
  app.redraw();
}

on("changed", (parts) => {
  if (parts === "none") return;
  $("undo").disabled = !app.past.length;
  $("redo").disabled = !app.future.length;
  $("unit").value = app.doc.unit;
  if (parts === "path" || parts === "all") refreshPath();
  if (parts === "linkage" || parts === "all") app.refresh();
  app.redraw();
});

// ---- play

app.pause = () => {
  app.playing = false;
  $("play").textContent = "▶";
  $("play").setAttribute("aria-label", "Play");
};
app.play = () => {
  if (!app.motion || app.motion.frames < 2) return;
  app.playing = true;
  app.clock = performance.now();
  $("play").textContent = "❚❚";
  $("play").setAttribute("aria-label", "Pause");
  requestAnimationFrame(tick);
};
const rpm = () => app.doc.task.rpm * 10 ** Number($("speed").value);

function tick(now) {
  if (!app.playing || !app.motion) return;
  const m = app.motion, seconds = Math.max(0, Math.min((now - app.clock) / 1000, 0.1));
  app.clock = now;
  const turns = seconds * rpm() / 60;
  if (m.loops) app.frame = (app.frame + turns * m.frames) % m.frames;
  else {
    app.way = app.way || 1;
    app.frame += app.way * turns * 2 * m.frames;
    if (app.frame >= m.frames - 1) { app.frame = m.frames - 1; app.way = -1; }
    if (app.frame <= 0) { app.frame = 0; app.way = 1; }
  }
  draw();
  requestAnimationFrame(tick);
}

app.inputText = () => {
  const m = app.motion;
  if (!m || m.input < 0 || !m.inputs.length) return "";
  const i = m.inputs[Math.min(Math.round(app.frame), m.frames - 1)], j = m.joints[m.input];
  return j.kind === "t" ? `${+(i / unitMetre(m.unit)).toPrecision(3)} ${m.unit}` : `${(((i * 180 / Math.PI) % 360 + 360) % 360).toFixed(0)}°`;
};
export const unitMetre = (u) => ({ mm: 1e-3, cm: 1e-2, m: 1, in: 0.0254, km: 1e3, um: 1e-6, ft: 0.3048 }[u] || 1);

function showPlace() {
  const m = app.motion;
  if (!m) return;
  if (document.activeElement !== $("scrub") || app.playing) $("scrub").value = Math.round(1000 * app.frame / Math.max(m.frames - (m.loops ? 0 : 1), 1));
  $("scrub").setAttribute("aria-valuetext", app.inputText());
  $("angle").textContent = app.inputText();
  $("rpm").textContent = `${+rpm().toPrecision(2)} rpm`;
}

$("play").onclick = () => (app.playing ? app.pause() : app.play());
$("scrub").oninput = () => {
  app.pause();
  if (app.motion) app.frame = Math.min(Number($("scrub").value) / 1000 * (app.motion.frames - (app.motion.loops ? 0 : 1)), app.motion.frames - 1);
  app.redraw();
};
$("speed").oninput = showPlace;

// ---- tools and the pointer

export function choose(tool) {
  app.tool.cancel?.();
  app.tool = tool;
  canvas.style.cursor = tool.cursor;
  for (const b of $("tools").querySelectorAll("button")) {
    const mine = b.dataset.tool === tool.name;
    b.setAttribute("aria-checked", mine);
    b.tabIndex = mine ? 0 : -1;
  }
  app.redraw();
}
let group = "Move";
for (const tool of tools) {
  if (tool.group !== group) $("tools").append(document.createElement("hr"));
  group = tool.group;
  const b = document.createElement("button");
  b.dataset.tool = tool.name;
  b.setAttribute("role", "radio");
  b.title = `${tool.title} (${tool.key.toUpperCase()})`;
  b.innerHTML = tool.icon;
  b.append(tool.name);
  b.onclick = () => choose(tool);
  $("tools").append(b);
}
$("tools").onkeydown = (e) => {
  const step = { ArrowDown: 1, ArrowRight: 1, ArrowUp: -1, ArrowLeft: -1 }[e.key];
  if (!step) return;
  e.preventDefault();
  e.stopPropagation();
  choose(tools[(tools.indexOf(app.tool) + step + tools.length) % tools.length]);
  $("tools").querySelector("[aria-checked=true]").focus();
};

const pointers = new Map();
let pinch = null, active = null;
const where = (e) => { const b = canvas.getBoundingClientRect(); return [e.clientX - b.left, e.clientY - b.top]; };
canvas.addEventListener("pointerdown", (e) => {
  app.touched = true;
  canvas.setPointerCapture(e.pointerId);
  pointers.set(e.pointerId, where(e));
  if (pointers.size === 2) {                       // two fingers move and zoom the paper
    app.tool.cancel?.();
    const [a, b] = [...pointers.values()];
    pinch = { distance: distance(a, b), middle: [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2] };
    active = null;
    return;
  }
  if (pointers.size > 1) return;
  active = e.button === 1 || e.button === 2 ? paper : app.tool;
  active.down(app.view.at(...where(e)), e);
  e.preventDefault();
  (e.target.closest(".handle") || canvas).focus({ preventScroll: true });
});
// Strokes are followed in the whole window and end when the button is up: a browser may take the capture of a pointer
// away while the page around the drawing changes, and then only says so with a move that goes nowhere.
addEventListener("pointermove", (e) => {
  const p = where(e), at = app.view.at(...p), last = pointers.get(e.pointerId);
  if (!last) {
    if (canvas.contains(e.target)) $("place").textContent = places(at);
    return;
  }
  if (e.pointerType !== "touch" && e.buttons === 0) {
    if (p[0] !== last[0] || p[1] !== last[1]) lift(e, last);     // released outside of the window
    return;
  }
  $("place").textContent = places(at);
  pointers.set(e.pointerId, p);
  if (pinch && pointers.size === 2) {
    const [a, b] = [...pointers.values()], middle = [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2], d = distance(a, b);
    app.view.x -= (middle[0] - pinch.middle[0]) / app.view.scale;
    app.view.y += (middle[1] - pinch.middle[1]) / app.view.scale;
    app.view.zoom(d / (pinch.distance || 1), ...middle);
    pinch = { distance: d, middle };
    app.redraw();
  } else if (active) active.move(at, e);
});
function lift(e, p) {
  if (!pointers.delete(e.pointerId)) return;
  if (!pointers.size) pinch = null;
  if (active && e.type !== "pointercancel") active.up(app.view.at(...p), e);
  else if (active) active.cancel?.();
  active = null;
}
for (const end of ["pointerup", "pointercancel"]) addEventListener(end, (e) => lift(e, where(e)));
canvas.addEventListener("contextmenu", (e) => e.preventDefault());
canvas.addEventListener("wheel", (e) => {
  e.preventDefault();
  app.view.zoom(Math.exp(-e.deltaY * (e.ctrlKey ? 0.01 : 0.0015)), ...where(e));
  app.redraw();
}, { passive: false });
canvas.addEventListener("dblclick", (e) => {
  const a = e.target.closest("[data-anchor]");
  if (a) removePicked(a);
});
const paper = {
  down(p) { this.p = p; },
  move(p) { app.view.x += this.p[0] - p[0]; app.view.y += this.p[1] - p[1]; app.redraw(); },
  up() {}, cancel() {},
};

app.pick = (what) => {
  app.picked = what;
  emit("picked");
  app.redraw();
};

// ---- keyboard

const typing = () => /^(input|select|textarea)$/i.test(document.activeElement.tagName) && document.activeElement.type !== "range"
  && document.activeElement.type !== "checkbox";
document.addEventListener("pointerdown", () => document.documentElement.classList.remove("keyboard"), true);
document.addEventListener("keydown", (e) => {
  document.documentElement.classList.add("keyboard");
  if ($("help").open) return;
  const key = e.key.toLowerCase(), control = e.ctrlKey || e.metaKey;
  if (control && key === "z") { e.preventDefault(); (e.shiftKey ? redo : undo)(); return; }
  if (control && key === "y") { e.preventDefault(); redo(); return; }
  if (control && key === "s") { e.preventDefault(); $("save").click(); return; }
  if (control && key === "o") { e.preventDefault(); $("open").click(); return; }
  if (control || e.altKey || typing()) return;
  const arrow = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[e.key];
  const at = document.activeElement;
  if (arrow && at.classList.contains("handle")) {
    e.preventDefault();
    nudge(at, arrow[0] * (e.shiftKey ? 5 : 1), arrow[1] * (e.shiftKey ? 5 : 1));
  } else if (arrow && at === canvas) {
    e.preventDefault();
    app.view.x += arrow[0] * 40 / app.view.scale;
    app.view.y += arrow[1] * 40 / app.view.scale;
    app.redraw();
  } else if (key === " " && at.tagName !== "BUTTON") {
    e.preventDefault();
    $("play").click();
  } else if (key === "delete" || key === "backspace") removePicked(at.closest?.("[data-anchor]"));
  else if (key === "escape") { app.tool.cancel?.(); app.pick(null); }
  else if (key === "+" || key === "=") $("zoom-in").click();
  else if (key === "-") $("zoom-out").click();
  else if (key === "0") app.fit();
  else if (key === "n") $("snap").click();
  else if (key === "m") app.assemble();
  else if (key === "?") $("keys").click();
  else {
    const tool = tools.find((t) => t.key === key);
    if (tool) choose(tool);
  }
});
$("keys").onclick = () => {
  const rows = [["Space", "play or pause"], ["Ctrl Z, Ctrl Y", "undo, redo"], ["Ctrl S, Ctrl O", "save, open"],
    ...tools.map((t) => [t.key.toUpperCase(), t.title]), ["arrows", "on a point: move it, with Shift five times as far; on the drawing: move the paper"],
    ["+ − 0", "zoom in, out, show all"], ["N", "snap to the grid"], ["M", "the other assembly mode"], ["Del", "take away the chosen point or link"],
    ["Esc", "leave a stroke"]];
  const help = $("help");
  help.replaceChildren(Object.assign(document.createElement("h2"), { textContent: "Keys" }));
  const dl = document.createElement("dl");
  for (const [k, what] of rows)
    dl.append(Object.assign(document.createElement("dt"), { textContent: k }), Object.assign(document.createElement("dd"), { textContent: what }));
  const close = Object.assign(document.createElement("button"), { textContent: "Close", onclick: () => help.close() });
  help.append(dl, close);
  help.showModal();
};

// ---- the bar on top

$("undo").onclick = undo;
$("redo").onclick = redo;
$("zoom-in").onclick = () => { app.view.zoom(1.3, app.view.width / 2, app.view.height / 2); app.redraw(); };
$("zoom-out").onclick = () => { app.view.zoom(1 / 1.3, app.view.width / 2, app.view.height / 2); app.redraw(); };
$("fit").onclick = app.fit;
$("snap").onclick = () => { app.snap = !app.snap; $("snap").setAttribute("aria-pressed", app.snap); };
$("fresh").onclick = () => { change("all", () => { app.doc = { ...blank(), unit: app.doc.unit }; }); app.ghosts = []; app.pick(null); };
$("unit").onchange = () => setUnit($("unit").value);
const dark = matchMedia("(prefers-color-scheme: dark)");
let theme = null;
try { theme = localStorage.getItem("theme"); } catch (error) { /* none */ }
function paint() { document.documentElement.classList.toggle("dark", theme ? theme === "dark" : dark.matches); }
dark.addEventListener("change", paint);
$("theme").onclick = () => {
  theme = document.documentElement.classList.contains("dark") ? "light" : "dark";
  try { localStorage.setItem("theme", theme); } catch (error) { /* none */ }
  paint();
};
paint();

// Everything in another unit: the same sizes, other numbers.
function setUnit(unit) {
  const f = unitMetre(app.doc.unit) / unitMetre(unit), scaled = (p) => p.map((x) => +(x * f).toPrecision(12));
  if (f === 1) return;
  change("all", (d) => {
    d.unit = unit;
    d.path.anchors = d.path.anchors.map((p) => [...scaled(p.slice(0, 2)), ...p.slice(2)]);
    const t = d.task;
    if (t.pivots) t.pivots = zoneScaled(t.pivots, f);
    t.forbidden = t.forbidden.map((z) => zoneScaled(z, f));
    for (const key of ["least", "most", "acceleration"]) if (t[key] !== null) t[key] = +(t[key] * f).toPrecision(12);
    if (d.photo) d.photo = { ...d.photo, x: d.photo.x * f, y: d.photo.y * f, w: d.photo.w * f, h: d.photo.h * f };
    if (d.linkage) d.linkage = inUnit(d.linkage, unit);
  });
  app.view.scale /= f;
  app.view.x *= f;
  app.view.y *= f;
  app.redraw();
}

export function inUnit(k, unit) {
  const out = clone(k), from = (k.units && k.units.length) || "m", f = unitMetre(from) / unitMetre(unit);
  const scaled = (p) => p.map((x) => x * f);
  out.units = { length: unit, angle: (k.units && k.units.angle) || "deg" };
  if (f === 1) return out;
  for (const p of [...out.joints, ...(out.tracers || [])]) if (p.at) p.at = scaled(p.at);
  for (const l of out.links) if (l.centre) l.centre = scaled(l.centre);
  for (const l of out.links) for (const s of l.shapes || []) {
    for (const key of ["line", "segment", "polygon"]) if (s[key]) s[key] = s[key].map(scaled);
    if (s.circle) s.circle = scaled(s.circle);
    if (typeof s.radius === "number") s.radius *= f;
  }
  for (const j of out.joints) for (const [o, keys] of [[j.stop, ["least", "greatest"]], [j.friction, ["radius"]], [j.clearance, ["gap", "depth"]]])
    if (o) for (const key of keys) if (typeof o[key] === "number" && !(o === j.stop && j.kind === "r")) o[key] *= f;
  for (const s of [...(out.springs || []), ...(out.dampers || []), ...(out.ropes || [])]) {
    if (typeof s.length === "number") s.length *= f;
    if (typeof s.free === "number" && s.links) s.free *= f;
    if (Array.isArray(s.at)) s.at = s.at.map((p) => (Array.isArray(p) ? scaled(p) : p));
  }
  for (const s of out.forces || []) if (s.at) s.at = scaled(s.at);
  const input = inputOf(out), joint = input && out.joints.find((j) => j.name === input.joint);
  if (joint && joint.kind === "t") for (const key of ["value", "first", "last"]) if (typeof input[key] === "number") input[key] *= f;
  return out;
}

// ---- files in

app.adopt = (linkage, keepView) => {
  change("linkage", (d) => {
    const k = inUnit(linkage, d.unit);
    k.tracers ||= [];
    d.linkage = k;
    d.locked = [];
  });
  app.frame = 0;
  if (!keepView) later(app.fit, 60);
};

app.usePath = (t, unit) => {
  const f = unitMetre(unit) / unitMetre(app.doc.unit);
  let a = t.x.map((x, i) => [x * f, t.y[i] * f, ...(t.theta ? [t.theta[i] * 180 / Math.PI] : t.angle ? [null] : []),
    ...(t.angle ? [t.angle[i] * 180 / Math.PI] : [])]);
  change("path", (d) => { d.path = { ...d.path, mode: "points", closed: t.closed, anchors: a }; });
  later(app.fit, 60);
};

async function openText(text, name) {
  try {
    if (/^\s*\{/.test(text) && /"studio"\s*:\s*1/.test(text)) {
      const d = accept(text);
      change("all", () => { app.doc = d; });
    } else if (/^\s*\{/.test(text) && /"linkwright-task"/.test(text)) openTask(JSON.parse(text));
    else {
      const o = await ask("open", { text, name });
      if (o.kind === "target") {
        if (!app.doc.linkage && !app.doc.path.anchors.length && [...$("unit").options].some((x) => x.value === o.unit)) app.doc.unit = o.unit;
        app.usePath(o, o.unit);
        if (o.note) app.say(o.note);
      } else {
        const k = complete(o.linkages[0], text), unit = (k.units && k.units.length) || "m";
        if (!app.doc.path.anchors.length && [...$("unit").options].some((x) => x.value === unit)) app.doc.unit = unit;
        app.adopt(k);
        if (o.linkages.length > 1) emit("results", o.linkages.map((l) => ({ title: l.name || "linkage", linkage: l })));
        app.show("mechanism");
      }
    }
    later(app.fit, 80);
  } catch (error) {
    app.say(`${name}: ${error.message}${error.line ? ` (line ${error.line}, column ${error.column})` : ""}`, true);
  }
}

function openTask(t) {
  if (!t.stations) throw new Error("the task names a file; open a task with its own stations");
  const unit = (t.units && t.units.length) || "m", degree = t.units && t.units.angle === "deg" ? 1 : 180 / Math.PI;
  change("all", (d) => {
    d.unit = unit;
    const a = t.stations.map((s) => [s.x, s.y, ...(s.theta !== undefined ? [s.theta * degree] : s.angle !== undefined ? [null] : []),
      ...(s.angle !== undefined ? [s.angle * degree] : [])]);
    d.path = { ...blank().path, mode: "points", closed: !!t.closed, anchors: a };
    const n = { ...blank().task, links: t.links || 4, turn: t.crank ? "full" : "auto", timing: t.timing || "auto",
      transmission: t.transmission ?? null, ...(t.lengths || {}) };
    n.pivots = t.pivots ? zoneOf(t.pivots) : null;
    n.forbidden = (t.forbidden || []).map(zoneOf);
    if (t.pivots && !n.pivots) later(() => app.say("The task wants the pivots on a line; the studio leaves this out.", true), 500);
    d.task = n;
  });
}

async function openImage(file) {
  const bitmap = await createImageBitmap(file), most = 1600, f = Math.min(1, most / Math.max(bitmap.width, bitmap.height));
  const c = Object.assign(document.createElement("canvas"), { width: Math.round(bitmap.width * f), height: Math.round(bitmap.height * f) });
  c.getContext("2d").drawImage(bitmap, 0, 0, c.width, c.height);
  const v = app.view, w = 0.7 * v.width / v.scale, h = w * c.height / c.width;
  change("photo", (d) => { d.photo = { src: c.toDataURL("image/jpeg", 0.82), x: v.x - w / 2, y: v.y + h / 2, w, h, opacity: 0.55 }; });
  choose(tools.find((t) => t.name === "Scale"));
  app.say("Click two points of the photo whose distance you know.");
  app.show("path");
}

export async function openFile(file) {
  if (file.type.startsWith("image/") && file.type !== "image/svg+xml") await openImage(file).catch((e) => app.say(`${file.name}: ${e.message}`, true));
  else if (file.size > 6e6) app.say(`${file.name} is larger than 6 MB`, true);
  else await openText(await file.text(), file.name);
}
$("open").onclick = () => $("file").click();
$("file").onchange = async () => { for (const f of $("file").files) await openFile(f); $("file").value = ""; };
document.addEventListener("dragover", (e) => e.preventDefault());
document.addEventListener("drop", async (e) => { e.preventDefault(); for (const f of e.dataTransfer.files) await openFile(f); });

app.download = (name, blob) => {
  const a = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: name });
  a.click();
  setTimeout(() => URL.revokeObjectURL(a.href), 5000);
  app.say(`${name} saved`);
};
$("save").onclick = () => app.download("studio.json", new Blob([JSON.stringify(app.doc)], { type: "application/json" }));

app.askScale = async (points, done) => {
  const help = $("help"), length = distance(...points);
  help.innerHTML = "";
  const label = Object.assign(document.createElement("label"), { textContent: `Distance of the two points in ${app.doc.unit}: ` });
  const input = Object.assign(document.createElement("input"), { type: "number", min: 0, step: "any", value: +length.toPrecision(4), id: "distance" });
  const ok = Object.assign(document.createElement("button"), { textContent: "Set the scale", className: "main", type: "submit" });
  const form = Object.assign(document.createElement("form"), { method: "dialog" });
  label.append(input);
  form.append(label, " ", ok);
  help.append(form);
  help.addEventListener("close", () => {
    const f = Number(input.value) / length;
    if (f > 0 && Number.isFinite(f)) {
      const [a] = points;
      change("photo", (d) => {
        const p = d.photo;
        d.photo = { ...p, x: a[0] + (p.x - a[0]) * f, y: a[1] + (p.y - a[1]) * f, w: p.w * f, h: p.h * f };
      });
      choose(tools[1]);
      app.fit();
    }
    done();
  }, { once: true });
  help.showModal();
  input.select();
};

// ---- start

new ResizeObserver(() => {
  const b = canvas.getBoundingClientRect(), first = !app.sized;
  app.view.width = b.width;
  app.view.height = b.height;
  app.sized = true;
  if (first) app.fit();
  app.redraw();
}).observe(canvas);

onConnection((up) => {
  $("offline").hidden = up;
  if (up) emit("changed", "all");
});

makePanels();
choose(tools[0]);
app.say("");
const linked = location.hash.length > 1;
const had = await recall();
changed("all");
try {
  const start = await ask("begin", {}), mark = `${start.file} ${location.pathname}`;
  app.version = start.version;
  if (start.file && !linked && sessionStorage.getItem("opened") !== mark) {
    sessionStorage.setItem("opened", mark);
    app.doc = blank();
    await openText(start.text, start.file);
  } else if (!had && !app.doc.path.anchors.length) choose(tools[1]);
} catch (error) { /* the banner says so */ }
later(() => { if (pointers.size === 0 && !app.touched) app.fit(); }, 120);
app.ready = true;
document.documentElement.dataset.ready = "yes";
window.studio = app;
