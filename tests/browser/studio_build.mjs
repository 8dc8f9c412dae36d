// The studio, third part: building from scratch, chains, what is laid over the drawing, forces, small and dark screens.
const { firefox, test, check, sleep, fresh, doc, canvas, settled, pictures, writeFileSync, join, browser, server } = globalThis.T;
const page = () => globalThis.T.page();
const tool = (name) => page().click(`[data-tool=${name}]`);
const freedom = () => page().run("document.getElementById('freedom').textContent");
const note = () => page().run("document.getElementById('note').textContent");

await fresh();

await test("a four-bar from scratch: links, ground, tracer; freedoms and warnings at once", async () => {
  const p = page(), [x, y] = await canvas(), A = [x + 300, y + 500], B = [x + 320, y + 400], C = [x + 520, y + 330], D = [x + 560, y + 500];
  await tool("Link");
  await p.stroke([A, [A[0] + 9, A[1] - 40], B]);
  await p.until("studio.fault.includes('ground')", "a warning: nothing at the ground");
  await p.stroke([B, [B[0] + 50, B[1] - 20], C]);
  await p.stroke([C, [C[0] + 9, C[1] + 50], D]);
  await tool("Ground");
  await p.click(A);
  await p.until("document.getElementById('freedom').textContent.startsWith('F = 3')", "three freedoms of an open chain");
  await p.click(D);
  await p.until("document.getElementById('freedom').textContent === 'F = 1, turns' || document.getElementById('freedom').textContent === 'F = 1, to and fro'", "one freedom");
  const k = (await doc()).linkage;
  check(`links ${k.links.length}, joints ${k.joints.length}`, k.links.length === 4 && k.joints.length === 4);
  check("the first ground pin drives", k.input.joint === k.joints.find((j) => j.links.includes("ground")).name);
  await tool("Tracer");
  await p.click([(B[0] + C[0]) / 2, (B[1] + C[1]) / 2]);
  await p.until("studio.motion && studio.motion.curves.length > 0", "the tracer draws a curve");
  check("a warning is gone", (await note()) === "" || !(await note()).includes("ground"));
  if (pictures) writeFileSync(join(pictures, "build.png"), await p.picture());
});

await test("one link too many is told; taken away it moves again", async () => {
  const p = page(), at = async (name) => p.where(`[data-key="joint.${name}"]`), k = (await doc()).linkage;
  const [b, d] = [k.joints.find((j) => !j.links.includes("ground")).name, k.joints.filter((j) => j.links.includes("ground"))[1].name];
  const n = k.links.length, from = await at(b), to = await at(d);
  await tool("Link");
  await p.stroke([from, [(from[0] + to[0]) / 2, (from[1] + to[1]) / 2], to]);
  await p.until("document.getElementById('freedom').textContent.startsWith('F = 0')", `no freedom left, not ${await freedom()}`);
  check("a link more", (await doc()).linkage.links.length === n + 1);
  await p.key("z", 2);
  await p.until("document.getElementById('freedom').textContent.startsWith('F = 1')");
});

await test("a slider-crank: a slot at the ground", async () => {
  const p = page(), [x, y] = await canvas();
  await p.click("#fresh");
  await tool("Link");
  const A = [x + 300, y + 420], B = [x + 340, y + 360], C = [x + 560, y + 420];
  await p.stroke([A, [A[0] + 9, A[1] - 9], B]);
  await p.stroke([B, [B[0] + 60, B[1] + 9], C]);
  await tool("Ground");
  await p.click(A);
  await tool("Slider");
  await p.stroke([C, [C[0] + 30, C[1]], [C[0] + 80, C[1]]]);
  await p.until("document.getElementById('freedom').textContent === 'F = 1, turns'", "it turns");
  check("slot", (await doc()).linkage.joints.some((j) => j.kind === "p" && j.along[0] > 0.99));
});

await test("a gear pair between two links on one carrier", async () => {
  const p = page(), [x, y] = await canvas();
  await p.click("#fresh");
  await tool("Link");
  const A = [x + 300, y + 420], B = [x + 340, y + 340], C = [x + 500, y + 420], D = [x + 540, y + 340];
  await p.stroke([A, [A[0] + 9, A[1] - 9], B]);
  await p.stroke([C, [C[0] + 9, C[1] - 9], D]);
  await tool("Ground");
  await p.click(A);
  await p.click(C);
  await tool("Gears");
  const middle = (u, v) => [(u[0] + v[0]) / 2, (u[1] + v[1]) / 2];
  await p.stroke([middle(A, B), [x + 400, y + 380], middle(C, D)]);
  await p.until("document.getElementById('freedom').textContent.startsWith('F = 1, turns')", "the wheels turn");
  check("two wheels", (await p.run("document.querySelectorAll('.wheel').length")) === 2);
});

