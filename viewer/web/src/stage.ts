// The picture: points and meshes with eye-dome lighting, lines above them, and the camera that
// looks at them. Draws only when something changed.

import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

// Eye-dome lighting: a pixel is darker the farther it lies behind its neighbours.
const EDL = /* glsl */ `
uniform sampler2D tColor, tDepth;
uniform vec2 uStep;
uniform float uNear, uFar, uStrength;
uniform vec3 uTop, uBottom;
in vec2 vAt;
out vec4 fragment;
float distanceAt(vec2 at) {
  float d = texture(tDepth, at).r;
  return d >= 1.0 ? uFar : uNear * uFar / (uFar - d * (uFar - uNear));
}
void main() {
  float d = texture(tDepth, vAt).r;
  vec3 back = mix(uBottom, uTop, smoothstep(0.0, 1.0, vAt.y));
  float here = log2(distanceAt(vAt));
  float sum = 0.0;
  for (int i = 0; i < 6; ++i) {
    float a = 1.0471976 * float(i);
    sum += max(0.0, here - log2(distanceAt(vAt + uStep * vec2(cos(a), sin(a)))));
  }
  float shade = exp(-uStrength * sum / 6.0);
  fragment = vec4(d >= 1.0 ? back : texture(tColor, vAt).rgb * shade, 1.0);
}`;
const EDL_VERTEX = /* glsl */ `
out vec2 vAt;
void main() {
  vAt = 0.5 + 0.5 * position.xy;
  gl_Position = vec4(position.xy, 0.0, 1.0);
}`;

const SLOW_MS = 60;
const FAST_MS = 22;

THREE.ColorManagement.enabled = false;

export class Stage {
  readonly renderer: THREE.WebGLRenderer;
  readonly camera = new THREE.PerspectiveCamera(50, 1, 0.01, 100);
  readonly controls: OrbitControls;
  /** The scene's own axes; its up is turned to the screen's. */
  readonly world = new THREE.Group();
  readonly overlay = new THREE.Group();
  radius = 1;
  frameMs = 0;
  drawn = 0;
  onBeforeDraw: (() => void) | null = null;
  /** The user moved the view: it is theirs from then on. */
  touched = false;

  private readonly scene = new THREE.Scene();
  private readonly lines = new THREE.Scene();
  private readonly target: THREE.WebGLRenderTarget;
  private readonly edl: THREE.ShaderMaterial;
  private readonly quad: THREE.Mesh;
  private readonly flat = new THREE.OrthographicCamera(-1, 1, 1, -1, 0, 1);
  private dirty = true;
  /** Share of the screen's resolution; less while frames take long. */
  private quality = 1;
  private lastDraw = 0;
  private lastNeed = 0;
  private lastAdapt = 0;

  private goal: { position: THREE.Vector3; target: THREE.Vector3 } | null = null;

