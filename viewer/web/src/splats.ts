// Points as round splats, as wide as the surface that they stand for.

import * as THREE from "three";
import { PART, type Part, type Store } from "./store";

export const MODES = ["rgb", "normal", "confidence", "sigma", "views", "age"] as const;
export type Mode = (typeof MODES)[number];

// Dark blue by way of teal to pale yellow: even in lightness, and readable for the colour-blind.
export const RAMP: [number, number, number][] = [
  [0.19, 0.16, 0.42],
  [0.16, 0.39, 0.56],
  [0.15, 0.6, 0.57],
  [0.47, 0.79, 0.42],
  [0.97, 0.9, 0.36],
];

const VERTEX = /* glsl */ `
in vec4 aColor;
in vec2 aNormal;
in vec4 aInfo;
uniform float uScale, uDefault, uSplat, uLeast, uClose, uMost;
uniform int uMode, uClip;
uniform vec2 uRange;
uniform vec3 uRamp[5], uBoxMin, uBoxMax;
out vec3 vColor;

vec3 unfold(vec2 q) {
  if (q.x < -127.5) return vec3(0.0);
  vec3 n = vec3(q / 127.0, 0.0);
  n.z = 1.0 - abs(n.x) - abs(n.y);
  if (n.z < 0.0) {
    vec2 s = vec2(n.x < 0.0 ? -1.0 : 1.0, n.y < 0.0 ? -1.0 : 1.0);
    n.xy = (1.0 - abs(n.yx)) * s;
  }
  return normalize(n);
}

vec3 ramp(float t) {
  float x = clamp(t, 0.0, 1.0) * 4.0;
  int i = int(min(floor(x), 3.0));
  return mix(uRamp[i], uRamp[i + 1], x - float(i));
}

float share(float v) { return (v - uRange.x) / max(uRange.y - uRange.x, 1e-20); }

void main() {
  vec4 p = modelViewMatrix * vec4(position, 1.0);
  gl_Position = projectionMatrix * p;
  bool outside = uClip == 1 && (any(lessThan(position, uBoxMin)) || any(greaterThan(position, uBoxMax)));
  if (aInfo.w < 0.0 || outside) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  float width = (aInfo.y > 0.0 ? aInfo.y : uDefault) * uSplat;
  float size = uScale * width / max(-p.z, 1e-6);
  // From near they grow by the root alone, and come apart in the end: points, not discs.
  if (size > uClose) size = sqrt(size * uClose);
  gl_PointSize = clamp(size, uLeast, uMost);
  if (uMode == 0) {
    vColor = aColor.rgb;
  } else if (uMode == 1) {
    vColor = 0.5 + 0.5 * unfold(aNormal);
  } else if (uMode == 2) {
    vColor = ramp(aColor.a);
  } else if (uMode == 3) {
    vColor = ramp(1.0 - share(log2(max(aInfo.x, 1e-20))));
  } else if (uMode == 4) {
    vColor = ramp(share(log2(1.0 + aInfo.w)));
  } else {
    vColor = ramp(share(aInfo.z));
  }
}`;

const FRAGMENT = /* glsl */ `
in vec3 vColor;
out vec4 fragment;
void main() {
  vec2 c = 2.0 * gl_PointCoord - 1.0;
  if (dot(c, c) > 1.0) discard;
  fragment = vec4(vColor, 1.0);
}`;

// Cells of the map are about two pixels of the camera apart; a little more closes the surface.
const SPLAT_WIDTHS = 3;

export class Splats {
  readonly group = new THREE.Group();
  readonly material: THREE.ShaderMaterial;
  mode: Mode = "rgb";
  size = 1;
  private readonly drawn: THREE.Points[] = [];

  constructor(private readonly store: Store) {
    this.material = new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      uniforms: {
        uScale: { value: 1 },
        uDefault: { value: 0.01 },
        uSplat: { value: SPLAT_WIDTHS },
        uLeast: { value: 1.5 },
        uClose: { value: 6 },
        uMost: { value: 16 },
        uMode: { value: 0 },
        uClip: { value: 0 },
        uRange: { value: new THREE.Vector2(0, 1) },
        uRamp: { value: RAMP.map((c) => new THREE.Vector3(...c)) },
        uBoxMin: { value: new THREE.Vector3() },
        uBoxMax: { value: new THREE.Vector3() },
      },
    });
  }

  clear(): void {
    for (const points of this.drawn) {
      this.group.remove(points);
      points.geometry.dispose();
    }
    this.drawn.length = 0;
  }

  /** Hands what changed to the graphics card. */
  sync(): void {
    this.store.parts.forEach((part, i) => {
      if (!this.drawn[i]) this.drawn[i] = this.make(part);
      if (part.dirtyTo <= part.dirtyFrom) return;
      const geometry = this.drawn[i].geometry;
      for (const attribute of Object.values(geometry.attributes) as THREE.BufferAttribute[]) {
        const size = attribute.itemSize;
        attribute.addUpdateRange(part.dirtyFrom * size, (part.dirtyTo - part.dirtyFrom) * size);
        attribute.needsUpdate = true;
      }
      geometry.setDrawRange(0, part.used);
      part.dirtyFrom = PART;
      part.dirtyTo = 0;
    });
  }

  private make(part: Part): THREE.Points {
    const geometry = new THREE.BufferGeometry();
    const add = (name: string, array: THREE.TypedArray, size: number, normalized: boolean) => {
      const attribute = new THREE.BufferAttribute(array, size, normalized);
      attribute.setUsage(THREE.DynamicDrawUsage);
      geometry.setAttribute(name, attribute);
    };
    add("position", part.position, 3, false);
    add("aColor", part.color, 4, true);
    add("aNormal", part.normal, 2, false);
    add("aInfo", part.info, 4, false);
    const points = new THREE.Points(geometry, this.material);
    points.frustumCulled = false;
    this.group.add(points);
    return points;
  }

  setMode(mode: Mode): void {
    this.mode = mode;
    this.material.uniforms.uMode.value = MODES.indexOf(mode);
    this.updateRange();
  }

  /** The ends of the ramp, in what the mode shows. */
  updateRange(): [number, number] {
    const of: Partial<Record<Mode, (part: Part, at: number) => number>> = {
      sigma: (p, i) => Math.log2(Math.max(p.info[4 * i], 1e-20)),
      views: (p, i) => Math.log2(1 + Math.max(p.info[4 * i + 3], 0)),
      age: (p, i) => p.info[4 * i + 2],
    };
    const value = of[this.mode];
    const range: [number, number] = value ? this.store.range(value) : [0, 1];
    this.material.uniforms.uRange.value.set(range[0], range[1]);
    return range;
  }

  /** @param heightPx of the picture; @param radius of the scene, for points without a footprint. */
  fit(camera: THREE.PerspectiveCamera, heightPx: number, radius: number, pixelRatio: number): void {
    const uniforms = this.material.uniforms;
    uniforms.uScale.value = (heightPx / 2) * camera.projectionMatrix.elements[5];
    uniforms.uDefault.value = (0.8 * radius) / Math.sqrt(Math.max(this.store.count, 1));
    uniforms.uSplat.value = SPLAT_WIDTHS * this.size;
    uniforms.uLeast.value = 1.4 * pixelRatio;
    uniforms.uClose.value = 6 * pixelRatio;
    uniforms.uMost.value = 16 * pixelRatio;
  }
}
