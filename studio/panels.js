// What stands beside the drawing: the path, conditions and search, the mechanism, what to look at, what to take away.
import { app, address, change, changed, emit, later, on } from "./state.js";
import { ask, bytes, latest, Refused } from "./api.js";
import { Little, plot } from "./view.js";
import { clone, complete, distance, drag, groundOf, inputOf, lengths, linkNames, onLink, placed, rebase, remove, turned } from "./mechanism.js";
import { csv, optionsOf, outline, taskOf } from "./path.js";
import { makeOverlays } from "./overlays.js";

// ---- small parts

export function make(tag, properties = {}, ...children) {
  const e = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name === "class") e.className = value;
    else if (name.startsWith("aria-") || name === "role" || name.startsWith("data-") || name === "for") e.setAttribute(name, value);
    else if (value !== undefined) e[name] = value;
  }
  e.append(...children.filter((c) => c !== null && c !== undefined && c !== false));
  return e;
}
const row = (...c) => make("div", { class: "row" }, ...c);
const hint = (text) => make("p", { class: "hint" }, text);
let ids = 0;

export function number(label, value, unit, set, o = {}) {
  const id = `n${++ids}`;
  const input = make("input", { id, type: "number", step: "any", value: value ?? "", placeholder: o.placeholder || "", min: o.min, max: o.max });
  input.onchange = () => {
    const v = input.value === "" ? null : Number(input.value);
    if (v !== null && !Number.isFinite(v)) return;
    set(v);
  };
  return row(make("label", { for: id }, label), input, make("span", { class: "unit" }, unit || ""));
}

function choice(label, value, options, set) {
  const id = `n${++ids}`, s = make("select", { id });
  for (const [v, text] of options) s.append(make("option", { value: v, selected: String(v) === String(value) }, text));
  s.onchange = () => set(s.value);
  return row(make("label", { for: id }, label), s);
}

function command(text) {
  const code = make("code", {}, text), copy = make("button", { class: "plain", title: "Copy", "aria-label": "Copy the command" }, "Copy");
  copy.onclick = async () => {
    try { await navigator.clipboard.writeText(code.textContent); app.say("Copied"); } catch (e) { getSelection().selectAllChildren(code); }
  };
  return make("div", { class: "command" }, code, copy);
}

// New contents of a part, with the focus where it was.
function swap(part, ...nodes) {
  const all = () => [...part.querySelectorAll("button, input, select, textarea, summary")];
  const at = all().indexOf(document.activeElement), before = part.scrollTop;
  part.replaceChildren(...nodes.filter((n) => n !== "" && n !== null && n !== undefined && n !== false));
  if (at >= 0) all()[at]?.focus({ preventScroll: true });
  part.scrollTop = before;
}

// Draw a part again soon, once for many changes, and not while a pointer is down: what it presses must stay.
let held = false;
addEventListener("pointerdown", () => { held = true; }, true);
for (const end of ["pointerup", "pointercancel"]) addEventListener(end, () => { setTimeout(() => { held = false; }, 0); }, true);
function soon(f) {
  let due = false;
  const go = () => {
    if (held) { later(go, 30); return; }
    due = false;
    f();
  };
  return () => { if (!due) { due = true; later(go, 0); } };
}

const round = (v, n = 3) => (v === null || v === undefined || !Number.isFinite(v) ? "–" : String(+v.toPrecision(n)));
const facts = (list) => {
  const dl = make("dl", { class: "facts" });
  for (const [k, v] of list) dl.append(make("dt", {}, k), make("dd", {}, v));
  return dl;
};

// ---- pictures that move

const little = new Set();
function movingPicture(linkage, width, height, o = {}) {
  const p = new Little(width, height, o.wanted);
  p.closed = o.closed;
  ask("motion", { linkage, points: 160, frames: 60 }).then((m) => { p.set(linkage, m); little.add(p); }).catch(() => {});
  return p;
}
const still = matchMedia("(prefers-reduced-motion: reduce)");
let last = 0;
function animate(now) {
  requestAnimationFrame(animate);
  if (now - last < 40) return;
  last = now;
  for (const p of little) {
    if (!p.svg.isConnected) { little.delete(p); continue; }
    if (!p.svg.offsetParent && !p.svg.getClientRects().length) continue;
    const n = p.motion.frames, t = still.matches ? 0 : now / 3000;
    const f = p.motion.loops ? (t % 1) * n : (n - 1) * Math.abs(((t % 2) + 2) % 2 - 1);
    p.show((f + p.motion.first) % (p.motion.loops ? n : Math.max(n, 1)) > n - 1 && !p.motion.loops ? n - 1 : p.motion.loops ? (f + p.motion.first) % n : f, placed, turned);
  }
}

// ---- path

