// The atlas in headless Chromium, opened from the disk.   node atlas.mjs FOLDER CHROMIUM REAL SPATIAL [BLOCKS]
// REAL: an atlas of all chains with 4, 6 and 8 links, whose notations are true; FOLDER may hold invented ones.
// Every page is opened: no error, no blocked script, nothing loaded, every link leads somewhere, no script of a
// hostile catalogue runs.  Then what a visitor does: search, filter, keys, copying, a phone, motion.
import { chromium } from "playwright-core";
import { existsSync, readdirSync, readFileSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";

const folder = resolve(process.argv[2]);
const files = readdirSync(folder).filter((f) => f.endsWith(".html"));
const url = (file) => pathToFileURL(`${folder}/${file}`).href;
let passed = 0, failed = 0;

async function test(name, run) {
  try {
    await run();
    passed++;
  } catch (error) {
    failed++;
    console.log(`FAIL ${name}: ${error.message}`);
  }
}

function check(what, condition) {
  if (!condition) throw new Error(what);
}

const browser = await chromium.launch({
  executablePath: process.argv[3] || "/usr/bin/chromium", args: ["--no-sandbox", "--disable-gpu"],
});

// A page that remembers all that goes wrong in it and all that it asks for.
async function open(file, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 900 }, ...options });
  const page = await context.newPage();
  const faults = [], requests = [];
  page.on("pageerror", (e) => faults.push(e.message));
  page.on("console", (m) => { if (m.type() === "error" || m.type() === "warning") faults.push(m.text()); });
  page.on("dialog", (d) => { faults.push(`dialog: ${d.message()}`); d.dismiss(); });
  page.on("request", (r) => requests.push(r.url()));
  await page.goto(url(file));
  return { context, page, faults, requests };
}

const isWide = (page) => page.evaluate(() =>
  document.documentElement.scrollWidth > document.documentElement.clientWidth + 1);

await test("every page opens without a fault and asks for nothing", async () => {
  const { context, page, faults, requests } = await open("index.html");
  for (const file of files) {
    requests.length = 0;
    await page.goto(url(file));
    check(`${file}: ${faults.join("; ")}`, faults.length === 0);
    check(`${file} asks for ${requests.slice(1)}`, requests.length === 1);
    check(`${file} has no heading`, (await page.locator("h1").count()) === 1);
    const policy = await page.locator("meta[http-equiv=Content-Security-Policy]").getAttribute("content");
    check(`${file}: policy ${policy}`, policy.startsWith("default-src 'none'") && !policy.includes("unsafe"));
    const injected = await page.evaluate(() =>
      document.querySelectorAll("script:not([id]), iframe, img, object").length);
    check(`${file} holds ${injected} elements that act`, injected === 1);
  }
  await context.close();
});

