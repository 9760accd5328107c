// Measures what the viewer costs and how late points are: plays a recording with the viewer and a
// client that reads, and without.
//
//   node latency.mjs LIVEMVS RUNS [livemvs run arguments but -o]
//
// Prints the frames/s of each run, and the age of points on arrival: from the engine's handing them
// over to the client's reading them. With STALLED=1 in the environment, a second client is connected
// that stops reading.

import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { readRecords, start, upgrade } from "./program.mjs";

const [program, runs, ...args] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), "livemvs-latency-"));
const common = ["run", ...args, "-o", join(folder, "out.ply"), "--stats", join(folder, "out.json"), "--progress", "none"];
const rate = () => JSON.parse(readFileSync(join(folder, "out.json"), "utf8")).frames_per_second;

async function watched() {
  const run = await start(program, [...common, "--view", "--no-browser", "--port", "0"]);
  const arrivals = new Map();
  const ages = [];
  let bytes = 0;
  let previews = 0;
  let done;
  const end = new Promise((resolve) => (done = resolve));
  const stalled = process.env.STALLED ? await upgrade(run.url) : null;
  stalled?.socket.pause(); // it takes nothing any more
  readRecords(await upgrade(run.url), (type, sequence, payload) => {
    const now = Date.now() / 1000;
    bytes += payload.length;
    if (type === 5) arrivals.set(Number(payload.readBigInt64LE(0)), now);
    if (type === 257) ++previews;
    if (type === 258) {
      for (const [frame, time] of JSON.parse(payload.subarray(4).toString()).handed) {
        if (arrivals.has(frame)) ages.push(1000 * (arrivals.get(frame) - time));
        arrivals.delete(frame);
      }
    }
    if (type === 10) done();
  });
  await end;
  while (!run.output().includes("stays open")) await new Promise((r) => setTimeout(r, 20));
  stalled?.socket.destroy();
  await run.stop();
  ages.sort((a, b) => a - b);
  return { rate: rate(), ages, bytes, previews };
}

const median = (list) => [...list].sort((a, b) => a - b)[Math.floor(list.length / 2)];
const withView = [];
const without = [];
let ages = [];
for (let i = 0; i < Number(runs); ++i) {
  spawnSync(program, common, { stdio: "ignore" });
  without.push(rate());
  const w = await watched();
  withView.push(w.rate);
  ages = ages.concat(w.ages);
  console.log(`without ${without.at(-1).toFixed(1)} frames/s, with ${w.rate.toFixed(1)}; ${(w.bytes / 1e6).toFixed(1)} MB, ${w.previews} pictures`);
}
ages.sort((a, b) => a - b);
const q = (p) => ages[Math.min(ages.length - 1, Math.floor(p * ages.length))].toFixed(0);
console.log(`median without ${median(without).toFixed(1)}, with ${median(withView).toFixed(1)} frames/s: ${(100 * (1 - median(withView) / median(without))).toFixed(1)} % less`);
console.log(`age of ${ages.length} frames' points on arrival: median ${q(0.5)} ms, 99 % within ${q(0.99)} ms, at most ${ages.at(-1).toFixed(0)} ms`);
