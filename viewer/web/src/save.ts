// What the page holds, as files: made here, so that nothing of it depends on the server.

import { HIDDEN_VIEWS, normalOf, type Store } from "./store";

export type Inside = ((x: number, y: number, z: number) => boolean) | null;

function chosen(store: Store, inside: Inside): number {
  let n = 0;
  each(store, inside, () => ++n);
  return n;
}

function each(store: Store, inside: Inside, visit: (part: number, at: number) => void): void {
  store.parts.forEach((part, p) => {
    for (let i = 0; i < part.used; ++i) {
      if (part.info[4 * i + 3] === HIDDEN_VIEWS) continue;
      const x = part.position[3 * i];
      if (inside && !inside(x, part.position[3 * i + 1], part.position[3 * i + 2])) continue;
      visit(p, i);
    }
  });
}

/** Binary PLY with the fields that livemvs writes. */
export function toPly(store: Store, inside: Inside): Blob {
  const n = chosen(store, inside);
  const header =
    "ply\nformat binary_little_endian 1.0\ncomment livemvs viewer\n" +
    "comment normals towards the camera that saw the point\n" +
    `element vertex ${n}\n` +
    ["x", "y", "z", "nx", "ny", "nz"].map((p) => `property float ${p}\n`).join("") +
    ["red", "green", "blue"].map((p) => `property uchar ${p}\n`).join("") +
    "property float sigma\nproperty float inlier_ratio\nproperty ushort views\nend_header\n";
  const stride = 37;
  const out = new DataView(new ArrayBuffer(n * stride));
  let o = 0;
  each(store, inside, (p, i) => {
    const part = store.parts[p];
    const normal = normalOf(part, i) ?? [0, 0, 0];
    for (let k = 0; k < 3; ++k) {
      out.setFloat32(o + 4 * k, part.position[3 * i + k], true);
      out.setFloat32(o + 12 + 4 * k, normal[k], true);
      out.setUint8(o + 24 + k, part.color[4 * i + k]);
    }
    out.setFloat32(o + 27, part.info[4 * i], true);
    out.setFloat32(o + 31, part.color[4 * i + 3] / 255, true);
    out.setUint16(o + 35, part.info[4 * i + 3], true);
    o += stride;
  });
  return new Blob([header, out.buffer], { type: "application/octet-stream" });
}

/** Binary glTF: points with colours. Its y is up, so the scene's axes are turned. */
export function toGlb(store: Store, inside: Inside, turn: [number, number, number, number]): Blob {
  const n = chosen(store, inside);
  const positions = new Float32Array(3 * n);
  const colors = new Uint8Array(4 * n);
  const min = [Infinity, Infinity, Infinity];
  const max = [-Infinity, -Infinity, -Infinity];
  let o = 0;
  each(store, inside, (p, i) => {
    const part = store.parts[p];
    for (let k = 0; k < 3; ++k) {
      const v = part.position[3 * i + k];
      positions[3 * o + k] = v;
      min[k] = Math.min(min[k], v);
      max[k] = Math.max(max[k], v);
      colors[4 * o + k] = part.color[4 * i + k];
    }
    colors[4 * o + 3] = 255;
    ++o;
  });
  const views = [
    { buffer: 0, byteOffset: 0, byteLength: 12 * n, target: 34962 },
    { buffer: 0, byteOffset: 12 * n, byteLength: 4 * n, target: 34962 },
  ];
  const gltf = {
    asset: { version: "2.0", generator: "livemvs" },
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0, rotation: turn }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0, COLOR_0: 1 }, mode: 0 }] }],
    accessors: [
      { bufferView: 0, componentType: 5126, count: n, type: "VEC3", min, max },
      { bufferView: 1, componentType: 5121, normalized: true, count: n, type: "VEC4" },
    ],
    bufferViews: views,
    buffers: [{ byteLength: 16 * n }],
  };
  let json = new TextEncoder().encode(JSON.stringify(gltf));
  const padded = new Uint8Array((json.length + 3) & ~3).fill(0x20);
  padded.set(json);
  json = padded;
  const head = new DataView(new ArrayBuffer(20));
  const words = [0x46546c67, 2, 12 + 8 + json.length + 8 + 16 * n, json.length, 0x4e4f534a];
  words.forEach((w, i) => head.setUint32(4 * i, w, true));
  const body = new DataView(new ArrayBuffer(8));
  body.setUint32(0, 16 * n, true);
  body.setUint32(4, 0x004e4942, true);
  return new Blob([head.buffer, json, body.buffer, positions, colors], { type: "model/gltf-binary" });
}

export function download(blob: Blob, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
