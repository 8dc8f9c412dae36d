// The studio in a headless browser: what a person does with pointer and keys, checked by what is on the page and by what
// the server was asked.   node studio.mjs LINKWRIGHT BROWSER [long] [PICTURES]
import { spawn, execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

const [, , program, chromium, long, pictures] = process.argv;
const folder = mkdtempSync(join(tmpdir(), "linkwright-studio-"));
const environment = { ...process.env, XDG_STATE_HOME: join(folder, "state"), XDG_CACHE_HOME: join(folder, "cache") };
let passed = 0, failed = 0;

const check = (what, condition) => { if (!condition) throw new Error(what); };
const sleep = (ms) => new Promise((go) => { setTimeout(go, ms); });
const servers = new Set();

async function serve(...words) {
  const child = spawn(program, ["studio", "--no-browser", "--quiet", ...words], { env: environment });
  servers.add(child);
  const address = await new Promise((yes, no) => {
    let text = "";
    child.stdout.on("data", (d) => { text += d; if (text.includes("\n")) yes(text.trim()); });
    child.on("exit", (code) => no(new Error(`the studio ended with ${code}`)));
  });
  return { address, child, async end(signal = "SIGINT") {
    const over = new Promise((yes) => { child.on("exit", yes); });
    child.kill(signal);
    servers.delete(child);
    return over;
  } };
}

const firefox = /firefox/.test(chromium);
const { launch } = await import(firefox ? "./firefox.mjs" : "./chromium.mjs");
const browser = await launch(chromium);
let server, page;

// LW_ONLY=words: only the tests whose names match.
async function test(name, run) {
  if (process.env.LW_ONLY && !new RegExp(process.env.LW_ONLY).test(name)) return;
  const start = Date.now();
  try {
    await run();
    check(`faults on the page: ${page.faults.join("; ")}`, page.faults.length === 0);
    passed++;
    if (process.env.LW_VERBOSE) console.log(`  ${name}: ${Date.now() - start} ms`);
  } catch (error) {
    failed++;
    console.log(`FAIL ${name}: ${error.message}`);
    console.log(JSON.stringify(await page.run("[studio.tool.name, studio.work, studio.stale, studio.touching, studio.dragging, studio.fault, document.getElementById('note').textContent]").catch(String)));
    if (pictures) writeFileSync(join(pictures, `fail-${failed}.png`), await page.picture().catch(() => ""));
    page.faults.length = 0;
  }
}

async function fresh(...words) {
  if (server) await server.end();
  server = await serve(...words);
  page = await browser.page();
  await page.go(server.address);
}
const doc = () => page.run("studio.doc");
const canvas = async () => page.run("(() => { const b = document.getElementById('canvas').getBoundingClientRect(); return [b.x, b.y, b.width, b.height]; })()");
const screen = async (p) => page.run(`(() => { const b = document.getElementById('canvas').getBoundingClientRect(), v = studio.view, p = ${JSON.stringify(p)}; return [b.x + v.X(p), b.y + v.Y(p)]; })()`);
const curve = () => page.run("document.querySelector('.curves-layer .curve')?.getAttribute('d')");
const joint = (name) => page.run(`studio.doc.linkage.joints.concat(studio.doc.linkage.tracers).find((q) => q.name === "${name}").at`);
const settled = () => page.until("studio.fresh() && !studio.touching && !studio.dragging", "the motion came");

// Drag a point by so many pixels, by way of the places given.
async function pull(name, ...ways) {
  const p = await page.where(`[data-point=${name}]`), old = await joint(name);
  await page.stroke([p, ...ways.map((w) => [p[0] + w[0], p[1] + w[1]])]);
  check(`${name} is dragged`, JSON.stringify(await joint(name)) !== JSON.stringify(old));
}

async function oval(points = 48, cx = 0.45, cy = 0.42, rx = 150, ry = 80) {
  const [x, y, w, h] = await canvas(), out = [];
  for (let i = 0; i <= points; i++) {
    const t = 2 * Math.PI * i / points;
    out.push([x + w * cx + rx * Math.cos(t), y + h * cy - ry * Math.sin(t) * (Math.sin(t) < 0 ? 0.6 : 1)]);
  }
  return out;
}

// ---- touch

await fresh("examples/hoeken.json");
await page.until(`fetch("api/begin", { method: "POST", headers: { "Content-Type": "application/json" }, body: "{}" }).then((r) => r.json()).then((b) => b.atlas === 2)`,
  "the atlas of curves is made");

await test("a file opens, its curve is drawn, nothing is loaded from elsewhere", async () => {
  await settled();
  check("unit of the file", (await doc()).unit === "mm");
  check("no curve", (await curve()).length > 2000);
  check("pivots", (await page.run("document.querySelectorAll('.joint.fixed').length")) === 2);
  check("freedom", (await page.run("document.getElementById('freedom').textContent")).startsWith("F = 1, turns"));
  const elsewhere = page.requests.filter((r) => !r.url.startsWith(server.address) && !r.url.startsWith("blob:") && !r.url.startsWith("data:") && !r.url.startsWith("about:"));
  check(`asked for ${elsewhere.map((r) => r.url)}`, elsewhere.length === 0);
});

await test("drag a joint: the curve follows while the pointer moves, and undo brings it back", async () => {
  const before = await joint("B"), from = await page.where("[data-point=B]"), curves = new Set();
  const n = page.asked("motion").length;
  await page.click("#snap");
  await page.press(from);
  for (let i = 1; i <= 10; i++) {                   // the pointer stays down: each step has a curve of its own
    const old = await curve();
    await page.move([from[0] + 4 * i, from[1] + 2 * i]);
    await page.until(`document.querySelector('.curves-layer .curve').getAttribute('d') !== ${JSON.stringify(old)}`, "the curve follows");
    curves.add(await curve());
  }
  await page.release([from[0] + 40, from[1] + 20]);
  await page.click("#snap");
  check(`the curve stood still: ${curves.size} curves`, curves.size === 10);
  await settled();
  const after = await joint("B"), asked = page.asked("motion").slice(n);
  check("the joint did not move", Math.hypot(after[0] - before[0], after[1] - before[1]) > 1);
  check("1000 points were asked for", asked.length >= 8 && asked.some((r) => JSON.parse(r.body).points === 1000));
  await page.key("z", 2);
  await settled();
  const back = await joint("B");
  check(`undo: ${back} for ${before}`, Math.hypot(back[0] - before[0], back[1] - before[1]) < 1e-9);
  await page.key("y", 2);
  await settled();
  check("redo", Math.hypot(...(await joint("B")).map((v, i) => v - after[i])) < 1e-9);
  await page.key("z", 2);
  await settled();
});

await test("drag a pivot and the tracer", async () => {
  for (const name of ["C", "P"]) {
    const old = await curve(), p = await page.where(`[data-point=${name}]`);
    await page.stroke([p, [p[0] + 6, p[1] + 3], [p[0] + 14, p[1] + 9]]);
    await page.until(`document.querySelector('.curves-layer .curve')?.getAttribute('d') !== ${JSON.stringify(old)}`, `${name} changes the curve`);
    await page.key("z", 2);
    await settled();
  }
});

await test("locked lengths stay while a joint is dragged", async () => {
  await page.click("#tab-mechanism");
  await page.until("studio.analysis");
  await page.click("[aria-label='Lock the lengths of rocker']");
  await page.click("[aria-label='Lock the lengths of crank']");
  const length = async (a, b) => { const [p, q] = [await joint(a), await joint(b)]; return Math.hypot(p[0] - q[0], p[1] - q[1]); };
  const rocker = await length("B", "C"), crank = await length("O", "A"), coupler = await length("A", "B");
  await pull("B", [10, 10], [40, 30]);
  await settled();
  check("rocker", Math.abs((await length("B", "C")) - rocker) < 1e-9 * rocker);
  check("crank", Math.abs((await length("O", "A")) - crank) < 1e-9 * crank);
  check("coupler", Math.abs((await length("A", "B")) - coupler) > 0.01);
  await page.key("z", 2);
  await page.key("z", 2);
  await page.key("z", 2);
  await settled();
  check("locks", (await doc()).locked.length === 0);
});

await test("play, speed, scrub", async () => {
  const place = () => page.run("document.querySelector('[data-key=\"link.coupler\"]').getAttribute('d')");
  await page.key("Escape");
  await page.run("document.getElementById('canvas').focus()");
  const first = await place();
  await page.key("Space");
  await page.until(`document.querySelector('[data-key="link.coupler"]').getAttribute('d') !== ${JSON.stringify(first)}`, "it moves");
  await page.click("#play");
  check("it stops", !(await page.run("studio.playing")));
  const at = await page.run("studio.frame");
  await sleep(120);
  check("it stands", (await page.run("studio.frame")) === at);
  const s = await page.run("(() => { const b = document.getElementById('scrub').getBoundingClientRect(); return [b.x, b.y + b.height / 2, b.width]; })()");
  await page.click([s[0] + s[2] / 2, s[1]]);
  await page.until("Math.abs(studio.frame / studio.motion.frames - 0.5) < 0.03", "scrubbed to the middle");
});

await test("keys reach points, and arrows move them", async () => {
  await page.run("document.querySelector('[data-point=P]').focus()");
  const before = await joint("P");
  await page.key("ArrowRight");
  await settled();
  check("the tracer did not move", (await joint("P"))[0] !== before[0] || (await joint("P"))[1] !== before[1]);
  check("the focus is lost", (await page.run("document.activeElement.dataset.point")) === "P");
  check("a label", (await page.run("document.activeElement.getAttribute('aria-label')")).startsWith("Tracer P at"));
  await page.key("z", 2);
  await settled();
});

await test("every button and field has a name", async () => {
  const bare = await page.run(`[...document.querySelectorAll("button, input, select, textarea, [role=button]")].filter((e) => !e.hidden && !(e.getAttribute("aria-label") ||
    e.textContent.trim() || e.labels?.length || e.title)).map((e) => e.outerHTML.slice(0, 80))`);
  check(bare.join(), bare.length === 0);
});

if (pictures) writeFileSync(join(pictures, "touch.png"), await page.picture());

// ---- two windows, a server that ends

await test("two windows do not disturb each other", async () => {
  const first = page;
  const other = page = await browser.page({}, first);
  await page.go(server.address);
  await page.front();
  await settled();
  await pull("C", [9, 0], [30, 9]);
  await settled();
  const there = await joint("C");
  page = first;
  await page.front();
  await settled();
  check("the first window moved too", Math.abs((await joint("C"))[0] - there[0]) > 0.5);
  await Promise.all([pull("P", [9, 0], [18, 0]), other.run("studio.refresh()")]);
  await settled();
  await other.close();
  await page.front();
  await page.key("z", 2);
  await settled();
});

await test("the server is killed and started again: nothing drawn is lost", async () => {
  await settled();
  const before = JSON.stringify((await doc()).linkage);
  await server.end("SIGKILL");
  await pull("P", [9, 0], [22, 4]);
  await page.until("!document.getElementById('offline').hidden", "the page says that the server is gone");
  const drawn = JSON.stringify((await doc()).linkage);
  check("the drag is lost", drawn !== before);
  const old = server.address;
  server = await serve("examples/hoeken.json");
  check(`another address: ${old} ${server.address}`, server.address === old);
  await page.until("document.getElementById('offline').hidden", "the page goes on");
  await settled();
  check("what was drawn is lost", JSON.stringify((await doc()).linkage) === drawn);
  await page.until("location.hash.length > 20");
  await page.reload();
  await page.until("document.documentElement.dataset.ready === 'yes' && window.studio.motion");
  check("a reload loses it", JSON.stringify((await doc()).linkage) === drawn);
});

// Memory of the page without garbage and of the server, elements, connections: nothing of it may grow with the drags.
async function held() {
  const proc = `/proc/${server.child.pid}`, status = readFileSync(`${proc}/status`, "utf8"), n = (word) => Number(status.match(new RegExp(`${word}:\\s+(\\d+)`))[1]);
  return { heap: await page.heap(), elements: await page.run("document.querySelectorAll('*').length"), server: n("VmRSS") * 1024,
    threads: n("Threads"), files: readdirSync(`${proc}/fd`).length };
}

await test(long === "long" ? "50 drags a second for a minute" : "300 drags in a row", async () => {
  await page.key("Escape");
  const seconds = long === "long" ? 60 : 0, p = await page.where("[data-point=B]"), n = page.requests.length, start = Date.now();
  const at = (i) => [p[0] + 14 * Math.sin(i / 9), p[1] + 9 * Math.cos(i / 7)];
  let i = 0, before;
  await page.press(p);
  for (; seconds ? Date.now() - start < 1000 * seconds : i < 300; i++) {
    await page.move(at(i));
    if (seconds) await sleep(Math.max(0, start + 20 * (i + 1) - Date.now()));
    if (!before && i === 100) before = await held();
  }
  await page.until("studio.work === 0 && !studio.touching", "the last drag is answered");
  await page.refresh?.();
  const after = await held();
  const asked = page.requests.slice(n).filter((r) => r.name === "motion"), newest = await page.run("JSON.stringify(studio.doc.linkage)");
  check("the newest is not the last one asked for", JSON.stringify(JSON.parse(asked[asked.length - 1].body).linkage) === newest);
  check("the curve on the drawing is not that of the newest", await page.run("studio.motionOf === studio.doc.linkage && !studio.stale"));
  await page.release(at(i - 1));
  await settled();
  const bad = asked.filter((r) => r.status !== 200 && r.status !== 422);
  check(`${bad.length} requests failed`, bad.length === 0);
  check("two questions were on their way at once", asked.every((r, k) => k === 0 || r.at >= asked[k - 1].done));
  const grown = Object.fromEntries(Object.keys(after).map((k) => [k, after[k] - before[k]]));
  check(`grown: ${JSON.stringify(grown)}`, grown.heap < 3e6 && grown.elements <= 4 && grown.server < 8e6 && grown.threads <= 4 && grown.files <= 4);
  const wire = asked.map((r) => 1000 * (r.done - r.at)).sort((a, b) => a - b);
  if (process.env.LW_VERBOSE || seconds)
    console.log(`  ${i} moves, ${asked.length} motions of 1000 points; over the wire ${wire[wire.length >> 1].toFixed(1)} ms median, ${wire[Math.floor(0.95 * wire.length)].toFixed(1)} ms 95 %; grown ${JSON.stringify(grown)}`);
});

globalThis.T = { firefox, test, check, sleep, fresh, doc, canvas, screen, curve, joint, settled, oval, page: () => page, server: () => server, folder, program, pictures, long: long === "long", browser, environment,
  readFileSync, writeFileSync, join, execFileSync };
for (const more of ["./studio_draw.mjs", "./studio_build.mjs"]) {
  try { await import(more); } catch (error) {
    if (error.code === "ERR_MODULE_NOT_FOUND") continue;
    failed++;
    console.log(`FAIL ${more}: ${error.stack}`);
  }
}

for (const child of servers) child.kill("SIGKILL");
await browser.close();
rmSync(folder, { recursive: true, force: true });
console.log(`test_studio_page: ${passed} passed, ${failed} failed`);
process.exit(failed ? 1 : 0);
