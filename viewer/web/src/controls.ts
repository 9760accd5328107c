// Buttons, keys and gestures.

import * as THREE from "three";
import type { Connection } from "./connection";
import { count } from "./format";
import { el, showRamp, type RunState } from "./hud";
import { icon } from "./icons";
import type { SceneInfo } from "./protocol";
import type { Rig } from "./rig";
import { download, toGlb, toPly } from "./save";
import { MODES, type Mode, type Splats } from "./splats";
import type { Stage } from "./stage";
import type { Store } from "./store";
import { pick, type CropBox, type Ruler } from "./tools";

interface Parts {
  store: Store;
  stage: Stage;
  splats: Splats;
  rig: Rig;
  ruler: Ruler;
  box: CropBox;
  connection: Connection;
  state: RunState;
  bounds: () => { min: number[]; max: number[] } | null;
  /** Where a mesh faces, in the scene's axes; zero: unknown. */
  facing: () => THREE.Vector3;
  sceneBox: () => SceneInfo["box"];
  unit: () => string;
  refresh: () => void;
}

const LABELS: Record<Mode, string> = { rgb: "Colour", normal: "Normal", confidence: "Confidence", sigma: "Sigma", views: "Views", age: "Age" };
const KEYS: [string, string][] = [
  ["1 … 6", "colour by: colour, normal, confidence, sigma, views, age"],
  ["Space", "start, pause, go on"],
  ["F", "follow the camera"],
  ["R", "show all"],
  ["M", "measure between two points"],
  ["B", "box: keep what is inside"],
  ["+  −", "larger, smaller points"],
  ["S", "save the points"],
  ["P", "save a picture"],
  ["T", "light or dark"],
  ["Esc", "put tools away"],
];

export class Controls {
  private following = false;
  private allowed = false;
  private framed = 0;

  constructor(private readonly p: Parts) {
    const buttons: [string, string, string, () => void][] = [
      ["b-follow", "follow", "", () => this.setFollow(!this.following)],
      ["b-fit", "fit", "", () => this.fit()],
      ["b-measure", "measure", "", () => this.toggleRuler()],
      ["b-box", "box", "", () => this.toggleBox()],
      ["b-shot", "shot", "", () => void this.shoot()],
      ["b-theme", "theme", "", () => this.flipTheme()],
      ["b-help", "help", "", () => el<HTMLDialogElement>("help-dialog").showModal()],
      ["b-pause", "pause", "Pause", () => this.pause()],
      ["b-finish", "finish", "Finish", () => this.p.connection.ask("finish")],
      ["b-save", "save", "Save", () => this.openSave()],
    ];
    for (const [id, name, label, act] of buttons) {
      el(id).innerHTML = icon(name) + (label ? `<span>${label}</span>` : "");
      el(id).setAttribute("aria-label", el(id).title);
      el(id).addEventListener("click", act);
    }
    for (const mode of MODES) this.addMode(mode);
    this.setMode("rgb");
    this.addDialogs();
    this.addGestures();
    // Panels stand above the controls, however many rows these need.
    const dock = new ResizeObserver(([entry]) => document.documentElement.style.setProperty("--nav", `${entry.target.clientHeight}px`));
    dock.observe(document.querySelector("nav")!);
    addEventListener("keydown", (event) => this.key(event));
    this.setTheme(localStorage.getItem("theme") ?? (matchMedia("(prefers-color-scheme: light)").matches ? "light" : "dark"));
    window.__livemvs = { count: () => this.p.stage.countPixels(), cut: () => this.p.connection.cut(), hold: () => (this.p.stage.touched = true), mode: (m: Mode) => this.setMode(m) };
  }

  private addMode(mode: Mode): void {
    const button = document.createElement("button");
    button.textContent = LABELS[mode];
    button.dataset.mode = mode;
    button.setAttribute("role", "radio");
    button.addEventListener("click", () => this.setMode(mode));
    el("modes").append(button);
  }

  private setMode(mode: Mode): void {
    this.p.splats.setMode(mode);
    for (const button of el("modes").querySelectorAll("button")) {
      button.setAttribute("aria-checked", String(button.dataset.mode === mode));
    }
    showRamp(mode, this.p.splats.updateRange(), this.p.unit());
    this.p.stage.invalidate();
  }

  /** Whether there is something to pause and finish. */
  allow(controls: boolean): void {
    this.allowed = controls;
    this.p.refresh();
  }

