// Measuring between two points, and a box that keeps what is inside.

import * as THREE from "three";
import type { Splats } from "./splats";
import type { Stage } from "./stage";
import { HIDDEN_VIEWS, type Store } from "./store";
import { length } from "./format";

const PICK_PX = 9;

/** The point nearest to the eye of those drawn near a place of the picture; in the scene's axes. */
export function pick(store: Store, stage: Stage, x: number, y: number, reach = PICK_PX): THREE.Vector3 | null {
  const canvas = stage.renderer.domElement;
  const width = canvas.clientWidth;
  const height = canvas.clientHeight;
  stage.world.updateMatrixWorld();
  const m = new THREE.Matrix4()
    .multiplyMatrices(stage.camera.projectionMatrix, stage.camera.matrixWorldInverse)
    .multiply(stage.world.matrixWorld).elements;
  let best: THREE.Vector3 | null = null;
  let bestScore = Infinity;
  for (const part of store.parts) {
    for (let i = 0; i < part.used; ++i) {
      if (part.info[4 * i + 3] === HIDDEN_VIEWS) continue;
      const px = part.position[3 * i];
      const py = part.position[3 * i + 1];
      const pz = part.position[3 * i + 2];
      const w = m[3] * px + m[7] * py + m[11] * pz + m[15];
      if (w <= 0) continue;
      const dx = ((m[0] * px + m[4] * py + m[8] * pz + m[12]) / w + 1) * 0.5 * width - x;
      const dy = (1 - (m[1] * px + m[5] * py + m[9] * pz + m[13]) / w) * 0.5 * height - y;
      const off2 = dx * dx + dy * dy;
      if (off2 > reach * reach) continue;
      // Near the eye, and near the pointer: a pixel aside counts like half a percent of depth.
      const score = w * (1 + 0.005 * Math.sqrt(off2));
      if (score < bestScore) {
        bestScore = score;
        best = new THREE.Vector3(px, py, pz);
      }
    }
  }
  return best;
}

function onScreen(stage: Stage, point: THREE.Vector3): { x: number; y: number; ahead: boolean } {
  const p = stage.world.localToWorld(point.clone()).project(stage.camera);
  const canvas = stage.renderer.domElement;
  return { x: ((p.x + 1) / 2) * canvas.clientWidth, y: ((1 - p.y) / 2) * canvas.clientHeight, ahead: p.z < 1 };
}

export class Ruler {
  active = false;
  ends: THREE.Vector3[] = [];
  private readonly line: THREE.Line;
  private readonly dots: THREE.Points;

  constructor(private readonly stage: Stage, private readonly store: Store, private readonly label: HTMLElement) {
    const style = { color: "#5b8cff", depthTest: false, transparent: true };
    this.line = new THREE.Line(new THREE.BufferGeometry(), new THREE.LineBasicMaterial(style));
    this.dots = new THREE.Points(new THREE.BufferGeometry(), new THREE.PointsMaterial({ ...style, size: 8, sizeAttenuation: false }));
    this.line.frustumCulled = this.dots.frustumCulled = false;
    stage.overlay.add(this.line, this.dots);
  }

  setColor(color: string): void {
    (this.line.material as THREE.LineBasicMaterial).color.set(color);
    (this.dots.material as THREE.PointsMaterial).color.set(color);
  }

  toggle(on = !this.active): void {
    this.active = on;
    if (!on) this.ends = [];
    this.redraw();
  }

  click(x: number, y: number): void {
    const point = pick(this.store, this.stage, x, y);
    if (!point) return;
    if (this.ends.length === 2) this.ends = [];
    this.ends.push(point);
    this.redraw();
  }

  private redraw(): void {
    this.line.geometry.setFromPoints(this.ends);
    this.dots.geometry.setFromPoints(this.ends);
    this.stage.invalidate();
  }

  /** The distance [scene], or null. */
  get distance(): number | null {
    return this.ends.length === 2 ? this.ends[0].distanceTo(this.ends[1]) : null;
  }

  place(unit: string): void {
    const d = this.distance;
    this.label.hidden = d === null;
    if (d === null) return;
    const at = onScreen(this.stage, this.ends[0].clone().add(this.ends[1]).multiplyScalar(0.5));
    this.label.textContent = length(d, unit);
    this.label.style.transform = `translate(-50%, -50%) translate(${at.x}px, ${at.y - 18}px)`;
  }
}

