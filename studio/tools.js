// What the pointer does on the drawing.  A tool has down, move and up with the place in the plane; `hit` is what was
// touched.
import { app, begin, change, changed } from "./state.js";
import { alike, clone, distance, drag, rebase, addLink, addGround, addTracer, addGear, empty, hit, remove } from "./mechanism.js";
import { hull, simplify, zoneCorners } from "./path.js";

const icon = (d) => `<svg viewBox="0 0 24 24" aria-hidden="true"><path d="${d}"/></svg>`;

// The plane under the pointer: snapped to points that are there, then to crossings of the grid; else in steps of a pixel.
export function snapped(p, without, moving) {
  const v = app.view, reach = 9 / v.scale;
  const points = [...app.doc.path.anchors.filter((a) => a !== without),
    ...(app.doc.linkage && app.posed ? [...app.doc.linkage.joints, ...app.doc.linkage.tracers].filter((q) => q.at && !(moving && moving(q)))
      .map((q) => app.posed(q)) : [])];
  for (const q of points) if (app.snap && distance(p, q) < reach) return [q[0], q[1]];
  if (!app.snap) return p;
  const s = v.step(), on = (step) => p.map((x) => +(Math.round(x / step) * step).toPrecision(12)), crossing = on(s);
  return distance(p, crossing) * v.scale < 6 ? crossing : on(s / 20);
}

// ---- the path

function addAnchor(mode, p) {
  const path = app.doc.path, first = path.anchors[0];
  if (path.closed) {
    app.say("The path is closed. Clear it to draw another one, or move its points.");
    return;
  }
  if (first && path.anchors.length > 2 && distance(p, first) < 12 / app.view.scale) {
    change("path", (d) => { d.path.closed = true; });
    app.say("Path closed");
    return;
  }
  const last = path.anchors[path.anchors.length - 1];
  if (last && distance(last, p) < 3 / app.view.scale) return;
  change("path", (d) => { d.path.mode = mode; d.path.anchors.push(p); });
}

const drawing = (mode, name, key, d, title) => ({
  name, key, icon: icon(d), title, group: "Draw", cursor: "crosshair",
  down(p, event) {
    const a = event.target.closest("[data-anchor]");
    const path = app.doc.path;
    if (a && !(Number(a.dataset.anchor) === 0 && !path.closed && path.anchors.length > 2)) {
      this.moving = Number(a.dataset.anchor);
      begin();
      return;
    }
    this.from = p;
    this.stroke = [p];
  },
  move(p) {
    if (this.moving !== undefined && this.moving !== null) {
      const a = app.doc.path.anchors[this.moving];
      const q = snapped(p, a);
      a[0] = q[0];
      a[1] = q[1];
      changed("path");
    } else if (this.stroke) {
      this.stroke.push(p);
      if (mode !== "points" && distance(p, this.from) > 8 / app.view.scale) this.free = true;
      app.rubber(this.free ? this.stroke : null);
    }
  },
  up(p) {
    const stroke = this.stroke, free = this.free;
    app.rubber(null);
    if (this.moving !== undefined && this.moving !== null) this.moving = null;
    else if (stroke && free && stroke.length > 3) this.finish(stroke);
    else if (stroke) addAnchor(mode, snapped(this.from));
    this.stroke = null;
    this.free = false;
  },
  finish(stroke) {
    const path = app.doc.path, reach = 2.2 / app.view.scale;
    const closes = distance(stroke[0], stroke[stroke.length - 1]) < 22 / app.view.scale && stroke.length > 12;
    let a = simplify(stroke, mode === "curve" ? reach : 3 * reach).map((q) => q.map((x) => +x.toPrecision(7)));
    if (closes) a = a.slice(0, -1);
    change("path", (d) => {
      d.path.anchors = path.closed || !path.anchors.length ? a : [...path.anchors, ...a];
      d.path.closed = closes;
      d.path.mode = mode;
    });
  },
  cancel() { this.stroke = null; this.moving = null; this.free = false; app.rubber(null); },
});

// ---- zones: a drag from corner to corner gives a box, a drag round the zone a polygon

