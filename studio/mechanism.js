// Linkages as docs/notation.md writes them, in the unit of the document: nothing here draws or asks.  Links are objects
// with a name, joints and tracers have their places in one posture.
export const clone = (o) => JSON.parse(JSON.stringify(o));
export const distance = (p, q) => Math.hypot(p[0] - q[0], p[1] - q[1]);
const nameOf = (link) => (typeof link === "string" ? link : link.name);

// What the server wrote, with what it does not know: masses, springs, ... of the text it read.
export function complete(written, text) {
  const k = clone(written);
  let old = null;
  try { old = JSON.parse(text); } catch (error) { /* another format */ }
  if (old && old.results) old = null;
  k.links = k.links.map((l) => ({ name: nameOf(l) }));
  if (!old) return k;
  for (const l of old.links || []) {
    const mine = k.links.find((m) => m.name === nameOf(l));
    if (mine && typeof l === "object") Object.assign(mine, l);
  }
  for (const key of ["gravity", "springs", "dampers", "forces", "motors", "ropes", "contacts"]) if (old[key]) k[key] = old[key];
  for (const j of old.joints || []) {
    const mine = k.joints.find((m) => m.name === j.name);
    for (const key of ["friction", "stop", "clearance"]) if (mine && j[key]) mine[key] = j[key];
  }
  return k;
}

export function inputOf(k) { return k.input || (k.inputs && k.inputs[0]) || null; }
export function groundOf(k) { return k.ground || "ground"; }
export const linkNames = (k) => k.links.map(nameOf);
export const onLink = (k, link) => k.joints.filter((j) => j.kind !== "g" && j.kind !== "n" && j.links.includes(link));

// Points of a link that are drawn: its joints and tracers, each place once.
export function pointsOf(k, link) {
  const points = [];
  for (const p of [...onLink(k, link), ...(k.tracers || []).filter((t) => t.link === link)])
    if (p.at && !points.some((q) => distance(q.at, p.at) < 1e-9)) points.push(p);
  return points;
}

// All joints and tracers at the place of one of them move together.
export function alike(k, at) {
  const size = Math.max(1e-12, ...k.joints.filter((j) => j.at).map((j) => Math.hypot(...j.at)));
  return [...k.joints, ...(k.tracers || [])].filter((p) => p.at && distance(p.at, at) <= 1e-7 * size);
}

export function lengths(k, link) {
  const p = pointsOf(k, link), all = [];
  for (let i = 0; i < p.length; i++)
    for (let j = i + 1; j < p.length; j++) all.push({ from: p[i], to: p[j], length: distance(p[i].at, p[j].at) });
  return all;
}

// A mechanism as it stands in a frame of its motion becomes its own posture.
export function rebase(k, motion, frame) {
  const out = clone(k), index = new Map(motion.links.map((n, i) => [n, i]));
  const move = (p, link) => placed(motion, frame, index.get(link), p);
  const turn = (link) => turned(motion, frame, index.get(link));
  for (const j of out.joints) {
    const [a, b] = j.links;
    const [c, s] = turn(a);
    if (j.at) j.at = move(j.at, j.kind === "p" ? b : a);
    if (j.along) j.along = [c * j.along[0] - s * j.along[1], s * j.along[0] + c * j.along[1]];
    if (j.angle !== undefined) j.angle += Math.atan2(s, c) * 180 / Math.PI;
  }
  for (const t of out.tracers || []) {
    const [c, s] = turn(t.link);
    t.at = move(t.at, t.link);
    if (t.angle) t.angle += Math.atan2(s, c) * 180 / Math.PI;
  }
  for (const l of out.links) if (l.centre) l.centre = move(l.centre, l.name);
  for (const l of out.links) for (const s of l.shapes || []) for (const key of ["line", "segment", "polygon"])
    if (s[key]) s[key] = s[key].map((p) => move(p, l.name));
  for (const l of out.links) for (const s of l.shapes || []) if (s.circle) s.circle = move(s.circle, l.name);
  for (const f of [...(out.springs || []), ...(out.dampers || []), ...(out.ropes || [])])
    if (Array.isArray(f.at) && f.links) f.at = f.at.map((p, i) => move(p, f.links[i]));
  for (const f of out.forces || []) if (f.at) f.at = move(f.at, f.link);
  const input = inputOf(out);
  if (input) delete input.value;
  return out;
}

