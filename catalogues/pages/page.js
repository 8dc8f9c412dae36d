"use strict";
(function () {
  // motions[m]: { loops, first, links: [[link, panel, from x, from y, x, y, angle, dx, dy, dangle, ...]] }
  // lengths in 1/10 px of the drawing, angles in 1/10000 rad; after the first frame, differences.
  const motions = JSON.parse(document.getElementById("motions").textContent);
  const SECONDS_A_ROUND = 7;
  const still = window.matchMedia("(prefers-reduced-motion: reduce)").matches;

  function unpack(packed) {
    const [link, panel, fromX, fromY, ...rest] = packed;
    const frames = [];
    let x = 0, y = 0, angle = 0;
    for (let i = 0; i < rest.length; i += 3) {
      x += rest[i];
      y += rest[i + 1];
      angle += rest[i + 2];
      frames.push({ x: x / 10, y: y / 10, angle: angle / 10000 });
    }
    return { link, panel, fromX: fromX / 10, fromY: fromY / 10, frames };
  }

  // One drawing: its elements by the link they move with.
  class Drawing {
    constructor(figure) {
      this.figure = figure;
      const motion = motions[Number(figure.dataset.motion)];
      this.loops = motion.loops;
      this.first = motion.first;
      this.links = motion.links.map(unpack);
      this.count = this.links.length ? this.links[0].frames.length : 1;
      for (const link of this.links) {
        const chosen = `[data-link="${link.link}"][data-panel="${link.panel}"]`;
        link.elements = Array.from(figure.querySelectorAll(chosen));
      }
      this.ties = Array.from(figure.querySelectorAll("[data-ends]"), (element) => new Tie(element, this.links));
    }

    // Length of a round in frames: back and forth when the motion does not loop.
    get round() {
      return this.loops ? this.count : Math.max(2 * (this.count - 1), 1);
    }

    // Put every link where it is at `time`, a number of frames in 0 .. round.
    show(time) {
      let t = time % this.round;
      if (!this.loops && t > this.count - 1) t = this.round - t;
      const i = Math.min(Math.floor(t), this.count - 1);
      const j = this.loops ? (i + 1) % this.count : Math.min(i + 1, this.count - 1);
      for (const link of this.links) move(link, link.frames[i], link.frames[j], t - i);
      for (const tie of this.ties) tie.move();
    }
  }

  // A rope or a spring: its ends move with two links, the points between stay in proportion along it, and as far aside.
  class Tie {
    constructor(element, links) {
      this.element = element;
      const n = element.getAttribute("points").split(/[ ,]+/).map(Number);
      this.points = Array.from({ length: n.length / 2 }, (_, i) => [n[2 * i], n[2 * i + 1]]);
      const [ax, ay, bx, by] = element.dataset.line.split(" ").map(Number);
      this.line = [[ax, ay], [bx, by]];
      this.ends = element.dataset.ends.split(" ").map((l) =>
        links.find((k) => k.link === Number(l) && k.panel === Number(element.dataset.panel)));
    }

    move() {
      const old = this.line;
      const [a, b] = this.ends.map((link, i) => (link && link.now ? link.now(old[i]) : old[i]));
      const wx = old[1][0] - old[0][0], wy = old[1][1] - old[0][1], was = Math.max(Math.hypot(wx, wy), 1e-9);
      const x = b[0] - a[0], y = b[1] - a[1], is = Math.max(Math.hypot(x, y), 1e-9);
      this.element.setAttribute("points", this.points.map((p) => {
        const dx = p[0] - old[0][0], dy = p[1] - old[0][1];
        const along = (dx * wx + dy * wy) / was / (this.element.dataset.rigid ? is : was), aside = (wx * dy - wy * dx) / was / is;
        return `${(a[0] + along * x - aside * y).toFixed(2)},${(a[1] + along * y + aside * x).toFixed(2)}`;
      }).join(" "));
    }
  }

  function move(link, a, b, part) {
    const turn = 2 * Math.PI;
    let way = b.angle - a.angle;
    way -= turn * Math.round(way / turn);
    const angle = a.angle + part * way;
    const x = a.x + part * (b.x - a.x), y = a.y + part * (b.y - a.y);
    const c = Math.cos(angle), s = Math.sin(angle);
    const e = x - c * link.fromX + s * link.fromY, f = y - s * link.fromX - c * link.fromY;
    const turned = `matrix(${c} ${s} ${-s} ${c} ${e} ${f})`;
    link.now = (p) => [c * p[0] - s * p[1] + e, s * p[0] + c * p[1] + f];
    for (const element of link.elements) {
      if (!element.dataset.hold) {
        element.setAttribute("transform", turned);
        continue;
      }
      const [hx, hy] = element.dataset.hold.split(" ").map(Number);
      element.setAttribute("transform", `translate(${c * hx - s * hy + e - hx} ${s * hx + c * hy + f - hy})`);
    }
  }

  // One target: its drawings, of which one is shown, and the controls.
  class Player {
    constructor(section) {
      this.section = section;
      this.play = section.querySelector(".play");
      this.time = section.querySelector(".time");
      this.speed = section.querySelector(".speed");
      this.names = section.querySelector(".names");
      this.drawings = Array.from(section.querySelectorAll("figure"), (f) => new Drawing(f));
      this.playing = false;
      this.play.addEventListener("click", () => this.run(!this.playing));
      this.time.addEventListener("input", () => {
        this.run(false);
        this.draw(Number(this.time.value));
      });
      this.names.addEventListener("change", () => this.label());
      section.querySelectorAll("input[type=radio]").forEach((radio, i) => {
        radio.addEventListener("change", () => this.choose(i));
      });
      section.querySelectorAll("tbody tr").forEach((row, i) => {
        row.addEventListener("click", () => {
          const radio = row.querySelector("input");
          if (radio && !radio.checked) {
            radio.checked = true;
            this.choose(i);
          }
        });
      });
      section.querySelector(".transport").hidden = false;
      this.choose(0);
      this.label();
    }

    choose(index) {
      const figures = this.drawings.map((d) => d.figure);
      const row = this.section.querySelectorAll("tbody tr")[index];
      this.section.querySelectorAll("tbody tr").forEach((r) => r.classList.toggle("shown", r === row));
      const shown = figures.findIndex((f) => f.dataset.result === String(index));
      figures.forEach((f, i) => { f.hidden = i !== shown; });
      this.drawing = this.drawings[shown];
      const moves = this.drawing && this.drawing.count > 1;
      this.play.disabled = this.time.disabled = !moves;
      if (!this.drawing) return;
      this.time.max = this.drawing.round;
      this.draw(this.drawing.first);
    }

    label() {
      for (const d of this.drawings) d.figure.classList.toggle("plain", !this.names.checked);
    }

    draw(frame) {
      this.now = frame;
      if (this.drawing) this.drawing.show(frame);
      this.time.value = frame;
    }

    run(on) {
      this.playing = on && !this.play.disabled;
      this.play.textContent = this.playing ? "Pause" : "Play";
      if (!this.playing) return;
      let last = null;
      const step = (clock) => {
        if (!this.playing) return;
        if (last !== null && this.drawing) {
          const rate = this.drawing.round / SECONDS_A_ROUND * Number(this.speed.value) / 1000;
          this.draw((this.now + Math.min(clock - last, 100) * rate) % this.drawing.round);
        }
        last = clock;
        window.requestAnimationFrame(step);
      };
      window.requestAnimationFrame(step);
    }
  }

  const players = Array.from(document.querySelectorAll("section"), (s) => new Player(s));
  const links = Array.from(document.querySelectorAll("nav a"));

  function open() {
    const asked = players.findIndex((p) => "#" + p.section.id === window.location.hash);
    const shown = Math.max(asked, 0);
    players.forEach((p, i) => {
      p.section.hidden = i !== shown;
      p.run(i === shown && !still);
    });
    links.forEach((a, i) => {
      if (i === shown) a.setAttribute("aria-current", "true");
      else a.removeAttribute("aria-current");
    });
  }

  window.addEventListener("hashchange", open);
  open();
})();