await test("a chain of six links and a known mechanism to begin with", async () => {
  const p = page();
  await p.click("#fresh");
  await p.click("#tab-mechanism");
  await p.until("document.querySelectorAll('#chains button').length > 0");
  await p.run("document.querySelector('#chains').previousElementSibling.previousElementSibling.querySelector('select').value = '6'");
  await p.run("document.querySelector('#chains').previousElementSibling.previousElementSibling.querySelector('select').dispatchEvent(new Event('change'))");
  await p.until("document.querySelectorAll('#chains img').length >= 25", "Watt and Stephenson");
  await p.click("#chains button");
  await settled();
  check("six links", (await doc()).linkage.links.length === 6);
  const first = JSON.stringify((await doc()).linkage);
  await p.click("#chains button");
  await p.until(`JSON.stringify(studio.doc.linkage) !== ${JSON.stringify(first)}`, "other dimensions");
  await p.until("document.querySelectorAll('#gallery option').length > 20");
  await p.choose("#gallery", "klann");
  await p.until("studio.doc.linkage && /Klann/i.test(studio.doc.linkage.name)");
  await settled();
});

await fresh("examples/gallery/hoeken.json");

await test("overlays: arrows, centres, centrodes, inflection circle, cognates, dead points, circuits", async () => {
  const p = page();
  await settled();
  await p.click("#tab-look");
  await p.until("studio.analysis && document.querySelectorAll('#panel-look .plot').length >= 3", "plots");
  const count = (s) => p.run(`document.querySelectorAll(${JSON.stringify(s)}).length`);
  const toggle = async (name, selector, least) => {
    await p.click(`[data-overlay=${name}]`);
    await p.until(`document.querySelectorAll(${JSON.stringify(selector)}).length >= ${least}`, name);
  };
  await p.run("(() => { studio.frame = 30; studio.redraw(); })()");       // in the first frame a centre is infinitely far
  await toggle("velocity", ".arrow.v", 2);
  await toggle("acceleration", ".arrow.a", 2);
  await toggle("centres", ".pole", 4);
  await toggle("centrodes", ".centrode", 2);
  await toggle("inflection", ".inflection", 1);
  await toggle("dead", ".dead", 2);
  await toggle("cognates", ".above-layer .curve.b", 3);
  await toggle("circuits", ".curves-layer .curve", 2);
  // the instant centre of coupler and ground lies on the lines of crank and rocker
  const off = await p.run(`(() => { const a = studio.analysis, m = studio.motion, f = 7, c = a.centres.find((q) => q.links[0] === 2 && q.links[1] === m.ground).at.slice(4 * f, 4 * f + 2);
    const pin = (n) => { const j = m.joints[n], l = j.links[0], o = m.origins, i = 4 * (f * m.links.length + l), v = m.places, x = j.at[0] - o[2 * l], y = j.at[1] - o[2 * l + 1];
      return [v[i] + v[i + 2] * x - v[i + 3] * y, v[i + 1] + v[i + 3] * x + v[i + 2] * y]; };
    const away = (p, q) => Math.abs((q[0] - p[0]) * (c[1] - p[1]) - (q[1] - p[1]) * (c[0] - p[0])) / Math.hypot(q[0] - p[0], q[1] - p[1]);
    const on = (l) => m.joints.map((j, n) => [j, n]).filter(([j]) => j.links.includes(l)).map(([, n]) => pin(n)); return Math.max(away(...on(1)), away(...on(3))); })()`);
  check(`centre off the lines of the cranks by ${off}`, off < 1e-4);
  const [x, , w] = await p.run("(() => { const b = document.querySelector('#panel-look .plot').getBoundingClientRect(); return [b.x, b.y, b.width]; })()");
  const at = await p.where("#panel-look .plot");
  await p.click([x + w * 0.6, at[1] - 20]);
  await p.until("studio.frame > 60", "the plot scrubs");
  if (pictures) writeFileSync(join(pictures, "look.png"), await p.picture());
  for (const o of ["velocity", "acceleration", "centres", "centrodes", "inflection", "dead", "cognates", "circuits"]) await p.click(`[data-overlay=${o}]`);
  await p.until("document.querySelectorAll('.above-layer *').length === 0", "all away again");
  check("no more", (await count(".pole")) === 0);
});

