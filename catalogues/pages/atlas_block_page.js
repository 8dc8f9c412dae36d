"use strict";
// chain.html#P-F-N: the page of a chain of a large family, from its block.
(function () {
  const home = document.getElementById("chain"), steps = document.getElementById("steps"), title = document.querySelector("h1");
  const atlas = document.title;

  function add(parent, name, text, attributes) {
    const e = document.createElement(name);
    if (text) e.textContent = text;
    for (const key of Object.keys(attributes || {})) e.setAttribute(key, attributes[key]);
    parent.append(e);
    return e;
  }

  function step(words, href, rel) {
    add(add(steps, "li"), "a", words, rel ? { href, rel } : { href });
  }

  function figure(parent, ...args) {
    const svg = atlasBlocks.picture(...args);
    svg.setAttribute("role", "img");
    add(parent, "figure").append(svg);
    return svg;
  }

  function grounds(all) {
    add(home, "h2", "Ground links", { id: "inversions" });
    const list = add(home, "div", "", { class: "inversions" });
    for (const [link, alike, places, rings, rows, n] of all) {
      const article = add(list, "article"), name = `Ground link ${link}${alike > 1 ? `, one of ${alike} alike` : ""}`;
      add(article, "h3", name);
      figure(article, places, rings, link - 1, false).setAttribute("aria-label", name);
      if (!rows.length) continue;
      const table = add(add(article, "div", "", { class: "scroll", tabindex: "0" }), "table");
      const head = add(add(table, "thead"), "tr"), names = ["Joints", "Input", "Assur groups", "Modes"], body = add(table, "tbody");
      for (const column of names) add(head, "th", column, { scope: "col" });
      for (const row of rows) {
        const line = add(body, "tr");
        row.forEach((value, i) => add(line, "td", value === 0 ? "" : String(value), { "data-label": names[i] }));
      }
      if (n > rows.length) add(article, "p", `and ${n - rows.length} more in the catalogue`, { class: "hint" });
    }
  }

  function show(links, dof, multiple, number, chain, of) {
    const [linkages, places, rings, facts, notations, ground] = chain;
    const family = `${links} links, F = ${dof}${multiple ? ", multiple joints" : ""}`;
    title.textContent = `Chain ${number} of ${of}: ${family}`;
    document.title = title.textContent;
    step(family, `index.html#links=${links}&dof=${dof}${multiple ? "&joints=multiple" : ""}`);
    if (number > 1) step("Previous", `#${links}-${dof}-${multiple}${number - 1}`, "prev");
    if (number < of) step("Next", `#${links}-${dof}-${multiple}${number + 1}`, "next");
    const first = add(home, "div", "", { class: "first" });
    figure(first, places, rings, -1, true).setAttribute("aria-label", "The chain, its links numbered");
    const table = add(first, "table", "", { class: "facts" });
    for (const [name, text] of facts) {
      const row = add(table, "tr");
      add(row, "th", name, { scope: "row" });
      add(row, "td", text);
    }
    if (linkages)
      add(add(home, "p", "", { class: "linkages" }), "a", `${linkages} linkage${linkages > 1 ? "s" : ""}, moving`,
        { href: `linkages-${links}-${dof}-${number}.html` });
    add(home, "h2", "Notations", { id: "notations" });
    const list = add(home, "div", "", { class: "notations" });
    for (const [name, text] of notations) {
      const part = add(list, "div", "", { class: "notation" });
      add(part, "h3", name);
      add(add(part, "button", "Copy", { type: "button", class: "copy" }), "span", ` ${name}`, { class: "unseen" });
      add(add(part, "pre", "", { tabindex: "0" }), "code", text);
    }
    grounds(ground);
  }

  function open() {
    const match = /^#(\d+)-(\d+)-(m?)(\d+)$/.exec(window.location.hash);
    home.replaceChildren();
    while (steps.children.length > 1) steps.lastChild.remove();
    document.title = atlas;
    title.textContent = "A chain";
    const none = () => add(home, "p", match ? `There is no chain ${match[0].slice(1)} in this atlas.` : "Choose a chain in the overview.");
    if (!match) none();
    else atlasBlocks.load(match[0].slice(1), (chain, of) => {
      if (window.location.hash === match[0]) show(match[1], match[2], match[3], Number(match[4]), chain, of);
    }, none);
  }

  window.addEventListener("hashchange", open);
  open();
})();
