// What `livemvs export` writes, as other people's readers see it: Khronos' validator, three.js in a
// real browser, and copc's reader for LAS.
//
//   node exports.mjs LIVEMVS SAMPLE-FOLDER OUTPUT-FOLDER
//
// Exits with 77, which CTest takes as skipped, where Chromium or npm's packages are missing.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { dirname, extname, join } from "node:path";
import { fileURLToPath } from "node:url";

const [program, sample, output] = process.argv.slice(2);
const web = join(dirname(fileURLToPath(import.meta.url)), "..");
const chromiumPath = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find((p) => existsSync(p));
const packages = await Promise.all(["playwright-core", "gltf-validator", "copc"].map((name) => import(name).catch(() => null)));
if (!chromiumPath || packages.includes(null)) {
  console.log("skipped: needs Chromium, and the packages of viewer/web (scripts/setup --dev)");
  process.exit(77);
}
const [playwright, validator, { Las }] = packages;

rmSync(output, { recursive: true, force: true });
mkdirSync(output, { recursive: true });
const file = (name) => join(output, name);
const livemvs = (...args) => execFileSync(program, args, { encoding: "utf8" });

// A binary PLY's header, and its rows as the header describes them.
function readPly(path) {
  const bytes = readFileSync(path);
  const end = bytes.indexOf("end_header\n") + "end_header\n".length;
  const header = bytes.subarray(0, end).toString("latin1");
  const count = Number(/element vertex (\d+)/.exec(header)[1]);
  const names = [...header.matchAll(/property (\w+) (\w+)\n/g)].map((m) => [m[2], m[1]]);
  const read = {
    float: (offset) => bytes.readFloatLE(offset),
    uchar: (offset) => bytes.readUInt8(offset),
    ushort: (offset) => bytes.readUInt16LE(offset),
    int: (offset) => bytes.readInt32LE(offset),
  };
  const size = { float: 4, uchar: 1, ushort: 2, int: 4 };
  const stride = names.reduce((sum, [, type]) => sum + size[type], 0);
  const at = (i) => {
    let offset = end + i * stride;
    const row = {};
    for (const [name, type] of names) {
      row[name] = read[type](offset);
      offset += size[type];
    }
    return row;
  };
  return { count, at };
}

livemvs("run", "--data", sample, "-o", file("cloud.ply"), "--seeds", "8000", "--last-frame", "59", "--progress", "none");
const mesh = join(sample, "mesh.ply.gz");
livemvs("export", file("cloud.ply"), "-o", file("cloud.glb"));
const CRS = 'LOCAL_CS["board",UNIT["metre",1]]';
writeFileSync(file("board.wkt"), `${CRS}\n`);
livemvs("export", file("cloud.ply"), "-o", file("cloud.las"), "--crs", file("board.wkt"));
livemvs("export", mesh, "-o", file("mesh.glb"));
livemvs("export", mesh, "-o", file("draco.glb"), "--draco");
const cloud = readPly(file("cloud.ply"));
assert.ok(cloud.count > 500, `${cloud.count} points`);

const tests = [];
const test = (name, body) => tests.push({ name, body });

test("Khronos' validator finds nothing wrong", async () => {
  for (const name of ["cloud.glb", "mesh.glb", "draco.glb"]) {
    const report = await validator.validateBytes(new Uint8Array(readFileSync(file(name))));
    const { numErrors, numWarnings } = report.issues;
    assert.equal(numErrors + numWarnings, 0, `${name}: ${JSON.stringify(report.issues.messages.slice(0, 3))}`);
  }
});