  update(_live: boolean): void {
    const { state } = this.p;
    const running = this.allowed && !state.ended && state.engine !== "finishing";
    el("b-pause").hidden = el("b-finish").hidden = !running;
    el<HTMLButtonElement>("b-pause").disabled = el<HTMLButtonElement>("b-finish").disabled = state.link !== "open";
    const waiting = state.engine === "waiting";
    const paused = state.engine === "paused" || waiting;
    const label = waiting ? "Start" : paused ? "Go on" : "Pause";
    if (el("b-pause").textContent !== label) {
      el("b-pause").innerHTML = icon(paused ? "play" : "pause") + `<span>${label}</span>`;
      el("b-pause").title = `${label} (space)`;
      el("b-pause").setAttribute("aria-label", el("b-pause").title);
    }
    el("b-pause").classList.toggle("primary", running && waiting);
    el<HTMLButtonElement>("b-save").disabled = this.p.store.visible === 0;
    el("b-save").classList.toggle("primary", !running);
    el("b-finish").classList.toggle("primary", running && !waiting);
    el("b-follow").hidden = !this.p.rig.known;
    // What is for points alone.
    const mesh = this.p.store.visible === 0 && state.points > 0;
    for (const id of ["modes", "b-measure", "b-box", "b-save"]) el(id).hidden = mesh;
  }

  private pause(): void {
    const { engine } = this.p.state;
    this.p.connection.ask(engine === "paused" || engine === "waiting" ? "resume" : "pause");
  }

  // The view: all of it until the user takes it over, or with the camera.

  frame(bounds: { min: number[]; max: number[] }): void {
    if (this.p.stage.touched || this.following) return;
    // Not at each point: when the scene has grown by a fifth.
    const { radius } = this.p.stage;
    if (this.framed > 0 && Math.abs(Math.log(radius / this.framed)) < 0.18) return;
    const first = this.framed === 0;
    this.framed = radius;
    this.show(bounds, first);
  }

  private fit(): void {
    const bounds = this.p.bounds();
    this.setFollow(false);
    if (bounds) this.show(bounds, false);
  }

  private show(bounds: { min: number[]; max: number[] }, atOnce: boolean): void {
    const { stage, rig } = this.p;
    const target = new THREE.Vector3().fromArray(bounds.min).add(new THREE.Vector3().fromArray(bounds.max)).multiplyScalar(0.5);
    target.applyQuaternion(stage.world.quaternion);
    // From the side of the first cameras, or from where a mesh was seen, a little above.
    const seen = this.p.facing().clone().applyQuaternion(stage.world.quaternion).setY(0);
    let side = seen.lengthSq() > 0 ? seen : new THREE.Vector3(0.4, 0, 1);
    if (rig.known) side = rig.center.clone().applyQuaternion(stage.world.quaternion).sub(target).setY(0);
    if (side.lengthSq() < 1e-12) side.set(0, 0, 1);
    side.normalize().setY(0.55).normalize();
    const fit = stage.radius / Math.sin((stage.camera.fov * Math.PI) / 360);
    const distance = Math.max(fit, fit / Math.min(stage.camera.aspect, 1)) * 0.92;
    stage.lookFrom(target.clone().addScaledVector(side, distance), target, atOnce);
  }

  private setFollow(on: boolean): void {
    this.following = on && this.p.rig.known;
    el("b-follow").setAttribute("aria-pressed", String(this.following));
    if (this.following) this.follow();
  }

  /** Goes with the camera, a little behind and above it. */
  follow(): void {
    if (!this.following) return;
    const { stage, rig } = this.p;
    const q = stage.world.quaternion;
    const center = rig.center.clone().applyQuaternion(q);
    const forward = rig.forward.clone().applyQuaternion(q);
    const up = rig.up.clone().applyQuaternion(q);
    const back = 0.55 * stage.radius;
    stage.lookFrom(center.clone().addScaledVector(forward, -back).addScaledVector(up, 0.35 * back), center.clone().addScaledVector(forward, stage.radius));
  }

  // Tools.

  private toggleRuler(): void {
    this.p.ruler.toggle();
    el("b-measure").setAttribute("aria-pressed", String(this.p.ruler.active));
    document.body.classList.toggle("measuring", this.p.ruler.active);
  }

  private toggleBox(): void {
    this.p.box.toggle(this.p.sceneBox() ?? this.p.bounds());
    el("b-box").setAttribute("aria-pressed", String(this.p.box.active));
  }