function pathPanel(panel) {
  const render = soon(() => {
    const p = app.doc.path, kinds = [["curve", "smooth curve"], ["lines", "straight lines"], ["points", "points in order"]];
    const closed = make("input", { type: "checkbox", checked: p.closed, disabled: p.anchors.length < 3, id: "closed" });
    closed.onchange = () => change("path", (d) => { d.path.closed = closed.checked; });
    const rows = make("details", { open: panel.querySelector("details")?.open });
    rows.append(make("summary", {}, `${p.anchors.length} points`));
    const area = make("textarea", { rows: 8, cols: 30, "aria-label": "Points, x,y in each line", value: p.anchors.map((a) => a.slice(0, 2).map((v) => +v.toPrecision(8)).join(", ")).join("\n") });
    area.onchange = () => {
      const a = area.value.split("\n").filter((l) => l.trim()).map((l) => l.split(/[,;\s]+/).map(Number).slice(0, 2));
      if (a.every((q) => q.length === 2 && q.every(Number.isFinite))) change("path", (d) => { d.path.anchors = a; });
      else app.say("Each line needs two numbers, x and y.", true);
    };
    rows.append(area);
    swap(panel,
      make("h2", {}, "The path you want"),
      hint(p.anchors.length ? `${p.closed ? "Closed" : "Open"} path. Drag its points; double-click takes one away.`
        : "Draw it with the tools on the left, or drop a file: CSV, SVG, DXF, or a photo to draw over."),
      choice("Drawn as", p.mode, kinds, (v) => change("path", (d) => { d.path.mode = v; })),
      make("label", { class: "check" }, closed, "closed: the last point goes on to the first"),
      p.mode === "points" ? "" : number("Stations to meet", p.stations, "", (v) => change("path", (d) => { d.path.stations = Math.max(3, Math.min(400, Math.round(v || 36))); }), { min: 3 }),
      row(make("button", { id: "clear-path", disabled: !p.anchors.length, onclick: () => change("path", (d) => { d.path.anchors = []; d.path.closed = false; }) }, "Clear the path"),
        make("button", { id: "load-path", onclick: () => document.getElementById("open").click() }, "Open CSV, SVG, DXF")),
      p.anchors.length ? rows : "",
      ...photoPart(),
      make("h2", {}, "Then"),
      make("button", { class: "main", disabled: p.anchors.length < 3, onclick: () => app.show("search") }, "Search linkages for it"),
      make("h2", {}, "Or begin with a mechanism"),
      hint("A known one, a chain to drag into shape, or your own with the tools under Build."),
      make("button", { onclick: () => app.show("mechanism") }, "Choose a mechanism"));
  });
  on("changed", (parts) => { if (parts !== "linkage" && parts !== "none" && document.activeElement?.tagName !== "TEXTAREA") render(); });
  render();
}

function photoPart() {
  const { photo } = app.doc;
  if (!photo) return [];
  const range = make("input", { type: "range", min: 0.1, max: 1, step: 0.05, value: photo.opacity, "aria-label": "How strongly the photo shows" });
  range.oninput = () => { app.doc.photo = { ...app.doc.photo, opacity: Number(range.value) }; app.redraw(); };
  return [make("h2", {}, "Photo"), row(make("span", { class: "label" }, `${round(photo.w)} × ${round(photo.h)} ${app.doc.unit}`), range),
    row(make("button", { onclick: () => change("photo", (d) => { d.photo = null; }) }, "Take the photo away"))];
}

// ---- nearest mechanisms while drawing

function nearestStrip() {
  const strip = document.getElementById("nearest");
  let shown = "";
  const find = latest("nearest", (o) => {
    if (o.atlas === 1) {
      strip.replaceChildren(make("span", { class: "chip" }, `the atlas of curves is being made, once: ${Math.round(100 * (o.done || 0))} %`));
      strip.hidden = false;
      setTimeout(look, 600);
      return;
    }
    strip.hidden = !o.hits.length;
    app.nearestMs = o.ms;
    app.nearestAt = performance.now();
    strip.replaceChildren(...o.hits.slice(0, innerWidth < 820 ? 4 : 5).map((h) => {
      const picture = movingPicture(h.linkage, 112, 76, { wanted: outline(app.doc.path, 8), closed: app.doc.path.closed });
      const b = make("button", { class: "little", title: "Take this mechanism",
        "aria-label": `${h.family || "linkage"}, ${round(h.error, 2)} ${app.doc.unit} off, transmission angle ${round(h.transmission, 2)} degrees: take it` },
      picture.svg, make("b", {}, h.family || "linkage"), make("br"), `${round(h.error, 2)} ${app.doc.unit} · ${h.transmission === null ? "–" : Math.round(h.transmission)}°`);
      b.onclick = () => { app.adopt(complete(h.linkage, ""), true); strip.hidden = true; shown = ""; app.show("mechanism"); };
      return b;
    }));
  }, () => { strip.hidden = true; });
  function look() {
    const p = app.doc.path, wanted = p.anchors.length >= 4 && app.tab === "path";
    if (!wanted) {
      strip.hidden = true;
      shown = "";
      return;
    }
    const points = outline(p, p.mode === "curve" ? 8 : 1), key = JSON.stringify([points, p.closed]);
    if (key === shown && !strip.hidden) return;
    shown = key;
    find({ x: points.map((q) => q[0]), y: points.map((q) => q[1]), closed: p.closed, unit: app.doc.unit, count: 6, turns: true });
  }
  on("changed", (parts) => { if (parts === "path" || parts === "all") look(); });
  on("tab", look);
}

