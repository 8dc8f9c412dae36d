// The studio, second part: drawing, nearest mechanisms, conditions, search, results, taking away.
const { firefox, test, check, sleep, fresh, doc, canvas, screen, settled, oval, server, folder, program, pictures, long, readFileSync, writeFileSync, join, execFileSync } = globalThis.T;
const page = () => globalThis.T.page();

// Drop files on the drawing, as a file manager does.
async function drop(files) {
  await page().run(`(async () => { const t = new DataTransfer(); for (const [name, type, data, binary] of ${JSON.stringify(files)})
    t.items.add(new File([binary ? Uint8Array.from(atob(data), (c) => c.charCodeAt(0)) : data], name, { type }));
    document.getElementById("canvas").dispatchEvent(new DragEvent("drop", { dataTransfer: t, bubbles: true, cancelable: true })); })()`);
}
const anchors = async () => (await doc()).path.anchors;
const undoAll = async () => { for (let i = 0; i < 60 && (await page().run("studio.past.length")); i++) await page().key("z", 2); };

await fresh();

await test("a smooth curve by hand: closed, stations on it, undo, redo", async () => {
  const p = page();
  await p.click("[data-tool=Curve]");
  await p.stroke(await oval());
  const path = (await doc()).path;
  check(`anchors: ${path.anchors.length}`, path.anchors.length >= 8 && path.anchors.length < 48);
  check("closed", path.closed);
  await p.until("studio.stations.length === 36", "36 stations");
  check("the server made them", p.asked("target").length > 0);
  check("drawn", (await p.run("document.querySelectorAll('.station').length")) === 36);
  // on the oval: x^2/150^2 + y^2/80^2 = 1 in pixels, in the upper half
  const s = await p.run("studio.stations.map((q) => [q[0] * studio.view.scale, q[1] * studio.view.scale])"), xs = s.map((q) => q[0]);
  check("as wide as drawn", Math.abs(Math.max(...xs) - Math.min(...xs) - 300) < 8);
  await p.key("z", 2);
  check("undo", (await anchors()).length === 0);
  await p.key("y", 2);
  check("redo", (await anchors()).length === path.anchors.length);
});

await test("the nearest mechanisms appear while one draws, and move", async () => {
  const p = page(), n = p.asked("nearest").length;
  check("asked while drawing", n > 0);
  await p.until("document.querySelectorAll('#nearest .little svg .link').length > 6", "five of them move");
  const at = "document.querySelector('#nearest .little .link').getAttribute('d')", first = await p.run(at);
  await p.until(`${at} !== ${JSON.stringify(first)}`, "they move");
  if (long) check(`the atlas took ${await p.run("studio.nearestMs")} ms`, (await p.run("studio.nearestMs")) < 100);
  if (pictures) writeFileSync(join(pictures, "draw.png"), await p.picture());
  await p.click("#nearest .little");
  await settled();
  check("taken", (await doc()).linkage.joints.length >= 4);
  await p.key("z", 2);
});

await test("points, lines, snap; a click on the first point closes; a point is dragged", async () => {
  const p = page(), [x, y] = await canvas();
  await undoAll();
  await p.click("#tab-path");
  await p.click("[data-tool=Lines]");
  for (const q of [[200, 200], [400, 210], [390, 400], [210, 380], [200, 200]]) await p.click([x + q[0], y + q[1]]);
  let path = (await doc()).path;
  check(`four corners, closed: ${path.anchors.length}`, path.anchors.length === 4 && path.closed && path.mode === "lines");
  await p.until("studio.stations.length === 36");
  const corner = path.anchors[1];
  check("a corner is a station", (await p.run("studio.stations")).some((s) => Math.hypot(s[0] - corner[0], s[1] - corner[1]) < 1e-6));
  const from = await screen(path.anchors[2]);
  await p.stroke([from, [from[0] + 10, from[1] + 5], [from[0] + 30, from[1] + 21]]);
  check("dragged", (await anchors())[2][0] > path.anchors[2][0] && (await anchors()).length === 4);
  await p.choose("#panel-path select", "points");
  await p.until("studio.stations.length === 4", "points are the stations");
  await p.click("#clear-path");
  check("cleared", (await anchors()).length === 0);
  await p.click("[data-tool=Points]");
  const g = await p.run("(() => { const v = studio.view, s = v.step(); return [v.X([2 * s, s]), v.Y([2 * s, s]), 2 * s, s]; })()");
  await p.click([x + g[0] + 3, y + g[1] - 3]);
  check("snapped to the grid", (await anchors())[0].every((v, i) => Math.abs(v - g[2 + i]) < 1e-9));
  await p.click("#snap");
  await p.click([x + g[0] + 63, y + g[1] - 43]);
  check("not snapped", (await anchors())[1].some((v) => Math.abs(v / g[3] - Math.round(v / g[3])) > 1e-6));
  await p.click("#snap");
});