await test("every link leads to a page and a place that are there", async () => {
  const seen = new Map(), { context, page } = await open("index.html");
  const ids = (file) => {
    if (!seen.has(file)) {
      const text = readFileSync(`${folder}/${file}`, "utf8");
      seen.set(file, new Set(Array.from(text.matchAll(/ id="([^"]*)"/g), (m) => m[1])));
    }
    return seen.get(file);
  };
  const linked = new Set(["index.html"]);
  for (const file of files) {
    await page.goto(url(file));
    if (file === "index.html")
      while (await page.locator("#more").isVisible()) await page.locator("#more").click();
    const hrefs = await page.$$eval("a[href]", (all) => all.map((a) => a.getAttribute("href")));
    check(`${file} has no link`, hrefs.length > 0);
    for (const href of hrefs) {
      const [target, place] = href.split("#");
      check(`${file}: ${href}`, target === "" || existsSync(`${folder}/${target}`));
      if (place && !place.includes("=")) check(`${file}: ${href}`, ids(target || file).has(place));
      if (target) linked.add(target);
    }
  }
  check("pages no link leads to: " + files.filter((f) => !linked.has(f)), files.every((f) => linked.has(f)));
  await context.close();
});

await test("search and filter", async () => {
  const { context, page, faults } = await open("index.html");
  const count = () => page.locator("#count").innerText();
  const cards = () => page.locator("#cards li").count();
  const all = Number((await count()).match(/^\d+/)[0]);
  check(`${all} of ${files.length} pages`, all === files.filter((f) => f.startsWith("chain-")).length);
  await page.selectOption("#links", "6");
  check(`four chains of six links, not ${await cards()}`, (await cards()) === 4);
  await page.selectOption("#joints", "simple");
  check(`two with simple joints, not ${await cards()}`, (await cards()) === 2);
  await page.selectOption("#joints", "");
  check("the address remembers", page.url().endsWith("#links=6"));
  await page.reload();
  check("and brings the filter again", (await cards()) === 4 && (await page.inputValue("#links")) === "6");
  await page.click("#clear");
  check("clear", (await count()).startsWith(String(all)));
  await page.selectOption("#links", "8");
  check("sixteen of eight links", (await cards()) === 16);
  await page.selectOption("#order", "symmetry");
  await page.fill("#q", "8-1-3");
  check("search by number", (await cards()) === 1 && (await page.locator("#cards a").getAttribute("href")) === "chain-8-1-3.html");
  await page.fill("#q", "no such chain");
  check("nothing found is said", (await cards()) === 0 && (await count()).startsWith("0 of"));
  await page.click("#clear");
  await page.locator(".assortments a").last().click();
  check("a link of the overview filters", (await count()).includes(" of ") && (await cards()) > 0);
  const drawn = await page.$$eval("#cards svg", (all) => all.every((s) => s.querySelectorAll("circle").length > 3));
  check("every card has a picture", drawn);
  check(faults.join("; "), faults.length === 0);
  await context.close();
});

// The chains that the search finds for a text.
async function found(page, text) {
  await page.fill("#q", text);
  while (await page.locator("#more").isVisible()) await page.locator("#more").click();
  return page.$$eval("#cards a", (all) => all.map((a) => a.getAttribute("href").replace(/^chain-|\.html$/g, "")));
}

const real = resolve(process.argv[4]), realUrl = (file) => pathToFileURL(`${real}/${file}`).href;

await test("a chain in any notation finds its page", async () => {
  const { context, page, faults } = await open("index.html");
  for (const file of readdirSync(real).filter((f) => /^chain-/.test(f))) {
    await page.goto(realUrl(file));
    const texts = await page.$$eval("pre code", (all) => all.map((c) => c.textContent));
    check(`${file}: ${texts.length} notations`, texts.length >= (/-m\d/.test(file) ? 1 : 5));
    await page.goto(realUrl("index.html"));
    for (const text of texts) {
      const hits = await found(page, text);
      check(`${file}: ${text} finds ${hits}`, hits.length === 1 && `chain-${hits[0]}.html` === file);
      check(`${file}: said`, (await page.locator("#found").innerText()).includes(`chain ${hits[0]}`));
    }
  }
  await page.goto(realUrl("index.html"));
  // other numbers of the links, a plain matrix, DOT
  const watt = await found(page, "(3 3) 1-2:0 1-2:2 1-2:2"), stephenson = await found(page, "(3 3) 1-2:1 1-2:1 1-2:2");
  check("two six-bars", watt.length === 1 && stephenson.length === 1 && watt[0] !== stephenson[0]);
  for (const text of ["10-20 20-30 30-40 40-10 10-50 50-60 60-40", "010101\n101000\n010100\n101010\n000101\n100010",
    "graph { a -- b -- c -- d -- e -- f -- a; a -- d }"]) {
    const hits = await found(page, text);
    check(`${text} finds ${hits}`, hits.join() === watt.join());
  }
  // pins of several links, with other numbers; the two such six-bars differ in how many there are
  const one = await found(page, "10-30-20 40-50 20-60 60-50 30-40 10-50"), two = await found(page, "1-2-3 4-5-6 1-4 2-5 3-6");
  check(`multiple joints: ${one}, ${two}`, [...one, ...two].sort().join() === "6-1-m1,6-1-m2");
  check("said", (await page.locator("#found").innerText()).includes("2 pins of several links, F = 1; this is chain 6-1-m"));
  // kinds of joints: the picture leads to the mechanisms with sliders
  await found(page, "1-2 1-3 1-5 2-4 2-6 3-4 5-6:t");
  check("said", (await page.locator("#found").innerText()).includes("with sliders"));
  check("sliders", (await page.locator("#cards a").getAttribute("href")).startsWith("sliders-6-1-"));
  for (const [text, part] of [["1-2 2-3 3-1", "cannot move"], ["1-2 2-3 3-4", "fewer than two joints"], ["0 1\n1 0\n1 1", "no chain"],
    ["1-2 1-2 2-3 3-1", "share two joints"], ["1-2 2-3 3-4 4-5 5-6 6-7 7-8 8-9 9-1", "not in this atlas"]]) {
    const hits = await found(page, text), said = await page.locator("#found").innerText();
    check(`${text}: ${hits}: ${said}`, hits.length === 0 && said.includes(part));
  }
  check(faults.join("; "), faults.length === 0);
  await context.close();
});

await test("names of machines and words", async () => {
  const { context, page, faults } = await open("index.html");
  await page.goto(realUrl("index.html"));
  const six = await found(page, "6 links simple joints"), multiple = await found(page, "8 links multiple joints");
  check(`six links: ${six}`, six.join() === "6-1-1,6-1-2" && (await found(page, "6 links")).length === 4);
  check(`multiple joints: ${multiple}`, multiple.length === 44 && multiple.every((c) => c.startsWith("8-1-m")));
  await page.fill("#q", "6 links sliders");
  const sliders = await page.$$eval("#cards a", (a) => a.map((l) => l.getAttribute("href")));
  check(`${sliders}`, sliders.join() === "sliders-6-1-1.html,sliders-6-1-2.html");
  await page.fill("#q", "");
  await page.selectOption("#joints", "multiple");
  check("filter", (await page.locator("#count").innerText()).startsWith("46 of 65"));
  await page.click("#clear");
  const all = await found(page, "");
  const [watt] = await found(page, "(3 3) 1-2:0 1-2:2 1-2:2"), [stephenson] = await found(page, "(3 3) 1-2:1 1-2:1 1-2:2");
  for (const [text, want] of [["Watt", ["4-1-1", watt]], ["watt chain", ["4-1-1", watt]], ["Stephenson", [stephenson]],
    ["Klann", [stephenson]], ["Ackermann steering", ["4-1-1"]], ["six-bar planar simple joints", six], ["2 loops simple joints", six], ["6 links not planar", []],
    ["8-1-3", ["8-1-3"]], ["8-1-1", ["8-1-1"]], ["no such words", []], ["F = 1", all], ["4+2", six], ["6 links 4+2", six]]) {
    const hits = await found(page, text);
    check(`${text} finds ${hits}`, hits.join() === want.join());
  }
  const jansen = await found(page, "Theo Jansen");
  check(`Jansen: ${jansen}`, jansen.length > 1 && jansen.every((c) => c.startsWith("8-1-")));
  check(`Jansen has one chain: ${jansen}`, jansen.filter((c) => c.includes("m")).length === 1);
  const symmetric = await found(page, "8 links symmetric"), asymmetric = await found(page, "8 links asymmetric");
  check(`${symmetric.length} and ${asymmetric.length}`, symmetric.length + asymmetric.length === 60);
  check("said", (await found(page, "6 linkz")).length === 0 && (await page.locator("#found").innerText()).includes("linkz"));
  check(faults.join("; "), faults.length === 0);
  await context.close();
});

await test("a sketched chain finds its page", async () => {
  const { context, page, faults } = await open("index.html");
  await page.goto(realUrl("index.html"));
  await page.click(".sketch summary");
  await page.locator("#sheet").scrollIntoViewIfNeeded();
  const box = await page.locator("#sheet").boundingBox(), unit = box.width / 640;
  const draw = async (x1, y1, x2, y2) => {
    await page.mouse.move(box.x + x1 * unit, box.y + y1 * unit);
    await page.mouse.down();
    await page.mouse.move(box.x + (x1 + x2) / 2 * unit, box.y + (y1 + y2) / 2 * unit);
    await page.mouse.move(box.x + x2 * unit, box.y + y2 * unit);
    await page.mouse.up();
  };
  const said = () => page.locator("#sketched").innerText();
  // a four-bar: the frame below, crank, coupler, rocker; ends need not meet exactly
  await draw(100, 300, 300, 300);
  await draw(105, 297, 140, 200);
  check("said: go on", (await said()).includes("go on"));
  await draw(140, 203, 280, 160);
  await draw(283, 158, 302, 304);
  check(await said(), (await said()).includes("chain 4-1-1"));
  // the coupler becomes a triangle, a dyad hangs on it and on a frame of three pins: Stephenson
  await draw(140, 200, 220, 100);
  await draw(220, 100, 280, 160);
  check(await said(), (await said()).includes("chain 4-1-1") && (await said()).includes("1 free end"));
  await draw(220, 100, 400, 100);
  await draw(400, 100, 420, 300);
  await draw(420, 300, 300, 300);
  await draw(420, 300, 260, 340);
  await draw(260, 340, 300, 300);
  await draw(260, 340, 100, 300);
  const text = await said(), hits = await page.$$eval("#cards a", (a) => a.map((l) => l.getAttribute("href")));
  check(`${text} ${hits}`, text.includes("6 links, 7 joints") && hits.length === 1 && hits[0].startsWith("chain-6-1-"));
  const by = (await found(page, "Stephenson"))[0];
  check(`Stephenson is ${by}`, hits[0] === `chain-${by}.html`);
  await page.click("#undo");
  check(await said(), !(await said()).includes("chain 6-1"));
  // a pin of three links: crank, rocker and connecting rods that all meet
  await page.click("#wipe");
  for (const [x1, y1, x2, y2] of [[100, 300, 500, 300], [100, 300, 300, 340], [300, 340, 500, 300], [100, 300, 160, 160],
    [160, 160, 300, 120], [300, 120, 440, 160], [440, 160, 500, 300], [300, 120, 300, 340]])
    await draw(x1, y1, x2, y2);
  const pins = await said(), drawn = await page.$$eval("#cards a", (a) => a.map((l) => l.getAttribute("href")));
  check(`${pins} ${drawn}`, pins.includes("1 pin of several links, F = 1; this is chain 6-1-m") && drawn.length > 1 &&
    drawn[0].startsWith("chain-6-1-m"));
  await page.click("#wipe");
  check("empty", (await said()) === "" && (await page.locator("#sheet circle").count()) === 0);
  check(faults.join("; "), faults.length === 0);
  await context.close();
});

await test("keys", async () => {
  const { context, page, faults } = await open("index.html");
  const focused = () => page.evaluate(() => document.activeElement.getAttribute("href") || document.activeElement.id);
  await page.keyboard.press("/");
  check("slash goes to the search", (await focused()) === "q");
  await page.keyboard.type("8 links");
  for (let i = 0; i < 20 && !(await focused()).startsWith("chain-"); i++) await page.keyboard.press("Tab");
  check("tab reaches the pictures", (await focused()) === "chain-8-1-1.html");
  await page.keyboard.press("ArrowRight");
  check("right", (await focused()) === "chain-8-1-2.html");
  await page.keyboard.press("End");
  check("end", (await focused()) === "chain-8-1-16.html");
  await page.keyboard.press("Home");
  await page.keyboard.press("Enter");
  await page.waitForURL(/chain-8-1-1\.html/);
  await page.keyboard.press("n");
  await page.waitForURL(/chain-8-1-2\.html/);
  await page.keyboard.press("p");
  await page.waitForURL(/chain-8-1-1\.html/);
  await page.keyboard.press("u");
  await page.waitForURL(/index\.html/);
  check(faults.join("; "), faults.length === 0);
  await context.close();
});

await test("notations are copied", async () => {
  const { context, page } = await open("chain-8-1-2.html", { permissions: ["clipboard-read", "clipboard-write"] });
  const buttons = page.locator(".copy");
  check("buttons", (await buttons.count()) >= 5);
  for (let i = 0; i < (await buttons.count()); i++) {
    await buttons.nth(i).focus();
    await page.keyboard.press("Enter");
    await page.waitForFunction(() => document.getElementById("said").textContent !== "");
    const said = await page.locator("#said").innerText();
    check(said, said.includes("copied"));
    const got = await page.evaluate(() => navigator.clipboard.readText());
    check("what was copied", got === (await page.locator("pre code").nth(i).textContent()));
    await page.evaluate(() => { document.getElementById("said").textContent = ""; });
  }
  await context.close();
});

await test("phone", async () => {
  const phone = { viewport: { width: 360, height: 740 }, deviceScaleFactor: 2, isMobile: true, hasTouch: true };
  const { context, page, faults } = await open("index.html", phone);
  const some = files.filter((f, i) => i % 7 === 0 || f.startsWith("linkages") || f === "index.html");
  for (const file of some) {
    await page.goto(url(file));
    check(`${file} is wider than the screen`, !(await isWide(page)));
    const small = await page.$$eval("p, td, a, button, h1, pre", (all) =>
      all.filter((e) => e.offsetParent && parseFloat(getComputedStyle(e).fontSize) < 12).length);
    check(`${file}: ${small} texts too small to read`, small === 0);
  }
  check(faults.join("; "), faults.length === 0);
  await context.close();
});

// Every linkage is chosen; it moves, or the page says why it does not.
async function watch(page, file) {
  const places = () => page.$$eval("figure:not([hidden]) [data-link]", (all) =>
    all.map((e) => e.getAttribute("transform")).join());
  let moved = 0;
  const radios = page.locator("input[type=radio]");
  for (let i = 0; i < (await radios.count()); i++) {
    await radios.nth(i).check();
    check(`${file}: one picture`, (await page.locator("figure:not([hidden])").count()) === 1);
    if (await page.locator(".play").isDisabled()) {
      check(`${file}: no word why ${i + 1} stands still`,
        (await page.locator("figure:not([hidden]) figcaption").innerText()).length > 10);
      continue;
    }
    if ((await page.locator(".play").innerText()) === "Play") await page.click(".play");
    const first = await places();
    await page.waitForFunction((before) => Array.from(document.querySelectorAll("figure:not([hidden]) [data-link]"),
      (e) => e.getAttribute("transform")).join() !== before, first, { timeout: 20000 });
    await page.click(".play");
    check(`${file}: pauses`, (await page.locator(".play").innerText()) === "Play");
    const still = await places();
    await page.waitForTimeout(150);
    check(`${file}: stands still`, (await places()) === still);
    moved++;
  }
  return { moved, curves: await page.locator("figure .curve").count() };
}

await test("linkages move", async () => {
  let moved = 0, curves = 0;
  for (const file of files.filter((f) => f.startsWith("linkages-"))) {
    const { context, page, faults } = await open(file);
    const seen = await watch(page, file);
    moved += seen.moved;
    curves += seen.curves;
    check(`${file}: way back`, (await page.locator("header a").count()) === 1);
    check(`${file}: ${faults.join("; ")}`, faults.length === 0);
    await context.close();
  }
  check("there are none", moved > 0 && curves > 0);
});

await test("a spatial model moves and is turned", async () => {
  const { context, page, faults, requests } = await open("index.html");
  requests.length = 0;
  await page.goto(pathToFileURL(resolve(process.argv[5])).href);
  const shot = async () => (await page.locator("#view").screenshot()).toString("base64");
  if ((await page.locator("#play").innerText()) === "Play") await page.click("#play");
  const before = await shot();
  await page.waitForFunction(() => Number(document.getElementById("time").value) > 2);
  await page.click("#play");
  const stopped = await shot();
  check("it moves", stopped !== before);
  check("it stops", (await shot()) === stopped);
  const box = await page.locator("#view").boundingBox();
  await page.mouse.move(box.x + 200, box.y + 200);
  await page.mouse.down();
  await page.mouse.move(box.x + 320, box.y + 240, { steps: 4 });
  await page.mouse.up();
  const turned = await shot();
  check("the mouse turns it", turned !== stopped);
  await page.locator("#view").focus();
  await page.keyboard.press("ArrowLeft");
  const keyed = await shot();
  check("keys turn it", keyed !== turned);
  await page.mouse.wheel(0, -300);
  check("the wheel zooms", (await shot()) !== keyed);
  await page.click("[data-view=home]");
  check("home", (await shot()) !== keyed);
  check(`asks for ${requests.slice(1)}; ${faults.join("; ")}`, requests.length === 1 && faults.length === 0);
  check("not wider than the screen", !(await isWide(page)));
  await context.close();
});

if (process.argv[6]) await test("large families are loaded in blocks", async () => {
  const { context, page, faults, requests } = await open("index.html");
  const blocksUrl = (file) => pathToFileURL(resolve(process.argv[6])).href + `/${file}`;
  const loaded = () => requests.filter((r) => r.endsWith(".js")).map((r) => r.replace(/.*\//, "")).join();
  requests.length = 0;
  await page.goto(blocksUrl("chain-4-1-1.html"));
  check(`a single page asks for ${loaded()}`, loaded() === "");
  await page.goto(blocksUrl("index.html#links=8"));
  await page.waitForFunction(() => Array.from(document.querySelectorAll("#cards svg")).every((s) => s.querySelectorAll("circle").length === 10));
  check(`only the block that is shown is loaded, not ${loaded()}`, loaded() === "chains-8-1-0.js");
  await page.locator("#cards a").nth(2).click();
  await page.waitForFunction(() => document.title === "Chain 3 of 16: 8 links, F = 1");
  check("picture", (await page.locator(".first svg circle").count()) === 10 && (await page.locator(".first svg text").count()) === 8);
  check("ground links", (await page.locator("article svg").count()) === 8);
  check("rows", (await page.locator("article tbody tr").count()) === 1);
  check("notations", (await page.locator(".copy:visible").count()) >= 5);
  await page.keyboard.press("n");
  await page.waitForFunction(() => document.title.startsWith("Chain 4 of 16"));
  check("one chain at a time", (await page.locator(".first").count()) === 1 && (await page.locator("#steps li").count()) === 4);
  check("the picture is that of the single page", (await page.evaluate(() => document.querySelector(".first polygon").getAttribute("points"))).length > 5);
  await page.goto(blocksUrl("chain.html#6-1-1"));
  await page.waitForFunction(() => document.title.startsWith("Chain 1 of 2"));
  check("hostile texts are texts", (await page.locator("#chain img, #chain script").count()) === 0 &&
    (await page.locator("pre code").allInnerTexts()).some((t) => t.includes("<script>alert(1)")));
  await page.goto(blocksUrl("chain.html#6-1-m2"));
  await page.waitForFunction(() => document.title === "Chain 2 of 2: 6 links, F = 1, multiple joints");
  check("two circles at the pins of three links", (await page.locator(".first svg circle").count()) === 5 + 2 &&
    (await page.locator(".first svg text").count()) === 6);
  await page.goto(blocksUrl("chain.html#8-1-17"));
  await page.waitForFunction(() => document.getElementById("chain").innerText.includes("no chain 8-1-17"));
  check(faults.join("; "), faults.length === 0);
  await page.goto(blocksUrl("chain.html#9-1-1"));
  await page.waitForFunction(() => document.getElementById("chain").innerText.includes("no chain 9-1-1"));
  await context.close();
});

await test("readable without scripts", async () => {
  const { context, page } = await open("index.html", { javaScriptEnabled: false });
  check("list of chains", (await page.locator("noscript").count()) === 1 || (await page.locator(".plain a").count()) > 0);
  await page.goto(url("chain-8-1-2.html"));
  check("picture", (await page.locator(".first svg circle").count()) === 10);
  check("inversions", (await page.locator("article svg").count()) > 2);
  await context.close();
});

await browser.close();
console.log(`browser: ${passed} passed, ${failed} failed`);
process.exit(failed ? 1 : 0);
