// Questions to the server.  The page's own address ends with the token, so relative addresses carry it.
import { app } from "./state.js";

let down = false;
const listeners = new Set();

export function onConnection(f) { listeners.add(f); }

function connected(yes) {
  if (down === !yes) return;
  down = !yes;
  for (const f of listeners) f(yes);
  if (down) retry();
}

async function retry() {
  while (down) {
    await new Promise((go) => { setTimeout(go, 700); });
    try {
      await ask("begin", {});
    } catch (error) { /* still down */ }
  }
}

export class Refused extends Error {}        // the server answered: no, and why

async function send(name, body) {
  let reply;
  try {
    reply = await fetch(`api/${name}`, {
      method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body),
    });
  } catch (error) {
    connected(false);
    throw error;
  }
  connected(true);
  if (reply.ok) return reply;
  let said = { error: `the server answered ${reply.status}` };
  try { said = await reply.json(); } catch (error) { /* no text */ }
  throw Object.assign(new Refused(said.error), said);
}

async function answer(name, body, read) {
  const counted = name !== "news" && !down;                 // those two may wait for long
  if (counted) app.work++;
  try { return await read(await send(name, body)); } finally { if (counted) app.work--; }
}
export const ask = (name, body) => answer(name, body, (reply) => reply.json());
export const bytes = (name, body) => answer(name, body, (reply) => reply.blob());

// A question that is asked again and again while something is dragged: one at a time is on its way, and of those that
// wait only the newest is asked.
export function latest(name, done, failed) {
  let busy = false, next = null;
  async function go(body) {
    busy = true;
    try {
      done(await ask(name, body), body);
    } catch (error) {
      failed(error, body);
    }
    busy = false;
    if (next) {
      const body2 = next;
      next = null;
      go(body2);
    }
  }
  return (body) => { if (busy) next = body; else go(body); };
}