await test("pen and finger draw; two fingers zoom", async () => {
  const p = page();
  await undoAll();
  await p.click("[data-tool=Curve]");
  if (!firefox) {                                  // its driver has no pen, and its own fingers zoom the page
    p.pen = true;
    await p.stroke((await oval()).slice(0, 20));
    p.pen = false;
    check("pen", (await anchors()).length > 4);
    await p.key("z", 2);
  }
  await p.fingers(true);
  const o = (await oval()).slice(0, 22);
  await p.touch("touchStart", [o[0]]);
  for (const q of o) await p.touch("touchMove", [q]);
  await p.touch("touchEnd", []);
  check(`finger: ${(await anchors()).length}`, (await anchors()).length > 4);
  if (firefox) return;                             // its driver tells two fingers apart as one
  const scale = await p.run("studio.view.scale"), [x, y] = await canvas(), n = (await anchors()).length;
  await p.touch("touchStart", [[x + 300, y + 300], [x + 340, y + 300]]);
  for (let i = 1; i < 8; i++) await p.touch("touchMove", [[x + 300 - 10 * i, y + 300], [x + 340 + 10 * i, y + 300]]);
  await p.touch("touchEnd", []);
  await p.fingers(false);
  check("zoomed", (await p.run("studio.view.scale")) > 2 * scale);
  check("nothing drawn by it", (await anchors()).length === n);
});

await test("drop CSV, SVG, DXF; units; what is wrong is said with its line", async () => {
  const p = page();
  await undoAll();
  await drop([["foot.csv", "text/csv", readFileSync("examples/walking-foot.csv", "utf8")]]);
  await p.until("studio.doc.path.anchors.length === 24", "24 points of the table");
  check("closed", (await doc()).path.closed);
  await p.choose("#unit", "cm");
  await p.until("studio.doc.unit === 'cm'");
  const cm = await anchors();
  await p.key("z", 2);
  check("in mm ten times as many", Math.abs((await anchors())[3][0] - 10 * cm[3][0]) < 1e-9);
  await drop([["d.svg", "image/svg+xml", '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="100mm" viewBox="0 0 100 100"><path d="M10 50 C 30 10 70 10 90 50 Z"/></svg>']]);
  await p.until("studio.doc.path.anchors.length === 60", "60 stations of the drawing");
  await drop([["d.dxf", "", "0\nSECTION\n2\nENTITIES\n0\nCIRCLE\n8\n0\n10\n0\n20\n0\n40\n25\n0\nENDSEC\n0\nEOF\n"]]);
  await p.until("studio.doc.path.closed && studio.doc.path.anchors.length === 60 && Math.abs(Math.hypot(...studio.doc.path.anchors[7]) - 25) < 0.5", "a circle");
  await drop([["bad.csv", "text/csv", "x,y\n1,2\n3,four\n"]]);
  await p.until("document.getElementById('note').textContent.includes('line 3')", "line of the fault");
  check("nothing lost", (await anchors()).length === 60);
});

await test("a photo under the path: dropped, and scaled by two clicks", async () => {
  const p = page(), [x, y] = await canvas();
  const png = (await p.run("(() => { const c = document.createElement('canvas'); c.width = 40; c.height = 30; c.getContext('2d').fillRect(5, 5, 9, 9); return c.toDataURL('image/png'); })()")).split(",")[1];
  await drop([["photo.png", "image/png", png, true]]);
  await p.until("studio.doc.photo && document.querySelector('image')", "the photo");
  const before = (await doc()).photo.w;
  await p.click([x + 300, y + 250]);
  await p.click([x + 400, y + 250]);
  await p.until("document.getElementById('help').open");
  const was = Number(await p.run("document.getElementById('distance').value"));
  await p.fill("#distance", String(2 * was));
  await p.click("#help button");
  await p.until(`Math.abs(studio.doc.photo.w / ${before} - 2) < 1e-3`, "twice as large");
});

