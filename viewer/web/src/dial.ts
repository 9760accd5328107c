// From which sides surfaces were seen: azimuth around the scene, the middle is from above.

import * as THREE from "three";
import { normalOf, type Store } from "./store";

const AZIMUTHS = 24;
const RINGS = 3; // elevations up to 25°, 55°, 90°
const RING_TOP = [25, 55, 90].map((d) => (d * Math.PI) / 180);
const LOWEST = (-35 * Math.PI) / 180;

export interface Next {
  /** "left", "right", "higher", "lower" or "" where nothing is missing nearby. */
  hint: string;
  azimuth: number;
}

export class Dial {
  coverage = 0;
  private readonly filled = new Float64Array(AZIMUTHS * RINGS);
  private counted = 0;

  constructor(private readonly canvas: HTMLCanvasElement) {}

  clear(): void {
    this.filled.fill(0);
    this.counted = 0;
  }

  private binOf(direction: THREE.Vector3): { azimuth: number; ring: number } | null {
    const elevation = Math.asin(THREE.MathUtils.clamp(direction.y, -1, 1));
    if (elevation < LOWEST) return null;
    const turn = Math.atan2(direction.x, direction.z) / (2 * Math.PI);
    return {
      azimuth: Math.floor((turn - Math.floor(turn)) * AZIMUTHS) % AZIMUTHS,
      ring: RING_TOP.findIndex((top) => elevation <= top + 1e-6),
    };
  }

  /** Counts points that came since the last call, at most about 20 000 of them. */
  update(store: Store, toScreen: THREE.Quaternion): void {
    const added = store.count - this.counted;
    const step = Math.max(1, Math.floor(added / 20000));
    const n = new THREE.Vector3();
    for (let id = this.counted; id < store.count; id += step) {
      const normal = normalOf(store.parts[id >> 16], id & 65535);
      if (!normal) continue;
      const bin = this.binOf(n.set(...normal).applyQuaternion(toScreen));
      if (bin) this.filled[bin.ring * AZIMUTHS + bin.azimuth] += step;
    }
    this.counted = store.count;
  }

  // Enough points to call a direction seen: a share of the mean of the outer rings.
  private enough(): number {
    const outer = this.filled.slice(0, AZIMUTHS * 2);
    const seen = outer.filter((v) => v > 0);
    if (seen.length === 0) return 1;
    return Math.max(50, 0.15 * (seen.reduce((a, b) => a + b, 0) / seen.length));
  }

  /** The nearest direction that is missing, as seen from the camera's. */
  next(here: THREE.Vector3): Next {
    const bin = this.binOf(here);
    const enough = this.enough();
    const open = (azimuth: number, ring: number) =>
      this.filled[ring * AZIMUTHS + ((azimuth + AZIMUTHS) % AZIMUTHS)] < enough;
    let wanting = 0;
    for (let i = 0; i < 2 * AZIMUTHS; ++i) if (this.filled[i] < enough) ++wanting;
    this.coverage = 1 - wanting / (2 * AZIMUTHS);
    if (!bin) return { hint: "", azimuth: 0 };
    const ring = Math.min(bin.ring, 1);
    for (let step = 1; step <= AZIMUTHS / 2; ++step) {
      // Azimuth grows counter-clockwise from above: to the right of who looks inwards.
      for (const [side, hint] of [[1, "right"], [-1, "left"]] as const) {
        if (open(bin.azimuth + side * step, ring)) {
          return { hint, azimuth: (bin.azimuth + side * step + 0.5) / AZIMUTHS };
        }
      }
      if (step === 2) {
        const other = 1 - ring;
        if (open(bin.azimuth, other)) {
          return { hint: other > ring ? "higher" : "lower", azimuth: (bin.azimuth + 0.5) / AZIMUTHS };
        }
      }
    }
    return { hint: "", azimuth: 0 };
  }

  draw(here: THREE.Vector3 | null, next: Next, view: number, ink: string, accent: string): void {
    const ratio = Math.min(devicePixelRatio, 2);
    const size = this.canvas.clientWidth;
    if (size === 0) return;
    if (this.canvas.width !== Math.round(size * ratio)) {
      this.canvas.width = this.canvas.height = Math.round(size * ratio);
    }
    const c = this.canvas.getContext("2d")!;
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.clearRect(0, 0, size, size);
    const middle = size / 2;
    const radius = middle - 12;
    const enough = this.enough();
    const edges = [radius, 0.66 * radius, 0.33 * radius, 0];
    // What the viewer sees in front is at the bottom of the dial.
    const angle = (azimuth: number) => Math.PI / 2 - 2 * Math.PI * azimuth + view;
    for (let ring = 0; ring < RINGS; ++ring) {
      for (let i = 0; i < AZIMUTHS; ++i) {
        const share = Math.min(1, this.filled[ring * AZIMUTHS + i] / enough);
        c.beginPath();
        c.arc(middle, middle, edges[ring] - 0.75, angle(i / AZIMUTHS) - 0.012, angle((i + 1) / AZIMUTHS) + 0.012, true);
        c.arc(middle, middle, edges[ring + 1] + 0.75, angle((i + 1) / AZIMUTHS) + 0.012, angle(i / AZIMUTHS) - 0.012);
        c.closePath();
        c.globalAlpha = 0.09;
        c.fillStyle = ink;
        c.fill();
        if (share > 0) {
          c.globalAlpha = 0.25 + 0.65 * share;
          c.fillStyle = accent;
          c.fill();
        }
      }
    }
    c.globalAlpha = 1;
    if (here) this.drawHere(c, here, angle, middle, radius, ink);
    if (next.hint) this.drawArrow(c, angle(next.azimuth), middle, radius, ink);
  }

  private drawHere(
    c: CanvasRenderingContext2D,
    here: THREE.Vector3,
    angle: (azimuth: number) => number,
    middle: number,
    radius: number,
    ink: string,
  ): void {
    const elevation = Math.max(0, Math.asin(THREE.MathUtils.clamp(here.y, -1, 1)));
    const a = angle(Math.atan2(here.x, here.z) / (2 * Math.PI));
    const r = radius * (1 - elevation / (Math.PI / 2));
    c.beginPath();
    c.arc(middle + r * Math.cos(a), middle + r * Math.sin(a), 4.5, 0, 2 * Math.PI);
    c.fillStyle = ink;
    c.fill();
  }

  private drawArrow(c: CanvasRenderingContext2D, a: number, middle: number, radius: number, ink: string): void {
    c.save();
    c.translate(middle + (radius + 6) * Math.cos(a), middle + (radius + 6) * Math.sin(a));
    c.rotate(a);
    c.beginPath();
    c.moveTo(-6, 0);
    c.lineTo(5, -5);
    c.lineTo(5, 5);
    c.closePath();
    c.fillStyle = ink;
    c.fill();
    c.restore();
  }
}