// ---- conditions and search

const TYPES = [["fourbar", "four-bar"], ["fourbar,slidercrank", "four-bar, slider-crank"], ["slidercrank", "slider-crank"], ["all", "every kind with four links"]];

// Conditions that can be left out one by one: name, how to leave it out, its words of `at_limit`.
const conditions = () => {
  const t = app.doc.task, list = [];
  if (t.turn !== "auto" && t.turn !== "rock") list.push(["turn", "the input turns fully", { turn: "auto" }]);
  list.push(["transmission", `transmission angle at least ${t.transmission ?? 20}°`, { transmission: 0.01 }]);
  if (t.maxSize !== null) list.push(["maxSize", `at most ${t.maxSize} diagonals large`, { maxSize: null }]);
  if (t.least !== null || t.most !== null || t.ratio !== null) list.push(["lengths", "limits of lengths", { least: null, most: null, ratio: null }]);
  if (t.pivots) list.push(["pivots", "zone for pivots", { pivots: null }]);
  t.forbidden.forEach((z, i) => list.push([`forbidden${i}`, `forbidden zone ${i + 1}`, { forbidden: t.forbidden.filter((y, k) => k !== i) }]));
  if (t.acceleration !== null) list.push(["acceleration", "acceleration", { acceleration: null }]);
  if (t.links === 4) list.push(["links", "four links only", { links: 6 }]);
  return list;
};

