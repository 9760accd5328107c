// The stream's bytes; docs/data-formats.md and docs/viewer.md describe them.

export const enum Type {
  Session = 1,
  Camera = 2,
  Scene = 3,
  Frame = 4,
  Points = 5,
  Refined = 6,
  Removed = 7,
  Statistics = 8,
  Message = 9,
  End = 10,
  Hello = 256,
  Preview = 257,
  Live = 258,
  Mesh = 259,
}

export const UNNUMBERED = 0xffffffff;
const MAGIC = 0x52564d4c; // "LMVR"
const HEADER = 20;

export interface Rec {
  type: number;
  sequence: number;
  data: DataView;
}

/** The records of a message; stops at bytes that are none. */
export function* records(buffer: ArrayBuffer): Generator<Rec> {
  const view = new DataView(buffer);
  let at = 0;
  while (at + HEADER <= view.byteLength && view.getUint32(at, true) === MAGIC) {
    const length = view.getUint32(at + 8, true);
    if (at + HEADER + length > view.byteLength) return;
    yield {
      type: view.getUint16(at + 4, true),
      sequence: view.getUint32(at + 12, true),
      data: new DataView(buffer, at + HEADER, length),
    };
    at += HEADER + ((length + 3) & ~3);
  }
}

function text(view: DataView, at: number): string {
  const length = Math.min(view.getUint32(at, true), view.byteLength - at - 4);
  return new TextDecoder().decode(new Uint8Array(view.buffer, view.byteOffset + at + 4, length));
}

function json(view: DataView, at: number): Record<string, unknown> {
  try {
    const value: unknown = JSON.parse(text(view, at));
    return typeof value === "object" && value !== null ? (value as Record<string, unknown>) : {};
  } catch {
    return {};
  }
}

export const decodeSession = (v: DataView) => json(v, 16);
export const decodeJson = (v: DataView) => json(v, 0);

export interface CameraInfo {
  width: number;
  height: number;
  fx: number;
  fy: number;
  cx: number;
  cy: number;
}
export const decodeCamera = (v: DataView): CameraInfo => ({
  width: v.getUint32(4, true),
  height: v.getUint32(8, true),
  fx: v.getFloat64(16, true),
  fy: v.getFloat64(24, true),
  cx: v.getFloat64(32, true),
  cy: v.getFloat64(40, true),
});

export interface SceneInfo {
  box: { min: number[]; max: number[] } | null;
  origin: string;
}
export function decodeScene(v: DataView): SceneInfo {
  const side = (at: number) => [0, 1, 2].map((k) => v.getFloat64(at + 8 * k, true));
  return {
    box: v.getUint32(0, true) === 1 ? { min: side(24), max: side(48) } : null,
    origin: text(v, 72),
  };
}

export interface FrameInfo {
  index: number;
  time: number;
  tracking: number;
  /** cam_from_world: quaternion w x y z and translation, or null. */
  pose: number[] | null;
}
export const decodeFrame = (v: DataView): FrameInfo => ({
  index: Number(v.getBigInt64(0, true)),
  time: v.getFloat64(8, true),
  tracking: v.getUint8(16),
  pose:
    v.getUint8(17) === 1
      ? Array.from({ length: 7 }, (_, k) => v.getFloat64(32 + 8 * k, true))
      : null,
});

export interface PointsPart {
  frame: number;
  count: number;
  firstId: number;
  view: DataView;
  min: number[];
  extent: number[];
  sigmaScale: number;
  footprintScale: number;
}
export const POINTS_HEADER = 48;
export const POINT_BYTES = 16;

export function decodePoints(v: DataView): PointsPart | null {
  if (v.byteLength < POINTS_HEADER) return null;
  const count = v.getUint32(8, true);
  if (v.byteLength < POINTS_HEADER + count * POINT_BYTES) return null;
  const floats = (at: number) => [0, 1, 2].map((k) => v.getFloat32(at + 4 * k, true));
  return {
    frame: Number(v.getBigInt64(0, true)),
    count,
    firstId: v.getUint32(12, true),
    view: v,
    min: floats(16),
    extent: floats(28),
    sigmaScale: v.getFloat32(40, true),
    footprintScale: v.getFloat32(44, true),
  };
}

export function decodeIds(v: DataView, at: number, count: number): Uint32Array {
  const ids = new Uint32Array(count);
  for (let i = 0; i < count && at + 4 * i + 4 <= v.byteLength; ++i) ids[i] = v.getUint32(at + 4 * i, true);
  return ids;
}

export const decodeMessage = (v: DataView) => ({ level: v.getUint32(0, true), text: text(v, 4) });
export const decodeEnd = (v: DataView) => ({
  reason: v.getUint32(0, true),
  frames: Number(v.getBigInt64(8, true)),
  points: Number(v.getBigInt64(16, true)),
  text: text(v, 24),
});

export interface PreviewInfo {
  frame: number;
  marks: DataView;
  markCount: number;
  jpeg: Uint8Array;
}
export function decodePreview(v: DataView): PreviewInfo | null {
  const markCount = v.getUint32(16, true);
  const bytes = v.getUint32(20, true);
  const start = 24 + 8 * markCount;
  if (start + bytes > v.byteLength) return null;
  return {
    frame: Number(v.getBigInt64(0, true)),
    marks: new DataView(v.buffer, v.byteOffset + 24, 8 * markCount),
    markCount,
    jpeg: new Uint8Array(v.buffer, v.byteOffset + start, bytes),
  };
}

export interface MeshPart {
  positions: Float32Array;
  colors: Uint8Array | null;
  indices: Uint32Array;
}
export function decodeMesh(v: DataView): MeshPart | null {
  const vertices = v.getUint32(0, true);
  const faces = v.getUint32(4, true);
  if (v.byteLength < 16 + vertices * 16 + faces * 12) return null;
  const bytes = v.buffer.slice(v.byteOffset, v.byteOffset + v.byteLength) as ArrayBuffer;
  const indices = new Uint32Array(bytes, 16 + 16 * vertices, 3 * faces);
  for (const index of indices) if (index >= vertices) return null;
  return {
    positions: new Float32Array(bytes, 16, 3 * vertices),
    colors: v.getUint32(8, true) === 1 ? new Uint8Array(bytes, 16 + 12 * vertices, 4 * vertices) : null,
    indices,
  };
}
