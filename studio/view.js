// The drawing area: which part of the plane it shows, elements by key, and how a mechanism looks.
import { linkNames, groundOf, inputOf, pointsOf, distance } from "./mechanism.js";

const NS = "http://www.w3.org/2000/svg";

// Elements by key: `put` makes or changes one, `end` takes away those that were not put since `begin`.
export class Layer {
  constructor(parent, name) {
    this.g = document.createElementNS(NS, "g");
    this.g.setAttribute("class", name);
    parent.append(this.g);
    this.all = new Map();
  }
  begin() { this.seen = new Set(); this.last = null; }
  put(key, tag, attributes, text) {
    let e = this.all.get(key);
    if (!e) {
      e = document.createElementNS(NS, tag);
      e.dataset.key = key;
      e.had = {};
      this.all.set(key, e);
      this.g.append(e);
    }
    for (const [name, value] of Object.entries(attributes)) {
      if (e.had[name] === value) continue;
      e.had[name] = value;
      if (value === undefined) e.removeAttribute(name); else e.setAttribute(name, value);
    }
    if (text !== undefined && e.textContent !== text) e.textContent = text;
    this.seen.add(key);
    return e;
  }
  end() {
    for (const [key, e] of this.all) {
      if (this.seen.has(key)) continue;
      e.remove();
      this.all.delete(key);
    }
  }
}

// Which part of the plane is shown.  x to the right, y up, in the unit of the document.
export class View {
  constructor(width, height) { Object.assign(this, { width, height, x: 0, y: 0, scale: 3 }); }
  X(p) { return this.width / 2 + (p[0] - this.x) * this.scale; }
  Y(p) { return this.height / 2 - (p[1] - this.y) * this.scale; }
  at(px, py) { return [this.x + (px - this.width / 2) / this.scale, this.y - (py - this.height / 2) / this.scale]; }
  zoom(factor, px, py) {
    const before = this.at(px, py);
    this.scale = Math.min(Math.max(this.scale * factor, 1e-7), 1e9);
    const after = this.at(px, py);
    this.x += before[0] - after[0];
    this.y += before[1] - after[1];
  }
  // Show points with a margin, in pixels, on each side: left, top, right, bottom.
  show(points, margin = [40, 40, 60, 90]) {
    const good = points.filter((p) => Number.isFinite(p[0]) && Number.isFinite(p[1]));
    if (!good.length) return;
    const low = [0, 1].map((d) => Math.min(...good.map((p) => p[d])));
    const high = [0, 1].map((d) => Math.max(...good.map((p) => p[d])));
    const [l, t, r, b] = this.width < 300 ? [6, 6, 6, 6] : margin;
    const w = Math.max(this.width - l - r, 20), h = Math.max(this.height - t - b, 20);
    const span = Math.max((high[0] - low[0]) / w, (high[1] - low[1]) / h);
    this.scale = span > 0 ? Math.min(1 / span, 1e9) : this.scale;
    this.x = (low[0] + high[0]) / 2 + (r - l) / 2 / this.scale;
    this.y = (low[1] + high[1]) / 2 - (b - t) / 2 / this.scale;
  }
  // Distance of grid lines, 1, 2 or 5 times a power of ten, at least 22 pixels.
  step() {
    const least = 22 / this.scale, power = 10 ** Math.floor(Math.log10(least));
    return [1, 2, 5, 10].map((f) => f * power).find((s) => s >= least * 0.999);
  }
  line(points, closed) {
    let d = "", pen = false;
    for (const p of points) {
      if (!Number.isFinite(p[0]) || !Number.isFinite(p[1])) { pen = false; continue; }
      d += `${pen ? "L" : "M"}${this.X(p).toFixed(1)} ${this.Y(p).toFixed(1)}`;
      pen = true;
    }
    return closed && d ? d + "Z" : d;
  }
  curve(c) {
    let d = "", pen = false;
    for (let i = 0; i < c.x.length; i++) {
      if (c.x[i] === null || c.y[i] === null) { pen = false; continue; }
      d += `${pen ? "L" : "M"}${(this.width / 2 + (c.x[i] - this.x) * this.scale).toFixed(1)} ` +
        `${(this.height / 2 - (c.y[i] - this.y) * this.scale).toFixed(1)}`;
      pen = true;
    }
    return c.closed && pen ? d + "Z" : d;
  }
}