  private async shoot(): Promise<void> {
    const picture = await this.p.stage.capture();
    if (picture) download(picture, "livemvs.png");
  }

  private openSave(): void {
    const { store, box } = this.p;
    el("save-text").textContent = `${count(store.visible)} points${box.active ? ", those in the box" : ""}, as they are now.`;
    el<HTMLDialogElement>("save-dialog").showModal();
  }

  private save(format: string): void {
    const { store, stage, box } = this.p;
    const inside = box.active ? box.inside : null;
    if (format === "ply") download(toPly(store, inside), "livemvs.ply");
    if (format === "glb") download(toGlb(store, inside, stage.world.quaternion.toArray() as [number, number, number, number]), "livemvs.glb");
  }

  private addDialogs(): void {
    const dialog = el<HTMLDialogElement>("save-dialog");
    for (const button of dialog.querySelectorAll("button")) {
      button.addEventListener("click", () => {
        dialog.close();
        this.save(button.dataset.format ?? "");
      });
    }
    const help = el<HTMLDialogElement>("help-dialog");
    help.querySelector("button")!.addEventListener("click", () => help.close());
    for (const [key, what] of KEYS) {
      const dt = document.createElement("dt");
      const dd = document.createElement("dd");
      dt.textContent = key;
      dd.textContent = what;
      el("keys").append(dt, dd);
    }
  }

  private addGestures(): void {
    const { stage, ruler, box, store } = this.p;
    const canvas = stage.renderer.domElement;
    let down: { x: number; y: number } | null = null;
    canvas.addEventListener("pointerdown", (event) => {
      down = { x: event.clientX, y: event.clientY };
      if (box.grab(event.clientX, event.clientY)) stage.controls.enabled = false;
    }, true);
    canvas.addEventListener("pointermove", (event) => box.drag(event.clientX, event.clientY));
    canvas.addEventListener("pointerup", (event) => {
      box.release();
      stage.controls.enabled = true;
      const still = down && Math.hypot(event.clientX - down.x, event.clientY - down.y) < 5;
      if (still && ruler.active) ruler.click(event.clientX, event.clientY);
    });
    canvas.addEventListener("dblclick", (event) => {
      const point = pick(store, stage, event.clientX, event.clientY, 16);
      if (!point || ruler.active) return;
      const target = stage.world.localToWorld(point);
      const eye = stage.camera.position.clone().sub(stage.controls.target).multiplyScalar(0.6).add(target);
      stage.lookFrom(eye, target);
    });
    stage.controls.addEventListener("start", () => this.setFollow(false));
  }

  private key(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
    const mode = MODES[Number(event.key) - 1];
    if (mode) return this.setMode(mode);
    const acts: Record<string, () => void> = {
      " ": () => !el("b-pause").hidden && this.pause(),
      f: () => this.setFollow(!this.following),
      r: () => this.fit(),
      m: () => !el("b-measure").hidden && this.toggleRuler(),
      b: () => !el("b-box").hidden && this.toggleBox(),
      s: () => this.p.store.visible > 0 && this.openSave(),
      p: () => void this.shoot(),
      t: () => this.flipTheme(),
      "+": () => this.resize(1.25),
      "-": () => this.resize(0.8),
      "?": () => el<HTMLDialogElement>("help-dialog").showModal(),
      Escape: () => {
        if (this.p.ruler.active) this.toggleRuler();
        if (this.p.box.active) this.toggleBox();
      },
    };
    const act = acts[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!act) return;
    event.preventDefault();
    act();
  }

  private resize(factor: number): void {
    this.p.splats.size = THREE.MathUtils.clamp(this.p.splats.size * factor, 0.3, 5);
    this.p.stage.invalidate();
  }

  private flipTheme(): void {
    this.setTheme(document.documentElement.dataset.theme === "light" ? "dark" : "light");
    localStorage.setItem("theme", document.documentElement.dataset.theme!);
  }

  private setTheme(theme: string): void {
    document.documentElement.dataset.theme = theme === "light" ? "light" : "dark";
    const style = getComputedStyle(document.documentElement);
    const color = (name: string) => style.getPropertyValue(name).trim();
    this.p.stage.setBackground(color("--top"), color("--bottom"));
    for (const part of [this.p.rig, this.p.ruler, this.p.box]) part.setColor(color("--accent"));
  }
}
