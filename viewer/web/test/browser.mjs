// The viewer in a real browser, on a real run of the bundled sample played at its own pace.
//
//   node browser.mjs LIVEMVS SAMPLE-FOLDER OUTPUT-FOLDER
//
// Exits with 77, which CTest takes as skipped, where there is no Chromium or no playwright-core.
// Pictures of every state are left in the output folder.

import assert from "node:assert/strict";
import { existsSync, mkdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { get, readRecords, runTests, start, upgrade } from "./program.mjs";

const [program, sample, output] = process.argv.slice(2);
const chromiumPath = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find((p) => existsSync(p));
const playwright = await import("playwright-core").catch(() => null);
if (!chromiumPath || !playwright) {
  console.log(`skipped: ${chromiumPath ? "no playwright-core; run npm ci in viewer/web" : "no Chromium"}`);
  process.exit(77);
}
mkdirSync(output, { recursive: true });

const browser = await playwright.chromium.launch({
  executablePath: chromiumPath,
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"],
});
const complaints = [];
const PATIENCE = { timeout: 60000, polling: 100 };

async function open(url, options = {}) {
  const context = await browser.newContext({ viewport: { width: 860, height: 540 }, colorScheme: "dark", acceptDownloads: true, ...options });
  const page = await context.newPage();
  page.on("pageerror", (error) => complaints.push(error.message));
  page.on("console", (message) => {
    // A connection that is refused because the server is gone is what one test is about.
    if (message.type() === "error" && !/WebSocket|ERR_CONNECTION_REFUSED|Failed to load resource/.test(message.text())) complaints.push(message.text());
  });
  await page.goto(url);
  await page.waitForFunction(() => window.__stats !== undefined, null, PATIENCE);
  return page;
}
const stats = (page) => page.evaluate(() => window.__stats);
const until = (page, condition, argument) => page.waitForFunction(condition, argument, PATIENCE);
const pixels = (page) => page.evaluate(() => window.__livemvs.count());
const shot = (page, name) => page.screenshot({ path: join(output, `${name}.png`) });
const pause = (ms) => new Promise((done) => setTimeout(done, ms));

const tests = [];
const test = (name, body) => tests.push({ name, body });

let run;
let page;
const runArgs = (ply) => ["run", "--data", sample, "-o", join(output, ply), "--seeds", "40000", "--progress", "none", "--speed", "0.04", "--view", "--no-browser", "--port", "0"];

test("the address lets in, and the token leaves it", async () => {
  run = await start(program, runArgs("live.ply"));
  page = await open(run.url);
  await shot(page, "empty");
  assert.equal(new URL(page.url()).search, "");
});

test("points grow, in the numbers and in the picture", async () => {
  await until(page, () => window.__stats.points > 500);
  await page.evaluate(() => window.__livemvs.hold()); // the view, or it would step back
  const first = (await stats(page)).points;
  const covered = (await pixels(page)).covered;
  assert.ok(covered > 100, `${covered} pixels`);
  await until(page, (n) => window.__stats.points > 2 * n, first);
  await shot(page, "live");
  // Points that refine others add no pixels: it may take a few more of them.
  let grown = 0;
  for (let tries = 0; tries < 20 && grown <= covered; ++tries) {
    grown = (await pixels(page)).covered;
    await pause(500);
  }
  assert.ok(grown > covered, `the picture did not grow: ${covered}, then ${grown} pixels`);
  const now = await stats(page);
  assert.equal(now.status, "Live");
  assert.ok(now.previews > 0 && now.latencies > 0);
});

test("pausing stops it at once, and going on goes on", async () => {
  // The frame under way may still come, but seldom is one: most of the time the next is awaited.
  let stoppedAtOnce = 0;
  for (let n = 0; n < 3; ++n) {
    await page.click("#b-pause");
    await until(page, () => window.__stats.status === "Paused");
    const before = await stats(page);
    await pause(2000); // more than two frames' time
    const after = await stats(page);
    assert.equal(after.status, "Paused");
    assert.ok(after.frames <= before.frames + 1, `${after.frames - before.frames} frames came`);
    if (after.frames === before.frames) ++stoppedAtOnce;
    if (n === 0) {
      await shot(page, "paused");
      await pause(1200);
      assert.equal((await stats(page)).points, after.points);
    }
    await page.keyboard.press("Space");
    await until(page, (last) => window.__stats.status === "Live" && window.__stats.frames > last.frames && window.__stats.points > last.points, after);
  }
  assert.ok(stoppedAtOnce > 0, "each time a frame came that should have waited");
});

test("strangers are refused", async () => {
  const { host, port } = new URL(run.url);
  const origin = `http://${host}`;
  assert.equal((await get(`${origin}/`)).status, 403);
  assert.equal((await get(`${origin}/?token=0123456789abcdef0123456789abcdef`)).status, 403);
  assert.equal((await get(`${origin}/app.js`)).status, 403);
  assert.equal((await get(run.url, { host: `evil.example:${port}` })).status, 421);
  assert.equal((await upgrade(run.url, { origin: "http://evil.example" })).status, 403);
  assert.equal((await upgrade(run.url, { host: `evil.example:${port}` })).status, 421);
  assert.equal((await upgrade(run.url, { cookie: "" })).status, 403);
  assert.equal((await upgrade(run.url, { cookie: `livemvs_${port}=0123456789abcdef0123456789abcdef` })).status, 403);
});

test("a second client sees the same, and one that stops reading holds nobody up", async () => {
  const stalled = await upgrade(run.url);
  assert.equal(stalled.status, 101);
  stalled.socket.pause();
  let records = 0;
  const reader = await upgrade(run.url);
  readRecords(reader, (type, sequence) => {
    if (sequence !== 0xffffffff) records = sequence + 1;
  });
  const before = (await stats(page)).next;
  await until(page, (n) => window.__stats.next > n + 10, before);
  await pause(500);
  assert.ok(records > before, `${records} of ${before}`);
  stalled.socket.destroy();
  reader.socket.destroy();
});

test("a cut line is joined where it broke", async () => {
  const before = await stats(page);
  await page.evaluate(() => window.__livemvs.cut());
  await until(page, () => window.__stats.reconnects === 1 && window.__stats.link === "open");
  await until(page, (n) => window.__stats.next > n, before.next);
  const after = await stats(page);
  assert.ok(after.points >= before.points);
  assert.equal(after.malformed, 0);
});

test("finishing writes the cloud", async () => {
  await page.click("#b-finish");
  await until(page, () => window.__stats.status === "Finished");
  await pause(300);
  assert.equal(readFileSync(join(output, "live.ply")).subarray(0, 4).toString(), "ply\n");
  assert.ok(await page.isHidden("#b-pause"));
  assert.ok((await stats(page)).ended.frames < 180);
  await page.keyboard.press("r");
  await pause(1500);
  await shot(page, "finished");
});

test("each colour mode shows something of its own", async () => {
  const seen = new Map();
  for (const [key, mode] of ["rgb", "normal", "confidence", "sigma", "views", "age"].entries()) {
    await page.keyboard.press(String(key + 1));
    await until(page, (m) => window.__stats.mode === m, mode);
    const { covered, colors } = await pixels(page);
    assert.ok(covered > 500, `${mode}: ${covered} pixels`);
    await pause(400);
    await shot(page, `mode-${mode}`);
    const picture = (await page.locator("#view").screenshot()).toString("base64");
    for (const [other, bytes] of seen) assert.notEqual(picture, bytes, `${mode} looks like ${other}`);
    seen.set(mode, picture);
    assert.ok(colors > 3, `${mode}: ${colors} colours`);
  }
  await page.keyboard.press("1");
});

test("the points can be saved", async () => {
  const points = (await stats(page)).points;
  for (const format of ["ply", "glb"]) {
    await page.click("#b-save");
    await shot(page, "save");
    const [download] = await Promise.all([page.waitForEvent("download"), page.click(`[data-format=${format}]`)]);
    const path = join(output, `saved.${format}`);
    await download.saveAs(path);
    const bytes = readFileSync(path);
    if (format === "ply") {
      const header = bytes.subarray(0, 800).toString("latin1");
      assert.equal(Number(/element vertex (\d+)/.exec(header)[1]), points);
      assert.equal(bytes.length, header.indexOf("end_header\n") + 11 + 37 * points);
    } else {
      assert.equal(bytes.subarray(0, 4).toString(), "glTF");
      assert.equal(bytes.readUInt32LE(8), bytes.length);
    }
  }
});

test("measuring and the box", async () => {
  await page.keyboard.press("m");
  // Clicks on a grid until two of them meet points.
  for (let y = 230; y < 400 && (await page.isHidden("#ruler")); y += 24) {
    for (let x = 380; x < 560 && (await page.isHidden("#ruler")); x += 90) {
      await page.mouse.click(x, y);
      await page.evaluate(() => window.__livemvs.count());
    }
  }
  assert.ok(await page.isVisible("#ruler"));
  assert.match(await page.textContent("#ruler"), /\d/);
  await shot(page, "measure");
  await page.keyboard.press("Escape");
  const all = (await pixels(page)).covered;
  await page.keyboard.press("b");
  await pause(300);
  assert.equal(await page.getAttribute("#b-box", "aria-pressed"), "true");
  await shot(page, "box");
  await page.keyboard.press("Escape");
  assert.ok(all > 0);
});

test("a page that is left alone says so", async () => {
  await run.stop();
  await until(page, () => window.__stats.link === "cut");
  await pause(300);
  await shot(page, "disconnected");
  assert.ok(await page.isVisible("#banner"));
  await page.context().close();
});

test("what was saved can be viewed, on a phone and in light", async () => {
  run = await start(program, ["view", join(output, "saved.ply"), "--no-browser", "--port", "0"]);
  page = await open(run.url, { viewport: { width: 390, height: 780 }, deviceScaleFactor: 2, hasTouch: true, isMobile: true, colorScheme: "light" });
  await until(page, () => window.__stats.points > 500 && window.__stats.status === "Finished");
  await pause(1500);
  await shot(page, "phone");
  assert.ok((await pixels(page)).covered > 500);
  await page.tap("#modes button:nth-child(3)");
  await until(page, () => window.__stats.mode === "confidence");
  const wide = await page.evaluate(() => document.documentElement.scrollWidth);
  assert.ok(wide <= 390, `${wide} px wide`);
  await page.context().close();
  assert.equal(await run.stop(), 0);
});

test("a mesh can be viewed", async () => {
  run = await start(program, ["view", join(sample, "mesh.ply.gz"), "--no-browser", "--port", "0"]);
  page = await open(run.url);
  await until(page, () => window.__stats.triangles > 100);
  await pause(1500);
  assert.ok((await pixels(page)).covered > 500);
  await shot(page, "mesh");
  await page.context().close();
  assert.equal(await run.stop(), 0);
});

const failed = await runTests(tests, async () => {
  if (!page) return;
  console.log(JSON.stringify(await stats(page).catch(() => null)));
  await shot(page, "failed").catch(() => {});
});
await run?.stop();
await browser.close();
if (complaints.length > 0) console.log("the browser complained:", complaints);
process.exit(failed || complaints.length > 0 ? 1 : 0);
