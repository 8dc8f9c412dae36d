// The wanted path: from anchors to the points of a curve, and to stations.
import { distance } from "./mechanism.js";

// Points of the path: a smooth curve through the anchors (Catmull-Rom), or straight lines.
export function outline(path, each = 24) {
  const a = path.anchors;
  if (path.mode !== "curve" || a.length < 3) return a.map((p) => [p[0], p[1]]);
  const n = a.length, at = (i) => (path.closed ? a[(i + n) % n] : a[Math.max(0, Math.min(n - 1, i))]), out = [];
  for (let i = 0; i < (path.closed ? n : n - 1); i++) {
    const [p, q, r, s] = [at(i - 1), at(i), at(i + 1), at(i + 2)];
    // centripetal knots keep the curve from overshooting where anchors are uneven
    const t1 = Math.sqrt(distance(p, q)) || 1e-9, t2 = t1 + (Math.sqrt(distance(q, r)) || 1e-9);
    const t3 = t2 + (Math.sqrt(distance(r, s)) || 1e-9), first = p === q, last = r === s;
    for (let k = 0; k < each; k++) {
      const t = t1 + (t2 - t1) * k / each, mix = (u, v, a0, a1) => [0, 1].map((d) => u[d] + (v[d] - u[d]) * (t - a0) / (a1 - a0));
      const A1 = first ? q : mix(p, q, 0, t1), A2 = mix(q, r, t1, t2), A3 = last ? r : mix(r, s, t2, t3);
      const B1 = first ? A2 : mix(A1, A2, 0, t2), B2 = last ? A2 : mix(A2, A3, t1, t3);
      out.push(mix(B1, B2, t1, t2));
    }
  }
  if (!path.closed) out.push([a[n - 1][0], a[n - 1][1]]);
  return out;
}

export const csv = (points) => `x,y\n${points.map((p) => `${p[0]},${p[1]}`).join("\n")}\n`;

// The points of a stroke that matter: none lies farther than `reach` from the line through those that are left.
export function simplify(points, reach) {
  if (points.length < 3) return points;
  const [a, b] = [points[0], points[points.length - 1]], l = distance(a, b);
  let worst = 0, at = 0;
  for (let i = 1; i < points.length - 1; i++) {
    const p = points[i];
    const d = l < 1e-12 ? distance(p, a) : Math.abs((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])) / l;
    if (d > worst) [worst, at] = [d, i];
  }
  if (worst <= reach) return [a, b];
  return [...simplify(points.slice(0, at + 1), reach).slice(0, -1), ...simplify(points.slice(at), reach)];
}

// A zone is a box [x, y, x, y] or a polygon [[x, y], ...] without corners that point inwards.
export const zoneCorners = (z) => (Array.isArray(z[0]) ? z : [[z[0], z[1]], [z[2], z[1]], [z[2], z[3]], [z[0], z[3]]]);
export const zoneScaled = (z, f) => (Array.isArray(z[0]) ? z.map((p) => p.map((x) => x * f)) : z.map((x) => x * f));
const zoneTask = (z) => (Array.isArray(z[0]) ? { polygon: z } : { box: [[z[0], z[1]], [z[2], z[3]]] });
// A circle of a task becomes the polygon round it.
export const zoneOf = (z) => (z.polygon ? z.polygon : z.box ? z.box.flat() : z.circle ? Array.from({ length: 16 }, (_, i) => {
  const [[x, y], r] = z.circle, a = (2 * i + 1) * Math.PI / 16;
  return [x + r / Math.cos(Math.PI / 16) * Math.cos(a), y + r / Math.cos(Math.PI / 16) * Math.sin(a)];
}) : null);

// The polygon without inward corners round all points, with 16 corners at most (of the hull those that matter least go).
export function hull(points) {
  const cross = (a, b, c) => (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]), half = (list) => {
    const out = [];
    for (const p of list) {
      while (out.length > 1 && cross(out[out.length - 2], out[out.length - 1], p) <= 0) out.pop();
      out.push(p);
    }
    return out.slice(0, -1);
  };
  const all = [...half(sorted), ...half(sorted.reverse())], n = () => all.length;
  while (n() > 16) {
    const lost = all.map((p, i) => cross(all[(i + n() - 1) % n()], p, all[(i + 1) % n()]));
    all.splice(lost.indexOf(Math.min(...lost)), 1);
  }
  return all;
}

// The task file (docs/notation.md, "Task") of a document with stations, and the options beside it.
export function taskOf(doc, stations, without) {
  const t = without ? { ...doc.task, ...without } : doc.task, task = { "linkwright-task": 1, units: { length: doc.unit, angle: "deg" } };
  task.closed = doc.path.closed;
  task.stations = stations.map((p) => ({ x: p[0], y: p[1], ...(Number.isFinite(p[2]) ? { theta: p[2] } : {}),
    ...(Number.isFinite(p[3]) ? { angle: p[3] } : {}) }));
  task.links = t.links;
  if (t.turn === "full" || t.turn === "crank") task.crank = true;
  if (t.timing !== "auto") task.timing = t.timing;
  if (t.transmission !== null) task.transmission = t.transmission;
  const lengths = {};
  for (const key of ["least", "most", "ratio"]) if (t[key] !== null) lengths[key] = t[key];
  if (Object.keys(lengths).length) task.lengths = lengths;
  if (t.pivots) task.pivots = zoneTask(t.pivots);
  if (t.forbidden.length) task.forbidden = t.forbidden.map(zoneTask);
  if (t.acceleration !== null) task.acceleration = t.acceleration / (t.rpm * Math.PI / 30) ** 2;
  return task;
}

export function optionsOf(doc, without) {
  const t = without ? { ...doc.task, ...without } : doc.task, o = {};
  if (t.types !== "fourbar") o.types = t.types;
  if (t.turn === "crank") o.crank_only = true;
  if (t.turn === "rock") o.through_limits = true;
  if (t.maxSize !== null) o.max_size = t.maxSize;
  if (t.seed !== 1) o.seed = t.seed;
  if (t.results !== 10) o.results = t.results;
  if (t.rounds) o.rounds = t.rounds;
  return o;
}