function hull(points) {
  const p = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const side = (a, b, c) => (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  const half = (list) => {
    const out = [];
    for (const q of list) {
      while (out.length > 1 && side(out[out.length - 2], out[out.length - 1], q) <= 0) out.pop();
      out.push(q);
    }
    return out.slice(0, -1);
  };
  return p.length < 3 ? p : [...half(p), ...half(p.reverse())];
}

// The two ends of points that lie on one line, or nearly; null if they span an area.
function thinnest(points) {
  if (points.length < 3) return points.slice();
  let ends = [points[0], points[0]];
  for (const p of points) for (const q of points) if (distance(p, q) > distance(...ends)) ends = [p, q];
  const [a, b] = ends, l = distance(a, b) || 1;
  const width = Math.max(...points.map((p) => Math.abs((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])) / l));
  return width < 2.5 ? ends : null;
}

// The symbol of a ground pin: a triangle on a hatched line.
function groundPin(layer, key, x, y) {
  layer.put(`${key}.tri`, "path", { class: "ground fill", d: `M${x} ${y}l-9 15h18z` });
  layer.put(`${key}.hatch`, "path", { class: "ground", d: `M${x - 13} ${y + 15}h26m-23 0l-4 5m11-5l-4 5m11-5l-4 5m11-5l-4 5`,
    "stroke-width": 1.2 });
}

// Outlines that can touch others, ropes and springs; `where` takes a point and its link.
function drawParts(layer, view, k, where) {
  const P = (p, link) => { const q = where(p, link); return [view.X(q), view.Y(q)]; };
  const path = (points, closed) => points.map((p, i) => `${i ? "L" : "M"}${p[0].toFixed(1)} ${p[1].toFixed(1)}`).join("") + (closed ? "Z" : "");
  for (const link of k.links) for (const [i, s] of (link.shapes || []).entries()) {
    const key = `shape.${link.name}.${i}`, r = (s.radius || 0) * view.scale;
    if (s.circle) {
      const [cx, cy] = P(s.circle, link.name);
      layer.put(key, "circle", { class: "outline", cx: cx.toFixed(1), cy: cy.toFixed(1), r: r.toFixed(1) });
      continue;
    }
    let points = (s.line || s.segment || s.polygon || []).map((p) => P(p, link.name));
    if (s.line) {                                       // without ends
      const [a, b] = points, f = 1e4 / (Math.hypot(b[0] - a[0], b[1] - a[1]) || 1), by = [f * (b[0] - a[0]), f * (b[1] - a[1])];
      points = [[a[0] - by[0], a[1] - by[1]], [b[0] + by[0], b[1] + by[1]]];
    }
    layer.put(key, "path", { class: `outline${s.polygon ? "" : " open"}`, d: path(points, s.polygon), "stroke-width": s.segment ? Math.max(2 * r, 1.5) : undefined });
  }
  const tie = (key, f, spring) => {
    if (!Array.isArray(f.at) || !f.links) return;
    const [a, b] = f.at.map((p, i) => P(p, f.links[i])), long = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1, points = [a], n = 9;
    for (let i = 0; i <= n && spring; i++) {
      const u = 0.2 + 0.6 * i / n, w = (i === 0 || i === n ? 0 : i % 2 ? 7 : -7) / long;
      points.push([a[0] + u * (b[0] - a[0]) - w * (b[1] - a[1]), a[1] + u * (b[1] - a[1]) + w * (b[0] - a[0])]);
    }
    layer.put(key, "path", { class: "tie", d: path([...points, b]) });
  };
  const jack = (key, f) => {                              // a hydraulic cylinder: its rod, and over it the tube
    if (!Array.isArray(f.at) || !f.links) return;
    const [a, b] = f.at.map((p, i) => P(p, f.links[i])), long = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
    const u = Math.min(0.95 * (f.retracted || 0) * view.scale / long, 1), w = 8 / long, x = b[0] - a[0], y = b[1] - a[1];
    const at = (along, aside) => [a[0] + along * x - aside * y, a[1] + along * y + aside * x];
    layer.put(key, "path", { class: "tie", d: path([at(0, w), at(u, w), at(u, -w), at(0, -w), at(0, w)]) });
    layer.put(`${key}.rod`, "path", { class: "tie", "stroke-width": 4, d: path([at(Math.max(1 - u, 0), 0), b]) });
  };
  (k.cylinders || []).forEach((f, i) => jack(`cylinder.${i}`, f));
  (k.ropes || []).forEach((f, i) => tie(`rope.${i}`, f));
  (k.springs || []).forEach((f, i) => tie(`spring.${i}`, f, true));
}

