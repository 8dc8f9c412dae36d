// Chromium without a window, driven by its DevTools protocol over two pipes: no package is needed.
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

export async function launch(program) {
  const folder = mkdtempSync(join(tmpdir(), "lw-"));      // short, as the names of sockets in it must be
  const child = spawn(program, ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
    "--disable-extensions", "--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-breakpad",
    "--disable-background-timer-throttling", "--disable-renderer-backgrounding", "--disable-backgrounding-occluded-windows",
    "--remote-debugging-pipe", `--user-data-dir=${folder}`, "about:blank"],
    { env: { ...process.env, TMPDIR: folder }, stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] });
  const [input, output] = [child.stdio[3], child.stdio[4]];
  const waiting = new Map(), listeners = new Set();
  let id = 0, rest = "";
  output.setEncoding("utf8");
  output.on("data", (data) => {
    const parts = (rest + data).split("\0");
    rest = parts.pop();
    for (const part of parts) {
      const m = JSON.parse(part), w = waiting.get(m.id);
      waiting.delete(m.id);
      if (w) m.error ? w.no(new Error(`${w.method}: ${m.error.message}`)) : w.yes(m.result);
      else for (const f of listeners) f(m);
    }
  });
  const gone = new Promise((yes) => { child.on("exit", yes); });
  child.on("exit", () => { for (const w of waiting.values()) w.no(new Error("the browser ended")); });
  const send = (method, params = {}, sessionId = undefined) => new Promise((yes, no) => {
    waiting.set(++id, { yes, no, method });
    input.write(`${JSON.stringify({ id, method, params, sessionId })}\0`);
  });
  return {
    // A page of its own; beside another one: a second window of the same browser.
    async page(size = {}, beside = null) { return new Page(send, listeners, size).begin(beside); },
    async close() {
      await Promise.race([send("Browser.close").catch(() => {}), new Promise((go) => { setTimeout(go, 2000); })]);
      await Promise.race([gone, new Promise((go) => { setTimeout(go, 3000); })]);
      child.kill("SIGKILL");
      rmSync(folder, { recursive: true, force: true, maxRetries: 10, retryDelay: 100 });
    },
  };
}

const KEYS = { Enter: 13, Escape: 27, Space: 32, ArrowLeft: 37, ArrowUp: 38, ArrowRight: 39, ArrowDown: 40, Delete: 46, Tab: 9 };

