// Wires the stream to the picture.

import * as THREE from "three";
import { Connection, type LinkState } from "./connection";
import { Controls } from "./controls";
import { Dial, type Next } from "./dial";
import { el, showNumbers, showRamp, showScale, showSpeed, showState, describe, type Live, type RunState } from "./hud";
import { Inset } from "./inset";
import * as P from "./protocol";
import { Rig } from "./rig";
import { Splats } from "./splats";
import { Stage } from "./stage";
import { Store } from "./store";
import { CropBox, Ruler } from "./tools";
import { Statistics } from "./statistics";

const store = new Store();
const stage = new Stage(el<HTMLCanvasElement>("view"));
const splats = new Splats(store);
const rig = new Rig();
const inset = new Inset(el<HTMLCanvasElement>("inset"));
const dial = new Dial(el<HTMLCanvasElement>("dial"));
const ruler = new Ruler(stage, store, el("ruler"));
const box = new CropBox(stage, splats);
const meshes = new THREE.Group();
stage.world.add(splats.group, meshes);
stage.overlay.add(rig.group);

const state: RunState = { link: "connecting", engine: "running", tracking: 1, ended: null, points: 0, source: "", problem: "" };
let unit = "";
const NOTHING: Live = {
  frames: 0,
  frames_total: 0,
  frames_dropped: 0,
  seeds: 0,
  motion_px: 0,
  window_px: 0,
  sharpness: 1,
  elapsed_s: 0,
};
let live: Live | null = null;
let triangles = 0;
/** Sum of the triangles' normals, by area: an open surface faces who filmed it. */
const facing = new THREE.Vector3();
let sceneBox: P.SceneInfo["box"] = null;
let next: Next = { hint: "", azimuth: 0 };
let oriented = false;
const statistics = new Statistics();

function clear(): void {
  store.clear();
  splats.clear();
  rig.clear();
  dial.clear();
  meshes.clear();
  triangles = 0;
  facing.set(0, 0, 0);
  state.ended = null;
  oriented = false;
}

const connection = new Connection({
  link(link: LinkState) {
    state.link = link;
    refresh();
  },
  record(record) {
    statistics.records++;
    try {
      take(record);
    } catch (error) {
      statistics.malformed++;
      console.warn("a record was passed over:", record.type, error);
    }
  },
});

function take({ type, data }: P.Rec): void {
  switch (type) {
    case P.Type.Hello: {
      const hello = P.decodeJson(data);
      if (connection.adopt(String(hello.session ?? ""))) clear();
      controls.allow(hello.controls === true);
      state.source = String(hello.title ?? "");
      break;
    }
    case P.Type.Session: {
      unit = String(P.decodeSession(data).unit ?? "");
      state.ended = null;
      break;
    }
    case P.Type.Camera:
      rig.setCamera(P.decodeCamera(data));
      break;
    case P.Type.Scene:
      sceneBox = P.decodeScene(data).box;
      break;
    case P.Type.Frame: {
      const frame = P.decodeFrame(data);
      state.tracking = frame.tracking;
      rig.move(frame);
      controls.follow();
      break;
    }
    case P.Type.Points: {
      const part = P.decodePoints(data);
      if (!part) throw new Error("short");
      store.add(part);
      statistics.arrived(part.frame);
      break;
    }
    case P.Type.Refined: {
      const part = P.decodePoints(data);
      if (!part) throw new Error("short");
      store.refine(part, P.decodeIds(data, P.POINTS_HEADER + part.count * P.POINT_BYTES, part.count));
      break;
    }
    case P.Type.Removed:
      store.remove(P.decodeIds(data, 4, data.getUint32(0, true)));
      break;
    case P.Type.Message:
      statistics.messages.push(P.decodeMessage(data).text);
      break;
    case P.Type.End:
      state.ended = P.decodeEnd(data);
      break;
    case P.Type.Statistics:
      // A journal's; where the program is there itself, what it says of this moment counts.
      if (!live) live = { ...NOTHING, ...P.decodeJson(data) };
      break;
    case P.Type.Live: {
      const json = P.decodeJson(data);
      live = json as unknown as Live;
      state.engine = String(json.state ?? "running");
      state.problem = String(json.problem ?? "");
      statistics.handed(json.handed);
      statistics.frames(live.frames);
      break;
    }
    case P.Type.Preview: {
      const preview = P.decodePreview(data);
      if (preview) inset.show(preview);
      el("camera").hidden = false;
      break;
    }
    case P.Type.Mesh:
      addMesh(P.decodeMesh(data));
      break;
  }
  changed = true;
}

