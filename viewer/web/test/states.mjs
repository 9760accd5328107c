// The states that a page comes to when something goes wrong, each by the real program: the board out
// of sight, an address of an earlier run, a program that is gone, nothing to see.
//
//   node states.mjs LIVEMVS OUTPUT-FOLDER [WORDS]   the tests alone whose names hold the words
//
// Renders what it films. Exits with 77, which CTest takes as skipped, where there is no Chromium or
// no playwright-core. Pictures of every state, on a desk and on a phone, are left in the folder.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { chmodSync, existsSync, linkSync, mkdirSync, readdirSync, renameSync, rmSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { runTests, start } from "./program.mjs";

const [program, output, only = ""] = process.argv.slice(2);
const chromiumPath = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find((p) => existsSync(p));
const playwright = await import("playwright-core").catch(() => null);
if (!chromiumPath || !playwright) {
  console.log(`skipped: ${chromiumPath ? "no playwright-core; run npm ci in viewer/web" : "no Chromium"}`);
  process.exit(77);
}
const SEEN = 40; // frames of the board, then
const LOST = 150; // without it, then
const AGAIN = 15; // of it
const FRAMES = SEEN + LOST + AGAIN;

function livemvs(...args) {
  const done = spawnSync(program, args, { encoding: "utf8" });
  assert.equal(done.status, 0, `${args.join(" ")}: ${done.stderr}`);
}

// A film of the board, in which it is out of sight for a while, and one in which it is never seen.
function render() {
  const film = join(output, "film");
  if (existsSync(join(film, "bare"))) return film;
  rmSync(film, { recursive: true, force: true });
  mkdirSync(film, { recursive: true });
  const synth = (scene, frames, name) =>
    livemvs("synth", "--scene", scene, "--frames", String(frames), "--arc", "70", "--size", "640x480", "--spp", "1", "--images", "--no-mesh", "--progress", "none", "--output", join(film, name));
  synth("board", SEEN + AGAIN, "board");
  synth("table", 8, "table"); // a picture that only repeats the one before is left out
  const images = join(film, "board", "images");
  const names = readdirSync(images).sort();
  mkdirSync(join(film, "bare"));
  const nameOf = (i) => `${String(i).padStart(6, "0")}.png`;
  const other = (i) => join(film, "table", "images", nameOf(i % 8));
  for (const [i, name] of names.entries()) {
    if (i >= SEEN) renameSync(join(images, name), join(images, nameOf(i + LOST)));
  }
  for (let i = SEEN; i < SEEN + LOST; ++i) linkSync(other(i), join(images, nameOf(i)));
  for (let i = 0; i < LOST; ++i) linkSync(other(i), join(film, "bare", nameOf(i)));
  return film;
}

const browser = await playwright.chromium.launch({
  executablePath: chromiumPath,
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"],
});
const PATIENCE = { timeout: 90000, polling: 50 };
const DESK = { viewport: { width: 1100, height: 700 }, colorScheme: "dark" };
const PHONE = { viewport: { width: 390, height: 780 }, colorScheme: "light", hasTouch: true, isMobile: true, deviceScaleFactor: 2 };
const pause = (ms) => new Promise((done) => setTimeout(done, ms));
const until = (page, condition, argument) => page.waitForFunction(condition, argument, PATIENCE);
const status = (page, text) => until(page, (t) => window.__stats?.status === t, text);

async function open(url, options = DESK) {
  const context = await browser.newContext(options);
  const page = await context.newPage();
  await page.goto(url);
  return page;
}

// One after the other: both draw with the same two cores. Nothing may lie on anything else.
async function look(pages, name) {
  for (const [kind, page] of Object.entries(pages)) {
    await page.screenshot({ path: join(output, `${kind}-${name}.png`) });
    const overlap = await page.evaluate(() => {
      const ids = ["numbers", "camera", "coverage", "banner", "scale", "status"];
      const boxes = [...ids.map((id) => document.getElementById(id)), document.querySelector("nav")].filter((e) => e && !e.hidden);
      const rects = boxes.map((e) => e.getBoundingClientRect());
      for (let i = 0; i < rects.length; ++i) {
        for (let j = 0; j < i; ++j) {
          const [a, b] = [rects[i], rects[j]];
          const over = Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1 && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1;
          if (over) return `${boxes[i].id || "nav"} over ${boxes[j].id || "nav"}`;
        }
      }
      return "";
    });
    assert.equal(overlap, "", `${kind}-${name}`);
  }
}

