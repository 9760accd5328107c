// The filming camera: where it is, what it sees, and the way it came.

import * as THREE from "three";
import type { CameraInfo, FrameInfo } from "./protocol";

const LOST = "#e5484d";
const MOST_PATH = 20000;

export class Rig {
  readonly group = new THREE.Group();
  /** In the scene's axes. */
  readonly center = new THREE.Vector3();
  readonly forward = new THREE.Vector3(0, 0, 1);
  readonly up = new THREE.Vector3(0, 1, 0);
  known = false;
  size = 0.1;
  private readonly upSum = new THREE.Vector3();
  private info: CameraInfo | null = null;
  private readonly frustum: THREE.LineSegments;
  private readonly path: THREE.Line;
  private readonly steps = new Float32Array(3 * MOST_PATH);
  private stepCount = 0;
  private color = "#5b8cff";
  private lost = false;

  constructor() {
    const line = (color: string, opacity: number) =>
      new THREE.LineBasicMaterial({ color, transparent: true, opacity, depthTest: false });
    this.frustum = new THREE.LineSegments(new THREE.BufferGeometry(), line("#5b8cff", 1));
    const geometry = new THREE.BufferGeometry();
    const attribute = new THREE.BufferAttribute(this.steps, 3);
    attribute.setUsage(THREE.DynamicDrawUsage);
    geometry.setAttribute("position", attribute);
    geometry.setDrawRange(0, 0);
    this.path = new THREE.Line(geometry, line("#5b8cff", 0.45));
    this.frustum.frustumCulled = this.path.frustumCulled = false;
    this.group.add(this.path, this.frustum);
    this.frustum.visible = false;
  }

  clear(): void {
    this.stepCount = 0;
    this.known = false;
    this.frustum.visible = false;
    this.upSum.set(0, 0, 0);
    this.path.geometry.setDrawRange(0, 0);
  }

  setColor(color: string): void {
    this.color = color;
    this.paint();
  }

  /** Lost: where the camera was last. */
  setLost(lost: boolean): void {
    if (lost === this.lost) return;
    this.lost = lost;
    this.paint();
  }

  private paint(): void {
    (this.frustum.material as THREE.LineBasicMaterial).color.set(this.lost ? LOST : this.color);
    (this.path.material as THREE.LineBasicMaterial).color.set(this.color);
  }

  setCamera(info: CameraInfo): void {
    this.info = info;
  }

  /** @return whether the camera's place is known. */
  move(frame: FrameInfo): boolean {
    if (!frame.pose) return false;
    const [w, x, y, z, tx, ty, tz] = frame.pose;
    const worldFromCam = new THREE.Quaternion(x, y, z, w).invert();
    this.center.set(-tx, -ty, -tz).applyQuaternion(worldFromCam);
    this.forward.set(0, 0, 1).applyQuaternion(worldFromCam);
    this.up.set(0, -1, 0).applyQuaternion(worldFromCam);
    this.upSum.add(this.up);
    this.known = true;
    this.frustum.visible = true;
    this.extendPath();
    this.drawFrustum(worldFromCam);
    return true;
  }

  /** The scene's up: the cameras' on average, or an axis of the scene that is nearly that. */
  sceneUp(): THREE.Vector3 {
    const up = this.upSum.clone().normalize();
    for (const axis of [new THREE.Vector3(0, 0, 1), new THREE.Vector3(0, 1, 0), new THREE.Vector3(0, -1, 0)]) {
      // Who films an object looks down at it: the mean leans towards it.
      if (up.dot(axis) > Math.cos((50 * Math.PI) / 180)) return axis;
    }
    return up;
  }

  private extendPath(): void {
    if (this.stepCount === MOST_PATH) {
      for (let i = 0; i < MOST_PATH / 2; ++i) this.steps.copyWithin(3 * i, 6 * i, 6 * i + 3);
      this.stepCount = MOST_PATH / 2;
    }
    this.center.toArray(this.steps, 3 * this.stepCount++);
    const attribute = this.path.geometry.getAttribute("position") as THREE.BufferAttribute;
    attribute.needsUpdate = true;
    this.path.geometry.setDrawRange(0, this.stepCount);
  }

  private drawFrustum(worldFromCam: THREE.Quaternion): void {
    const c = this.info ?? { width: 4, height: 3, fx: 4, fy: 4, cx: 2, cy: 1.5 };
    const at = (u: number, v: number) =>
      new THREE.Vector3((u - c.cx) / c.fx, (v - c.cy) / c.fy, 1)
        .multiplyScalar(this.size)
        .applyQuaternion(worldFromCam)
        .add(this.center);
    const corners = [at(0, 0), at(c.width, 0), at(c.width, c.height), at(0, c.height)];
    const roof = at(c.width / 2, -0.18 * c.height);
    const points: THREE.Vector3[] = [];
    corners.forEach((corner, i) => points.push(this.center, corner, corner, corners[(i + 1) % 4]));
    points.push(at(0.35 * c.width, 0), roof, roof, at(0.65 * c.width, 0));
    this.frustum.geometry.setFromPoints(points);
  }
}
