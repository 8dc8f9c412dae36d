// The document, its undo and redo, and where it is kept: in the address, in this window, and in the browser.
import { clone } from "./mechanism.js";

export const blank = () => ({
  studio: 1, unit: "mm",
  path: { mode: "curve", closed: false, anchors: [], stations: 36 },
  task: { links: 4, types: "fourbar", turn: "auto", transmission: null, maxSize: null, least: null, most: null, ratio: null,
    pivots: null, forbidden: [], rpm: 30, acceleration: null, timing: "auto", seed: 1, results: 10 },
  linkage: null, locked: [], photo: null,
});

export const app = { doc: blank(), past: [], future: [], listeners: {}, work: 0 };
export const on = (event, f) => { (app.listeners[event] ||= []).push(f); };
export const emit = (event, ...a) => { for (const f of app.listeners[event] || []) f(...a); };

// app.work counts what is on its way: answers, panels and the drawing to be shown again, the document to be kept.
export const later = (f, ms) => { app.work++; setTimeout(() => { app.work--; f(); }, ms); };

// A photo is large and never edited: snapshots share it.
const snapshot = (doc) => { const { photo, ...rest } = doc; return { ...clone(rest), photo }; };

// One step that can be undone.  `parts` tells who has to look: "path", "task", "linkage", "photo", "all".
export function change(parts, f) {
  app.past.push(snapshot(app.doc));
  if (app.past.length > 300) app.past.shift();
  app.future = [];
  f(app.doc);
  changed(parts);
}

// A step in parts, as while dragging: `begin` once, then change app.doc and call `changed`.
export function begin() {
  app.past.push(snapshot(app.doc));
  app.future = [];
}

export function changed(parts) {
  emit("changed", parts);
  keep();
}

export function undo() { step(app.past, app.future); }
export function redo() { step(app.future, app.past); }
function step(from, to) {
  if (!from.length) return;
  to.push(snapshot(app.doc));
  app.doc = from.pop();
  changed("all");
}

// ---- kept in the address and in the browser

async function pack(text) {
  const stream = new Blob([text]).stream().pipeThrough(new CompressionStream("deflate-raw"));
  const b = new Uint8Array(await new Response(stream).arrayBuffer());
  let s = "";
  for (const c of b) s += String.fromCharCode(c);
  return btoa(s).replace(/\+/g, "-").replace(/\//g, "_").replace(/=+$/, "");
}

async function unpack(text) {
  const s = atob(text.replace(/-/g, "+").replace(/_/g, "/")), b = Uint8Array.from(s, (c) => c.charCodeAt(0));
  const stream = new Blob([b]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Response(stream).text();
}

let timer = 0;
function keep() {
  if (timer) clearTimeout(timer); else app.work++;
  const mine = timer = setTimeout(async () => {
    await save();
    if (timer === mine) { timer = 0; app.work--; }
  }, 150);
}

async function save() {
  const text = JSON.stringify(app.doc), { photo, ...rest } = app.doc;
  try {
    sessionStorage.setItem("document", text);
    localStorage.setItem("document", text);
  } catch (error) {                               // a large photo: keep the rest
    try {
      sessionStorage.setItem("document", JSON.stringify({ ...rest, photo: null }));
      localStorage.setItem("document", JSON.stringify({ ...rest, photo: null }));
    } catch (again) { /* no storage at all */ }
  }
  const packed = await pack(JSON.stringify({ ...rest, photo: null }));
  history.replaceState(null, "", `#${packed}`);
  try { sessionStorage.setItem("address", packed); } catch (error) { /* no storage */ }
}
addEventListener("pagehide", () => {
  try {
    sessionStorage.setItem("document", JSON.stringify(app.doc));
  } catch (error) { /* kept a moment ago */ }
});

export const address = async () => location.href.split("#")[0] + "#" +
  await pack(JSON.stringify({ ...app.doc, photo: null }));

// A document as a file or an address holds it; throws what is wrong with it.
export function accept(text) {
  const d = JSON.parse(text), b = blank();
  if (d.studio !== 1 || typeof d.path !== "object" || !Array.isArray(d.path.anchors)) throw new Error("this is no file of the studio");
  return { ...b, ...d, path: { ...b.path, ...d.path }, task: { ...b.task, ...d.task } };
}

export async function recall() {
  const kept = () => { try { return sessionStorage.getItem("document") || localStorage.getItem("document"); } catch (e) { return null; } };
  const here = location.hash.slice(1);
  let own = false;                                 // this window wrote the address; what it kept is as new or newer
  try { own = here && sessionStorage.getItem("address") === here; } catch (error) { /* no storage */ }
  for (const find of own ? [async () => kept(), async () => unpack(here)] : [async () => here && unpack(here), async () => kept()]) {
    try {
      const text = await find();
      if (text) {
        app.doc = accept(text);
        return true;
      }
    } catch (error) { /* the next place */ }
  }
  return false;
}