export class CropBox {
  active = false;
  min = new THREE.Vector3(-1, -1, -1);
  max = new THREE.Vector3(1, 1, 1);
  private readonly edges: THREE.LineSegments;
  private readonly handles: THREE.Points;
  private dragged = -1;

  constructor(private readonly stage: Stage, private readonly splats: Splats) {
    const style = { color: "#5b8cff", depthTest: false, transparent: true };
    this.edges = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ ...style, opacity: 0.7 }));
    this.handles = new THREE.Points(new THREE.BufferGeometry(), new THREE.PointsMaterial({ ...style, size: 13, sizeAttenuation: false }));
    this.edges.frustumCulled = this.handles.frustumCulled = false;
    stage.overlay.add(this.edges, this.handles);
    this.redraw();
  }

  setColor(color: string): void {
    (this.edges.material as THREE.LineBasicMaterial).color.set(color);
    (this.handles.material as THREE.PointsMaterial).color.set(color);
  }

  toggle(bounds: { min: number[]; max: number[] } | null): void {
    this.active = !this.active && bounds !== null;
    if (this.active && bounds) {
      this.min.fromArray(bounds.min);
      this.max.fromArray(bounds.max);
    }
    this.redraw();
  }

  inside = (x: number, y: number, z: number): boolean =>
    x >= this.min.x && x <= this.max.x && y >= this.min.y && y <= this.max.y && z >= this.min.z && z <= this.max.z;

  private handle(i: number): THREE.Vector3 {
    const p = this.min.clone().add(this.max).multiplyScalar(0.5);
    p.setComponent(i >> 1, (i & 1 ? this.max : this.min).getComponent(i >> 1));
    return p;
  }

  grab(x: number, y: number): boolean {
    this.dragged = -1;
    if (!this.active) return false;
    let nearest = 16;
    for (let i = 0; i < 6; ++i) {
      const at = onScreen(this.stage, this.handle(i));
      const off = Math.hypot(at.x - x, at.y - y);
      if (at.ahead && off < nearest) {
        nearest = off;
        this.dragged = i;
      }
    }
    return this.dragged >= 0;
  }

  /** Moves the face that was grabbed along its axis, to follow the pointer. */
  drag(x: number, y: number): void {
    if (this.dragged < 0) return;
    const axis = this.dragged >> 1;
    const here = this.handle(this.dragged);
    const step = 0.01 * this.max.distanceTo(this.min);
    const ahead = here.clone();
    ahead.setComponent(axis, here.getComponent(axis) + step);
    const a = onScreen(this.stage, here);
    const b = onScreen(this.stage, ahead);
    const dx = b.x - a.x;
    const dy = b.y - a.y;
    const length2 = dx * dx + dy * dy;
    if (length2 < 1e-3) return;
    const moved = here.getComponent(axis) + (((x - a.x) * dx + (y - a.y) * dy) / length2) * step;
    if (this.dragged & 1) this.max.setComponent(axis, Math.max(moved, this.min.getComponent(axis) + step));
    else this.min.setComponent(axis, Math.min(moved, this.max.getComponent(axis) - step));
    this.redraw();
  }

  release(): void {
    this.dragged = -1;
  }

  private redraw(): void {
    this.edges.visible = this.handles.visible = this.active;
    const uniforms = this.splats.material.uniforms;
    uniforms.uClip.value = this.active ? 1 : 0;
    uniforms.uBoxMin.value.copy(this.min);
    uniforms.uBoxMax.value.copy(this.max);
    const corner = (i: number) =>
      new THREE.Vector3(i & 1 ? this.max.x : this.min.x, i & 2 ? this.max.y : this.min.y, i & 4 ? this.max.z : this.min.z);
    const lines: THREE.Vector3[] = [];
    for (let i = 0; i < 8; ++i) {
      for (const bit of [1, 2, 4]) if (!(i & bit)) lines.push(corner(i), corner(i | bit));
    }
    this.edges.geometry.setFromPoints(lines);
    this.handles.geometry.setFromPoints(Array.from({ length: 6 }, (_, i) => this.handle(i)));
    this.stage.invalidate();
  }
}