// Draw a linkage with its points where `where(point, link)` says.  o: key prefix, little (no symbols' names), picked.
export function drawMechanism(layer, view, k, where, turn, o = {}) {
  const key = o.key || "", ground = groundOf(k), input = inputOf(k);
  const P = (p, link) => { const q = where(p.at, link); return [view.X(q), view.Y(q)]; };
  const drive = input && k.joints.find((j) => j.name === input.joint);
  if (!o.little) drawParts(layer, view, k, where);
  for (const link of linkNames(k)) {
    if (link === ground) continue;
    const all = pointsOf(k, link).map((p) => P(p, link)), points = hull(all);
    const far = thinnest(points), bar = far !== null;
    if (bar) points.splice(0, points.length, ...far);
    const d = points.map((p, i) => `${i ? "L" : "M"}${p[0].toFixed(1)} ${p[1].toFixed(1)}`).join("") + (bar ? "" : "Z");
    layer.put(`${key}link.${link}`, "path", { d, class: `link${bar ? " bar" : ""}${drive && drive.links.includes(link) ? " input" : ""}` +
      `${o.picked && o.picked.link === link ? " picked" : ""}${o.ghost ? " ghost" : ""}`, "stroke-width": o.little ? (bar ? 4 : 1.5) : undefined });
  }
  for (const j of k.joints) {
    const id = `${key}joint.${j.name}`, fixed = j.links.includes(ground);
    if (j.kind === "n") continue;
    if (j.kind === "g") {
      if (!o.little) drawGear(layer, view, k, j, where, id);
      continue;
    }
    const [x, y] = P(j, j.kind === "p" ? j.links[1] : j.links[0]).map((v) => +v.toFixed(1));
    if (j.kind === "t" || j.kind === "p") {
      const along = j.along || [1, 0], [c, s] = turn(j.links[0]);
      const angle = Math.atan2(s * along[0] + c * along[1], c * along[0] - s * along[1]);
      const far = o.little ? 14 : 60, ux = Math.cos(angle) * far, uy = -Math.sin(angle) * far;
      layer.put(`${id}.slot`, "path", { class: "slot", d: `M${x - ux} ${y - uy}L${x + ux} ${y + uy}` });
      if (j.kind === "t")
        layer.put(`${id}.block`, "rect", { class: "slider", x: o.little ? -5 : -13, y: o.little ? -3 : -8, width: o.little ? 10 : 26,
          height: o.little ? 6 : 16, rx: 2, transform: `translate(${x} ${y}) rotate(${(-angle * 180 / Math.PI).toFixed(2)})` });
    } else if (fixed && j.kind === "r" && !o.little) groundPin(layer, id, x, y);
    layer.put(id, "circle", { cx: x, cy: y, r: o.little ? 2.5 : 6.5, "stroke-width": o.little ? 1 : undefined,
      class: `joint${fixed && j.kind === "r" ? " fixed" : ""}${j === drive ? " drive" : ""}` +
        `${o.picked && o.picked.point && o.picked.point.name === j.name ? " picked" : ""}` });
    if (!o.little && o.names) layer.put(`${id}.name`, "text", { class: "name", x: x + 10, y: y - 9 }, j.name);
  }
  for (const t of k.tracers || []) {
    const [x, y] = P(t, t.link);
    layer.put(`${key}tracer.${t.name}`, "circle", { cx: x.toFixed(1), cy: y.toFixed(1), r: o.little ? 2.5 : 6,
      "stroke-width": o.little ? 0 : undefined,
      class: `tracer${o.picked && o.picked.point && o.picked.point.name === t.name ? " picked" : ""}` });
    if (!o.little && o.names) layer.put(`${key}tracer.${t.name}.name`, "text", { class: "name", x: x + 10, y: y - 9 }, t.name);
  }
}

