"use strict";
// Sketch of a chain: bars are drawn from pin to pin; bars that form a triangle are one link.  Calls changed(pins) with the
// links at each pin, and says what it sees.
const atlasSketch = (function () {
  const GRID = 20, NEAR = 16, NS = "http://www.w3.org/2000/svg";

  // Bodies of the bars: bodies that share two pins are one, and so are three that share a pin two by two.
  function bodies(bars) {
    let all = bars.map(([a, b]) => new Set([a, b]));
    const shared = (p, q) => [...p].filter((x) => q.has(x));
    const join = (...parts) => {
      all = all.filter((body) => !parts.includes(body));
      all.push(new Set(parts.flatMap((body) => [...body])));
    };
    const step = () => {
      for (const p of all)
        for (const q of all) {
          const common = p === q ? [] : shared(p, q);
          if (common.length > 1) return join(p, q), true;
          if (common.length !== 1) continue;
          for (const r of all) {
            if (r === p || r === q) continue;
            const first = shared(p, r).filter((x) => x !== common[0]), second = shared(q, r).filter((x) => x !== common[0]);
            if (first.length && second.some((x) => x !== first[0] || first.length > 1)) return join(p, q, r), true;
          }
        }
      return false;
    };
    while (step());
    return all;
  }

  // The outline of points (convex hull, Andrew 1979).
  function outline(points) {
    const sorted = points.slice().sort((a, b) => a.x - b.x || a.y - b.y);
    const half = (list) => {
      const hull = [];
      for (const p of list) {
        while (hull.length > 1) {
          const [a, b] = hull.slice(-2);
          if ((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x) > 0) break;
          hull.pop();
        }
        hull.push(p);
      }
      return hull.slice(0, -1);
    };
    return half(sorted).concat(half(sorted.reverse()));
  }

  class Sketch {
    constructor(svg, changed) {
      this.svg = svg;
      this.changed = changed;
      this.pins = [];                // { x, y }
      this.bars = [];                // [pin, pin]
      this.from = null;
      svg.addEventListener("pointerdown", (e) => this.begin(e));
      svg.addEventListener("pointermove", (e) => this.move(e));
      svg.addEventListener("pointerup", (e) => this.end(e));
      svg.addEventListener("pointercancel", () => this.stop());
      this.draw();
    }

    place(event) {
      const box = this.svg.getBoundingClientRect(), view = this.svg.viewBox.baseVal;
      return { x: ((event.clientX - box.left) / box.width) * view.width, y: ((event.clientY - box.top) / box.height) * view.height };
    }

    near(p) {
      return this.pins.findIndex((q) => Math.hypot(p.x - q.x, p.y - q.y) < NEAR);
    }

    // The pin at this place; a new one on the grid if there is none.
    pin(p) {
      const there = this.near(p);
      if (there >= 0) return there;
      const at = { x: Math.round(p.x / GRID) * GRID, y: Math.round(p.y / GRID) * GRID }, again = this.near(at);
      return again >= 0 ? again : this.pins.push(at) - 1;
    }

    begin(event) {
      event.preventDefault();
      this.svg.setPointerCapture(event.pointerId);
      this.from = this.place(event);
      this.to = this.from;
      this.draw();
    }

    move(event) {
      if (!this.from) return;
      this.to = this.place(event);
      this.draw();
    }

    end(event) {
      if (!this.from) return;
      const to = this.place(event), from = this.from;
      this.stop();
      if (Math.hypot(to.x - from.x, to.y - from.y) < NEAR) return;
      const a = this.pin(from), b = this.pin(to);
      if (a !== b && !this.bars.some(([p, q]) => (p === a && q === b) || (p === b && q === a))) this.bars.push([a, b]);
      this.update();
    }

    stop() {
      this.from = null;
      this.draw();
    }

    undo() {
      this.bars.pop();
      this.update();
    }

    clear() {
      this.bars = [];
      this.update();
    }

    update() {
      const used = this.pins.map((_, i) => this.bars.some((bar) => bar.includes(i))), number = [];
      used.forEach((u, i) => { number[i] = u ? used.slice(0, i).filter(Boolean).length : -1; });
      this.bars = this.bars.map(([a, b]) => [number[a], number[b]]);
      this.pins = this.pins.filter((_, i) => used[i]);
      this.draw();
      const links = bodies(this.bars);
      this.changed(this.pins.map((_, i) => links.flatMap((l, k) => (l.has(i) ? [k + 1] : []))), links.length);
    }

    add(name, attributes) {
      const e = document.createElementNS(NS, name);
      for (const key of Object.keys(attributes)) e.setAttribute(key, attributes[key]);
      this.svg.append(e);
    }

    draw() {
      this.svg.replaceChildren();
      for (const body of bodies(this.bars).filter((l) => l.size > 2)) {
        const points = outline([...body].map((i) => this.pins[i])).map((p) => `${p.x},${p.y}`).join(" ");
        this.add("polygon", { points, class: "f-link s-link" });
      }
      for (const [a, b] of this.bars) {
        const p = this.pins[a], q = this.pins[b];
        this.add("line", { x1: p.x, y1: p.y, x2: q.x, y2: q.y, class: "s-link" });
      }
      if (this.from) this.add("line", { x1: this.from.x, y1: this.from.y, x2: this.to.x, y2: this.to.y, class: "s-link drawn" });
      for (const p of this.pins) this.add("circle", { cx: p.x, cy: p.y, r: 6, class: "f-paper s-ground" });
    }
  }

  return { Sketch, bodies };
})();
