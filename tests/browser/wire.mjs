// How long a motion of 1000 points takes over the wire, from the question to its whole answer, while a linkage is dragged
// and after it is released; medians.   node wire.mjs LINKWRIGHT [MODEL.json...]     Needs no browser.
import { spawn } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import http from "node:http";
import { tmpdir } from "node:os";
import { join } from "node:path";

const [, , program, ...given] = process.argv, folder = mkdtempSync(join(tmpdir(), "linkwright-wire-"));
const files = given.length ? given : ["hoeken", "jansen", "geared-five-bar", "gallery/klann", "gallery/strandbeest",
  "gallery/scott-russell", "gallery/peaucellier", "gallery/excavator", "gallery/scissor-lift"].map((n) => `examples/${n}.json`);
const child = spawn(program, ["studio", "--no-browser", "--quiet"], { env: { ...process.env, XDG_STATE_HOME: folder, XDG_CACHE_HOME: "/dev/null" } });
const address = await new Promise((yes) => { let text = ""; child.stdout.on("data", (d) => { text += d; if (text.includes("\n")) yes(text.trim()); }); });
const agent = new http.Agent({ keepAlive: true, maxSockets: 1 });
const ask = (body) => new Promise((yes, no) => {
  const start = performance.now();
  const r = http.request(`${address}api/motion`, { method: "POST", agent, headers: { "Content-Type": "application/json", "Content-Length": Buffer.byteLength(body) } }, (a) => {
    const parts = [];
    a.on("data", (d) => parts.push(d));
    a.on("end", () => yes({ ms: performance.now() - start, kilobytes: Buffer.concat(parts).length / 1e3, links: JSON.parse(Buffer.concat(parts)).links.length }));
  });
  r.on("error", no);
  r.end(body);
});
console.log("mechanism           links    kB   dragged [ms]   released [ms]");
for (const file of files) {
  const linkage = JSON.parse(readFileSync(file, "utf8")), median = async (o, n) => {
    const all = [];
    for (let i = 0; i < n; i++) all.push(await ask(JSON.stringify({ linkage, points: 1000, ...o })));
    return all.sort((a, b) => a.ms - b.ms)[n >> 1];
  };
  const dragged = await median({ frames: 90, draft: true }, 41), released = await median({ frames: 180, others: true }, 5);
  console.log(`${file.split("/").pop().replace(".json", "").padEnd(20)} ${String(dragged.links).padStart(4)} ${dragged.kilobytes.toFixed(0).padStart(5)} ${dragged.ms.toFixed(1).padStart(14)} ${released.ms.toFixed(1).padStart(15)}`);
}
child.kill("SIGINT");
rmSync(folder, { recursive: true, force: true });
process.exit(0);
