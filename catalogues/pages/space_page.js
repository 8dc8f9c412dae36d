"use strict";
(function () {
  // data: { up, right, front, loops, seconds, radius, unit, origins, shapes: [{ kind, link, to, tube, grounded, p }], paths, frames }
  // lengths in radii of the scene from its middle, the radius in the unit; a frame holds x, y, z and a quaternion w, x, y, z for each link
  const data = JSON.parse(document.getElementById("data").textContent);
  const canvas = document.getElementById("view"), pen = canvas.getContext("2d");
  const [play, time, clock, speed] = ["play", "time", "clock", "speed"].map((id) => document.getElementById(id));
  const still = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
  const PIECES = 12, FRONT = 0.02, BEHIND = 1 / PIECES, TEETH = 9;       // as in space_drawing.c
  const there = data.loops ? data.frames.length : data.frames.length - 1;      // [frames], and back unless it loops
  const round = Math.max(data.loops ? there : 2 * there, 1);
  const SECONDS_A_ROUND = data.seconds ? (data.seconds * round) / there : 6;

  const add = (a, b, s) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (a) => a.map((x) => x / Math.hypot(...a));
  const points = (flat) => Array.from({ length: flat.length / 3 }, (_, i) => flat.slice(3 * i, 3 * i + 3));
  const shapes = data.shapes.map((s) => ({ ...s, p: points(s.p) })), paths = data.paths.map(points);
  const origins = points(data.origins);

  // ---- the direction of the view: azimuth about `up`, elevation above the level plane ----
  const a = unit(add(data.front, data.up, -dot(data.front, data.up))), b = cross(data.up, a);
  const home = { azimuth: 0, elevation: Math.asin(dot(data.front, data.up)), zoom: 1 };
  let view = { ...home }, now = 0, playing = false;

  function axes() {
    const level = add(a.map((x) => x * Math.cos(view.azimuth)), b, Math.sin(view.azimuth));
    const front = add(level.map((x) => x * Math.cos(view.elevation)), data.up, Math.sin(view.elevation));
    const right = add(b.map((x) => x * Math.cos(view.azimuth)), a, -Math.sin(view.azimuth));
    return [right, cross(front, right), front];
  }

  // ---- poses ----
  function rotate(q, p) {
    const [w, x, y, z] = q, v = [x, y, z], t = cross(v, p).map((c) => 2 * c);
    return add(add(p, t, w), cross(v, t), 1);
  }

  function poses(at) {
    let t = at % round;
    if (!data.loops && t > data.frames.length - 1) t = round - t;
    const i = Math.min(Math.floor(t), data.frames.length - 1);
    const j = data.loops ? (i + 1) % data.frames.length : Math.min(i + 1, data.frames.length - 1);
    const first = data.frames[i], second = data.frames[j], part = t - i;
    return origins.map((_, k) => {
      const p = first.slice(7 * k, 7 * k + 7), q = second.slice(7 * k, 7 * k + 7);
      const sign = p[3] * q[3] + p[4] * q[4] + p[5] * q[5] + p[6] * q[6] < 0 ? -1 : 1;
      const mixed = p.map((x, n) => (1 - part) * x + part * (n < 3 ? q[n] : sign * q[n]));
      return { at: mixed.slice(0, 3), turn: unit(mixed.slice(3)) };
    });
  }

  // The points of a shape, the last of them on the link `to` if there is one.
  const place = (s, placed) => s.p.map((x, i) => {
    const link = s.to !== undefined && i === s.p.length - 1 ? s.to : s.link, pose = placed[link];
    return add(pose.at, rotate(pose.turn, add(x, origins[link], -1)), 1);
  });

  // ---- scale: every frame is on the canvas, from whichever side it is seen ----
  const MARGIN = 40, FOOT = 28;
  const everywhere = data.frames.flatMap((_, f) => {
    const placed = poses(f);
    return shapes.flatMap((s) => place(s, placed));
  });

  // Scale, and the middle of all points to the right and up.
  function fit(right, up, width, height) {
    const least = [Infinity, Infinity], most = [-Infinity, -Infinity];
    for (const p of everywhere)
      [dot(p, right), dot(p, up)].forEach((x, i) => {
        least[i] = Math.min(least[i], x);
        most[i] = Math.max(most[i], x);
      });
    if (!everywhere.length) return [1, 0, 0];
    const wide = Math.max(most[0] - least[0], 1e-12), high = Math.max(most[1] - least[1], 1e-12);
    const scale = Math.max(Math.min((width - 2 * MARGIN) / wide, (height - 2 * MARGIN - FOOT) / high), 1);
    return [scale, (least[0] + most[0]) / 2, (least[1] + most[1]) / 2];
  }

  // The largest 1, 2 or 5 times a power of ten that is at most x.
  function roundDown(x) {
    const power = 10 ** Math.floor(Math.log10(x)), digit = x / power;
    return (digit >= 5 ? 5 : digit >= 2 ? 2 : 1) * power;
  }

  function drawScaleBar(scale, width, height, inks) {
    const length = roundDown((0.2 * width * data.radius) / scale), end = 94 + (length * scale) / data.radius, foot = height - 14;
    stroke({ p: [[94, foot - 5], [94, foot], [end, foot], [end, foot - 5]] }, inks.text, 1.5);
    pen.fillStyle = inks.text;
    pen.fillText(`${Number(length.toPrecision(1))} ${data.unit} parallel to the picture`, end + 7, foot);
  }

  // ---- drawing: pieces from the farthest to the nearest ----
  function ink(name) {
    return window.getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  }

  function stroke(piece, colour, width) {
    pen.beginPath();
    piece.p.forEach(([x, y], i) => (i ? pen.lineTo(x, y) : pen.moveTo(x, y)));
    if (piece.closed) pen.closePath();
    pen.strokeStyle = colour;
    pen.lineWidth = width;
    pen.stroke();
  }

  function paint(piece, inks) {
    const dark = piece.grounded ? inks.ground : inks.link;
    if (piece.kind === "path") stroke(piece, inks.blue, 2.2);
    if (piece.kind === "guide") stroke(piece, inks.faint, 1.6);
    if (piece.kind === "bar") {
      const [[x0, y0], [x1, y1]] = piece.p, length = Math.hypot(x1 - x0, y1 - y0), cut = 4 / length;
      if (length > 8) {                       // a light seam: this bar passes over what is behind it
        const p = [[x0 + cut * (x1 - x0), y0 + cut * (y1 - y0)], [x1 - cut * (x1 - x0), y1 - cut * (y1 - y0)]];
        stroke({ p }, inks.paper, 8);
      }
      stroke(piece, inks.link, 5);
    }
    if (piece.kind === "pin") {
      stroke(piece, dark, 12);
      stroke(piece, piece.grounded ? inks.faint : inks.paper, 8);
    }
    if (piece.kind === "tie") stroke(piece, inks.orange, 1.6);
    if (piece.kind === "rod") stroke(piece, inks.link, 3);
    if (piece.kind === "tube") {
      stroke(piece, inks.link, 11);
      stroke(piece, inks.paper, 7);
    }
    if (piece.kind === "plate") {
      stroke(piece, dark, 3);
      pen.globalAlpha = 0.25;
      pen.fillStyle = dark;
      pen.fill();
      pen.globalAlpha = 1;
    }
    if (piece.kind === "ball" || piece.kind === "tracer") {
      pen.beginPath();
      pen.arc(piece.p[0][0], piece.p[0][1], piece.kind === "ball" ? 6 : 4.5, 0, 7);
      pen.fillStyle = piece.grounded ? inks.faint : inks.paper;
      pen.fill();
      pen.strokeStyle = piece.kind === "ball" ? dark : inks.blue;
      pen.lineWidth = 2.4;
      pen.stroke();
    }
  }

  function draw() {
    const dense = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
    if (canvas.width !== Math.round(width * dense)) canvas.width = Math.round(width * dense);
    if (canvas.height !== Math.round(height * dense)) canvas.height = Math.round(height * dense);
    pen.setTransform(dense, 0, 0, dense, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.lineCap = "round";
    pen.lineJoin = "round";
    const inks = Object.fromEntries(["paper", "text", "link", "ground", "faint", "blue", "red", "green", "orange"].map((n) => [n, ink(n)]));
    const [right, up, front] = axes(), [fitted, x, y] = fit(right, up, width, height), scale = fitted * view.zoom, pieces = [];
    const project = (p) => [width / 2 + scale * (dot(p, right) - x), (height - FOOT) / 2 - scale * (dot(p, up) - y), dot(p, front)];
    const offset = { ball: FRONT, tracer: FRONT, guide: -BEHIND, path: -BEHIND };
    const put = (kind, list, rest) => {
      const p = list.map(project), depth = p.reduce((sum, q) => sum + q[2], 0) / p.length;
      pieces.push({ kind, p, depth: depth + (offset[kind] || 0), closed: kind === "plate", ...rest });
    };
    const putZigzag = (from, way) => {
      const [x0, y0] = project(from), [x1, y1] = project(add(from, way, 1)), long = Math.max(Math.hypot(x1 - x0, y1 - y0), 1e-9);
      const part = (i) => (i < 0 ? 0 : i > TEETH ? 1 : 0.2 + (0.6 * i) / TEETH);
      const corner = (i) => {
        const [px, py] = project(add(from, way, part(i))), across = i <= 0 || i >= TEETH ? 0 : i % 2 ? 7 : -7;
        return [px - (across * (y1 - y0)) / long, py + (across * (x1 - x0)) / long];
      };
      for (let i = -1; i <= TEETH; i++) {
        const depth = dot(add(from, way, (part(i) + part(i + 1)) / 2), front);
        pieces.push({ kind: "tie", p: [corner(i), corner(i + 1)], depth });
      }
    };
    const placed = poses(now);
    for (const s of shapes) {
      const p = place(s, placed);
      if (p.length !== 2) {
        put(s.kind, p, { grounded: s.grounded });
        continue;
      }
      const way = add(p[1], p[0], -1), length = Math.hypot(...way);
      if (s.kind === "tie") {
        const tube = Math.min(s.tube / length, 1), at = (u) => add(p[0], way, u);
        if (s.tube) {
          put("rod", [at(tube), at(1)], {});
          put("tube", [at(0), at(tube)], {});
        } else putZigzag(p[0], way);
        continue;
      }
      const n = Math.max(1, Math.min(PIECES, Math.ceil((PIECES * length) / 2)));
      const bar = s.kind === "bar", end = bar ? Math.min((2 * FRONT) / length, 1 / 3) : 0;
      const cut = (i) => add(p[0], way, i < 0 ? 0 : i > n ? 1 : end + ((1 - 2 * end) * i) / n);
      for (let i = bar ? -1 : 0; i < n + (bar ? 1 : 0); i++) put(s.kind, [cut(i), cut(i + 1)], { grounded: s.grounded });
    }
    for (const path of paths)
      for (let i = 0; i + 1 < path.length + (data.loops ? 1 : 0); i++) put("path", [path[i], path[(i + 1) % path.length]], {});
    pieces.sort((p, q) => p.depth - q.depth);
    for (const piece of pieces) paint(piece, inks);
    pen.font = "12px system-ui, sans-serif";
    drawScaleBar(scale, width, height, inks);
    if (data.seconds) clock.textContent = `${((data.seconds * Math.min(now, data.loops ? now : round - now)) / there).toFixed(2)} s`;
    [["x", inks.red], ["y", inks.green], ["z", inks.blue]].forEach(([name, colour], i) => {
      const way = [right[i], -up[i]];
      stroke({ p: [[44, height - 44], [44 + 24 * way[0], height - 44 + 24 * way[1]]] }, colour, 2);
      pen.fillStyle = colour;
      pen.fillText(name, 41 + 34 * way[0], height - 40 + 34 * way[1]);
    });
  }

  // ---- by hand ----
  function turn(dx, dy) {
    view.azimuth -= dx;
    view.elevation = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, view.elevation + dy));
    draw();
  }

  function zoom(by) {
    view.zoom = Math.max(0.2, Math.min(20, view.zoom * by));
    draw();
  }

  const fingers = new Map();
  canvas.addEventListener("pointerdown", (e) => {
    canvas.setPointerCapture(e.pointerId);
    fingers.set(e.pointerId, [e.clientX, e.clientY]);
  });
  canvas.addEventListener("pointermove", (e) => {
    const last = fingers.get(e.pointerId);
    if (!last) return;
    const other = [...fingers].find(([id]) => id !== e.pointerId);
    if (other) {
      const from = Math.hypot(last[0] - other[1][0], last[1] - other[1][1]);
      const to = Math.hypot(e.clientX - other[1][0], e.clientY - other[1][1]);
      if (from > 0) zoom(to / from);
    } else turn((e.clientX - last[0]) / 150, (e.clientY - last[1]) / 150);
    fingers.set(e.pointerId, [e.clientX, e.clientY]);
  });
  for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (e) => fingers.delete(e.pointerId));
  canvas.addEventListener("wheel", (e) => {
    e.preventDefault();
    zoom(Math.exp(-e.deltaY / 600));
  }, { passive: false });
  canvas.addEventListener("keydown", (e) => {
    const step = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[e.key];
    if (step) turn(...step);
    else if (e.key === "+" || e.key === "=") zoom(1.1);
    else if (e.key === "-") zoom(1 / 1.1);
    else if (e.key === " ") run(!playing);
    else return;
    e.preventDefault();
  });
  for (const button of document.querySelectorAll("[data-view]"))
    button.addEventListener("click", () => {
      const level = { front: [-Math.PI / 180 * 35, 0], side: [Math.PI / 180 * 55, 0], top: [-Math.PI / 180 * 35, Math.PI / 2] };
      const [azimuth, elevation] = level[button.dataset.view] || [home.azimuth, home.elevation];
      view = { azimuth, elevation, zoom: 1 };
      draw();
    });

  // ---- time ----
  function run(on) {
    playing = on && data.frames.length > 1;
    play.textContent = playing ? "Pause" : "Play";
    let last = null;
    const step = (clock) => {
      if (!playing) return;
      if (last !== null) now = (now + (Math.min(clock - last, 100) / 1000) * (round / SECONDS_A_ROUND) * Number(speed.value)) % round;
      last = clock;
      time.value = now;
      draw();
      window.requestAnimationFrame(step);
    };
    if (playing) window.requestAnimationFrame(step);
  }

  time.max = round;
  time.addEventListener("input", () => {
    run(false);
    now = Number(time.value);
    draw();
  });
  play.addEventListener("click", () => run(!playing));
  window.addEventListener("resize", draw);
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  document.getElementById("still").hidden = true;
  canvas.hidden = false;
  document.querySelector(".transport").hidden = false;
  document.getElementById("keys").hidden = false;
  play.disabled = time.disabled = data.frames.length < 2;
  draw();
  run(!still);
})();