function addMesh(part: P.MeshPart | null): void {
  if (!part) throw new Error("malformed mesh");
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(part.positions, 3));
  if (part.colors) geometry.setAttribute("color", new THREE.BufferAttribute(part.colors, 4, true));
  geometry.setIndex(new THREE.BufferAttribute(part.indices, 1));
  const material = new THREE.MeshLambertMaterial({
    color: part.colors ? 0xffffff : 0xb8bec8,
    vertexColors: part.colors !== null,
    flatShading: true,
    side: THREE.DoubleSide,
  });
  meshes.add(new THREE.Mesh(geometry, material));
  triangles += part.indices.length / 3;
  addFacing(part);
}

function addFacing({ positions, indices }: P.MeshPart): void {
  const corner = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
  for (let f = 0; f < indices.length; f += 3) {
    corner.forEach((c, k) => c.fromArray(positions, 3 * indices[f + k]));
    const [a, b, c] = corner;
    facing.add(b.sub(a).cross(c.sub(a)));
  }
}

// What is shown, in the scene's axes.
function bounds(): { min: number[]; max: number[] } | null {
  if (triangles > 0) {
    const all = new THREE.Box3();
    for (const mesh of meshes.children) {
      const geometry = (mesh as THREE.Mesh).geometry;
      if (!geometry.boundingBox) geometry.computeBoundingBox();
      all.union(geometry.boundingBox!);
    }
    return { min: all.min.toArray(), max: all.max.toArray() };
  }
  return store.bounds();
}

// Turns the scene's up to the screen's, from the first cameras on.
function orient(): void {
  if (oriented && store.lastFrame > 30) return;
  const up = rig.known ? rig.sceneUp() : new THREE.Vector3(0, 0, 1);
  stage.world.quaternion.setFromUnitVectors(up, new THREE.Vector3(0, 1, 0));
  stage.world.updateMatrixWorld(true);
  oriented = rig.known || state.ended !== null;
}

const controls = new Controls({ store, stage, splats, rig, ruler, box, connection, state, bounds, facing: () => facing, sceneBox: () => sceneBox, unit: () => unit, refresh: () => refresh() });

let changed = true;
let lastDial = 0;

function refresh(): void {
  changed = true;
}

function update(): void {
  requestAnimationFrame(update);
  if (changed) {
    changed = false;
    state.points = store.visible + triangles;
    splats.sync();
    orient();
    const known = bounds();
    if (known) {
      stage.radius = Math.max(0.5 * Math.hypot(...known.max.map((v, k) => v - known.min[k])), 1e-9);
      rig.size = 0.16 * stage.radius;
      controls.frame(known);
    }
    showState(state);
    rig.setLost(state.tracking === 2 && !state.ended);
    showNumbers(live, store.visible, triangles, statistics.rate, state.ended !== null);
    if (live) showSpeed(live, describe(state).text === "Live");
    controls.update(live !== null);
    stage.invalidate();
  }
  const now = performance.now();
  if (now - lastDial > 200) {
    lastDial = now;
    updateDial();
    if (splats.mode !== "rgb") showRamp(splats.mode, splats.updateRange(), unit);
    statistics.publish({ store, stage, splats, connection, state, live, inset, dial, triangles });
  }
}

function updateDial(): void {
  dial.update(store, stage.world.quaternion);
  el("coverage").hidden = !rig.known || store.count === 0;
  if (el("coverage").hidden) return;
  const here = rig.forward.clone().negate().applyQuaternion(stage.world.quaternion);
  next = state.ended ? { hint: "", azimuth: 0 } : dial.next(here);
  if (state.ended) dial.next(here);
  const eye = stage.camera.position.clone().sub(stage.controls.target);
  const style = getComputedStyle(document.documentElement);
  dial.draw(state.ended ? null : here, next, Math.atan2(eye.x, eye.z), style.getPropertyValue("--ink"), style.getPropertyValue("--accent"));
  el("coverage-text").textContent = `${Math.round(100 * dial.coverage)}\u202f% seen`;
  el("next-text").textContent = next.hint ? `go ${next.hint}` : "";
}

stage.onBeforeDraw = () => {
  splats.fit(stage.camera, stage.renderer.domElement.height, stage.radius, stage.pixelRatio);
  ruler.place(unit);
  const distance = stage.camera.position.distanceTo(stage.controls.target);
  const perPixel = (2 * distance * Math.tan((stage.camera.fov * Math.PI) / 360)) / stage.renderer.domElement.clientHeight;
  showScale(perPixel, unit, state.points > 0);
};

// The token has done its work: the cookie lets everything else in.
if (location.search) history.replaceState(null, "", "/");
connection.open();
requestAnimationFrame(update);