await fresh("examples/walking-foot.csv");

await test("conditions: boxes by hand, numbers, what the server is asked", async () => {
  const p = page();
  await p.until("studio.stations.length === 24");
  const at = async (q) => screen(q), box = async (tool, a, b) => { await p.click(`[data-tool=${tool}]`); await p.stroke([await at(a), await at([(a[0] + b[0]) / 2, b[1]]), await at(b)]); };
  await p.click("#tab-search");
  await p.run("(() => { studio.doc.task.rounds = 1; studio.view.show([[-150, -100], [250, 200]]); studio.redraw(); })()");
  await box("Pivots", [-100, -90], [170, 140]);
  await p.click("[data-tool=Forbid]");                                   // a stroke round the zone: a polygon
  const round = [];
  for (let i = 0; i <= 24; i++) round.push(await at([200 + 22 * Math.cos(i * Math.PI / 12), 125 + 25 * Math.sin(i * Math.PI / 12)]));
  await p.stroke(round);
  const t = (await doc()).task;
  check(`pivots ${t.pivots}`, t.pivots && Math.abs(t.pivots[0] + 100) < 4 && Math.abs(t.pivots[3] - 140) < 4);
  check(`forbidden ${JSON.stringify(t.forbidden)}`, t.forbidden.length === 1 && t.forbidden[0].length > 7 && t.forbidden[0].length <= 16
    && t.forbidden[0].every((q) => Math.abs(Math.hypot((q[0] - 200) / 22, (q[1] - 125) / 25) - 1) < 0.15));
  await p.until("document.querySelectorAll('.box-pivots, .box-forbidden').length === 2", "both are drawn");
  check("the panel lists them", (await p.run("document.getElementById('panel-search').textContent")).includes("Nothing in"));
  await p.fill("#panel-search input[placeholder='20'][max='89']", "25");
  await p.until("studio.doc.task.transmission === 25");
});

await test("search: live progress, best so far on the drawing, error plot, cards; the command does the same", async () => {
  const p = page(), n = p.asked("search").length;
  await p.click("#search");
  await p.until("document.getElementById('state')", "the state of the search");
  await p.until("document.querySelectorAll('#results .card').length > 0", "cards", 120);
  const body = JSON.parse(p.asked("search")[n].body);
  check("task", body.task.pivots.box.length === 2 && body.task.forbidden[0].polygon.length > 7 && body.task.transmission === 25 && body.task.stations.length === 24);
  check("news were asked for", p.asked("news").length > 1);
  check("error plot", (await p.run("document.querySelector('#panel-search .plot path')?.getAttribute('d').length")) > 5);
  check("the best is on the drawing", (await doc()).linkage.joints.length === 4);
  const results = await p.run("studio.search.results");
  for (const r of results) check("verified, within its conditions", r.verified && r.transmission > 24.9);
  const command = await p.run("document.querySelector('#panel-search .command code').textContent");
  writeFileSync(join(folder, "task.json"), JSON.stringify(body.task));
  const words = command.split(" ").slice(1).map((w) => (w === "task.json" ? join(folder, "task.json") : w));
  const cli = JSON.parse(execFileSync(program, [...words, "--json", "--quiet"], { encoding: "utf8" }));
  check(`${cli.results.length} results of ${command}`, cli.results.length === results.length);
  cli.results.forEach((r, i) => {
    for (const [name, v] of Object.entries(r.dimensions)) {
      const angle = /^(theta|beta|input|tool)/.test(name), mine = results[i].dimensions[name] * (angle ? 1 : 1000);
      const off = angle ? Math.abs(Math.sin((mine - v) / 2)) : Math.abs(mine - v);
      check(`result ${i + 1}: ${name} ${mine} ${v}`, off <= 1e-6 * Math.max(1, Math.abs(v)));
    }
  });
  if (pictures) writeFileSync(join(pictures, "search.png"), await p.picture());
});