// Both wheels of a gear pair, about pins that their links share with one carrier.
function drawGear(layer, view, k, j, where, id) {
  const pin = (link, other) => k.joints.find((q) => q.kind === "r" && q.links.includes(link) &&
    k.joints.some((r) => r.kind === "r" && r !== q && r.links.includes(other) &&
      r.links.some((l) => q.links.includes(l) && l !== link && l !== other)));
  const a = pin(j.links[0], j.links[1]), b = pin(j.links[1], j.links[0]);
  if (!a || !b) return;
  const p = where(a.at, j.links[0]), q = where(b.at, j.links[1]), d = distance(p, q), ratio = Math.abs(j.ratio || 1);
  const part = j.ratio < 0 ? ratio / (1 + ratio) : Math.abs(ratio / (1 - ratio) || 1);
  layer.put(`${id}.a`, "circle", { class: "wheel", cx: view.X(p), cy: view.Y(p), r: (d * part * view.scale).toFixed(1) });
  layer.put(`${id}.b`, "circle", { class: "wheel", cx: view.X(q), cy: view.Y(q), r: (d * (part / ratio) * view.scale).toFixed(1) });
}

// A small moving picture of a linkage: on a card, beside a drawing.
export class Little {
  constructor(width, height, wanted) {
    this.svg = document.createElementNS(NS, "svg");
    this.svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.svg.setAttribute("aria-hidden", "true");
    this.view = new View(width, height);
    this.layer = new Layer(this.svg, "little-mechanism");
    this.wanted = wanted;
  }
  set(k, motion) {
    this.k = k;
    this.motion = motion;
    const points = this.wanted ? [...this.wanted] : [];
    for (const c of motion.curves) for (let i = 0; i < c.x.length; i += 7) points.push([c.x[i], c.y[i]]);
    for (const j of k.joints) if (j.at) points.push(j.at);
    this.view.show(points, [8, 8, 8, 8]);
    this.show(motion.first);
  }
  show(frame, placed, turned) {
    if (!this.motion) return;
    const { layer, view, motion, k } = this, index = new Map(motion.links.map((n, i) => [n, i]));
    layer.begin();
    if (this.wanted) layer.put("wanted", "path", { class: "wanted", d: view.line(this.wanted, this.closed), "stroke-width": 1.2 });
    motion.curves.forEach((c, i) => c.shown && layer.put(`curve${i}`, "path", { class: "curve", d: view.curve(c), "stroke-width": 1.4 }));
    if (placed)
      drawMechanism(layer, view, k, (p, link) => placed(motion, frame, index.get(link), p),
        (link) => turned(motion, frame, index.get(link)), { little: true });
    layer.end();
  }
}

// The step of an axis that is at least `least`: 1, 2 or 5 times a power of ten; of degrees a part of a turn.
function evenStep(least, degrees) {
  const power = 10 ** Math.floor(Math.log10(least)), steps = degrees && least > 10 ? [15, 30, 45, 90, 180, 360, 720] : [1, 2, 5, 10].map((k) => k * power);
  return steps.find((k) => k >= 0.99 * least) ?? least;
}