export function placed(motion, frame, link, p) {
  const at = pose(motion, frame, link), o = motion.origins;
  const x = p[0] - o[2 * link], y = p[1] - o[2 * link + 1];
  return [at[0] + at[2] * x - at[3] * y, at[1] + at[3] * x + at[2] * y];
}

export function turned(motion, frame, link) { return pose(motion, frame, link).slice(2); }

// x, y, cos, sin of a link; frames between two are interpolated.
function pose(motion, frame, link) {
  const n = motion.frames, f = Math.floor(frame), part = frame - f;
  const i = 4 * (Math.min(f, n - 1) * motion.links.length + link);
  const g = f + 1 < n ? f + 1 : motion.loops ? 0 : n - 1;
  const j = 4 * (g * motion.links.length + link), v = motion.places;
  if (part === 0) return v.slice(i, i + 4);
  const out = [0, 1, 2, 3].map((d) => v[i + d] + part * (v[j + d] - v[i + d]));
  const r = Math.hypot(out[2], out[3]) || 1;
  return [out[0], out[1], out[2] / r, out[3] / r];
}

// Move the joints and tracers at one place.  Lengths of locked links stay: points are put back on them in turn until
// they fit; pivots at the ground stand still unless they are dragged themselves.
export function drag(k, from, to, locked) {
  const moved = alike(k, from);
  for (const p of moved) p.at = [...to];
  if (!locked.length) return;
  const ground = groundOf(k), nodes = [], rods = [];
  const node = (p) => {
    let n = nodes.find((q) => q.items.includes(p));
    if (n) return n;
    const at = before.get(p), items = [...before.keys()].filter((q) => distance(before.get(q), at) < 1e-9);
    const held = items.includes(moved[0]) ? false : items.some((q) => q.links && q.links.includes(ground) && q.kind !== "p");
    n = { items, at: [...at], held, pulled: items.includes(moved[0]) };
    nodes.push(n);
    return n;
  };
  const before = new Map([...k.joints, ...(k.tracers || [])].filter((p) => p.at)
    .map((p) => [p, moved.includes(p) ? from : [...p.at]]));
  for (const link of locked) {
    const p = [...before.keys()].filter((q) => (q.links ? q.links.includes(link) && q.kind !== "g" : q.link === link));
    for (let i = 0; i < p.length; i++)
      for (let j = i + 1; j < p.length; j++) {
        const a = node(p[i]), b = node(p[j]);
        if (a !== b) rods.push({ a, b, length: distance(before.get(p[i]), before.get(p[j])) });
      }
  }
  const pulled = nodes.find((n) => n.pulled);
  if (!pulled) return;
  if (pulled.items.some((q) => q.links && q.links.includes(ground))) pulled.held = true;
  for (let round = 0; round < 900; round++) {
    if (round < 80 || pulled.held) pulled.at = [...to];
    let worst = 0;
    for (const { a, b, length } of rods) {
      const d = distance(a.at, b.at) || 1e-12, off = (d - length) / d, weight = (a.held ? 0 : 1) + (b.held ? 0 : 1);
      worst = Math.max(worst, Math.abs(d - length) / (length || 1));
      if (!weight) continue;
      for (let c = 0; c < 2; c++) {
        const way = (b.at[c] - a.at[c]) * off / weight;
        if (!a.held) a.at[c] += way;
        if (!b.held) b.at[c] -= way;
      }
    }
    if (round >= 80 && worst < 1e-13) break;
  }
  for (const n of nodes) for (const p of n.items) p.at = [...n.at];
}

// ---- building ------------------------------------------------------------------------------------------------------

function unused(names, word) {
  for (let i = 1; ; i++) if (!names.includes(word + i)) return word + i;
}
const letters = (k) => {
  const names = [...k.joints.map((j) => j.name), ...(k.tracers || []).map((t) => t.name)];
  for (let i = 0; ; i++) {
    const name = String.fromCharCode(65 + (i % 26)) + (i < 26 ? "" : Math.floor(i / 26));
    if (!names.includes(name)) return name;
  }
};

export function empty(unit) {
  return { linkwright: 1, name: "", units: { length: unit, angle: "deg" }, links: [{ name: "ground" }], ground: "ground",
    joints: [], tracers: [] };
}