await test("results: use one, compare two side by side and overlaid", async () => {
  const p = page();
  if ((await p.run("studio.search.results.length")) < 2) { check("one result alone", true); return; }
  await p.click("[data-result='1'] button");
  await settled();
  await p.until("document.querySelector('[data-result=\"1\"]').classList.contains('used')");
  await p.click("[data-result='0'] input");
  await p.click("[data-result='1'] input");
  await p.until("document.querySelectorAll('#compare tr').length > 5", "a table");
  await p.until("document.querySelectorAll('.curves-layer .curve.b').length > 0", "two curves over each other");
  if (pictures) writeFileSync(join(pictures, "compare.png"), await p.picture());
});

if (long) await test("what the conditions cost", async () => {
  const p = page();
  await p.click("#costs");
  await p.until("[...document.querySelectorAll('[data-cost]')].filter((c) => /costs/.test(c.textContent)).length >= 3", "costs", 180);
  await p.until("![...document.querySelectorAll('[data-cost]')].some((c) => /measuring/.test(c.textContent))", "all of them", 180);
  if (pictures) writeFileSync(join(pictures, "costs.png"), await p.picture());
});

await test("stop keeps the best; improve goes on from the drawing", async () => {
  const p = page();
  await p.run("document.querySelector('#panel-search select').scrollIntoView()");
  await p.run("delete studio.doc.task.rounds");
  await p.choose("#panel-search select", "6");
  await p.until("studio.doc.task.links === 6");
  await p.click("#improve");
  await p.until("studio.search.news && studio.search.news.best", "a best", 120);
  const n = p.asked("search").length;
  check("from the drawing", JSON.parse(p.asked("search")[n - 1].body).start.joints.length === 4);
  await p.click("#stop");
  await p.until("studio.search.state === 'stopped' || studio.search.state === 'done'", "stopped", 30);
  check("asked", p.asked("stop").length === 1);
  await p.until("studio.search.results.length > 0 && document.querySelectorAll('#results .card').length > 0", "the best is kept");
});

await test("take away: every format, the path, the task; a saved file opens again", async () => {
  const p = page();
  await settled();
  await p.click("#tab-away");
  await p.run(`(() => { window.saved = {}; studio.download = (name, blob) => { blob.arrayBuffer().then((b) => { saved[name] = [...new Uint8Array(b)].slice(0, 400); saved[name].size = b.byteLength; saved[name + " size"] = b.byteLength; }); }; })()`);
  const begins = { json: "{", svg: "<?xml", pdf: "%PDF", png: "\x89PNG", gif: "GIF8", html: "<!", dxf: "", scad: "", step: "ISO-10303-21", stl: "", mjcf: "<", poses: "", urdf: "<", adams: "", slvs: "", pmks: "" };
  for (const format of Object.keys(begins)) {
    const k = await p.run("Object.keys(saved).length");
    await p.click(`[data-format=${format}]`);
    await p.until(`Object.keys(saved).length > ${k} || document.getElementById('note').textContent.includes(':')`, format);
    const note = await p.run("document.getElementById('note').textContent");
    const name = await p.run("Object.keys(saved).filter((n) => !n.endsWith(' size')).pop()");
    const head = String.fromCharCode(...(await p.run(`saved[${JSON.stringify(name)}]`)));
    check(`${format}: ${note} ${head.slice(0, 20)}`, head.startsWith(begins[format]) && (await p.run(`saved[${JSON.stringify(name + " size")}]`)) > 100);
    check("a command", (await p.run("document.querySelector('#panel-away .command code').textContent")).startsWith("linkwright "));
  }
  const kept = JSON.stringify(await doc());
  await p.click("#fresh");
  check("new", (await doc()).linkage === null);
  await drop([["studio.json", "application/json", kept]]);
  await p.until("studio.doc.linkage !== null");
  check("the file opens again", JSON.stringify(await doc()) === kept);
  await p.until("location.hash.length > 100");
  await p.quiet();
  const there = await p.run("location.href");
  const other = await globalThis.T.browser.page();
  await other.go(there);
  await other.until("studio.doc.linkage !== null", "the address opens it");
  check("the address holds all", JSON.stringify((await other.run("studio.doc")).linkage) === JSON.stringify((await doc()).linkage));
});
