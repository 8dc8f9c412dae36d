"use strict";
// Chains from what people paste and type: a topology in any notation, the name of a machine, words such as "10 links planar".
// A chain is { n, links, joints, edges: [[a, b], ...] } with links 0 .. links-1; a pin of more than two links is one more
// vertex, joined to each of them.  Several chains with simple joints may stand for it.
const atlasFind = (function () {
  const MOST = 64, TREES = 2000;

  // Known machines: other words for them, and the links at each pin.  Sliders count as pins.
  const MACHINES = [
    ["Four-bar", "four bar fourbar 4bar slider crank chebyshev roberts hoecken hoeken evans grasshopper ackermann steering "
      + "trammel scott russell pumpjack level luffing crane grashof crank rocker lambda", "1-2 2-3 3-4 1-4"],
    ["Watt's straight line", "watt watts straight line", "1-2 2-3 3-4 1-4"],
    ["Watt chain", "watt watts six bar", "1-2 1-3 1-5 2-4 2-6 3-4 5-6"],
    ["Stephenson chain", "stephenson stephensons six bar", "1-3 1-5 1-6 2-4 2-5 2-6 3-4"],
    ["Five-bar", "five bar fivebar 5bar", "1-2 2-3 3-4 4-5 1-5"],
    ["Klann leg", "klann walking walker", "1-2 2-3 1-4 3-4 3-5 1-6 5-6"],
    ["Jansen leg", "theo jansen strandbeest beach animal walking walker", "1-2 2-3-4 4-5 1-5-6 3-6-7 5-8 7-8"],
    ["Peaucellier inversor", "peaucellier lipkin straight line", "1-2 2-3-4 1-5-6 3-6-7 4-5-8 7-8"],
    ["Hart inversor", "hart straight line", "1-2 2-3 3-4 4-5 2-5 1-6 3-6"],
    ["Pantograph", "pantograph", "1-2 2-3 2-4 3-5 4-5-6 1-6"],
    ["Windscreen wiper", "windscreen wiper windshield", "1-2 2-3 3-4-5 1-5 4-6 1-6"],
    ["Toggle press", "toggle press sewing machine", "1-2 2-3 3-4-5 1-5 4-6 1-6"],
    ["Excavator bucket", "excavator bucket", "1-2 2-3 3-4-5 1-4 5-6 1-6"],
    ["Umbrella", "umbrella", "1-2-3 3-4 4-5-6 1-5 2-6"],
    ["V-twin engine", "v twin engine", "1-2 2-3-4 4-5 1-5 3-6 1-6"],
    ["Scissor lift", "scissor lift", "1-2 1-3 2-4 3-4 5-6 2-6 1-5 7-8 5-8 6-7 7-9 8-10 9-10"],
    ["Andrews' squeezer", "andrew andrews squeezer seven body", "1-2 2-3 3-4-5-6 1-4 1-7-8 6-8 5-7"],
  ].map(([name, words, pins]) => ({ name, words: words.split(" "), pins: pins.split(" ").map((p) => p.split("-").map(Number)) }));

  // ---- chains -----------------------------------------------------------------------------------------------

  // The chain of the labels on each pin; { error } if a link is twice on a pin, or two links share two pins.
  function fromPins(pins) {
    const labels = new Map(), seen = new Set(), edges = [];
    const id = (label) => {
      if (!labels.has(label)) labels.set(label, labels.size);
      return labels.get(label);
    };
    for (const pin of pins)
      for (const [i, p] of pin.entries())
        for (const q of pin.slice(0, i)) {
          const a = id(String(q)), b = id(String(p)), key = a < b ? `${a} ${b}` : `${b} ${a}`;
          if (a === b) return { error: `link ${p} is joined to itself` };
          if (seen.has(key)) return { error: `links ${q} and ${p} share two joints` };
          seen.add(key);
        }
    const links = labels.size;
    let n = links;
    for (const pin of pins) {
      if (pin.length === 2) edges.push(pin.map((p) => labels.get(String(p))));
      else edges.push(...pin.map((p) => [labels.get(String(p)), n]));
      n += pin.length > 2;
    }
    if (n > MOST) return { error: `more than ${MOST} links` };
    return { n, links, joints: pins.reduce((sum, pin) => sum + pin.length - 1, 0), edges };
  }

  function neighbours(chain) {
    const at = Array.from({ length: chain.n }, () => []);
    for (const [a, b] of chain.edges) {
      at[a].push(b);
      at[b].push(a);
    }
    return at;
  }

  // Colours of the links that do not depend on their numbers: equal for links that a symmetry exchanges.
  function colours(at, links) {
    let colour = at.map((to, i) => to.length + (i < links ? 0 : 100));
    for (let round = 0; round < 5; round++) {
      colour = at.map((to, i) => {
        let h = (colour[i] * 0x9e3779b1) >>> 0;
        for (const c of to.map((k) => colour[k]).sort((a, b) => a - b)) h = (Math.imul(h ^ c, 0x01000193) + 0x7f4a7c15) >>> 0;
        return h;
      });
    }
    return colour;
  }

  function prepared(chain) {
    if (!chain.at) {
      chain.at = neighbours(chain);
      chain.colour = colours(chain.at, chain.links);
      chain.key = `${chain.n} ${chain.edges.length} ${chain.colour.slice().sort((a, b) => a - b).join(" ")}`;
    }
    return chain;
  }

  // Are two chains the same but for the numbers of their links?
  function same(first, second) {
    const a = prepared(first), b = prepared(second);
    if (a.key !== b.key) return false;
    const order = [], placed = new Set();      // each link after a neighbour, if it has one before it
    while (order.length < a.n) {
      const next = a.at.findIndex((to, i) => !placed.has(i) && (to.some((k) => placed.has(k))));
      const i = next >= 0 ? next : a.at.findIndex((_, k) => !placed.has(k));
      placed.add(i);
      order.push(i);
    }
    const to = new Array(a.n).fill(-1), used = new Array(a.n).fill(false);
    const joined = b.at.map((list) => new Set(list));
    const place = (depth) => {
      if (depth === a.n) return true;
      const i = order[depth];
      for (let k = 0; k < b.n; k++) {
        if (used[k] || a.colour[i] !== b.colour[k]) continue;
        if (!a.at[i].every((m) => to[m] < 0 || joined[k].has(to[m]))) continue;
        to[i] = k;
        used[k] = true;
        if (place(depth + 1)) return true;
        to[i] = -1;
        used[k] = false;
      }
      return false;
    };
    return place(0);
  }

  // ---- pins that join several links -------------------------------------------------------------------------

  // All trees on the given links, as lists of edges (Pruefer sequences).
  function trees(links) {
    const k = links.length, all = [];
    if (k === 2) return [[[links[0], links[1]]]];
    for (let code = 0; code < k ** (k - 2); code++) {
      const sequence = Array.from({ length: k - 2 }, (_, i) => Math.floor(code / k ** i) % k);
      const degree = new Array(k).fill(1), edges = [];
      for (const s of sequence) degree[s]++;
      for (const s of sequence) {
        const leaf = degree.indexOf(1);
        edges.push([links[leaf], links[s]]);
        degree[leaf] = 0;
        degree[s]--;
      }
      edges.push(degree.flatMap((d, i) => (d === 1 ? [links[i]] : [])));
      all.push(edges);
    }
    return all;
  }

  // Every chain with simple joints that pins of several links can stand for, each once; { error } if there are too many.
  function expand(pins) {
    const choices = pins.map(trees), total = choices.reduce((n, c) => n * c.length, 1), chains = [];
    if (total > TREES) return { error: "too many links on one pin" };
    for (let i = 0; i < total; i++) {
      let rest = i;
      const chain = fromPins(choices.flatMap((c) => {
        const edges = c[rest % c.length];
        rest = Math.floor(rest / c.length);
        return edges;
      }));
      if (!chain.error && !chains.some((c) => same(c, chain))) chains.push(chain);
    }
    return { chains };
  }

  // ---- notations --------------------------------------------------------------------------------------------

  function readGraph6(text) {
    const word = text.replace(/^>>graph6<</, "");
    if (!/^[?-~]+$/.test(word)) return null;
    const n = word.charCodeAt(0) - 63, pairs = [];
    if (n < 2 || n > MOST - 2 || word.length !== 1 + Math.ceil((n * (n - 1)) / 12)) return null;
    let bit = 0;
    for (let j = 1; j < n; j++)
      for (let i = 0; i < j; i++, bit++)
        if (((word.charCodeAt(1 + Math.floor(bit / 6)) - 63) >> (5 - (bit % 6))) & 1) pairs.push([i, j]);
    const chain = fromPins(pairs);
    return chain.n === n ? chain : null;
  }

  // A square matrix: 0 and 1, or numbers of joints above the diagonal.
  function readMatrix(text) {
    let rows = text.split(/[\n;]+/).map((row) => row.trim()).filter(Boolean);
    if (!rows.every((row) => /^[\d\s,rtpg[\]{}()|]+$/.test(row))) return null;
    rows = rows.map((row) => (row.match(/\d+[rtpg]?/g) || []));
    if (rows.every((row) => row.length === 1 && row[0].length === rows.length)) rows = rows.map((row) => row[0].split(""));
    if (rows.length === 1) {                                  // all in one line
      const n = Math.sqrt(rows[0].length);
      if (!Number.isInteger(n)) return null;
      rows = Array.from({ length: n }, (_, i) => rows[0].slice(i * n, i * n + n));
    }
    const n = rows.length, pairs = [];
    if (n < 3) return null;
    if (!rows.every((row) => row.length === n)) return { error: `a matrix of ${n} rows needs ${n} numbers in each` };
    const value = (i, j) => parseInt(rows[i][j], 10);
    for (let i = 0; i < n; i++) {
      if (value(i, i) !== 0) return { error: `the matrix joins link ${i + 1} to itself` };
      for (let j = i + 1; j < n; j++) {
        if (value(j, i) !== 0 && value(i, j) !== value(j, i)) return { error: `entries ${i + 1}, ${j + 1} of the matrix differ` };
        if (value(i, j) !== 0) pairs.push([i + 1, j + 1]);
      }
    }
    return fromPins(pairs);
  }

  function readEdges(text) {
    const plain = text.replace(/[@>]\s*\d+/g, " ").trim();
    const words = plain.split(/[\s,;]+/).filter(Boolean);
    if (words.length < 3 || !words.every((w) => /^\d+([-\u2013]\d+)+(:[rtpg])?!?$/.test(w))) return null;
    return fromPins(words.map((w) => w.match(/\d+/g)));
  }

  function readSentence(text) {
    if (!/^\(\s*(basis\b|\()/i.test(text)) return null;
    const words = text.replace(/;[^\n]*/g, "").match(/\(\s*\d+[^()]*\)/g);
    if (!words) return { error: "a sentence has words such as (1 r 2 r 3 r 4 r)" };
    const pairs = new Map();
    for (const word of words) {
      const parts = word.match(/\d+/g), joints = word.match(/[rtpg]/gi) || [];
      if (joints.length !== parts.length && joints.length !== parts.length - 1)
        return { error: `the word ${word} needs a joint after each link` };
      parts.forEach((p, i) => {
        const q = parts[(i + 1) % parts.length];
        pairs.set([p, q].sort().join(" "), [p, q]);
      });
    }
    return fromPins([...pairs.values()]);
  }

  function readFranke(text) {
    const match = /^\(([\d\s,]*)\)\s*((?:\d+-\d+)?:\d+(?:\s+\d+-\d+:\d+)*)$/.exec(text);
    if (!match) return null;
    const degree = (match[1].match(/\d+/g) || []).map(Number), met = new Array(degree.length).fill(0), pairs = [];
    let next = degree.length + 1;
    for (const line of match[2].split(/\s+/)) {
      const [from, to, count] = line.includes("-") ? line.match(/\d+/g).map(Number) : [0, 0, Number(line.slice(1))];
      if (from === 0) {
        for (let i = 0; i < count; i++) pairs.push([i, (i + 1) % count]);
        continue;
      }
      if (from > degree.length || to > degree.length) return { error: `there is no circle ${Math.max(from, to)}` };
      let last = from;
      met[from - 1]++;
      met[to - 1]++;
      for (let i = 0; i < count; i++) {
        pairs.push([last, next]);
        last = next++;
      }
      pairs.push([last, to]);
    }
    const wrong = degree.findIndex((d, i) => d !== met[i]);
    if (wrong >= 0) return { error: `circle ${wrong + 1} has ${met[wrong]} joints, not ${degree[wrong]}` };
    return fromPins(pairs);
  }

  function readDrawnGraph(text) {
    const pairs = /<graph/i.test(text)
      ? Array.from(text.matchAll(/<edge\b[^>]*>/gi), ([e]) => [/source="([^"]*)"/.exec(e), /target="([^"]*)"/.exec(e)])
        .filter(([a, b]) => a && b).map(([a, b]) => [a[1], b[1]])
      : Array.from(text.matchAll(/([\w.]+)\s*--\s*(?=([\w.]+))/g), (m) => [m[1], m[2]]);
    return pairs.length > 2 ? fromPins(pairs) : null;
  }

  // A chain from text in any notation, with the name of the notation; { error } if it is one, but wrong; null if it is none.
  function read(text) {
    const readers = [["sentence", readSentence], ["Franke's notation", readFranke], ["graph", readDrawnGraph],
      ["list of joints", readEdges], ["matrix", readMatrix], ["graph6", readGraph6]];
    for (const [notation, reader] of readers) {
      const chain = reader(text.trim());
      if (chain) return { ...chain, notation, slides: /\dt|\bt\b/.test(text) && notation !== "graph6" };
    }
    return null;
  }

  // What keeps a chain from moving as a whole, in words; "" if nothing was found.
  function fault(chain) {
    const { at } = prepared(chain);
    const reach = (without) => {
      const seen = new Set(), open = [without === 0 ? 1 : 0];
      while (open.length) {
        const i = open.pop();
        if (i === without || seen.has(i)) continue;
        seen.add(i);
        open.push(...at[i]);
      }
      return seen.size;
    };
    if (reach(-1) < chain.n) return "it falls apart into separate pieces";
    if (at.some((to) => to.length < 2)) return "a link has fewer than two joints";
    for (let i = 0; i < chain.n; i++)
      if (reach(i) < chain.n - 1) return `it falls apart where one ${i < chain.links ? "link" : "pin"} is taken out`;
    const freedom = 3 * (chain.links - 1) - 2 * chain.joints;
    if (freedom < 1) return "it cannot move";
    return "";
  }

  // ---- words ------------------------------------------------------------------------------------------------

  const NUMBERS = ["zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve",
    "thirteen", "fourteen"];
  const GENERAL = new Set(["linkage", "linkages", "mechanism", "mechanisms", "chain", "leg", "the", "a", "of", "s"]);

  function machines(text) {
    const words = text.toLowerCase().replace(/[\u2019']s\b/g, "").split(/[^a-z0-9]+/).filter((w) => w && !GENERAL.has(w));
    return words.length ? MACHINES.filter((m) => words.every((w) => m.words.includes(w))) : [];
  }

  // Conditions from words; `rest` holds the words that mean nothing here.
  function words(text) {
    const tests = [];
    let rest = ` ${text.toLowerCase()} `.replace(new RegExp(`\\b(${NUMBERS.join("|")})\\b`, "g"), (w) => NUMBERS.indexOf(w));
    const take = (pattern, make) => {
      rest = rest.replace(pattern, (...match) => {
        tests.push(make(match));
        return " ";
      });
    };
    take(/\b(\d+-\d+-m?\d+)\b/g, (m) => (c) => c.name === m[1]);
    take(/\b(?:no multiple|simple) joints?\b/g, () => (c) => !c.multiple);
    take(/\bmultiple(?: joints?)?\b/g, () => (c) => c.multiple);
    let sliders = false;
    take(/\bsliders?\b/g, () => {
      sliders = true;
      return (c) => c.sliders > 0;
    });
    take(/\b(\d+(?:\+\d+)+)\b/g, (m) => (c) => c.assortment === m[1].replace(/\+/g, " "));
    take(/\b(?:not[- ]planar|non-?planar)\b/g, () => (c) => !c.planar);
    take(/\bplanar\b/g, () => (c) => c.planar);
    take(/\b(?:asymmetric|not symmetric|no symmetry)\b/g, () => (c) => c.symmetry === 1);
    take(/\b(?:symmetric|symmetrical|symmetry)\b/g, () => (c) => c.symmetry > 1);
    take(/\b(\d+)[- ]*(?:links?|bars?|members?)\b|\b(?:links?|p)\s*=\s*(\d+)\b/g, (m) => (c) => c.links === Number(m[1] || m[2]));
    take(/\b(\d+)[- ]*loops?\b|\b(?:loops?|l)\s*=\s*(\d+)\b/g, (m) => (c) => c.loops === Number(m[1] || m[2]));
    take(/\b(\d+)[- ]*joints?\b|\bjoints?\s*=\s*(\d+)\b/g, (m) => (c) => c.joints === Number(m[1] || m[2]));
    take(/\b(\d+)[- ]*(?:dof|freedoms?|degrees? of freedom)\b|\b(?:f|dof)\s*=?\s*(\d+)\b/g,
      (m) => (c) => c.dof === Number(m[1] || m[2]));
    take(/\bwith linkages?\b/g, () => (c) => c.linkages > 0);
    take(/\b(?:chains?|and|with)\b|,/g, () => () => true);
    return { test: (c) => tests.every((t) => t(c)), rest: rest.trim().split(/\s+/).filter(Boolean), sliders };
  }

  return { read, same, fromPins, expand, fault, machines, words };
})();