const zoneTool = (name, key, d, title, put) => ({
  name, key, icon: icon(d), title, group: "Conditions", cursor: "crosshair",
  down(p) { this.way = [p]; },
  shape(p) {
    const [a, b] = [this.way[0], p], far = Math.max(...this.way.map((q) => distance(a, q)));
    if (this.way.length > 8 && distance(a, b) < 0.5 * far) return hull(this.way);
    const [c, e] = [snapped(a), snapped(b)];
    return [Math.min(c[0], e[0]), Math.min(c[1], e[1]), Math.max(c[0], e[0]), Math.max(c[1], e[1])];
  },
  move(p) {
    if (!this.way) return;
    this.way.push(p);
    app.rubber(zoneCorners(this.shape(p)), true);
  },
  up(p) {
    const z = this.way && this.shape(p);
    this.cancel();
    if (!z) return;
    const x = zoneCorners(z).map((q) => q[0]), y = zoneCorners(z).map((q) => q[1]);
    if (x.length < 3 || Math.min(Math.max(...x) - Math.min(...x), Math.max(...y) - Math.min(...y)) * app.view.scale < 6) return;
    change("task", (doc) => put(doc.task, z));
    app.show("search");
  },
  cancel() { this.way = null; app.rubber(null); },
});

// ---- mechanisms

function ensureLinkage() {
  if (!app.doc.linkage) app.doc.linkage = empty(app.doc.unit);
  else if (app.fresh()) app.doc.linkage = rebase(app.doc.linkage, app.motion, app.frame);
  return app.doc.linkage;
}
const reach = () => 13 / app.view.scale;

function edit(f) {
  change("none", () => {
    const k = clone(ensureLinkage()), why = f(k);
    if (why) app.say(why, true);
    app.doc.linkage = k;
  });
  app.frame = 0;
  changed("linkage");
}

const builder = (name, key, d, title, two, act) => ({
  name, key, icon: icon(d), title, group: "Build", cursor: "crosshair",
  down(p) { app.pause(); this.from = snapped(p); },
  move(p) { if (this.from && two) app.rubber([this.from, snapped(p)]); },
  up(p) {
    const from = this.from, to = snapped(p);
    this.from = null;
    app.rubber(null);
    if (!from) return;
    if (two && distance(from, to) < reach()) {
      app.say(two);
      return;
    }
    edit((k) => act(k, from, to));
    app.show("mechanism");
  },
  cancel() { this.from = null; app.rubber(null); },
});

export const select = {
  name: "Move", key: "v", group: "Move", cursor: "grab",
  icon: icon("M5 3l13 8-6 1.5L9 19z"), title: "Move points and joints; drag the paper",
  down(p, event) {
    const target = event.target.closest("[data-anchor],[data-point]");
    if (target && target.dataset.point) return this.take(target.dataset.point);
    if (target) {
      begin();
      this.anchor = Number(target.dataset.anchor);
      return undefined;
    }
    if (app.doc.linkage && app.posed) {
      const k = posture(), what = hit(k, p, reach());
      app.pick(what && what.link ? { link: what.link } : null);
    }
    this.paper = { p, x: app.view.x, y: app.view.y };
    return undefined;
  },
  take(name) {
    app.pause();
    const kept = app.doc.linkage;
    begin();
    this.start = app.fresh() ? rebase(kept, app.motion, app.frame) : clone(kept);
    this.point = [...this.start.joints, ...this.start.tracers].find((q) => q.name === name);
    app.pick({ point: this.point });
    this.moved = false;
  },
  move(p, event) {
    if (this.start) {
      app.dragging = true;
      const k = clone(this.start);
      const here = alike(this.start, this.point.at).map((q) => q.name);
      drag(k, this.point.at, snapped(p, null, (q) => here.includes(q.name)), app.doc.locked);
      this.moved = true;
      app.doc.linkage = k;
      app.touch();
    } else if (this.anchor !== undefined && this.anchor !== null) {
      const a = app.doc.path.anchors[this.anchor], q = snapped(p, a);
      [a[0], a[1]] = q;
      changed("path");
    } else if (this.paper) {
      app.view.x += this.paper.p[0] - p[0];
      app.view.y += this.paper.p[1] - p[1];
      app.redraw();
    }
    return event;
  },
  up() {
    app.dragging = false;
    if (this.start && !this.moved) app.past.pop();
    if (this.start && this.moved) changed("linkage");
    this.start = null;
    this.anchor = null;
    this.paper = null;
  },
  cancel() { app.dragging = false; this.start = null; this.anchor = null; this.paper = null; },
};

function posture() {
  return app.fresh() ? rebase(app.doc.linkage, app.motion, app.frame) : app.doc.linkage;
}