function searchPanel(panel) {
  const s = { id: 0, state: "", news: null, results: [], compared: [], costs: {}, used: -1 };
  app.search = s;
  const box = make("div"), progress = make("div"), cards = make("div");
  panel.append(box, progress, cards);

  const render = soon(() => {
    const t = app.doc.task, u = app.doc.unit, set = (key) => (v) => change("task", (d) => { d.task[key] = v; });
    const box4 = (label, z, away) => row(make("span", { class: "label" }, Array.isArray(z[0]) ? `${label} a polygon of ${z.length} corners` : `${label} ${z.map((x) => round(x)).join(", ")}`), make("button", { class: "plain", "aria-label": `Take ${label} away`, onclick: away }, "✕"));
    const cost = (key) => {
      const c = s.costs[key];
      return c ? make("p", { class: `cost${c.gain > 0.02 ? " active" : ""}`, "data-cost": key }, c.text) : "";
    };
    const going = s.state === "running", n = app.stations.length;
    swap(box,
      make("h2", {}, "Conditions"),
      choice("Links", t.links, [[4, "4"], [6, "up to 6"], [8, "up to 8"]], (v) => set("links")(Number(v))), cost("links"),
      choice("Kinds with four links", t.types, TYPES, set("types")),
      choice("Input", t.turn, [["auto", "turns fully if closed"], ["full", "turns fully"], ["crank", "turns fully, shortest"], ["rock", "may rock, pass limits"]], set("turn")), cost("turn"),
      number("Least transmission angle", t.transmission, "°", set("transmission"), { placeholder: "20", min: 0, max: 89 }), cost("transmission"),
      number("Most size, in diagonals of the path", t.maxSize, "×", set("maxSize"), { placeholder: "6", min: 0.1 }), cost("maxSize"),
      number("Shortest length", t.least, u, set("least"), { min: 0 }),
      number("Longest length", t.most, u, set("most"), { min: 0 }),
      number("Longest over shortest", t.ratio, "×", set("ratio"), { placeholder: "20", min: 1 }), cost("lengths"),
      number("Speed of the crank", t.rpm, "rpm", (v) => set("rpm")(v || 30), { min: 0.001 }),
      number("Most acceleration of the point", t.acceleration, `${u}/s²`, set("acceleration"), { min: 0 }), cost("acceleration"),
      t.pivots ? box4("Pivots in", t.pivots, () => set("pivots")(null)) : "", cost("pivots"),
      ...t.forbidden.flatMap((z, i) => [box4("Nothing in", z, () => change("task", (d) => { d.task.forbidden.splice(i, 1); })), cost(`forbidden${i}`)]),
      hint("Zones for pivots (B) and forbidden zones (F): choose the tool, drag a box or draw round the zone."),
      row(make("button", { id: "search", class: "main", disabled: going || n < 3, onclick: () => start() }, "Search"),
        make("button", { id: "improve", disabled: going || n < 3 || !app.doc.linkage, title: "Search from the mechanism on the drawing", onclick: () => start(true) }, "Improve from here"),
        make("button", { id: "stop", disabled: !going, onclick: () => ask("stop", { id: s.id }).catch(() => {}) }, "Stop")),
      n < 3 ? hint("Draw a path first, with three points or more.") : "");
    renderProgress();
  });

  function renderProgress() {
    const n = s.news;
    progress.replaceChildren();
    if (!s.state) return;
    const bar = make("i");
    bar.style.transform = `scaleX(${n ? Math.min(n.done, 1) : 0})`;
    const h = n ? n.history : [], pairs = [];
    for (let i = 0; i < h.length; i += 2) pairs.push([h[i], h[i + 1]]);
    const lastError = pairs.length ? pairs[pairs.length - 1][1] : null;
    const words = { running: "searching", done: "done", stopped: "stopped; the best is kept", nothing: "no linkage meets these conditions", failed: "failed" }[s.state];
    progress.append(make("div", { class: "progress", role: "progressbar", "aria-label": "Search", "aria-valuenow": Math.round(100 * (n ? n.done : 0)), "aria-valuemin": 0, "aria-valuemax": 100 }, bar),
      make("p", { id: "state", role: "status" }, `${words}${n ? `, ${round(n.seconds, 2)} s` : ""}${lastError !== null ? `; best error ${round(lastError)} ${app.doc.unit} (rms)` : ""}`));
    if (n && n.error) progress.append(make("p", { class: "bad" }, n.error));
    if (pairs.length) {
      pairs.push([Math.max(n.seconds, 1.05 * pairs[pairs.length - 1][0]), lastError]);
      const x = [], y = [];
      pairs.forEach(([a, b], i) => { if (i) { x.push(a); y.push(pairs[i - 1][1]); } x.push(a); y.push(b); });
      progress.append(plot({ label: "Error over time", x: "time [s]", y: `error [${app.doc.unit}]`, log: true, height: 120, series: [{ x, y, colour: "var(--wanted)" }] }));
    }
    if (s.command) progress.append(hint("The same on the command line, with the task saved as task.json:"), command(s.command),
      row(make("button", { onclick: () => app.download("task.json", new Blob([JSON.stringify(s.task, null, 1)], { type: "application/json" })) }, "Save task.json"),
        s.state !== "running" && s.results.length ? make("button", { id: "costs", onclick: costs }, "What do the conditions cost?") : ""));
  }

  async function follow(id, each) {
    let after = -1;
    for (;;) {
      const n = await ask("news", { id, after });
      after = n.version;
      each(n);
      if (n.state !== "running") return n;
    }
  }

  async function start(improve) {
    s.state = "running";
    s.results = [];
    s.compared = [];
    s.costs = {};
    s.news = null;
    s.used = -1;
    app.ghosts = [];
    cards.replaceChildren();
    s.task = taskOf(app.doc, app.stations);
    try {
      const from = improve && app.doc.linkage ? (app.fresh() ? rebase(app.doc.linkage, app.motion, 0) : app.doc.linkage) : undefined;
      const o = await ask("search", { task: s.task, ...optionsOf(app.doc), ...(from ? { start: from } : {}) });
      s.id = o.id;
      s.command = o.command;
      render();
      const kept = app.doc.linkage;
      let best = "";
      const end = await follow(o.id, (n) => {
        s.news = n;
        s.state = n.state;
        const text = JSON.stringify(n.best);
        if (n.best && text !== best && n.state === "running") {
          best = text;
          showBest(n.best);
        }
        renderProgress();
      });
      app.doc.linkage = kept;
      s.results = end.results || [];
      if (s.results.length) use(0);
      else app.refresh();
    } catch (error) {
      s.state = "failed";
      s.news = { done: 0, seconds: 0, history: [], error: error.message };
      if (!(error instanceof Refused)) s.news.error = "the server went away; search again";
    }
    render();
    renderCards();
  }

  // The best so far moves on the drawing; the document stays as it is until the end.
  function showBest(linkage) {
    const k = complete(linkage, "");
    ask("motion", { linkage: k, points: 400, frames: 120 }).then((m) => {
      if (s.state !== "running") return;
      app.doc.linkage = k;
      app.motion = m;
      app.motionOf = k;
      app.stale = false;
      app.frame = Math.min(app.frame, m.frames - 1);
      s.shown = (s.shown || 0) + 1;
      document.getElementById("player").hidden = false;
      if (!app.playing) app.play();
      emit("motion");
    }).catch(() => {});
  }

  function use(i) {
    s.used = i;
    app.adopt(complete(s.results[i].linkage, ""), true);
    app.frame = 0;
    later(app.fit, 80);
    renderCards();
  }

  function renderCards() {
    cards.replaceChildren();
    if (!s.results.length) return;
    const wanted = outline(app.doc.path, 8), u = app.doc.unit, list = make("ol", { class: "cards", id: "results" });
    s.results.forEach((r, i) => {
      const check = make("input", { type: "checkbox", checked: s.compared.includes(i), "aria-label": `Compare result ${i + 1}` });
      check.onchange = () => {
        s.compared = check.checked ? [...s.compared, i].slice(-2) : s.compared.filter((c) => c !== i);
        renderCards();
      };
      const picture = movingPicture(r.linkage, 150, 96, { wanted, closed: app.doc.path.closed });
      const dl = make("dl");
      const f = [["error", `${round(r.error_mean)} ${u}`], ["strays", `${round(r.stray, 2)} ${u}`], ["size", `${round(r.size)} ${u}`], ["transmission", `${round(r.transmission, 2)}°`], ["links", String(r.links ?? r.linkage.links.length)]];
      if (r.error_mean !== undefined) for (const [k, v] of f) dl.append(make("dt", {}, k), make("dd", {}, v));
      list.append(make("li", { class: `card${s.used === i ? " used" : ""}`, "data-result": i }, picture.svg, make("b", {}, `${i + 1} ${r.title}${r.class ? ` (${r.class})` : ""}`), dl,
        r.at_limit ? make("p", { class: "cost active" }, `at its limit: ${r.at_limit}`) : "",
        row(make("button", { onclick: () => use(i), "aria-label": `Use result ${i + 1}` }, "Use"), make("label", {}, check, " compare"))));
    });
    cards.append(make("h2", {}, `${s.results.length} result${s.results.length > 1 ? "s" : ""}, best first`), list);
    compare();
  }

  function compare() {
    const [a, b] = s.compared.map((i) => s.results[i]);
    app.ghosts = [];
    if (b || (a && s.used >= 0 && s.compared[0] !== s.used)) {
      const pair = b ? s.compared : [s.used, s.compared[0]], [x, y] = pair.map((i) => s.results[i]);
      const u = app.doc.unit, wanted = outline(app.doc.path, 8);
      const pictures = make("div", { class: "compare" }, ...[x, y].map((r) => movingPicture(r.linkage, 160, 150, { wanted, closed: app.doc.path.closed }).svg));
      const table = make("table", { id: "compare" }), put = (name, f) => table.append(make("tr", {}, make("th", {}, name), make("td", {}, f(x)), make("td", {}, f(y))));
      put("result", (r) => `${s.results.indexOf(r) + 1} ${r.title}`);
      put(`mean error [${u}]`, (r) => round(r.error_mean));
      put(`greatest error [${u}]`, (r) => round(r.error_max));
      put(`strays from the path [${u}]`, (r) => round(r.stray));
      put(`size [${u}]`, (r) => round(r.size));
      put("least transmission angle [°]", (r) => round(r.transmission, 2));
      put("links", (r) => String(r.links ?? ""));
      cards.append(make("h2", {}, "Side by side"), pictures, table, hint("On the drawing they lie over each other, the second one green."));
      const ghost = complete(y.linkage, "");
      ask("motion", { linkage: ghost, points: 300, frames: 120 }).then((m) => { app.ghosts = [{ linkage: ghost, motion: m }]; app.redraw(); }).catch(() => {});
      if (s.used !== pair[0]) use(pair[0]);
    }
    app.redraw();
  }

  // The same search without each condition: how much smaller would the error be?
  async function costs() {
    const base = s.results[0].error_mean, u = app.doc.unit, stations = app.stations, list = conditions();
    s.costs = {};
    for (const [key, name, without] of list) {
      s.costs[key] = { text: "measuring …", gain: 0 };
      render();
      try {
        const o = await ask("search", { task: taskOf(app.doc, stations, without), ...optionsOf(app.doc, without), results: 1, ...(without.links ? { budget: 150000 } : {}) });
        const end = await follow(o.id, () => {});
        const other = end.results && end.results[0] ? Math.min(end.results[0].error_mean, base) : base;
        const gain = base > 0 ? (base - other) / base : 0;
        s.costs[key] = { gain, text: gain > 0.02 ? `costs ${round(100 * gain, 2)} % of the error: ${round(other)} ${u} without (${name}), ${round(base)} ${u} with` : `costs nothing (${name})` };
      } catch (error) {
        s.costs[key] = { gain: 0, text: `not measured: ${error.message}` };
      }
      render();
    }
  }

  on("changed", (parts) => { if (parts === "task" || parts === "all") { s.costs = {}; render(); } });
  on("target", render);
  on("results", (list) => { s.results = list; s.state = s.state || "done"; s.used = 0; renderCards(); });
  on("motion", () => { const b = document.getElementById("improve"); if (b) b.disabled = s.state === "running" || app.stations.length < 3 || !app.doc.linkage; });
  render();
}