// A plot as SVG: series { name, x, y, class, style }, the place of a cursor, names of the axes with units.
export function plot(o) {
  const w = o.width || 330, h = o.height || 150, left = 64, right = 10, top = 10, bottom = 34;
  const svg = document.createElementNS(NS, "svg"), put = (tag, a, text) => {
    const e = document.createElementNS(NS, tag);
    for (const [n, v] of Object.entries(a)) e.setAttribute(n, v);
    if (text !== undefined) e.textContent = text;
    svg.append(e);
    return e;
  };
  svg.setAttribute("viewBox", `0 0 ${w} ${h}`);
  svg.setAttribute("class", "plot");
  svg.setAttribute("role", "img");
  svg.setAttribute("aria-label", o.label);
  const xs = o.series.flatMap((s) => s.x).filter(Number.isFinite), f = o.log ? (v) => Math.log10(Math.max(v, 1e-12)) : (v) => v;
  const ys = o.series.flatMap((s) => s.y).filter((v) => Number.isFinite(v)).map(f);
  if (!xs.length || !ys.length) return svg;
  let [x0, x1] = [Math.min(...xs), Math.max(...xs)], [y0, y1] = [Math.min(...ys), Math.max(...ys)];
  if (o.y0 !== undefined) y0 = Math.min(y0, o.y0);
  if (o.y1 !== undefined) y1 = Math.max(y1, o.y1);
  if (x1 === x0) x1 = x0 + 1;
  if (y1 - y0 < 1e-9 * Math.abs(y1) || y1 === y0) { y0 -= 0.5; y1 += 0.5; }
  const X = (v) => left + (v - x0) / (x1 - x0) * (w - left - right), Y = (v) => h - bottom - (f(v) - y0) / (y1 - y0) * (h - top - bottom);
  const tick = (v) => +(o.log ? 10 ** v : v).toPrecision(3);
  for (let i = 0; i <= 2; i++) {
    const v = y0 + (y1 - y0) * i / 2, y = h - bottom - (h - top - bottom) * i / 2;
    put("line", { class: "axis", x1: left, x2: w - right, y1: y, y2: y });
    put("text", { x: left - 5, y: y + 4, "text-anchor": "end" }, tick(v));
  }
  const step = evenStep((x1 - x0) / 4, o.x.includes("°"));
  for (let i = Math.ceil(x0 / step - 1e-9); i * step <= x1 + 1e-9 * step; i++)
    put("text", { x: X(i * step), y: h - bottom + 14, "text-anchor": "middle" }, +(i * step).toPrecision(6));
  put("text", { x: (left + w - right) / 2, y: h - 4, "text-anchor": "middle" }, o.x);
  put("text", { x: 0, y: 0, transform: `translate(10 ${(h - bottom + top) / 2}) rotate(-90)`, "text-anchor": "middle" }, o.y);
  for (const s of o.series) {
    let d = "", pen = false;
    s.x.forEach((v, i) => {
      if (!Number.isFinite(s.y[i])) { pen = false; return; }
      d += `${pen ? "L" : "M"}${X(v).toFixed(1)} ${Y(s.y[i]).toFixed(1)}`;
      pen = true;
    });
    put("path", { d, stroke: s.colour, "stroke-dasharray": s.dash || "none" });
  }
  for (const m of o.marks || []) put("line", { x1: X(m), x2: X(m), y1: top, y2: h - bottom, stroke: "var(--bad)", "stroke-dasharray": "2 3" });
  if (o.least !== undefined) put("line", { x1: left, x2: w - right, y1: Y(o.least), y2: Y(o.least), stroke: "var(--bad)", "stroke-dasharray": "5 4" });
  svg.cursor = put("line", { x1: 0, x2: 0, y1: top, y2: h - bottom, stroke: "var(--ink)", opacity: 0 });
  svg.move = (v) => { const x = X(v); svg.cursor.setAttribute("opacity", 0.5); svg.cursor.setAttribute("x1", x); svg.cursor.setAttribute("x2", x); };
  svg.valueAt = (px) => { const b = svg.getBoundingClientRect(); return x0 + ((px - b.left) / b.width * w - left) / (w - left - right) * (x1 - x0); };
  return svg;
}
