// All points, in parts that the graphics card takes as they are. A point's id says where it lies.

import { POINTS_HEADER, POINT_BYTES, type PointsPart } from "./protocol";

const PART_LOG2 = 16;
export const PART = 1 << PART_LOG2;

export interface Part {
  position: Float32Array; // 3 a point
  color: Uint8Array; // rgb and confidence
  normal: Int8Array; // octahedral, in 127ths; -128: none
  info: Float32Array; // sigma, footprint, frame, views
  used: number;
  /** What changed since it was last drawn: [first, end). */
  dirtyFrom: number;
  dirtyTo: number;
}

export const HIDDEN_VIEWS = -1;

export class Store {
  parts: Part[] = [];
  count = 0; // ids that were given
  removed = 0;
  lastFrame = 0;
  hasFootprints = false;
  version = 0;
  /** A few positions, evenly over all, for measures that stray points must not move. */
  private sample: number[] = [];
  private sampleEvery = 1;
  private sampleNext = 0;

  clear(): void {
    this.parts = [];
    this.count = this.removed = this.lastFrame = 0;
    this.sample = [];
    this.sampleEvery = 1;
    this.sampleNext = 0;
    ++this.version;
  }

  get visible(): number {
    return this.count - this.removed;
  }

  add(part: PointsPart): void {
    for (let i = 0; i < part.count; ++i) this.write(part, i, part.firstId + i);
    this.count = Math.max(this.count, part.firstId + part.count);
    this.lastFrame = Math.max(this.lastFrame, part.frame);
    ++this.version;
  }

  refine(part: PointsPart, ids: Uint32Array): void {
    for (let i = 0; i < part.count; ++i) {
      if (ids[i] < this.count) this.write(part, i, ids[i]);
    }
    ++this.version;
  }

  remove(ids: Uint32Array): void {
    for (const id of ids) {
      if (id >= this.count) continue;
      const part = this.parts[id >> PART_LOG2];
      const at = id & (PART - 1);
      if (part.info[4 * at + 3] === HIDDEN_VIEWS) continue;
      part.info[4 * at + 3] = HIDDEN_VIEWS;
      this.touch(part, at);
      ++this.removed;
    }
    ++this.version;
  }

  private write(from: PointsPart, i: number, id: number): void {
    const part = this.partOf(id);
    const at = id & (PART - 1);
    const v = from.view;
    const o = POINTS_HEADER + i * POINT_BYTES;
    for (let k = 0; k < 3; ++k) {
      part.position[3 * at + k] =
        from.min[k] + (v.getUint16(o + 2 * k, true) / 65535) * from.extent[k];
      part.color[4 * at + k] = v.getUint8(o + 8 + k);
    }
    part.normal[2 * at] = v.getInt8(o + 6);
    part.normal[2 * at + 1] = v.getInt8(o + 7);
    part.color[4 * at + 3] = v.getUint8(o + 11);
    const level = (q: number, scale: number) => (q === 255 ? 0 : scale * 2 ** (-q / 16));
    const footprint = level(v.getUint8(o + 13), from.footprintScale);
    part.info[4 * at] = level(v.getUint8(o + 12), from.sigmaScale);
    part.info[4 * at + 1] = footprint;
    part.info[4 * at + 2] = from.frame;
    part.info[4 * at + 3] = v.getUint8(o + 14);
    if (footprint > 0) this.hasFootprints = true;
    this.touch(part, at);
    if (id >= this.count && this.sampleNext++ % this.sampleEvery === 0) this.keepSample(part, at);
  }

  private touch(part: Part, at: number): void {
    part.used = Math.max(part.used, at + 1);
    part.dirtyFrom = Math.min(part.dirtyFrom, at);
    part.dirtyTo = Math.max(part.dirtyTo, at + 1);
  }

  private partOf(id: number): Part {
    const index = id >> PART_LOG2;
    while (this.parts.length <= index) {
      const info = new Float32Array(4 * PART);
      for (let i = 3; i < info.length; i += 4) info[i] = HIDDEN_VIEWS;
      this.parts.push({
        position: new Float32Array(3 * PART),
        color: new Uint8Array(4 * PART),
        normal: new Int8Array(2 * PART),
        info,
        used: 0,
        dirtyFrom: PART,
        dirtyTo: 0,
      });
    }
    return this.parts[index];
  }

  private keepSample(part: Part, at: number): void {
    const limit = 3 * 3000;
    this.sample.push(part.position[3 * at], part.position[3 * at + 1], part.position[3 * at + 2]);
    if (this.sample.length < limit) return;
    // Every other one goes, and half as many come from now on.
    const kept: number[] = [];
    for (let i = 0; i < this.sample.length; i += 6) kept.push(...this.sample.slice(i, i + 3));
    this.sample = kept;
    this.sampleEvery *= 2;
  }

  /** Box of the middle 96 % along each axis. */
  bounds(): { min: number[]; max: number[] } | null {
    if (this.sample.length < 3) return null;
    const min: number[] = [];
    const max: number[] = [];
    for (let k = 0; k < 3; ++k) {
      const values: number[] = [];
      for (let i = k; i < this.sample.length; i += 3) values.push(this.sample[i]);
      values.sort((a, b) => a - b);
      min.push(values[Math.floor(0.02 * (values.length - 1))]);
      max.push(values[Math.ceil(0.98 * (values.length - 1))]);
    }
    return { min, max };
  }

  /** Quantiles 5 % and 95 % of a value of up to about 4000 points. */
  range(value: (part: Part, at: number) => number): [number, number] {
    const values: number[] = [];
    const step = Math.max(1, Math.floor(this.count / 4000));
    for (let id = 0; id < this.count; id += step) {
      const part = this.parts[id >> PART_LOG2];
      const v = value(part, id & (PART - 1));
      if (Number.isFinite(v)) values.push(v);
    }
    if (values.length === 0) return [0, 1];
    values.sort((a, b) => a - b);
    return [values[Math.floor(0.05 * (values.length - 1))], values[Math.ceil(0.95 * (values.length - 1))]];
  }
}

/** Unit normal of a point, or null. */
export function normalOf(part: Part, at: number): [number, number, number] | null {
  const q0 = part.normal[2 * at];
  const q1 = part.normal[2 * at + 1];
  if (q0 === -128) return null;
  let u = q0 / 127;
  let v = q1 / 127;
  const z = 1 - Math.abs(u) - Math.abs(v);
  if (z < 0) {
    const folded = (1 - Math.abs(v)) * (u < 0 ? -1 : 1);
    v = (1 - Math.abs(u)) * (v < 0 ? -1 : 1);
    u = folded;
  }
  const n = Math.hypot(u, v, z);
  return [u / n, v / n, z / n];
}