// ---- the mechanism

function mechanismPanel(panel) {
  const facts1 = make("div"), list = make("div"), begin = make("div");
  panel.append(facts1, list, begin);
  let shown = "";

  const render = soon(() => {
    const k = app.doc.linkage;
    facts1.replaceChildren(...(k ? [make("h2", {}, k.name || "Mechanism"), ...classPart()] : []));
    const key = JSON.stringify([k, app.doc.locked, app.doc.unit, app.picked, app.stations.length < 3]);
    if (key === shown) return;
    shown = key;
    if (!k) { list.replaceChildren(); return; }
    const u = app.doc.unit, ground = groundOf(k), table = make("table", { class: "links" });
    table.append(make("tr", {}, make("th", {}, "link"), make("th", {}, `length [${u}]`), make("th", {}, "lock"), make("th", {}, "mass [kg]")));
    for (const name of linkNames(k)) {
      if (name === ground) continue;
      const all = lengths(k, name).filter((l) => l.length > 1e-9), link = k.links.find((l) => l.name === name);
      const lock = make("input", { type: "checkbox", checked: app.doc.locked.includes(name), "aria-label": `Lock the lengths of ${name}` });
      lock.onchange = () => change("task", (d) => { d.locked = lock.checked ? [...d.locked, name] : d.locked.filter((l) => l !== name); });
      const cell = make("td");
      all.slice(0, 3).forEach((l) => {
        const input = make("input", { type: "number", step: "any", min: 0, value: +l.length.toPrecision(6), "aria-label": `Distance of ${l.from.name} and ${l.to.name} on ${name}`, title: `${l.from.name}–${l.to.name}` });
        input.onchange = () => setLength(l, Number(input.value));
        cell.append(input, make("br"));
      });
      const mass = make("input", { type: "number", step: "any", min: 0, value: link.mass ?? "", "aria-label": `Mass of ${name}`, placeholder: "–" });
      mass.onchange = () => setMass(name, mass.value === "" ? null : Number(mass.value));
      table.append(make("tr", {}, make("th", {}, name), cell, make("td", {}, lock), make("td", {}, mass)));
    }
    const input = inputOf(k), grounded = k.joints.filter((j) => (j.kind === "r" || j.kind === "t") && j.links.includes(ground));
    const parts = [table];
    if (grounded.length) parts.push(choice("Driven at", input ? input.joint : "", [["", "nowhere"], ...grounded.map((j) => [j.name, `${j.name} (${j.links.find((l) => l !== ground)})`])],
      (v) => { const posture = now(); change("linkage", (d) => { d.linkage = posture; delete d.linkage.inputs; if (v) d.linkage.input = { joint: v }; else delete d.linkage.input; }); }));
    parts.push(...pickedPart(k), row(make("button", { id: "assembly", onclick: app.assemble, title: "The same lengths, put together the other way (M)" }, "Other assembly")),
      row(make("button", { id: "improve2", disabled: app.stations.length < 3, onclick: () => { app.show("search"); document.getElementById("improve").click(); } }, "Improve from here"),
      make("button", { onclick: () => change("linkage", (d) => { d.linkage = null; d.locked = []; }) }, "Clear the mechanism")));
    swap(list, ...parts);
  });

  const now = () => (app.fresh() ? rebase(app.doc.linkage, app.motion, app.frame) : clone(app.doc.linkage));

  function setLength(l, length) {
    if (!(length > 0)) return;
    const k = now(), find = (q) => [...k.joints, ...k.tracers].find((p) => p.name === q.name), ground = groundOf(k);
    let [a, b] = [find(l.from), find(l.to)];
    if (b.links && b.links.includes(ground)) [a, b] = [b, a];
    const d = distance(a.at, b.at) || 1, to = [0, 1].map((i) => a.at[i] + (b.at[i] - a.at[i]) * length / d);
    change("linkage", (doc) => { drag(k, b.at, to, doc.locked); doc.linkage = k; });
    app.frame = 0;
  }

  // A mass is a slender bar, or a plate through the points of the link: its centre is that of the points.
  function setMass(name, mass) {
    const k = now(), link = k.links.find((l) => l.name === name), points = [...onLink(k, name)].filter((j) => j.at).map((j) => j.at);
    change("linkage", (d) => {
      for (const key of ["mass", "centre", "inertia"]) delete link[key];
      if (mass > 0 && points.length) {
        link.mass = mass;
        link.centre = [0, 1].map((i) => points.reduce((sum, p) => sum + p[i], 0) / points.length);
        const metre = { mm: 1e-3, cm: 1e-2, m: 1, in: 0.0254 }[d.unit], far = Math.max(...points.map((p) => distance(p, link.centre)), 0);
        link.inertia = mass * (2 * far * metre) ** 2 / 12;
        if (!k.gravity) k.gravity = [0, -9.81];
      }
      d.linkage = k;
    });
    app.frame = 0;
  }

  function classPart() {
    const a = app.analysis, m = app.motion, out = [];
    const t = a ? a.transmission.filter((v) => v !== null) : [];
    out.push(facts([["degrees of freedom", m ? String(m.mobility) : "–"],      // always four rows: nothing below jumps
      ["class", a && a.class ? `${a.class.symbol}, ${a.class.name}` : "–"],
      ["circuits", a && a.ranges.length ? String(new Set(a.ranges.map((r) => r.circuit)).size) : "–"],
      ["least transmission angle", t.length ? `${Math.round(Math.min(...t) * 180 / Math.PI)}°` : "–"]]));
    return out;
  }

  function pickedPart(k) {
    const what = app.picked;
    if (!what) return [hint("Drag joints, pivots and tracers on the drawing. Locked links keep their lengths.")];
    if (what.link) return [make("h3", {}, `Link ${what.link}`), row(make("button", { onclick: () => { const p = now(); change("linkage", (d) => { remove(p, { link: what.link }); d.linkage = p; }); app.pick(null); } }, "Take this link away"))];
    const p = [...k.joints, ...k.tracers].find((q) => q.name === what.point.name);
    if (!p) return [];
    const q = app.posed ? app.posed(p) : p.at, parts = [make("h3", {}, `${p.links ? "Joint" : "Tracer"} ${p.name}${p.links ? `: ${p.links.join(" and ")}` : ` on ${p.link}`}`)];
    ["x", "y"].forEach((axis, i) => parts.push(number(axis, +q[i].toPrecision(7), app.doc.unit, (v) => {
      const n = now(), r = [...n.joints, ...n.tracers].find((s) => s.name === p.name), to = [...r.at];
      to[i] = v;
      change("linkage", (d) => { drag(n, r.at, to, d.locked); d.linkage = n; });
      app.frame = 0;
    })));
    if (p.links && p.kind !== "g") parts.push(choice("Kind", p.kind, [["r", "pin"], ["t", "slider"], ["p", "pin in a slot"], ["f", "weld"]], (v) => {
      const n = now();
      change("linkage", (d) => {
        const j = n.joints.find((s) => s.name === p.name);
        j.kind = v;
        if (v === "t" || v === "p") j.along ||= [1, 0]; else delete j.along;
        d.linkage = n;
      });
    }));
    for (const g of k.joints.filter((j) => j.kind === "g")) parts.push(number(`Ratio of gears ${g.name}`, g.ratio, "", (v) => {
      const n = now();
      change("linkage", (d) => { n.joints.find((s) => s.name === g.name).ratio = v; d.linkage = n; });
    }));
    return parts;
  }

  async function beginPart() {
    const known = make("select", { "aria-label": "Known mechanisms", id: "gallery" }), chains = make("div", { class: "chains", id: "chains" });
    known.append(make("option", { value: "" }, "known mechanisms …"));
    known.onchange = async () => {
      if (!known.value) return;
      try {
        const text = JSON.stringify(await ask("gallery", { name: known.value })), o = await ask("open", { text, name: "gallery.json" });
        app.adopt(complete(o.linkages[0], text));
      } catch (error) { app.say(error.message, true); }
    };
    const size = () => { const b = app.view; return 0.45 * Math.min(b.width, b.height) / b.scale; };
    const pick = choice("Chain of", 4, [[4, "4 links"], [6, "6 links"], [8, "8 links"]], async (v) => load(Number(v)));
    async function load(links) {
      try {
        const o = await ask("chains", { links });
        chains.replaceChildren(...o.mechanisms.map((m, i) => {
          const b = make("button", { "aria-label": `Mechanism ${i + 1} of ${links} links` });
          if (m.picture) b.append(make("img", { alt: "", src: `data:image/svg+xml,${encodeURIComponent(m.picture)}` })); else b.append(String(i + 1));
          let seed = 0;
          b.onclick = async () => {
            try {
              const c = await ask("chain", { mechanism: m.mechanism, seed: ++seed, unit: app.doc.unit, size: size() });
              app.adopt(complete(c.linkage, ""));
            } catch (error) { app.say(error.message, true); }
          };
          return b;
        }));
      } catch (error) { app.say(error.message, true); }
    }
    begin.append(make("h2", {}, "Begin with"), row(known), make("h3", {}, "or a chain to drag into shape"), pick, hint("Click once more for other dimensions."), chains,
      hint("or your own: Link (K), Ground (G), Slider (S), Gears (W), Tracer (T) on the left."));
    try {
      for (const g of await ask("gallery", {})) known.append(make("option", { value: g.name, title: g.use }, g.title));
    } catch (error) { known.disabled = true; }
    on("tab", (t) => { if (t === "mechanism" && !chains.children.length) load(4); });
  }

  for (const event of ["changed", "motion", "picked", "tab", "analysis", "target"]) on(event, () => { if (!app.touching && !app.dragging && app.tab === "mechanism") render(); });
  beginPart();
}