  constructor(private readonly canvas: HTMLCanvasElement) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: false, powerPreference: "high-performance" });
    const gl = this.renderer.getContext();
    const names = gl.getExtension("WEBGL_debug_renderer_info");
    const drawer = String(gl.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
    if (/swiftshader|llvmpipe|software/i.test(drawer)) this.quality = 0.5;
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
    this.renderer.autoClear = false;
    this.target = new THREE.WebGLRenderTarget(1, 1, { depthTexture: new THREE.DepthTexture(1, 1) });
    this.target.depthTexture!.type = THREE.UnsignedIntType;
    this.edl = new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: EDL_VERTEX,
      fragmentShader: EDL,
      depthTest: false,
      depthWrite: false,
      uniforms: {
        tColor: { value: this.target.texture },
        tDepth: { value: this.target.depthTexture },
        uStep: { value: new THREE.Vector2() },
        uNear: { value: 0.01 },
        uFar: { value: 100 },
        uStrength: { value: 12 },
        uTop: { value: new THREE.Color() },
        uBottom: { value: new THREE.Color() },
      },
    });
    this.quad = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), this.edl);
    this.quad.frustumCulled = false;
    const light = new THREE.DirectionalLight(0xffffff, 2.2);
    light.position.set(0.4, 1, 0.6);
    this.scene.add(this.world, light, new THREE.HemisphereLight(0xffffff, 0x888888, 1.4));
    this.lines.add(this.overlay);
    this.camera.position.set(0, 0.6, 2.2);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.12;
    this.controls.zoomToCursor = true;
    this.controls.addEventListener("change", () => this.invalidate());
    this.controls.addEventListener("start", () => {
      this.touched = true;
      this.goal = null;
    });
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.resize();
    requestAnimationFrame(() => this.loop());
  }

  setBackground(top: string, bottom: string): void {
    this.edl.uniforms.uTop.value.set(top);
    this.edl.uniforms.uBottom.value.set(bottom);
    this.invalidate();
  }

  invalidate(): void {
    this.dirty = true;
    this.lastNeed = performance.now();
  }

  get pixelRatio(): number {
    return this.renderer.getPixelRatio();
  }

  /** Moves the view smoothly, or at once. */
  lookFrom(position: THREE.Vector3, target: THREE.Vector3, atOnce = false): void {
    this.goal = { position: position.clone(), target: target.clone() };
    if (atOnce) {
      this.camera.position.copy(position);
      this.controls.target.copy(target);
      this.goal = null;
    }
    this.invalidate();
  }

  private resize(): void {
    const { clientWidth, clientHeight } = this.canvas;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2) * this.quality);
    this.renderer.setSize(clientWidth, clientHeight, false);
    const size = this.renderer.getDrawingBufferSize(new THREE.Vector2());
    this.target.setSize(size.x, size.y);
    this.edl.uniforms.uStep.value.set((1.4 * this.pixelRatio) / size.x, (1.4 * this.pixelRatio) / size.y);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    this.invalidate();
  }

  private loop(): void {
    requestAnimationFrame(() => this.loop());
    if (this.goal) {
      this.camera.position.lerp(this.goal.position, 0.14);
      this.controls.target.lerp(this.goal.target, 0.14);
      if (this.camera.position.distanceTo(this.goal.position) < 1e-3 * this.radius) this.goal = null;
      this.invalidate();
    }
    this.controls.update();
    this.adapt();
    // A picture that took long gives the stream its time, too.
    if (!this.dirty || performance.now() - this.lastDraw < 2 * this.frameMs) return;
    this.dirty = false;
    this.draw();
    this.lastDraw = performance.now();
  }

  // Slow machines draw fewer pixels while something moves, and all of them once it rests.
  private adapt(): void {
    const now = performance.now();
    const resting = now - this.lastNeed > 600;
    let wanted = this.quality;
    if (resting) wanted = 1;
    else if (this.frameMs > SLOW_MS) wanted = Math.max(0.5, this.quality - 0.25);
    else if (this.frameMs < FAST_MS) wanted = Math.min(1, this.quality + 0.25);
    if (wanted === this.quality || (!resting && now - this.lastAdapt < 1000)) return;
    this.lastAdapt = now;
    const slow = this.frameMs;
    this.quality = wanted;
    this.resize();
    if (resting) this.lastNeed = now - 1e9; // resizing is no need of its own
    this.frameMs = slow;
  }

  draw(): void {
    const begin = performance.now();
    const distance = this.camera.position.distanceTo(this.controls.target);
    this.camera.near = Math.max(0.002 * distance, 1e-4 * this.radius);
    this.camera.far = distance + 30 * this.radius;
    this.camera.updateProjectionMatrix();
    this.edl.uniforms.uNear.value = this.camera.near;
    this.edl.uniforms.uFar.value = this.camera.far;
    this.onBeforeDraw?.();
    this.renderer.setRenderTarget(this.target);
    this.renderer.clear();
    this.renderer.render(this.scene, this.camera);
    this.renderer.setRenderTarget(null);
    this.renderer.clear();
    this.renderer.render(this.quad, this.flat);
    this.overlay.quaternion.copy(this.world.quaternion);
    this.renderer.render(this.lines, this.camera);
    ++this.drawn;
    // The graphics card works behind our back: the frame is done when the next one may begin.
    requestAnimationFrame(() => {
      const took = performance.now() - begin;
      this.frameMs += 0.3 * (Math.min(took, 1000) - this.frameMs);
    });
  }

  /** Draws, and counts the pixels that differ from the background by more than a little. */
  countPixels(): { covered: number; total: number; colors: number } {
    this.draw();
    const gl = this.renderer.getContext();
    const { drawingBufferWidth: width, drawingBufferHeight: height } = gl;
    const pixels = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    const top = this.edl.uniforms.uTop.value as THREE.Color;
    const bottom = this.edl.uniforms.uBottom.value as THREE.Color;
    let covered = 0;
    const colors = new Set<number>();
    for (let y = 0; y < height; ++y) {
      const s = y / height;
      const t = s * s * (3 - 2 * s);
      const back = [top.r, top.g, top.b].map((c, k) => 255 * (c * t + [bottom.r, bottom.g, bottom.b][k] * (1 - t)));
      for (let x = 0; x < width; ++x) {
        const o = 4 * (y * width + x);
        const off = Math.abs(pixels[o] - back[0]) + Math.abs(pixels[o + 1] - back[1]) + Math.abs(pixels[o + 2] - back[2]);
        if (off <= 12) continue;
        ++covered;
        colors.add(((pixels[o] >> 4) << 8) | ((pixels[o + 1] >> 4) << 4) | (pixels[o + 2] >> 4));
      }
    }
    return { covered, total: width * height, colors: colors.size };
  }

  /** The picture as a PNG. */
  capture(): Promise<Blob | null> {
    this.draw();
    return new Promise((done) => this.canvas.toBlob(done, "image/png"));
  }
}
