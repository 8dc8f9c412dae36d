// How long a motion of 1000 points takes over the wire, from the question to its whole answer, while a linkage is dragged
// and after it is released, and the processor time of the server for the first; medians.  The input pin's link is
// moved a little each time, as by a hand.   node wire.mjs LINKWRIGHT [MODEL.json...]     Needs no browser.
import { spawn } from "node:child_process";
import { mkdtempSync, readdirSync, readFileSync, rmSync } from "node:fs";
import http from "node:http";
import { tmpdir } from "node:os";
import { join } from "node:path";

const [, , program, ...given] = process.argv, folder = mkdtempSync(join(tmpdir(), "linkwright-wire-"));
const files = given.length ? given : ["hoeken", "jansen", "geared-five-bar", "gallery/klann", "gallery/strandbeest",
  "two-four-bars", "gallery/scotch-yoke",
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
const spent = () => readdirSync(`/proc/${child.pid}/task`).reduce((sum, t) =>      // [ms]
  sum + Number(readFileSync(`/proc/${child.pid}/task/${t}/schedstat`, "utf8").split(" ")[0]) / 1e6, 0);
console.log("mechanism           links    kB   dragged [ms]   processor [ms]   released [ms]");
for (const file of files) {
  const linkage = JSON.parse(readFileSync(file, "utf8")), points = [...linkage.joints, ...linkage.tracers || []].filter((p) => p.at);
  const home = points.map((p) => [...p.at]), size = Math.max(...home.map((p) => Math.hypot(p[0] - home[0][0], p[1] - home[0][1])));
  const median = async (o, n) => {
    const all = [];
    for (let i = 0; i < n; i++) {
      points.forEach((p, k) => { if (home[k].join() === home[1].join()) p.at = [home[1][0] + 0.03 * size * i / n, home[1][1] + 0.02 * size * i / n]; });
      const before = spent(), one = await ask(JSON.stringify({ linkage, points: 1000, ...o }));
      all.push({ ...one, cpu: spent() - before });
    }
    const cpu = all.map((r) => r.cpu).sort((a, b) => a - b)[n >> 1];
    return { ...all.sort((a, b) => a.ms - b.ms)[n >> 1], cpu };
  };
  const dragged = await median({ frames: 90, draft: true }, 41), released = await median({ frames: 180, others: true }, 5);
  console.log(`${file.split("/").pop().replace(".json", "").padEnd(20)} ${String(dragged.links).padStart(4)} ${dragged.kilobytes.toFixed(0).padStart(5)} ${dragged.ms.toFixed(1).padStart(14)} ${dragged.cpu.toFixed(1).padStart(16)} ${released.ms.toFixed(1).padStart(15)}`);
}
child.kill("SIGINT");
rmSync(folder, { recursive: true, force: true });
process.exit(0);