// ---- take away

const FORMATS = [["json", "Linkage", "json", "linkage of linkwright"], ["svg", "SVG", "svg", "picture"], ["pdf", "PDF", "pdf", "picture"], ["png", "PNG", "png", "picture"], ["gif", "GIF", "gif", "animation"],
  ["html", "Page", "html", "a page to mail, which moves"], ["dxf", "DXF", "dxf", "plates to cut"], ["scad", "OpenSCAD", "scad", "plates in layers"], ["step", "STEP", "step", "solids"], ["stl", "STL", "stl", "meshes"],
  ["mjcf", "MJCF", "xml", "MuJoCo"], ["poses", "CSV", "csv", "poses of the links"], ["urdf", "URDF", "urdf", "robots"], ["adams", "ADAMS", "adm", "dataset"], ["slvs", "SolveSpace", "slvs", "sketch"], ["pmks", "PMKS", "txt", "table"]];
const PICTURES = ["svg", "pdf", "png", "gif", "html"];

function awayPanel(panel) {
  const shown = make("div"), grid = make("div", { class: "formats" });
  const name = () => ((app.doc.linkage && app.doc.linkage.name) || "mechanism").replace(/[^\w-]+/g, "-").toLowerCase().replace(/^-|-$/g, "") || "mechanism";
  for (const [format, title, end, about] of FORMATS) {
    const b = make("button", { title: about, "data-format": format, "aria-label": `${title}: ${about}` }, title);
    b.onclick = async () => {
      const file = `${name()}.${end}`;
      shown.replaceChildren(hint("The same on the command line, with the linkage saved as mechanism.json:"),
        command(format === "json" ? "linkwright trace mechanism.json --plot curve.svg" : PICTURES.includes(format) ? `linkwright draw mechanism.json -o ${file}` : `linkwright convert mechanism.json --format ${format} -o ${file}`));
      try {
        const target = app.stations.length > 2 && PICTURES.includes(format) ? `# units: ${app.doc.unit}\n${csv(app.stations)}` : undefined;
        app.download(file, await bytes("export", { linkage: app.doc.linkage, format, target }));
      } catch (error) { app.say(`${title}: ${error.message}`, true); }
    };
    grid.append(b);
  }
  const link = make("button", { id: "copy-address" }, "Copy the address");
  link.onclick = async () => {
    const a = await address();
    try { await navigator.clipboard.writeText(a); app.say("Address copied: it opens this drawing while the studio runs"); } catch (e) { app.say(a); }
  };
  const none = hint("Choose a result, a chain or a known mechanism first.");
  panel.append(make("h2", {}, "The mechanism"), none, grid, shown, make("h2", {}, "The path"),
    row(make("button", { id: "path-csv", onclick: () => app.download("path.csv", new Blob([`# units: ${app.doc.unit}\n# closed: ${app.doc.path.closed ? "yes" : "no"}\n${csv(app.stations)}`], { type: "text/csv" })) }, "CSV of the stations"),
      make("button", { id: "task-json", onclick: () => app.download("task.json", new Blob([JSON.stringify(taskOf(app.doc, app.stations), null, 1)], { type: "application/json" })) }, "Task with conditions")),
    make("h2", {}, "Everything"), hint("The address of this page holds the drawing; a file also holds the photo. Both open it again."),
    row(link, make("button", { onclick: () => document.getElementById("save").click() }, "Save studio.json")));
  const enable = () => {
    for (const b of grid.children) b.disabled = !app.doc.linkage;
    none.hidden = !!app.doc.linkage;
    for (const id of ["path-csv", "task-json"]) document.getElementById(id).disabled = app.stations.length < 2;
  };
  on("changed", enable);
  on("target", enable);
}