await test("double points of a figure of eight", async () => {
  const p = page();
  await p.choose("#gallery", "watt");
  await p.until("studio.doc.linkage && /Watt/i.test(studio.doc.linkage.name)");
  await settled();
  await p.click("[data-overlay=doubles]");
  await p.until("document.querySelectorAll('.double').length === 1", "the double point");
  const at = await p.run("studio.analysis.doubles[0]"), tracer = await p.run("studio.doc.linkage.tracers[0].at");
  check(`double point ${at}`, Math.hypot(at[0] - tracer[0], at[1] - tracer[1]) < 0.05);
  await p.click("[data-overlay=doubles]");
  await p.key("z", 2);
  await settled();
  await p.click("#fit");
});

await test("the other assembly mode: the same lengths, the other side, and back; masses come along", async () => {
  const p = page();
  await p.click("#tab-mechanism");
  await p.until("document.querySelectorAll('#gallery option').length > 20");
  await p.choose("#gallery", "hoeken");
  await p.until("studio.doc.linkage && /Hoe/i.test(studio.doc.linkage.name)");
  await settled();
  await p.click("#tab-mechanism");
  const coupler = await p.run("studio.doc.linkage.links[2].name");
  await p.fill(`[aria-label='Mass of ${coupler}']`, "0.4");
  await settled();
  const k = (await doc()).linkage, at = (q, n) => [...q.joints, ...q.tracers].find((j) => j.name === n).at, d = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);
  await p.click("#assembly");
  await p.until(`JSON.stringify(studio.doc.linkage) !== ${JSON.stringify(JSON.stringify(k))}`, "the other mode");
  await settled();
  const o = (await doc()).linkage, moved = k.joints.filter((j) => d(j.at, at(o, j.name)) > 1e-3).map((j) => j.name);
  check(`one pin changes sides, not ${moved}`, moved.length === 1);
  for (const link of k.links) {
    const on = [...k.joints.filter((j) => j.links.includes(link.name)), ...k.tracers.filter((t) => t.link === link.name)].map((j) => j.name);
    for (const a of on) for (const b of on) check(`${a} ${b}`, Math.abs(d(at(k, a), at(k, b)) - d(at(o, a), at(o, b))) < 1e-6);
    if (link.centre) check("centre of mass", Math.abs(d(link.centre, at(k, on[0])) - d(o.links.find((l) => l.name === link.name).centre, at(o, on[0]))) < 1e-6);
  }
  await p.run("document.getElementById('canvas').focus()");
  await p.key("m");
  await p.until(`Math.hypot(...studio.doc.linkage.joints.find((j) => j.name === "${moved[0]}").at.map((v, i) => v - ${JSON.stringify(at(k, moved[0]))}[i])) < 1e-6`, "M brings it back");
  await settled();
});

await test("masses give the torque of the drive and the forces in the joints", async () => {
  const p = page();
  check("told what is missing", (await p.run("document.getElementById('panel-look').textContent")).includes("masses"));
  await p.click("#tab-mechanism");
  const link = await p.run("studio.doc.linkage.links[2].name");
  await p.fill(`[aria-label='Mass of ${link}']`, "0.4");
  await p.until("studio.doc.linkage.links[2].mass === 0.4 && studio.doc.linkage.links[2].inertia > 0");
  await settled();
  await p.click("#tab-look");
  await p.until("document.querySelector('[data-plot=torque] path')?.getAttribute('d').length > 500", "a plot of the torque");
  const f = await p.run("({ n: studio.forces.drive.length, j: studio.forces.joints.length, unit: studio.forces.unit, most: Math.max(...studio.forces.drive.map(Math.abs)) })");
  check(JSON.stringify(f), f.n === 181 && f.j === 4 && f.unit === "N m" && f.most > 0);
});

await test("a length is typed, a kind is changed, Delete takes a point away", async () => {
  const p = page();
  await p.click("#tab-mechanism");
  const label = await p.run("document.querySelector('.links input[aria-label^=Distance]').getAttribute('aria-label')");
  await p.fill(`[aria-label="${label}"]`, "33");
  await p.until(`Math.abs(Number(document.querySelector('[aria-label="${label}"]').value) - 33) < 1e-5`, "33 mm");
  await settled();
  await tool("Move");
  const n = (await doc()).linkage.tracers.length;
  const name = (await doc()).linkage.tracers[0].name;
  await p.click(await p.where(`[data-point=${name}]`));
  await p.key("Delete");
  await p.until(`studio.doc.linkage.tracers.length === ${n - 1}`, "one tracer less");
});

