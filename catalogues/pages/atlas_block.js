"use strict";
// Pictures of chains from numbers, and chains of large families from blocks that are loaded when they are needed.
const atlasBlocks = (function () {
  const NS = "http://www.w3.org/2000/svg", SIZE = 32;
  const waiting = new Map(), blocks = new Map();

  function shape(svg, name, attributes) {
    const e = document.createElementNS(NS, name);
    for (const key of Object.keys(attributes)) e.setAttribute(key, attributes[key]);
    svg.append(e);
    return e;
  }

  // Where the sides a b and c d cross, as a fraction of a b; -1 if they do not.
  function crossing(a, b, c, d) {
    const u = [b[0] - a[0], b[1] - a[1]], v = [d[0] - c[0], d[1] - c[1]], w = [c[0] - a[0], c[1] - a[1]];
    const turn = u[0] * v[1] - u[1] * v[0], s = (w[0] * v[1] - w[1] * v[0]) / turn, t = (w[0] * u[1] - w[1] * u[0]) / turn;
    return s > 0.02 && s < 0.98 && t > 0.02 && t < 0.98 ? s : -1;
  }

  // places: x and y of the pins in 1/100 of a bar, y down; rings: the pins of each link in order; ground: the index of
  // the frame or -1; numbers: write the numbers of the links.  A pin of more than two links is two circles.
  function picture(places, rings, ground, numbers) {
    const svg = document.createElementNS(NS, "svg"), at = (j) => [places[2 * j], places[2 * j + 1]];
    const xs = places.filter((_, i) => i % 2 === 0), ys = places.filter((_, i) => i % 2 === 1), edge = numbers ? 26 : 16;
    const x = Math.min(...xs) - edge, y = Math.min(...ys) - edge, below = ground < 0 ? edge : 40;
    svg.setAttribute("viewBox", `${x} ${y} ${Math.max(...xs) + edge - x} ${Math.max(...ys) + below - y}`);
    if (ground >= 0)
      for (const [px, py] of rings[ground].map(at)) {
        shape(svg, "polygon", { points: `${px},${py} ${px - 13},${py + 22} ${px + 13},${py + 22}`, class: "f-paper s-ground" });
        const hatch = [-15, -5, 5, 15].map((dx) => `M${px + dx} ${py + 22}l-7 8`).join("");
        shape(svg, "path", { d: `M${px - 20} ${py + 22}h40${hatch}`, class: "hatch s-ground" });
      }
    const sides = (ring) => ring.slice(ring.length > 2 ? 0 : 1).map((j, i) => [at(ring.length > 2 ? ring[(i || ring.length) - 1] : ring[i]), at(j)]);
    const order = rings.map((_, i) => i).filter((i) => i !== ground).sort((a, b) => (rings[a].length < 3) - (rings[b].length < 3) || a - b);
    order.forEach((i, above) => {
      const ring = rings[i], points = ring.map((j) => at(j).join()).join(" ");
      for (const [a, b] of sides(ring))                            // gaps in what is crossed
        for (const below of order.slice(0, above))
          for (const [c, d] of sides(rings[below])) {
            const s = crossing(a, b, c, d), length = Math.hypot(b[0] - a[0], b[1] - a[1]), part = 12 / length;
            const point = (f) => [a[0] + f * (b[0] - a[0]), a[1] + f * (b[1] - a[1])];
            if (s < 0 || ring.some((j) => rings[below].includes(j))) continue;
            const [p, q] = [point(s - part), point(s + part)];
            shape(svg, "line", { x1: p[0], y1: p[1], x2: q[0], y2: q[1], class: "gap s-paper" });
          }
      if (ring.length > 2) shape(svg, "polygon", { points, class: "f-link s-link" });
      else shape(svg, "polyline", { points, class: "s-link" });
    });
    xs.forEach((cx, j) => {
      const multiple = rings.filter((ring) => ring.includes(j)).length > 2;
      if (multiple) shape(svg, "circle", { cx, cy: ys[j], r: 12, class: "f-paper s-ground" });
      shape(svg, "circle", { cx, cy: ys[j], r: multiple ? 6 : 8, class: "f-paper s-ground" });
    });
    if (numbers)
      rings.forEach((ring, i) => {
        const [a, b] = [at(ring[0]), at(ring[ring.length - 1])], n = ring.length, length = Math.hypot(b[0] - a[0], b[1] - a[1]);
        const middle = [0, 1].map((k) => ring.reduce((sum, j) => sum + at(j)[k], 0) / n), off = n > 2 ? 0 : 16 / length;
        shape(svg, "text", { x: middle[0] - off * (b[1] - a[1]), y: middle[1] + off * (b[0] - a[0]) + 7, class: "f-blue number-of-link" })
          .textContent = String(i + 1);
      });
    return svg;
  }

  // Calls then(chain, of) with the data of the chain `name` (8-1-3, 8-1-m3) when its block is there; fail() if the block
  // cannot be loaded.
  function load(name, then, fail) {
    const [, family, number] = /^(\d+-\d+-m?)(\d+)$/.exec(name), key = family + Math.floor((number - 1) / SIZE);
    const give = () => {
      const { of, chains } = blocks.get(key), chain = chains[(number - 1) % SIZE];
      if (chain) then(chain, of);
      else fail();
    };
    if (blocks.has(key)) return give();
    if (!waiting.has(key)) {
      const script = document.createElement("script");
      waiting.set(key, []);
      script.onerror = () => {
        waiting.get(key).forEach((w) => w.fail());
        waiting.delete(key);
      };
      script.src = `chains-${key}.js`;
      document.head.append(script);
    }
    waiting.get(key).push({ give, fail });
    return undefined;
  }

  // Called by the blocks.
  function take(key, of, chains) {
    blocks.set(key, { of, chains });
    (waiting.get(key) || []).forEach((w) => w.give());
    waiting.delete(key);
  }

  return { picture, load, take };
})();