// What stands at a place: a joint, a tracer, a link, or nothing.
export function hit(k, at, reach) {
  let best = null;
  for (const p of [...k.joints, ...(k.tracers || [])]) {
    if (!p.at) continue;
    const d = distance(p.at, at);
    if (d < reach && (!best || d < best.d - 1e-12)) best = { d, point: p };
  }
  if (best) return best;
  for (const link of linkNames(k)) {
    if (link === groundOf(k)) continue;
    for (const { from, to } of lengths(k, link)) {
      const ux = to.at[0] - from.at[0], uy = to.at[1] - from.at[1], l2 = ux * ux + uy * uy || 1;
      const t = Math.max(0, Math.min(1, ((at[0] - from.at[0]) * ux + (at[1] - from.at[1]) * uy) / l2));
      const d = distance(at, [from.at[0] + t * ux, from.at[1] + t * uy]);
      if (d < reach && (!best || d < best.d)) best = { d, link };
    }
  }
  return best;
}

// Join a link to what stands at a place; a free end becomes a tracer, which another link can be pinned to.
function attach(k, link, at, what) {
  const other = what && (what.link || (what.point.links ? what.point.links.find((l) => l !== link) : what.point.link));
  if (other === undefined || other === null || other === link) {
    k.tracers.push({ name: letters(k), link, at: [...at] });
    return;
  }
  const place = what.point ? what.point.at : at;
  if (what.point && !what.point.links) k.tracers = k.tracers.filter((t) => t !== what.point);
  k.joints.push({ name: letters(k), kind: "r", links: [other, link], at: [...place] });
}

export function addLink(k, from, to, reach) {
  const a = hit(k, from, reach), b = hit(k, to, reach);
  const link = unused(linkNames(k), "link");
  k.links.push({ name: link });
  attach(k, link, a && a.point ? a.point.at : from, a);
  attach(k, link, b && b.point ? b.point.at : to, b);
  return link;
}

// The point stands on the ground from now on; the first such pin of a link without an input drives it.
export function addGround(k, at, reach, slide) {
  const what = hit(k, at, reach), ground = groundOf(k);
  if (!what) return "Place a ground pin on a joint, a free end or a link.";
  const link = what.link || (what.point.links ? what.point.links.find((l) => l !== ground) : what.point.link);
  const place = what.point ? what.point.at : at;
  if (alike(k, place).some((p) => p.links && p.links.includes(ground))) return "This point is at the ground already.";
  if (what.point && !what.point.links) k.tracers = k.tracers.filter((t) => t !== what.point);
  const joint = { name: letters(k), kind: slide ? "p" : "r", links: [ground, link], at: [...place] };
  if (slide) joint.along = slide;
  k.joints.push(joint);
  if (!inputOf(k) && !slide) k.input = { joint: joint.name };
  return "";
}

export function addTracer(k, at, reach) {
  const what = hit(k, at, reach);
  const link = what && (what.link || (what.point.links ? what.point.links[1] : what.point.link));
  if (!link) return "Place a tracer on a link; drag it away afterwards if it stands off.";
  k.tracers.push({ name: letters(k), link, at: [...(what.point ? what.point.at : at)] });
  return "";
}

export function addGear(k, from, to, reach) {
  const a = hit(k, from, reach), b = hit(k, to, reach), ground = groundOf(k);
  const link = (w) => w && (w.link || (w.point.links ? w.point.links.find((l) => l !== ground) : w.point.link));
  const u = link(a), v = link(b);
  if (!u || !v || u === v) return "Draw a gear pair from one link to another; both turn on pins of one link.";
  if (k.joints.some((j) => j.links.includes(u) && j.links.includes(v))) return "These two links share a joint already.";
  k.joints.push({ name: letters(k), kind: "g", links: [u, v], ratio: -1 });
  return "";
}

// Take away a joint, a tracer or a link with all that hangs on it.
export function remove(k, what) {
  if (what.link) {
    k.links = k.links.filter((l) => nameOf(l) !== what.link);
    k.joints = k.joints.filter((j) => !j.links.includes(what.link));
    k.tracers = k.tracers.filter((t) => t.link !== what.link);
  } else {
    const gone = alike(k, what.point.at);
    for (const p of gone)
      if (p.links)
        for (const l of p.links)
          if (l !== groundOf(k) && !k.tracers.some((t) => t.link === l && distance(t.at, p.at) < 1e-9))
            k.tracers.push({ name: letters(k), link: l, at: [...p.at] });
    k.joints = k.joints.filter((j) => !gone.includes(j));
    k.tracers = k.tracers.filter((t) => !gone.includes(t));
  }
  const input = inputOf(k);
  if (input && !k.joints.some((j) => j.name === input.joint)) {
    delete k.input;
    delete k.inputs;
  }
}