test("copc's reader reads the LAS file: header, points, colours, extra bytes", async () => {
  const bytes = readFileSync(file("cloud.las"));
  const header = Las.Header.parse(bytes);
  assert.deepEqual([header.majorVersion, header.minorVersion, header.pointDataRecordFormat, header.pointCount], [1, 4, 7, cloud.count]);
  assert.equal(header.pointCountByReturn[0], cloud.count);
  assert.equal(bytes.length, header.pointDataOffset + cloud.count * header.pointDataRecordLength);
  const records = await Las.Vlr.walk(async (begin, end) => new Uint8Array(bytes.subarray(begin, end)), header);
  const wkt = Las.Vlr.find(records, "LASF_Projection", 2112);
  assert.equal(bytes.subarray(wkt.contentOffset, wkt.contentOffset + wkt.contentLength).toString(), `${CRS}\0`);
  const extra = Las.Vlr.find(records, "LASF_Spec", 4);
  const fields = Las.ExtraBytes.parse(bytes.subarray(extra.contentOffset, extra.contentOffset + extra.contentLength));
  assert.deepEqual(fields.map((f) => f.name), ["sigma", "inlier_ratio", "views", "nx", "ny", "nz"]);
  const view = Las.View.create(new Uint8Array(bytes.subarray(header.pointDataOffset)), header, fields);
  const get = Object.fromEntries(["X", "Y", "Z", "Red", "Green", "Blue", ...fields.map((f) => f.name)].map((name) => [name, view.getter(name)]));
  const low = [Infinity, Infinity, Infinity];
  for (let i = 0; i < cloud.count; i++) {
    const row = cloud.at(i);
    ["x", "y", "z"].forEach((axis, k) => {
      const value = get[axis.toUpperCase()](i);
      low[k] = Math.min(low[k], value);
      assert.ok(Math.abs(value - row[axis]) <= header.scale[k], `${axis} of point ${i}`);
    });
    assert.deepEqual([get.Red(i), get.Green(i), get.Blue(i)], [row.red, row.green, row.blue].map((v) => 257 * v));
    assert.deepEqual([get.sigma(i), get.inlier_ratio(i), get.views(i)], [row.sigma, row.inlier_ratio, row.views]);
    ["nx", "ny", "nz"].forEach((n) => assert.ok(Math.abs(get[n](i) - row[n]) < 1e-5, `${n} of point ${i}`));
  }
  low.forEach((v, k) => assert.ok(Math.abs(v - header.min[k]) < header.scale[k] / 2, `${v} is not the least, ${header.min[k]}`));
});

