"use strict";
(function () {
  // data: [links, dof, number, planar, symmetry, grounds, linkages, sliders, assortment, graph6, form, places, rings];
  // without the last two (see atlas_block.js) the chain stands in a block, and so does its page; a chain with multiple joints
  // has the links on each pin (1-2-5 1-3 ...) instead of graph6
  const STEP = 60;
  const byId = (id) => document.getElementById(id);
  const chains = JSON.parse(byId("data").textContent).map((d) => ({
    links: d[0], dof: d[1], number: d[2], planar: d[3], symmetry: d[4], grounds: d[5], linkages: d[6], sliders: d[7],
    assortment: d[8], graph6: d[9], form: d[10], places: d[11], rings: d[12], multiple: d[9].includes("-"),
    name: `${d[0]}-${d[1]}-${d[9].includes("-") ? "m" : ""}${d[2]}`,
    joints: (3 * (d[0] - 1) - d[1]) / 2, loops: (3 * (d[0] - 1) - d[1]) / 2 - d[0] + 1,
  }));
  const said = byId("found");
  const fields = ["q", "links", "dof", "assortment", "planar", "joints", "order"].map(byId);
  const withLinkages = byId("linkages"), cards = byId("cards"), more = byId("more");
  let found = [], shown = 0, toSliders = false;      // toSliders: cards lead to the mechanisms with sliders

  function card(c) {
    const item = document.createElement("li"), link = document.createElement("a");
    const name = document.createElement("span"), note = document.createElement("span");
    link.href = toSliders && c.sliders ? `sliders-${c.name}.html` : c.places ? `chain-${c.name}.html` : `chain.html#${c.name}`;
    name.textContent = c.name;
    note.textContent = c.assortment + (c.linkages ? `, ${c.linkages} linkage${c.linkages > 1 ? "s" : ""}` : "") +
      (toSliders && c.sliders ? `, ${c.sliders} with sliders` : "");
    note.className = "hint";
    link.setAttribute("aria-label", `Chain ${c.number} with ${c.links} links, F = ${c.dof}, ` +
      `${c.multiple ? "multiple joints, " : ""}assortment ${c.assortment}`);
    link.append(name, note);
    item.append(link);
    const draw = (places, rings) => {
      const svg = atlasBlocks.picture(places, rings, -1, false);
      svg.setAttribute("aria-hidden", "true");
      if (link.firstChild.tagName === "svg") link.firstChild.remove();
      link.prepend(svg);
    };
    draw(c.places || [0, 0], c.rings || []);
    if (!c.places) atlasBlocks.load(c.name, (chain) => draw(chain[1], chain[2]), () => undefined);
    return item;
  }

  function showMore() {
    const next = found.slice(shown, shown + STEP);
    cards.append(...next.map(card));
    shown += next.length;
    more.hidden = shown >= found.length;
    const all = found.length === chains.length ? "" : ` of ${chains.length}`;
    byId("count").textContent = `${found.length}${all} chain${chains.length === 1 ? "" : "s"}` +
      (shown < found.length ? `, the first ${shown} shown` : "");
  }

  // Chains of this atlas that are the same as one of those given.
  function matching(given) {
    const fits = (c, chain) => c.links === chain.links && c.joints === chain.joints &&
      atlasFind.same(c.chain = c.chain || atlasFind.read(c.graph6), chain);
    return chains.filter((c) => given.some((chain) => fits(c, chain)));
  }

  // The chains of this atlas for a machine: with all links on its pins, and those with simple joints that stand for it.
  function stands(pins) {
    const whole = atlasFind.fromPins(pins), exact = whole.error ? [] : matching([whole]);
    return { whole, exact, simple: whole.n > whole.links ? matching(atlasFind.expand(pins).chains || []) : [] };
  }

  // Say what a chain is, and which page it has.
  function describe(chain, what, hits) {
    const freedom = 3 * (chain.links - 1) - 2 * chain.joints, fault = atlasFind.fault(chain), shared = chain.n - chain.links;
    const size = `${what}: ${chain.links} links, ${chain.joints} joints` +
      `${shared ? `, ${shared} pin${shared > 1 ? "s" : ""} of several links` : ""}, F = ${freedom}`;
    if (hits.length) return `${size}; this is chain ${hits.map((c) => c.name).join(", ")}.`;
    return `${size}; ${fault ? fault : "this chain is not in this atlas"}.`;
  }

  // The chains that the text asks for, as a test; and what to say about it.
  function understand(text) {
    if (!text.trim()) return { test: () => true, say: "" };
    const form = text.trim().replace(/\s+/g, " ");
    if (/^\(.*\d-\d/.test(form) && !form.includes(":")) {
      return { test: (c) => c.form === form, say: `Chains of the structure ${form}.` };
    }
    const chain = atlasFind.read(text);
    if (chain && chain.error) return { test: () => false, say: `This is no chain: ${chain.error}.` };
    if (chain) {
      const hits = matching([chain]), what = chain.notation[0].toUpperCase() + chain.notation.slice(1);
      const drawn = chain.slides && hits.some((c) => c.sliders);
      return { test: (c) => hits.includes(c), sliders: drawn,
        say: describe(chain, what, hits) + (drawn ? " Its picture leads to the mechanisms of this chain with sliders." : "") };
    }
    const machines = atlasFind.machines(text);
    if (machines.length) {
      const all = new Set(), lines = machines.map((m) => {
        const names = (hits) => hits.map((c) => c.name).join(", ");
        const { exact, simple } = stands(m.pins);
        exact.concat(simple).forEach((c) => all.add(c));
        if (!exact.length && !simple.length) return `${m.name}: not in this atlas`;
        if (m.pins.every((p) => p.length === 2)) return `${m.name}: chain ${names(exact)}`;
        return `${m.name}: ${exact.length ? `chain ${names(exact)}; ` : ""}some pins join several links` +
          (simple.length ? `, with simple joints it is chain ${names(simple)}` : "");
      });
      return { test: (c) => all.has(c), say: lines.join("; ") + "." };
    }
    const words = atlasFind.words(text);
    const unknown = words.rest.filter((w) => !chains.some((c) => c.graph6.toLowerCase() === w));
    if (!words.rest.length) return { test: words.test, say: "", sliders: words.sliders };
    return { test: (c) => words.test(c) && words.rest.every((w) => c.graph6.toLowerCase() === w),
      say: unknown.length ? `\u201c${unknown.join(" ")}\u201d means nothing here. Try: 10 links planar symmetric, 3 loops, F = 2, ` +
        "4+2, 8-1-3, Watt, Jansen, or paste a chain in any notation." : "" };
  }

  function search() {
    const [q, links, dof, assortment, planar, joints, order] = fields.map((f) => f.value);
    const wanted = understand(q);
    toSliders = Boolean(wanted.sliders);
    said.textContent = wanted.say;
    byId("q").rows = Math.min(8, q.split("\n").length);
    found = chains.filter((c) => wanted.test(c) &&
      (links === "" || c.links === Number(links)) && (dof === "" || c.dof === Number(dof)) &&
      (assortment === "" || c.assortment === assortment) && (planar === "" || c.planar === Number(planar)) &&
      (joints === "" || c.multiple === (joints === "multiple")) &&
      (!withLinkages.checked || c.linkages > 0));
    if (order === "symmetry") found.sort((a, b) => b.symmetry - a.symmetry);
    if (order === "grounds") found.sort((a, b) => a.grounds - b.grounds);
    cards.replaceChildren();
    shown = 0;
    showMore();
  }

  function fill(select, values) {
    for (const value of values) {
      const option = document.createElement("option");
      option.value = option.textContent = String(value);
      select.append(option);
    }
  }

  function distinct(of) {
    return Array.from(new Set(chains.map(of)));
  }

  // The filter stands in the address, so that a link or the back button brings it again.
  function remember() {
    const p = new URLSearchParams();
    for (const f of fields) if (f.value) p.set(f.id, f.value);
    if (withLinkages.checked) p.set("linkages", "1");
    window.history.replaceState(null, "", "#" + p.toString());
    search();
  }

  function recall() {
    const p = new URLSearchParams(window.location.hash.slice(1));
    for (const f of fields) f.value = p.get(f.id) || "";
    withLinkages.checked = p.has("linkages");
    for (const f of fields) if (f.selectedIndex === -1) f.value = "";
    search();
  }

  function move(event) {
    const links = Array.from(cards.querySelectorAll("a")), at = links.indexOf(document.activeElement);
    if (at < 0 || event.ctrlKey || event.altKey || event.metaKey) return;
    const top = links[0].offsetTop, columns = Math.max(links.findIndex((a) => a.offsetTop > top), 1);
    const step = { ArrowLeft: -1, ArrowRight: 1, ArrowUp: -columns, ArrowDown: columns }[event.key];
    let to = event.key === "Home" ? 0 : event.key === "End" ? links.length - 1 : step ? at + step : at;
    if (to >= links.length && !more.hidden) {
      showMore();
      return move(event);
    }
    to = Math.min(Math.max(to, 0), links.length - 1);
    if (to === at) return undefined;
    event.preventDefault();
    links[to].focus();
    return undefined;
  }

  fill(byId("links"), distinct((c) => c.links).sort((a, b) => a - b));
  fill(byId("dof"), distinct((c) => c.dof).sort((a, b) => a - b));
  fill(byId("assortment"), distinct((c) => c.assortment));
  for (const f of fields) f.addEventListener("input", remember);
  withLinkages.addEventListener("input", remember);
  byId("joints").parentElement.hidden = !chains.some((c) => c.multiple);
  withLinkages.parentElement.hidden = !chains.some((c) => c.linkages > 0);
  byId("clear").addEventListener("click", () => {
    for (const f of fields) f.value = "";
    withLinkages.checked = false;
    remember();
  });
  more.addEventListener("click", () => {
    const first = shown;
    showMore();
    const next = cards.children[first];
    if (next) next.firstElementChild.focus();
  });
  cards.addEventListener("keydown", move);
  document.addEventListener("keydown", (event) => {
    const typing = /^(input|select|textarea)$/i.test(document.activeElement.tagName);
    if (event.key === "/" && !typing) {
      event.preventDefault();
      byId("q").focus();
    }
  });
  window.addEventListener("hashchange", () => {
    recall();
    byId("chains").scrollIntoView();
  });

  const sketch = new atlasSketch.Sketch(byId("sheet"), (pins, links) => {
    const shared = pins.filter((p) => p.length > 1), loose = pins.filter((p) => p.length === 1);
    let say = "";
    if (links > 0 && (links < 3 || shared.length < 3)) say = `${links} link${links > 1 ? "s" : ""}: go on until the chain is closed.`;
    else if (links > 0) {
      const { whole, exact, simple } = stands(shared), hits = exact.concat(simple);
      if (whole.error) say = `This is no chain: ${whole.error}.`;
      else say = describe(whole, "Sketch", exact);
      if (simple.length) say += ` With simple joints it is chain ${simple.map((c) => c.name).join(", ")}.`;
      if (loose.length) say += ` ${loose.length} free end${loose.length > 1 ? "s" : ""}.`;
      toSliders = false;
      found = hits;
      said.textContent = "";
      cards.replaceChildren();
      shown = 0;
      showMore();
    } else search();
    byId("sketched").textContent = say;
  });
  byId("undo").addEventListener("click", () => sketch.undo());
  byId("wipe").addEventListener("click", () => sketch.clear());
  document.querySelector(".sketch").hidden = false;
  document.querySelector(".filter").hidden = false;
  document.querySelector(".keys").hidden = false;
  recall();
})();
