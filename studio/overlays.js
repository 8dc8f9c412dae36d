// What can be laid over the drawing, and the plots beside it: velocities, centres, limits, forces.
import { app, on } from "./state.js";
import { ask, latest, Refused } from "./api.js";
import { plot } from "./view.js";
import { complete, groundOf, linkNames, placed } from "./mechanism.js";
import { make, number } from "./panels.js";

const LIST = [
  ["names", "names of the points"],
  ["velocity", "velocity of the points", "--speed"],
  ["acceleration", "acceleration of the points", "--force"],
  ["centres", "instant centres", "--pole"],
  ["centrodes", "centrodes of a link: fixed, and dashed the moving one", "--pole"],
  ["inflection", "inflection circle of a link", "--force"],
  ["cognates", "Roberts' cognates: the same curve", "--other"],
  ["dead", "dead points: where a link at the ground stands still", "--bad"],
  ["doubles", "double points of the curve", "--curve"],
  ["circuits", "other circuits and assembly modes, dotted", "--curve"],
];

export function makeOverlays(panel) {
  const plots = make("div"), toggles = make("div"), forces = make("div");
  let link = null, cursors = [];
  const choose = make("select", { "aria-label": "Link of centrodes and inflection circle" });
  choose.onchange = () => { link = choose.value; app.redraw(); };
  for (const [id, title, colour] of LIST) {
    const box = make("input", { type: "checkbox", checked: app.overlays.has(id), "data-overlay": id });
    box.onchange = () => {
      if (box.checked) app.overlays.add(id); else app.overlays.delete(id);
      analyse();
      app.redraw();
    };
    const mark = make("span", { class: "swatch" });
    if (colour) mark.style.borderTopColor = `var(${colour})`; else mark.hidden = true;
    toggles.append(make("label", { class: "check" }, box, make("span", {}, mark, title)));
  }
  panel.append(make("h2", {}, "On the drawing"), toggles, make("div", { class: "row" }, make("span", { class: "label" }, "Link"), choose), plots, forces);

  const wanted = () => app.doc.linkage && app.motion && !app.touching &&
    (!app.dragging && (app.tab === "look" || app.tab === "mechanism") || [...app.overlays].some((o) => o !== "names" && o !== "circuits"));
  let asked = "";
  const find = latest("analyse", (a, body) => {
    app.analysis = a;
    app.analysisOf = body.frames;
    app.cognates = [];
    if (app.overlays.has("cognates")) for (const c of a.cognates || []) ask("motion", { linkage: c, points: 60, frames: body.frames }).then((m) => {
      app.cognates.push({ linkage: complete(c, ""), motion: m });
      app.redraw();
    }).catch(() => {});
    app.fireAnalysis();
    render();
    app.redraw();
  }, (error) => {
    app.analysis = null;
    plots.replaceChildren(make("p", { class: "hint" }, error instanceof Refused ? `Not for this mechanism: ${error.message}` : ""));
  });
  app.fireAnalysis = () => { for (const f of app.listeners.analysis || []) f(); };

  function analyse() {
    if (!wanted()) return;
    const key = JSON.stringify([app.doc.linkage, app.motion.frames, app.overlays.has("cognates")]);
    if (key === asked && app.analysis) return;
    asked = key;
    find({ linkage: app.doc.linkage, frames: app.motion.frames });
    if (app.tab === "look") load();
  }

  // ---- forces, when a link has a mass
  const findForces = latest("forces", (o) => {
    app.forces = o;
    renderForces();
  }, (error) => { app.forces = null; forces.replaceChildren(make("h2", {}, "Forces"), make("p", { class: "hint" }, error.message)); });
  function load() {
    const k = app.doc.linkage, heavy = k && k.links.some((l) => l.mass > 0);
    if (!heavy) {
      app.forces = null;
      forces.replaceChildren(make("h2", {}, "Forces"), make("p", { class: "hint" }, "Give the links masses under Mechanism; then the torque of the drive and the forces in the joints appear here."));
      return;
    }
    const speed = app.doc.task.rpm * Math.PI / 30, m = app.motion;
    if (!m.loops) {
      forces.replaceChildren(make("h2", {}, "Forces"), make("p", { class: "hint" }, "Shown for inputs that turn fully."));
      return;
    }
    findForces({ linkage: k, speed });
  }

  const degrees = (a) => a.map((v) => (v === null ? NaN : v * 180 / Math.PI));
  function angles() {
    const m = app.motion, slide = m.joints[m.input] && m.joints[m.input].kind === "t";
    return { slide, x: slide ? m.inputs.map((v) => v * 1000) : degrees(m.inputs) };
  }

  function render() {
    const a = app.analysis, m = app.motion;
    cursors = [];
    plots.replaceChildren();
    const k = app.doc.linkage;
    if (!k || !m) return;
    choose.replaceChildren(...linkNames(k).filter((n) => n !== groundOf(k)).map((n) => make("option", { value: n }, n)));
    if (!linkNames(k).includes(link) || link === groundOf(k)) link = k.tracers.length ? k.tracers[0].link : linkNames(k)[2] || linkNames(k)[1];
    choose.value = link;
    if (!a || app.tab !== "look") return;
    const { x, slide } = angles(), name = slide ? "input [mm]" : "input [°]", unit = app.doc.unit;
    const least = app.doc.task.transmission ?? 20;
    const add = (title, o) => {
      const svg = plot({ x: name, ...o });
      svg.addEventListener("pointerdown", (e) => scrub(svg, e));
      svg.addEventListener("pointermove", (e) => { if (e.buttons) scrub(svg, e); });
      cursors.push(svg);
      plots.append(make("h3", {}, title), svg);
    };
    const marks = (a.dead || []).map((d) => (slide ? d.input * 1000 : d.input * 180 / Math.PI)).filter((v) => v >= Math.min(...x) && v <= Math.max(...x));
    if (a.transmission.some((v) => v !== null)) add("Transmission angle", { label: "Transmission angle over the input", y: "angle [°]", y0: 0, y1: 90, least, marks, series: [{ x, y: degrees(a.transmission), colour: "var(--curve)" }] });
    const p = a.points[0];
    if (p) {
      const w = app.doc.task.rpm * Math.PI / 30, v = [], acc = [];
      for (let f = 0; f < m.frames; f++) {
        const r = p.rates.slice(4 * f, 4 * f + 4);
        v.push(r[0] === null ? NaN : Math.hypot(r[0], r[1]) * w);
        acc.push(r[2] === null ? NaN : Math.hypot(r[2], r[3]) * w * w);
      }
      add(`Speed of ${p.name} at ${app.doc.task.rpm} rpm`, { label: "Speed of the tracer", y: `speed [${unit}/s]`, y0: 0, series: [{ x, y: v, colour: "var(--speed)" }] });
      add(`Acceleration of ${p.name}`, { label: "Acceleration of the tracer", y: `[${unit}/s²]`, y0: 0, series: [{ x, y: acc, colour: "var(--force)" }] });
    }
    if (a.ranges.length > 1) plots.append(make("p", { class: "hint" }, `${new Set(a.ranges.map((r) => r.circuit)).size} circuits; the input ` +
      a.ranges.map((r) => (r.turns ? "turns fully" : `goes from ${Math.round(r.first * 180 / Math.PI)}° to ${Math.round(r.last * 180 / Math.PI)}°`)).filter((t, i, l) => l.indexOf(t) === i).join(", or ")));
    renderForces();
    follow();
  }

  function renderForces() {
    const o = app.forces;
    if (!o) return;
    const x = degrees(o.input), svg = plot({ label: "Torque of the drive", x: "input [°]", y: o.unit === "N" ? "force [N]" : "torque [N m]", series: [{ x, y: o.drive, colour: "var(--force)" }] });
    const colours = ["var(--curve)", "var(--wanted)", "var(--other)", "var(--pole)", "var(--force)", "var(--ink)"];
    const joints = o.joints.slice(0, 6), all = plot({ label: "Forces in the joints", x: "input [°]", y: "force [N]", y0: 0, series: joints.map((j, i) => ({ x, y: j.force, colour: colours[i] })) });
    const key = make("p", { class: "hint" });
    joints.forEach((j, i) => {
      const s = make("span", { class: "swatch" });
      s.style.borderTopColor = colours[i];
      key.append(s, `${j.name}  `);
    });
    svg.dataset.plot = "torque";
    forces.replaceChildren(make("h2", {}, `Drive at ${app.doc.task.rpm} rpm`), svg, make("h3", {}, "Forces in the joints"), all, key,
      number("Speed", app.doc.task.rpm, "rpm", (v) => { app.doc.task.rpm = v || 30; load(); render(); }, { min: 0.001 }));
  }

  function scrub(svg, e) {
    const { x } = angles(), at = svg.valueAt(e.clientX);
    let best = 0;
    x.forEach((v, i) => { if (Math.abs(v - at) < Math.abs(x[best] - at)) best = i; });
    app.pause();
    app.frame = best;
    app.redraw();
  }
  function follow() {
    if (!cursors.length || !app.motion) return;
    const { x } = angles(), v = x[Math.min(Math.round(app.frame), x.length - 1)];
    for (const c of cursors) if (Number.isFinite(v)) c.move(v);
  }

  // ---- on the drawing
  function arrow(layer, key, from, to, c) {
    const v = app.view, x1 = v.X(from), y1 = v.Y(from), x2 = v.X(to), y2 = v.Y(to), l = Math.hypot(x2 - x1, y2 - y1);
    if (!(l > 3)) return;
    const ux = (x2 - x1) / l, uy = (y2 - y1) / l;
    layer.put(key, "path", { class: `arrow ${c}`, d: `M${x1} ${y1}L${x2} ${y2}M${x2 - 9 * ux + 4 * uy} ${y2 - 9 * uy - 4 * ux}L${x2} ${y2}L${x2 - 9 * ux - 4 * uy} ${y2 - 9 * uy + 4 * ux}` });
  }

  on("drawn", ({ above }) => {
    above.begin();
    const a = app.analysis, m = app.motion, k = app.doc.linkage, v = app.view;
    if (a && m && k && !app.stale && !app.touching && app.analysisOf === m.frames) draw(above, a, m, k, v);
    above.end();
    follow();
  });

  function draw(above, a, m, k, v) {
    const f = Math.min(Math.round(app.frame), m.frames - 1), w = app.overlays, index = new Map(m.links.map((n, i) => [n, i]));
    const size = 0.22 * Math.min(v.width, v.height) / v.scale, places = new Map(), most = [0, 0];
    for (const p of a.points) for (let i = 0; i < p.rates.length; i += 4) {
      if (p.rates[i] === null) continue;
      most[0] = Math.max(most[0], Math.hypot(p.rates[i], p.rates[i + 1]));
      most[1] = Math.max(most[1], Math.hypot(p.rates[i + 2], p.rates[i + 3]));
    }
    for (const q of [...k.joints, ...k.tracers]) if (q.at) places.set(q.name, placed(m, f, index.get(q.links ? q.links[0] : q.link), q.at));
    for (const p of a.points) {
      const r = p.rates.slice(4 * f, 4 * f + 4), at = places.get(p.name);
      if (!at || r[0] === null) continue;
      if (w.has("velocity") && most[0]) arrow(above, `v.${p.name}`, at, [at[0] + r[0] / most[0] * size, at[1] + r[1] / most[0] * size], "v");
      if (w.has("acceleration") && most[1]) arrow(above, `a.${p.name}`, at, [at[0] + r[2] / most[1] * size, at[1] + r[3] / most[1] * size], "a");
    }
    for (const c of a.centres) {
      const ground = c.links[1] === m.ground, width = ground ? 4 : 2, at = c.at.slice(width * f, width * f + 2), key = c.links.join("-");
      if (w.has("centres") && at[0] !== null) {
        above.put(`p.${key}`, "circle", { class: "pole", cx: v.X(at).toFixed(1), cy: v.Y(at).toFixed(1), r: 4.5 });
        above.put(`pt.${key}`, "text", { x: v.X(at) + 8, y: v.Y(at) + 4 }, `${c.links[1] + 1}${c.links[0] + 1}`);
      }
      if (!ground || m.links[c.links[0]] !== link) continue;
      if (w.has("centrodes")) {
        const fixed = [], moving = [], i = c.links[0], here = m.places.slice(4 * (f * m.links.length + i), 4 * (f * m.links.length + i) + 4);
        for (let g = 0; g < m.frames; g++) {
          const q = c.at.slice(4 * g, 4 * g + 2);
          if (q[0] === null || Math.abs(q[0] - v.x) * v.scale > 4 * v.width || Math.abs(q[1] - v.y) * v.scale > 4 * v.height) { fixed.push([NaN, NaN]); moving.push([NaN, NaN]); continue; }
          fixed.push(q);
          const t = m.places.slice(4 * (g * m.links.length + i), 4 * (g * m.links.length + i) + 4), x = q[0] - t[0], y = q[1] - t[1];
          const bx = t[2] * x + t[3] * y, by = -t[3] * x + t[2] * y;
          moving.push([here[0] + here[2] * bx - here[3] * by, here[1] + here[3] * bx + here[2] * by]);
        }
        above.put("centrode", "path", { class: "centrode", d: v.line(fixed) });
        above.put("centrode.moving", "path", { class: "centrode moving", d: v.line(moving) });
      }
      if (w.has("inflection")) {
        const [px, py, qx, qy] = c.at.slice(4 * f, 4 * f + 4);
        if (px !== null) above.put("inflection", "circle", { class: "inflection", cx: v.X([(px + qx) / 2, 0]).toFixed(1), cy: v.Y([0, (py + qy) / 2]).toFixed(1), r: Math.min(Math.hypot(qx - px, qy - py) / 2 * v.scale, 1e5).toFixed(1) });
      }
    }
    if (w.has("cognates")) (app.cognates || []).forEach((c, n) => drawCognate(above, c, n, f));
    if (w.has("doubles")) (a.doubles || []).forEach((q, n) => above.put(`double.${n}`, "path", { class: "double", d: `M${v.X(q)} ${v.Y(q) - 7}l7 7l-7 7l-7 -7z` }));
    if (w.has("dead")) for (const [n, d] of (a.dead || []).entries()) {
      let best = 0;
      const turn = (x) => Math.abs(((x % (2 * Math.PI)) + 3 * Math.PI) % (2 * Math.PI) - Math.PI), slide = m.joints[m.input].kind === "t";
      m.inputs.forEach((x, i) => { if ((slide ? Math.abs(x - d.input) < Math.abs(m.inputs[best] - d.input) : turn(x - d.input) < turn(m.inputs[best] - d.input))) best = i; });
      for (const j of k.joints) if (j.at && j.links.includes(m.links[d.link]) && !j.links.includes(groundOf(k))) {
        const q = placed(m, best, d.link, j.at);
        above.put(`dead.${n}.${j.name}`, "path", { class: "dead", d: `M${v.X(q) - 6} ${v.Y(q) - 6}l12 12m0-12l-12 12` });
      }
    }
  }

  function drawCognate(layer, c, n, f) {
    const m = c.motion, v = app.view, index = new Map(m.links.map((name, i) => [name, i])), at = Math.min(f, m.frames - 1);
    for (const name of linkNames(c.linkage)) {
      if (name === groundOf(c.linkage)) continue;
      const points = [...c.linkage.joints.filter((j) => j.links.includes(name)), ...c.linkage.tracers.filter((t) => t.link === name)].map((p) => placed(m, at, index.get(name), p.at));
      layer.put(`cognate${n}.${name}`, "path", { class: "curve b", "stroke-width": 1.5, d: v.line(points, points.length > 2) });
    }
  }

  for (const event of ["motion", "tab"]) on(event, () => { analyse(); if (app.tab === "look" && app.motion) { render(); if (!app.forces) load(); } });
}