// A page that loads files with three.js and draws them.
const PAGE = `<!doctype html><script type="importmap">{"imports": {"three": "/three/build/three.module.js"}}</script>
<canvas id="c" width="640" height="480"></canvas><script type="module">
import * as THREE from "three";
import { GLTFLoader } from "/three/examples/jsm/loaders/GLTFLoader.js";
import { DRACOLoader } from "/three/examples/jsm/loaders/DRACOLoader.js";
import { PLYLoader } from "/three/examples/jsm/loaders/PLYLoader.js";
const renderer = new THREE.WebGLRenderer({ canvas: document.getElementById("c"), preserveDrawingBuffer: true });
const draco = new DRACOLoader().setDecoderPath("/three/examples/jsm/libs/draco/gltf/");
window.show = async (name) => {
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0x30343c);
  let object;
  if (name.endsWith(".ply")) {
    object = new THREE.Points(await new PLYLoader().loadAsync("/out/" + name), new THREE.PointsMaterial({ vertexColors: true }));
  } else {
    object = (await new GLTFLoader().setDRACOLoader(draco).loadAsync("/out/" + name)).scene;
  }
  scene.add(object, new THREE.HemisphereLight(0xffffff, 0xffffff, 3));
  object.updateMatrixWorld(true);
  let drawn;
  object.traverse((o) => { if (o.isPoints || o.isMesh) drawn = o; });
  if (drawn.isPoints) drawn.material.size = 3, drawn.material.sizeAttenuation = false;
  const box = new THREE.Box3().setFromObject(object, true);
  const sphere = box.getBoundingSphere(new THREE.Sphere());
  const camera = new THREE.PerspectiveCamera(40, 4 / 3, sphere.radius / 100, sphere.radius * 10);
  camera.position.copy(sphere.center).add(new THREE.Vector3(0.2, 1, 1).normalize().multiplyScalar(2.4 * sphere.radius));
  camera.lookAt(sphere.center);
  renderer.render(scene, camera);
  const geometry = drawn.geometry;
  const color = geometry.getAttribute("color");
  const position = geometry.getAttribute("position");
  const first = new THREE.Vector3().fromBufferAttribute(position, 0).applyMatrix4(drawn.matrixWorld);
  const srgb = color ? new THREE.Color().fromBufferAttribute(color, 0).convertLinearToSRGB() : null;
  return { points: drawn.isPoints === true, count: position.count, faces: geometry.index ? geometry.index.count / 3 : 0, normals: !!geometry.getAttribute("normal"),
    first: first.toArray(), color: srgb && srgb.toArray().map((v) => Math.round(255 * v)), min: box.min.toArray(), max: box.max.toArray() };
};
window.ready = true;
</script>`;
const TYPES = { ".js": "text/javascript", ".wasm": "application/wasm" };
const server = createServer((request, response) => {
  const url = request.url.split("?")[0];
  if (url === "/favicon.ico") return response.writeHead(204).end();
  if (url === "/") return response.setHeader("content-type", "text/html").end(PAGE);
  const path = url.startsWith("/three/") ? join(web, "node_modules", url) : join(output, url.replace("/out/", ""));
  if (!existsSync(path)) return response.writeHead(404).end();
  response.setHeader("content-type", TYPES[extname(path)] ?? "application/octet-stream").end(readFileSync(path));
});
await new Promise((done) => server.listen(0, "127.0.0.1", done));
const browser = await playwright.chromium.launch({
  executablePath: chromiumPath,
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"],
});
const page = await (await browser.newContext({ viewport: { width: 660, height: 500 } })).newPage();
page.on("console", (message) => message.type() === "error" && console.log("page:", message.text()));
await page.goto(`http://127.0.0.1:${server.address().port}/`);
await page.waitForFunction(() => window.ready, null, { timeout: 60000 });
const show = async (name) => {
  const seen = await page.evaluate((n) => window.show(n), name);
  await page.locator("#c").screenshot({ path: file(`${name}.png`) });
  return seen;
};
const near = (a, b, tolerance) => a.forEach((v, i) => assert.ok(Math.abs(v - b[i]) <= tolerance, `${a} is not ${b}`));

test("three.js reads the cloud: its place, y up, and its colours", async () => {
  const seen = await show("cloud.glb");
  const row = cloud.at(0);
  assert.ok(seen.points);
  assert.equal(seen.count, cloud.count);
  near(seen.first, [row.x, row.z, -row.y], 1e-6);
  assert.deepEqual(seen.color, [row.red, row.green, row.blue]);
  const ply = await show("cloud.ply");
  assert.equal(ply.count, cloud.count);
  near([seen.min[0], seen.min[1], -seen.max[2]], [ply.min[0], ply.min[2], ply.min[1]], 1e-6);
});

test("three.js reads the mesh, and the same of Draco's", async () => {
  const seen = await show("mesh.glb");
  const packed = await show("draco.glb");
  assert.ok(!seen.points && seen.normals && packed.normals);
  assert.ok(seen.faces > 10);
  assert.ok(packed.faces > 0 && packed.faces <= seen.faces);
  const longest = Math.max(...seen.max.map((v, i) => v - seen.min[i]));
  near(packed.min, seen.min, longest / 65535);
  near(packed.max, seen.max, longest / 65535);
});

let failed = 0;
for (const { name, body } of tests) {
  try {
    await body();
    console.log(`passed: ${name}`);
  } catch (error) {
    failed++;
    console.log(`FAILED: ${name}\n${error.stack}`);
  }
}
await browser.close();
server.close();
process.exit(failed ? 1 : 0);
