// Firefox without a window, driven by Marionette over a socket, with the same pages as chromium.mjs: no package is needed.
import { spawn } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { connect } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { Page } from "./chromium.mjs";

export async function launch(program) {
  const folder = mkdtempSync(join(tmpdir(), "linkwright-browser-"));
  writeFileSync(join(folder, "user.js"), 'user_pref("marionette.port", 0);\nuser_pref("browser.tabs.remote.warmup.enabled", false);\n');
  const child = spawn(program, ["--headless", "--marionette", "--remote-allow-system-access", "--no-remote", "--profile", folder], { stdio: "ignore" });
  const active = join(folder, "MarionetteActivePort");
  for (let i = 0; i < 1200 && !existsSync(active); i++) await new Promise((go) => { setTimeout(go, 50); });
  const socket = connect(Number(readFileSync(active, "utf8")), "127.0.0.1"), waiting = new Map();
  let id = 0, rest = Buffer.alloc(0);
  socket.on("data", (data) => {                    // LENGTH:[1, id, error, result]
    rest = Buffer.concat([rest, data]);
    for (let colon = rest.indexOf(58); colon > 0; colon = rest.indexOf(58)) {
      const n = Number(rest.subarray(0, colon));
      if (rest.length < colon + 1 + n) return;
      const m = JSON.parse(rest.subarray(colon + 1, colon + 1 + n));
      rest = rest.subarray(colon + 1 + n);
      const w = waiting.get(m[1]);
      waiting.delete(m[1]);
      if (w) m[2] ? w.no(new Error(`${w.name}: ${m[2].message}`)) : w.yes(m[3]);
    }
  });
  socket.on("error", () => {});
  const send = (name, params = {}) => new Promise((yes, no) => {
    waiting.set(++id, { yes, no, name });
    const text = JSON.stringify([0, id, name, params]);
    socket.write(`${Buffer.byteLength(text)}:${text}`);
  });
  await send("WebDriver:NewSession", {});
  await send("WebDriver:SetTimeouts", { script: 600000, pageLoad: 600000 });
  return {
    async page(size = {}) { return new FirefoxPage(send, size).begin(); },
    async close() {
      const gone = new Promise((yes) => { child.on("exit", yes); });
      send("Marionette:Quit", { flags: ["eForceQuit"] }).catch(() => {});
      await Promise.race([gone, new Promise((go) => { setTimeout(go, 5000); })]);
      child.kill("SIGKILL");
      rmSync(folder, { recursive: true, force: true, maxRetries: 10, retryDelay: 100 });
    },
  };
}

const KEYS = { Enter: "\uE007", Escape: "\uE00C", Space: " ", ArrowLeft: "\uE012", ArrowUp: "\uE013", ArrowRight: "\uE014", ArrowDown: "\uE015",
  Delete: "\uE017", Tab: "\uE004" };
let front = null;                                   // the window that commands go to