// Arrow keys on a point do what dragging does.
export function nudge(element, dx, dy) {
  const s = app.view.step();
  if (element.dataset.anchor) {
    change("path", (d) => { const a = d.path.anchors[Number(element.dataset.anchor)]; a[0] += dx * s; a[1] += dy * s; });
    return;
  }
  app.pause();
  change("none", (d) => {
    const k = clone(posture()), q = [...k.joints, ...k.tracers].find((r) => r.name === element.dataset.point);
    drag(k, q.at, [q.at[0] + dx * s, q.at[1] + dy * s], d.locked);
    d.linkage = k;
  });
  app.frame = 0;
  changed("linkage");
}

export function removePicked(element) {
  if (element && element.dataset.anchor) {
    change("path", (d) => {
      d.path.anchors.splice(Number(element.dataset.anchor), 1);
      if (d.path.anchors.length < 3) d.path.closed = false;
    });
    return;
  }
  const what = app.picked;
  if (!what || !app.doc.linkage) return;
  edit((k) => {
    if (what.point) what.point = [...k.joints, ...k.tracers].find((q) => q.name === what.point.name);
    if (what.link || what.point) remove(k, what);
  });
  app.pick(null);
}

const scale = {
  name: "Scale", key: "y", group: "Photo", cursor: "crosshair", title: "Set the scale of the photo by two clicks",
  icon: icon("M4 16L16 4l4 4L8 20zM8 12l2 2M11 9l2 2M14 6l2 2"),
  down(p) { this.from = p; },
  move() {},
  up(p) {
    if (!app.doc.photo) {
      app.say("Drop a photo on the drawing first.");
      return;
    }
    this.points = [...(this.points || []), p].slice(-2);
    app.rubber(this.points);
    if (this.points.length === 2) app.askScale(this.points, () => { this.points = []; app.rubber(null); });
  },
  cancel() { this.points = []; app.rubber(null); },
};

export const tools = [
  select,
  drawing("curve", "Curve", "c", "M3 18C6 4 12 4 12 11s5 8 9-3", "Smooth curve: click points, or draw with the button held; click the first point to close"),
  drawing("lines", "Lines", "l", "M3 19L8 6l7 9 6-10", "Straight lines from corner to corner"),
  drawing("points", "Points", "p", "M5 17h.01M10 8h.01M16 13h.01M20 5h.01", "Points to pass through, in order"),
  scale,
  zoneTool("Pivots", "b", "M4 4h16v16H4zM12 14l-3 4h6zM12 11v3", "Where the fixed pivots are: drag a box, or draw round it", (t, z) => { t.pivots = z; }),
  zoneTool("Forbid", "f", "M4 4h16v16H4zM7 7l10 10M17 7L7 17", "Zone that nothing may enter: drag a box, or draw round it", (t, z) => { if (t.forbidden.length < 7) t.forbidden.push(z); }),
  builder("Link", "k", "M6 18L18 6M6 18h.01M18 6h.01M4 18a2 2 0 1 0 4 0 2 2 0 1 0-4 0M16 6a2 2 0 1 0 4 0 2 2 0 1 0-4 0",
    "Link: drag from end to end; ends on links and points are pinned", "Drag from one end of the link to the other.",
    (k, a, b) => { addLink(k, a, b, reach()); }),
  builder("Ground", "g", "M12 6l-5 9h10zM4 18h16M6 18l-2 3M12 18l-2 3M18 18l-2 3", "Ground pin on a joint, a free end or a link; the first one drives", null,
    (k, a) => addGround(k, a, reach())),
  builder("Slider", "s", "M3 16h18M8 10h8v6H8zM12 13h.01", "Slider: drag from a point along its slot", "Drag from the point in the direction of the slot.",
    (k, a, b) => { const d = distance(a, b); return addGround(k, a, reach(), [(b[0] - a[0]) / d, (b[1] - a[1]) / d]); }),
  builder("Gears", "w", "M8 8m-5 0a5 5 0 1 0 10 0a5 5 0 1 0-10 0M16 16m-4 0a4 4 0 1 0 8 0a4 4 0 1 0-8 0", "Gear pair: drag from one link to another",
    "Drag from one link to the other.", (k, a, b) => addGear(k, a, b, reach())),
  builder("Tracer", "t", "M12 12m-3 0a3 3 0 1 0 6 0a3 3 0 1 0-6 0M12 3v3M12 18v3M3 12h3M18 12h3", "Tracer: a point of a link whose path you want", null,
    (k, a) => addTracer(k, a, reach())),
];