// ---- tabs

export function makePanels() {
  const tabs = [["path", "Path", pathPanel], ["search", "Search", searchPanel], ["mechanism", "Mechanism", mechanismPanel], ["look", "Look", makeOverlays], ["away", "Export", awayPanel]];
  const bar = document.getElementById("tabs"), panels = document.getElementById("panels");
  app.show = (name) => {
    app.tab = name;
    for (const [id] of tabs) {
      const mine = id === name, b = document.getElementById(`tab-${id}`);
      b.setAttribute("aria-selected", mine);
      b.tabIndex = mine ? 0 : -1;
      document.getElementById(`panel-${id}`).hidden = !mine;
    }
    emit("tab", name);
  };
  for (const [id, title, fill] of tabs) {
    const b = make("button", { id: `tab-${id}`, role: "tab", "aria-controls": `panel-${id}` }, title);
    b.onclick = () => app.show(id);
    bar.append(b);
    const panel = make("div", { id: `panel-${id}`, role: "tabpanel", "aria-labelledby": `tab-${id}` });
    panels.append(panel);
    fill(panel);
  }
  bar.onkeydown = (e) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[e.key];
    if (!step) return;
    e.preventDefault();
    e.stopPropagation();
    const at = tabs.findIndex(([id]) => id === app.tab);
    app.show(tabs[(at + step + tabs.length) % tabs.length][0]);
    document.getElementById(`tab-${app.tab}`).focus();
  };
  nearestStrip();
  app.show("path");
  requestAnimationFrame(animate);
}