mkdirSync(output, { recursive: true });
const film = render();
const board = join(film, "board");
const scan = (images, name, ...more) => {
  rmSync(join(output, name), { recursive: true, force: true });
  return ["scan", "--data", images, "--board", join(board, "board.json"), "--calibration", join(board, "intrinsics.txt"), "-o", join(output, name), "--seeds", "20000", "--progress", "none", "--view", "--no-browser", ...more];
};
const flip = async (pages) => {
  for (const page of Object.values(pages)) await page.evaluate(() => document.getElementById("b-theme").click());
  await pause(500);
};
const banner = (page) => page.textContent("#banner");

const tests = [];
const test = (name, body) => tests.push({ name, body });
let run;
let pages = {};
let port;

test("a recording waits to be started, and starts", async () => {
  run = await start(program, scan(join(board, "images"), "scan", "--realtime", "--wait", "--port", "0"));
  port = new URL(run.url).port;
  pages = { desk: await open(run.url), phone: await open(run.url, PHONE) };
  for (const page of Object.values(pages)) await status(page, "Ready");
  await pause(500);
  await look(pages, "ready");
  assert.equal(await pages.desk.textContent("#b-pause"), "Start");
  await pages.desk.click("#b-pause");
  await status(pages.desk, "Live");
});

test("without the board in sight it is lost, goes on showing the camera's picture, and comes back", async () => {
  await status(pages.desk, "Lost");
  const before = await pages.desk.evaluate(() => window.__stats.previews);
  await until(pages.desk, (n) => window.__stats.status === "Lost" && window.__stats.previews > n, before);
  run.hold(); // pictures take longer than it stays so
  await pause(500);
  await look(pages, "lost");
  assert.match(await banner(pages.desk), /Tracking lost.*[Bb]oard not seen/);
  run.release();
  await until(pages.desk, () => window.__stats.status === "Live" || window.__stats.status === "Finished");
  assert.ok(await pages.desk.isHidden("#banner"));
});

test("it finishes; a scale in centimetres is known from the board", async () => {
  for (const page of Object.values(pages)) await status(page, "Finished");
  await pause(1500);
  await look(pages, "finished");
  assert.match(await pages.desk.textContent("#scale"), /\s(cm|mm|m)$/u);
  assert.equal(await pages.desk.textContent("#l-time"), "Time");
});

test("a program that is closed leaves what there is", async () => {
  await run.stop();
  for (const page of Object.values(pages)) await until(page, () => window.__stats.link === "cut");
  await pause(1000);
  await look(pages, "closed");
  assert.match(await banner(pages.desk), /closed/);
  assert.ok(await pages.desk.isEnabled("#b-save"));
});

test("an address of an earlier run does not let in, and the page says so", async () => {
  const old = run.url;
  run = await start(program, scan(join(film, "bare"), "bare", "--realtime", "--wait", "--port", port));
  for (const page of Object.values(pages)) await until(page, () => window.__stats.link === "refused");
  await pause(300);
  await look(pages, "refused");
  assert.match(await banner(pages.desk), /another run/);
  for (const [kind, options] of [["desk", DESK], ["phone", PHONE]]) {
    const stranger = await open(old, options);
    await stranger.screenshot({ path: join(output, `${kind}-not-allowed.png`) });
    assert.match(await stranger.textContent("h1"), /Not allowed/);
    assert.match(await stranger.textContent("p"), /Open the address/);
    // Its style got past its own policy.
    assert.match(await stranger.evaluate(() => getComputedStyle(document.body).backgroundImage), /gradient/);
    await stranger.context().close();
  }
  for (const page of Object.values(pages)) await page.context().close();
});