export class Page {
  constructor(send, listeners, size) {
    Object.assign(this, { faults: [], requests: [], size: { width: 1280, height: 860, deviceScaleFactor: 1, mobile: false, ...size } });
    this.send = (method, params) => send(method, params, this.session);
    this.root = send;
    listeners.add((m) => m.sessionId === this.session && this.hear(m));
  }
  async begin(beside) {
    const { browserContextId } = beside ? { browserContextId: beside.context } : await this.root("Target.createBrowserContext");
    this.context = browserContextId;
    const { targetId } = await this.root("Target.createTarget", { url: "about:blank", browserContextId });
    this.target = targetId;
    this.session = (await this.root("Target.attachToTarget", { targetId, flatten: true })).sessionId;
    for (const domain of ["Page", "Runtime", "Network", "Log"]) await this.send(`${domain}.enable`);
    await this.send("Emulation.setDeviceMetricsOverride", this.size);
    await this.send("Emulation.setFocusEmulationEnabled", { enabled: true });
    await this.send("Page.bringToFront");
    if (this.size.mobile) await this.send("Emulation.setTouchEmulationEnabled", { enabled: true });
    return this;
  }
  // In front, and drawing: windows behind others get no pointer moves.
  async front() {
    await this.send("Page.bringToFront");
    await this.run("new Promise((go) => { requestAnimationFrame(() => requestAnimationFrame(go)); })");
  }
  async close() { await this.root("Target.closeTarget", { targetId: this.target }); }
  hear(m) {
    const p = m.params;
    if (m.method === "Runtime.exceptionThrown") this.faults.push(p.exceptionDetails.exception?.description || p.exceptionDetails.text);
    if (m.method === "Log.entryAdded" && p.entry.level === "error" && !/ERR_CONNECTION|Failed to load resource/.test(p.entry.text)) this.faults.push(p.entry.text);
    if (m.method === "Network.requestWillBeSent")
      this.requests.push({ url: p.request.url, name: p.request.url.split("/api/")[1], body: p.request.postData, at: p.timestamp, id: p.requestId });
    if (m.method === "Network.loadingFinished") { const r = this.requests.find((q) => q.id === p.requestId); if (r) r.done = p.timestamp; }
    if (m.method === "Network.responseReceived") { const r = this.requests.find((q) => q.id === p.requestId); if (r) r.status = p.response.status; }
  }
  asked(name) { return this.requests.filter((r) => r.name === name); }
  async go(url) {
    await this.send("Page.navigate", { url: "about:blank" });
    await this.send("Page.navigate", { url });
    await this.until("document.documentElement.dataset.ready === 'yes'", "the page is ready");
  }
  async run(script) {
    const r = await this.send("Runtime.evaluate", { expression: `(async () => (${script}))()`, awaitPromise: true, returnByValue: true });
    if (r.exceptionDetails) throw new Error(`${script}: ${r.exceptionDetails.exception?.description || r.exceptionDetails.text}`);
    return r.result.value;
  }
  async until(script, what = script, seconds = 60) {
    for (let i = 0; i < seconds * 40; i++) {
      if (await this.run(script).catch(() => false)) return;
      await new Promise((go) => { setTimeout(go, 25); });
    }
    throw new Error(`waited in vain: ${what}`);
  }
  // Until nothing is on its way: no answer, no panel or drawing to be shown again.
  async quiet() {
    await this.until("!window.studio || (studio.work === 0 && !studio.touching)", "the page is at rest");
  }
  // Place of an element's middle on the screen.
  async where(selector) {
    await this.quiet();
    const p = await this.run(`(() => { const e = document.querySelector(${JSON.stringify(selector)}); if (!e) return null;
      e.scrollIntoView({ block: "nearest", inline: "nearest" }); const b = e.getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; })()`);
    if (!p) throw new Error(`there is no ${selector}`);
    return p;
  }
  async mouse(type, [x, y], buttons = 0) {
    await this.send("Input.dispatchMouseEvent", { type, x, y, button: type === "mouseMoved" ? "none" : "left", buttons, clickCount: 1, pointerType: this.pen ? "pen" : "mouse" });
  }
  async press(p) { await this.mouse("mouseMoved", p); await this.mouse("mousePressed", p, 1); }
  async move(p) { await this.mouse("mouseMoved", p, 1); }
  async release(p) { await this.mouse("mouseReleased", p); }
  async click(selector) {
    const p = typeof selector === "string" ? await this.where(selector) : selector;
    await this.press(p);
    await this.release(p);
    await this.quiet();
  }
  async stroke(points) {
    await this.quiet();
    await this.press(points[0]);
    for (const p of points.slice(1)) await this.move(p);
    await this.release(points[points.length - 1]);
    await this.quiet();
  }
  async fingers(yes) { await this.send("Emulation.setTouchEmulationEnabled", { enabled: yes, ...(yes ? { maxTouchPoints: 2 } : {}) }); }
  async reload() { await this.send("Page.reload"); }
  async touch(type, points) { await this.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) }); }
  async key(key, modifiers = 0) {
    const named = KEYS[key], text = key === "Space" ? " " : key, code = named || key.toUpperCase().charCodeAt(0);
    const event = { key: text, windowsVirtualKeyCode: code, modifiers, ...(named && key !== "Enter" && key !== "Space" ? {} : { text: key === "Enter" ? "\r" : text }) };
    await this.send("Input.dispatchKeyEvent", { type: modifiers & 2 ? "rawKeyDown" : "keyDown", ...event, ...(modifiers & 2 ? { text: undefined } : {}) });
    await this.send("Input.dispatchKeyEvent", { type: "keyUp", key: text, windowsVirtualKeyCode: code, modifiers });
    await this.quiet();
  }
  // Type into a field as a person does, and leave it.
  async fill(selector, text) {
    await this.click(selector);
    await this.run(`document.querySelector(${JSON.stringify(selector)}).select?.()`);
    await this.send("Input.insertText", { text: String(text) });
    await this.run("document.activeElement.blur()");
    await this.quiet();
  }
  async choose(selector, value) {
    await this.run(`(() => { const s = document.querySelector(${JSON.stringify(selector)}); s.value = ${JSON.stringify(value)};
      s.dispatchEvent(new Event("change", { bubbles: true })); })()`);
    await this.quiet();
  }
  async media(features) { await this.send("Emulation.setEmulatedMedia", { features: Object.entries(features).map(([name, value]) => ({ name, value })) }); }
  async heap() {
    await this.send("HeapProfiler.collectGarbage");
    return (await this.send("Runtime.getHeapUsage")).usedSize;
  }
  async picture() { return Buffer.from((await this.send("Page.captureScreenshot")).data, "base64"); }
}
