// The search of an atlas in Chromium or Firefox, opened from the disk; no package is needed.   node atlas_search.mjs FOLDER BROWSER
// FOLDER: an atlas of all chains with 4, 6 and 8 links, with multiple joints, and with sliders for 6 links.
import { readdirSync, readFileSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";

const [folder, program] = [resolve(process.argv[2]), process.argv[3]], firefox = program.includes("firefox");
const { launch } = await import(firefox ? "./firefox.mjs" : "./chromium.mjs");
const browser = await launch(program);
let passed = 0, failed = 0;

function check(what, condition) {
  condition ? passed++ : failed++;
  if (!condition) console.log(`FAIL ${what}`);
}

async function open(file, size = {}) {
  const page = await browser.page(size), url = `${pathToFileURL(folder).href}/${file}`;
  page.to = async (address) => {
    await (firefox ? page.command("WebDriver:Navigate", { url: address }) : page.send("Page.navigate", { url: address }));
    await page.until(`document.readyState === "complete" && location.href === ${JSON.stringify(address)}`);
  };
  await page.to(url);
  return page;
}

// What the cards lead to when the text stands in the search, and what is said.
const ask = (page, text) => page.run(`(() => {
  const q = document.getElementById("q"), more = document.getElementById("more");
  q.value = ${JSON.stringify(text)};
  q.dispatchEvent(new Event("input", { bubbles: true }));
  while (!more.hidden) more.click();
  return { said: document.getElementById("found").innerText,
    hits: Array.from(document.querySelectorAll("#cards a"), (a) => a.getAttribute("href").replace(/^chain-|\\.html$/g, "")) };
})()`);

const unescaped = (html) => html.replace(/&lt;/g, "<").replace(/&gt;/g, ">").replace(/&quot;/g, '"').replace(/&#39;/g, "'").replace(/&amp;/g, "&");
const page = await open("index.html");

// every notation of every chain, and an 0/1 matrix with other numbers of the links
const kinds = new Map();
for (const file of readdirSync(folder).filter((f) => f.startsWith("chain-"))) {
  const name = file.replace(/^chain-|\.html$/g, ""), html = readFileSync(`${folder}/${file}`, "utf8");
  for (const [, notation, text] of html.matchAll(/<h3>([^<]*)<\/h3><button[^]*?<code>([^<]*)<\/code>/g)) {
    const { hits, said } = await ask(page, unescaped(text));
    check(`${name}, ${notation}: ${hits}: ${said}`, hits.join() === name && said.includes(`chain ${name}`));
    kinds.set(notation, (kinds.get(notation) || 0) + 1);
    if (notation !== "joints") continue;
    const n = Number(name.split("-")[0]), pairs = text.split(" ").map((w) => w.split("-").map((i) => (Number(i) * 3) % n));
    const unique = n === 6 ? null : Array.from({ length: n }, (_, i) => Array.from({ length: n }, (_, k) =>
      Number(pairs.some(([a, b]) => (a === i && b === k) || (a === k && b === i)))).join("")).join("\n");
    if (unique) check(`${name}, 0/1 matrix`, (await ask(page, unique)).hits.join() === name);
  }
}
check(`notations: ${[...kinds]}`, kinds.size === 7 && kinds.get("pins") === 46 && kinds.get("sentence") === 19);

const only = (list) => (hits) => hits.join() === list;
for (const [text, good] of [["Watt", (h) => h.length === 2 && h[0] === "4-1-1"], ["Stephenson", (h) => h.length === 1], ["Klann", (h) => h.length >= 1],
  ["Jansen", (h) => h.some((c) => c.startsWith("8-1-m"))], ["Theo", (h) => h.length > 1], ["Ackermann", only("4-1-1")],
  ["6 links simple joints", only("6-1-1,6-1-2")], ["10 links", only("")], ["8 links", (h) => h.length === 60], ["3 loops", (h) => h.length === 60],
  ["planar", (h) => h.length === 65], ["not planar", only("")], ["symmetric", (h) => h.length > 20],
  ["8 links multiple joints", (h) => h.length === 44], ["6 links sliders", only("sliders-6-1-1,sliders-6-1-2")],
  ["8-1-1", only("8-1-1")], ["8-1-m1", only("8-1-m1")], ["wat", only("")], ["lin", only("")]]) {
  const { hits, said } = await ask(page, text);
  check(`${text}: ${hits}: ${said}`, good(hits));
}

// a chain drawn with the mouse: frame, crank, coupler and rocker
await ask(page, "");
await page.run("document.querySelector('.sketch').open = true");
await page.run("document.getElementById('sheet').scrollIntoView()");
const [x, y, unit] = await page.run("(() => { const b = document.getElementById('sheet').getBoundingClientRect(); return [b.x, b.y, b.width / 640]; })()");
for (const [x1, y1, x2, y2] of [[100, 300, 300, 300], [105, 297, 140, 200], [140, 203, 280, 160], [283, 158, 302, 304]])
  await page.stroke([[x1, y1], [(x1 + x2) / 2, (y1 + y2) / 2], [x2, y2]].map(([px, py]) => [x + px * unit, y + py * unit]));
const said = await page.run("document.getElementById('sketched').innerText");
check(`sketch: ${said}`, said.includes("chain 4-1-1"));

// on a phone the search stands first: at the top of the first screen, before pictures and tables
const phone = await open("index.html", { width: 360, height: 740, mobile: true });
const top = await phone.run(`(() => { const at = (s) => document.querySelector(s).getBoundingClientRect().top;
  return { q: at("#q"), cards: at("#cards"), table: at("table"), high: innerHeight }; })()`);
check(`phone: ${JSON.stringify(top)}`, top.q < 0.5 * top.high && top.q < top.cards && top.q < top.table);

await browser.close();
console.log(`search in ${firefox ? "Firefox" : "Chromium"}: ${passed} passed, ${failed} failed`);
process.exit(failed ? 1 : 0);