test("a board that is never seen is told while it is looked for", async () => {
  pages = { desk: await open(run.url, { ...DESK, colorScheme: "light" }), phone: await open(run.url, { ...PHONE, colorScheme: "dark" }) };
  await status(pages.desk, "Ready");
  await pages.desk.click("#b-pause");
  await status(pages.desk, "Searching");
  await until(pages.desk, () => window.__stats.previews > 0);
  run.hold();
  await pause(500);
  await look(pages, "searching");
  assert.match(await pages.desk.textContent("#empty-hint"), /[Bb]oard not seen/);
  run.release();
  await until(pages.desk, () => window.__stats.ended !== null || window.__stats.link === "cut");
  for (const page of Object.values(pages)) await page.context().close();
  assert.equal(await run.ended, 3);
});

test("a run that fails says why, and keeps what it has", async () => {
  // A disk that is full: the journal may not grow beyond so much.
  const limited = join(output, "limited.sh");
  writeFileSync(limited, `#!/bin/bash\nulimit -f 64\nexec "${program}" "$@"\n`);
  chmodSync(limited, 0o755);
  run = await start(limited, scan(join(board, "images"), "failed", "--realtime", "--wait", "--port", "0"));
  pages = { desk: await open(run.url), phone: await open(run.url, PHONE) };
  for (const page of Object.values(pages)) await status(page, "Ready");
  await pages.desk.click("#b-pause");
  for (const page of Object.values(pages)) await status(page, "Failed");
  await pause(1500);
  await look(pages, "failed");
  assert.match(await banner(pages.desk), /The run failed.*\S/);
  assert.equal(await run.ended, 4);
  await flip(pages);
  await look(pages, "failed-other-theme");
  for (const page of Object.values(pages)) await page.context().close();
});

test("a program that dies leaves the page disconnected, and trying", async () => {
  run = await start(program, scan(join(board, "images"), "killed", "--realtime", "--wait", "--port", "0"));
  pages = { desk: await open(run.url), phone: await open(run.url, PHONE) };
  for (const page of Object.values(pages)) await status(page, "Ready");
  await pages.desk.click("#b-pause");
  for (const page of Object.values(pages)) await until(page, () => window.__stats.points > 500);
  await run.kill();
  for (const page of Object.values(pages)) await status(page, "Disconnected");
  await pause(1500);
  await look(pages, "disconnected");
  assert.match(await banner(pages.desk), /Connection lost/);
  assert.ok(await pages.desk.isEnabled("#b-save"));
  await flip(pages);
  await look(pages, "disconnected-other-theme");
  for (const page of Object.values(pages)) await page.context().close();
});

test("a scan's mesh and its points, from afar and from near", async () => {
  livemvs("mesh", join(output, "scan"), "-o", join(output, "scan", "model.glb")); // closed before, it may have left it out
  for (const name of ["model.glb", "cloud.ply"]) {
    run = await start(program, ["view", join(output, "scan", name), "--no-browser", "--port", "0"]);
    pages = { desk: await open(run.url), phone: await open(run.url, PHONE) };
    for (const page of Object.values(pages)) await status(page, "Finished");
    await pause(1500);
    await look(pages, name);
    await flip(pages);
    await look(pages, `${name}-other-theme`);
    await pages.desk.mouse.move(550, 330);
    for (let i = 0; i < 14; ++i) {
      await pages.desk.mouse.wheel(0, -240);
      await pause(60);
    }
    await pause(2000);
    await look({ desk: pages.desk }, `${name}-near`);
    assert.equal(await pages.desk.isVisible("#modes"), name === "cloud.ply"); // which a mesh has no use for
    for (const page of Object.values(pages)) await page.context().close();
    assert.equal(await run.stop(), 0);
  }
});

const failed = await runTests(tests.filter((t) => t.name.includes(only)), async () => {
  for (const [kind, page] of Object.entries(pages)) {
    console.log(JSON.stringify(await page.evaluate(() => window.__stats).catch(() => null)));
    await page.screenshot({ path: join(output, `${kind}-at-failure.png`) }).catch(() => {});
  }
});
await run?.stop();
await browser.close();
process.exit(failed ? 1 : 0);