if (!firefox) await test("a phone: nothing is wider than the screen, everything is reached", async () => {
  const old = page(), phone = await browser.page({ width: 360, height: 740, deviceScaleFactor: 2, mobile: true });
  await phone.go(server().address);
  await phone.until("studio.motion");
  const speed = await phone.run("(() => { const b = document.getElementById('speed').getBoundingClientRect(); return b.width > 50 && b.right < 360; })()");
  check("the speed of the motion can be set", speed && (await phone.run("document.getElementById('rpm').textContent")).endsWith("rpm"));
  check("wider than the screen", !(await phone.run("document.documentElement.scrollWidth > 361")));
  const beyond = await phone.run("[...document.querySelectorAll('header button, header select')].filter((e) => e.getBoundingClientRect().right > 360).map((e) => e.id)");
  check(`beyond the right edge of the top bar: ${beyond}`, beyond.length === 0);
  const [, , w, h] = await phone.run("(() => { const b = document.getElementById('canvas').getBoundingClientRect(); return [b.x, b.y, b.width, b.height]; })()");
  check(`room to draw: ${w} x ${h}`, w > 300 && h > 200);
  for (const tab of ["path", "search", "mechanism", "look", "away"]) {
    await phone.click(`#tab-${tab}`);
    check(tab, !(await phone.run(`document.getElementById("panel-${tab}").hidden`)));
    check(`${tab} is wider`, !(await phone.run("document.documentElement.scrollWidth > 361")));
  }
  const small = await phone.run("[...document.querySelectorAll('button, select')].filter((e) => e.offsetParent && e.getBoundingClientRect().height < 24).map((e) => e.outerHTML.slice(0, 60))");
  check(`too small to touch: ${small}`, small.length === 0);
  const p = await phone.where("[data-point=P]"), before = await phone.run("JSON.stringify(studio.doc.linkage.tracers)");
  await phone.touch("touchStart", [p]);
  for (let i = 1; i < 9; i++) await phone.touch("touchMove", [[p[0] + 3 * i, p[1] - 2 * i]]);
  await phone.touch("touchEnd", []);
  check("a finger drags the tracer", (await phone.run("JSON.stringify(studio.doc.linkage.tracers)")) !== before);
  check(phone.faults.join(), phone.faults.length === 0);
  if (pictures) writeFileSync(join(pictures, "phone.png"), await phone.picture());
  check("the page beside it", (await old.run("1")) === 1);
});

await test("dark: by the system and by the button; texts keep their contrast", async () => {
  const p = page(), contrast = `(() => { const lum = (c) => { const [r, g, b] = c.match(/[\\d.]+/g).map(Number).map((v) => { v /= 255; return v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4; }); return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
    const back = lum(getComputedStyle(document.body).backgroundColor); return Math.min(...[...document.querySelectorAll("aside h2, aside label, aside .hint, aside dt, #tabs button")].filter((e) => e.offsetParent)
      .map((e) => { const c = lum(getComputedStyle(e).color); return (Math.max(c, back) + 0.05) / (Math.min(c, back) + 0.05); })); })()`;
  check(`contrast in light: ${await p.run(contrast)}`, (await p.run(contrast)) >= 4.5);
  await p.media({ "prefers-color-scheme": "dark" });
  await p.until("document.documentElement.classList.contains('dark')");
  check(`contrast in dark: ${await p.run(contrast)}`, (await p.run(contrast)) >= 4.5);
  await p.click("#theme");
  check("light by the button", !(await p.run("document.documentElement.classList.contains('dark')")));
  await p.click("#theme");
  await p.click("#tab-mechanism");
  await p.until("document.querySelector('.chains img')");
  check("chains are drawn light on dark", await p.run("getComputedStyle(document.querySelector('.chains img')).filter.includes('invert') && getComputedStyle(document.querySelector('.chains button')).backgroundColor !== 'rgb(255, 255, 255)'"));
  if (pictures) writeFileSync(join(pictures, "dark.png"), await p.picture());
});

await test("the list of keys", async () => {
  const p = page();
  await p.run("document.getElementById('canvas').focus()");
  await p.key("?");
  check("open", await p.run("document.getElementById('help').open"));
  await p.key("Escape");
  await p.until("!document.getElementById('help').open");
  await p.key("k");
  check("a key chooses a tool", (await p.run("studio.tool.name")) === "Link");
});