class FirefoxPage extends Page {
  constructor(send, size) {
    super(send, new Set(), size);
    this.size = size;
  }
  async command(name, params) {
    if (front !== this.handle) await this.root("WebDriver:SwitchToWindow", { handle: this.handle, focus: true });
    front = this.handle;
    return this.root(name, params);
  }
  async begin() {
    this.handle = (await this.root("WebDriver:NewWindow", { type: "window", focus: true })).handle;
    await this.command("WebDriver:SetWindowRect", { width: this.size.width || 1280, height: (this.size.height || 860) + 85 });
    return this;
  }
  async front() { front = null; await this.run("1"); }
  async close() { await this.command("WebDriver:CloseWindow"); front = null; }
  // The questions are heard where the page asks them.
  async go(url) {
    if (!this.had) {                               // all pages share one storage here: begin without what others left
      await this.command("WebDriver:Navigate", { url: new URL("icon.svg", url).href });
      await this.run("(() => { localStorage.clear(); sessionStorage.clear(); })()");
      this.had = true;
    }
    await this.command("WebDriver:Navigate", { url: "about:blank" });
    await this.command("WebDriver:Navigate", { url });
    await this.listen();
  }
  async listen() {
    await this.until("document.documentElement.dataset.ready === 'yes'", "the page is ready");
    await this.run(`(() => { if (window.heard) return; const ask = window.fetch; window.heard = []; window.faults = [];
      window.addEventListener("error", (e) => window.faults.push(e.message));
      window.fetch = function (url, o) { const r = { url: String(url), name: String(url).split("api/")[1], body: o && o.body, at: performance.now() / 1000 }; window.heard.push(r);
        const p = ask.call(window, url, o); p.then((a) => { r.status = a.status; r.done = performance.now() / 1000; }, () => {}); return p; }; })()`);
  }
  async reload() { await this.command("WebDriver:Refresh"); await this.listen(); }
  async run(script) {
    const r = await this.command("WebDriver:ExecuteAsyncScript", { args: [], script: `const done = arguments[arguments.length - 1];
      (async () => (${script}))().then((v) => done({ v: v === undefined ? null : v }), (e) => done({ e: String(e) }));` });
    if (r.value.e) throw new Error(`${script}: ${r.value.e}`);
    return r.value.v;
  }
  async hear() { /* the page does it */ }
  async refresh() {
    this.requests = await this.run("window.heard ? window.heard.map((r) => ({ ...r })) : []");
    this.faults.push(...await this.run("window.faults ? window.faults.splice(0) : []"));
  }
  async quiet() { await super.quiet(); await this.refresh(); }
  async act(type, id, actions, parameters) {
    await this.command("WebDriver:PerformActions", { actions: [{ type, id, actions, ...(parameters ? { parameters } : {}) }] });
  }
  mouseActions(actions) { return this.act("pointer", "mouse", actions, { pointerType: "mouse" }); }
  move([x, y]) { return this.mouseActions([{ type: "pointerMove", x: Math.round(x), y: Math.round(y), duration: 0 }]); }
  async press(p) { await this.move(p); await this.mouseActions([{ type: "pointerDown", button: 0 }]); }
  async release(p) { await this.move(p); await this.mouseActions([{ type: "pointerUp", button: 0 }]); await this.refresh(); }
  async key(key, modifiers = 0) {
    const k = { type: "keyDown", value: KEYS[key] || key }, held = modifiers & 2 ? [{ type: "keyDown", value: "\uE009" }] : [];
    await this.act("key", "keys", [...held, k, { ...k, type: "keyUp" }, ...held.map((h) => ({ ...h, type: "keyUp" }))]);
    await this.quiet();
  }
  async fill(selector, text) {
    await this.click(selector);
    await this.run(`document.querySelector(${JSON.stringify(selector)}).select?.()`);
    await this.act("key", "keys", [...String(text)].flatMap((c) => [{ type: "keyDown", value: c }, { type: "keyUp", value: c }]));
    await this.run("document.activeElement.blur()");
    await this.quiet();
  }
  // Touches one after the other, as Chromium's protocol tells them.
  async touch(type, points) {
    this.fingersDown ||= 0;
    const many = Math.max(points.length, this.fingersDown), actions = [];
    for (let i = 0; i < many; i++) {
      const [x, y] = (points[i] || [0, 0]).map(Math.round), move = { type: "pointerMove", x, y, duration: 0 };
      actions.push({ type: "pointer", id: `finger${i}`, parameters: { pointerType: "touch" },
        actions: type === "touchStart" ? [move, { type: "pointerDown", button: 0 }] : type === "touchMove" ? [move] : [{ type: "pointerUp", button: 0 }] });
    }
    this.fingersDown = type === "touchEnd" ? 0 : many;
    await this.command("WebDriver:PerformActions", { actions });
    await this.refresh();
  }
  async fingers() { /* always there */ }
  async media(features) {
    await this.command("Marionette:SetContext", { value: "chrome" });
    await this.command("WebDriver:ExecuteScript", { args: [], script: `Services.prefs.setIntPref("ui.systemUsesDarkTheme", ${features["prefers-color-scheme"] === "dark" ? 1 : 0});` });
    await this.command("Marionette:SetContext", { value: "content" });
  }
  async heap() { return 0; }
  async picture() { return Buffer.from((await this.command("WebDriver:TakeScreenshot", { full: false })).value, "base64"); }
}
