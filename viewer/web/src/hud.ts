// Words and numbers around the picture.

import { count, duration, length, roundDown, short } from "./format";
import type { LinkState } from "./connection";
import { RAMP, type Mode } from "./splats";

export const el = <T extends HTMLElement = HTMLElement>(id: string): T => document.getElementById(id) as T;

/** What the page knows of the run. */
export interface RunState {
  link: LinkState;
  /** "running", "paused", "finishing" … as the program says. */
  engine: string;
  tracking: number;
  ended: { reason: number; text: string } | null;
  points: number;
  source: string;
  /** Of tracking, as the program says; empty: none. */
  problem: string;
}

type Kind = "" | "live" | "warn" | "bad";

export function describe(s: RunState): { text: string; kind: Kind } {
  if (s.link === "refused") return { text: "Not allowed", kind: "bad" };
  if (s.ended) {
    return s.ended.reason === 2 ? { text: "Failed", kind: "bad" } : { text: s.ended.reason === 1 ? "Stopped" : "Finished", kind: "" };
  }
  if (s.link === "cut") return { text: "Disconnected", kind: "bad" };
  if (s.link === "connecting") return { text: "Connecting", kind: "" };
  if (s.engine === "waiting") return { text: "Ready", kind: "warn" };
  if (s.engine === "paused") return { text: "Paused", kind: "warn" };
  if (s.engine === "finishing") return { text: "Finishing", kind: "live" };
  if (s.tracking === 2) return { text: "Lost", kind: "bad" };
  if (s.tracking === 0) return { text: "Searching", kind: "warn" };
  return { text: "Live", kind: "live" };
}

export function showState(s: RunState): void {
  const { text, kind } = describe(s);
  el("status").dataset.kind = kind;
  el("status-text").textContent = text;
  el("source").textContent = s.source;
  document.title = s.source ? `${s.source} – livemvs` : "livemvs";
  showBanner(s);
  const empty = el("empty");
  empty.hidden = s.points > 0;
  if (s.points > 0) return;
  empty.classList.toggle("still", s.ended !== null || s.link === "refused");
  const [head, hint] = emptyWords(s);
  el("empty-text").textContent = head;
  el("empty-hint").textContent = hint;
}

function emptyWords(s: RunState): [string, string] {
  if (s.link === "refused") return ["Nothing to show", ""];
  if (s.ended) return ["No points", "Nothing converged. Did the camera move around the object, and is there texture on it?"];
  if (s.engine === "waiting") return ["Ready to start", "Press Start, then move the camera sideways around the object."];
  if (s.tracking === 0 && s.problem) return ["Looking for the camera\u2019s place", sentence(s.problem)];
  return ["Waiting for the first points", "Move the camera sideways around the object: depth shows from the second view on."];
}

function sentence(words: string): string {
  return words ? `${words[0].toUpperCase()}${words.slice(1).replace(/\.$/, "")}.` : "";
}

function showBanner(s: RunState): void {
  let head = "";
  let rest = "";
  let kind: Kind = "warn";
  if (s.link === "refused") {
    [head, rest, kind] = ["This address is of another run.", "Open the one that livemvs printed last.", "bad"];
  } else if (s.ended?.reason === 2) {
    [head, rest, kind] = ["The run failed.", `${sentence(s.ended.text)} What is here can be saved.`, "bad"];
  } else if (s.link === "cut" && s.ended) {
    [head, rest] = ["livemvs is closed.", "What is here can still be looked at and saved."];
  } else if (s.link === "cut") {
    [head, rest, kind] = ["Connection lost.", "Trying again; nothing is lost.", "bad"];
  } else if (!s.ended && s.tracking === 2 && s.engine !== "paused") {
    [head, rest, kind] = ["Tracking lost.", `${sentence(s.problem)} Go back to where the camera was.`, "bad"];
  }
  const banner = el("banner");
  banner.hidden = head === "";
  banner.dataset.kind = kind;
  banner.querySelector("b")!.textContent = head;
  banner.querySelector("span")!.textContent = rest;
}

export interface Live {
  frames: number;
  frames_total: number;
  frames_dropped: number;
  seeds: number;
  motion_px: number;
  window_px: number;
  sharpness: number;
  elapsed_s: number;
  eta_s?: number;
  problem?: string;
}

export function showNumbers(live: Live | null, points: number, triangles: number, rate: number, ended: boolean): void {
  const mesh = points === 0 && triangles > 0;
  el("n-what").textContent = mesh ? "triangles" : "points";
  if (mesh) points = triangles;
  el("numbers").querySelector("dl")!.hidden = live === null;
  el("n-points").textContent = short(points);
  el("n-points").title = count(points);
  if (!live) return;
  el("n-seeds").textContent = short(live.seeds);
  el("n-rate").textContent = rate > 0 ? rate.toFixed(rate < 10 ? 1 : 0) : "–";
  el("n-frame").textContent = live.frames_total > 0 ? `${count(live.frames)} / ${count(live.frames_total)}` : count(live.frames);
  el("row-dropped").hidden = live.frames_dropped === 0;
  el("n-dropped").textContent = count(live.frames_dropped);
  const left = ended ? undefined : live.eta_s;
  el("l-time").textContent = left === undefined ? "Time" : "Left";
  el("n-time").textContent = duration(left ?? live.elapsed_s);
  el("progress").hidden = live.frames_total === 0;
  const share = live.frames_total > 0 ? live.frames / live.frames_total : 0;
  (el("progress").firstElementChild as HTMLElement).style.width = `${100 * share}%`;
}

/** Motion is well while it stays below eight search windows a frame and the picture is sharp. */
export function speedOf(live: Live): { share: number; tooFast: boolean } {
  const motion = live.window_px > 0 ? live.motion_px / (8 * live.window_px) : 0;
  const blur = live.sharpness > 0 ? 0.5 / live.sharpness : 0;
  const share = Math.max(motion, blur >= 1 ? blur : 0);
  return { share, tooFast: share >= 1 };
}

export function showSpeed(live: Live, running: boolean): void {
  const box = el("speed");
  box.hidden = !running;
  const { share, tooFast } = speedOf(live);
  box.classList.toggle("fast", tooFast);
  (box.querySelector(".bar i") as HTMLElement).style.width = `${Math.min(100, 66.7 * share)}%`;
  el("speed-text").textContent = tooFast ? "Slow down" : `${live.motion_px.toFixed(1)} px`;
}

export function showScale(unitsPerPixel: number, unit: string, shown: boolean): void {
  const box = el("scale");
  box.hidden = !shown || !Number.isFinite(unitsPerPixel) || unitsPerPixel <= 0;
  if (box.hidden) return;
  const value = roundDown(130 * unitsPerPixel);
  box.querySelector("span")!.textContent = length(value, unit).replace(/\.0+(?!\d)/, ""); // it is a round one
  (box.querySelector("i") as HTMLElement).style.width = `${value / unitsPerPixel}px`;
}

export function showRamp(mode: Mode, range: [number, number], unit: string): void {
  const box = el("ramp");
  const ends: Partial<Record<Mode, [string, string]>> = {
    confidence: ["0 %", "100 %"],
    sigma: [`σ ${length(2 ** range[1], unit)}`, length(2 ** range[0], unit)],
    views: [`${Math.round(2 ** range[0] - 1)}`, `${Math.round(2 ** range[1] - 1)} views`],
    age: [`frame ${count(range[0])}`, count(range[1])],
  };
  const text = ends[mode];
  box.hidden = !text;
  if (!text) return;
  el("ramp-low").textContent = text[0];
  el("ramp-high").textContent = text[1];
  const stops = RAMP.map((c) => `rgb(${c.map((v) => Math.round(255 * v)).join(" ")})`);
  (box.querySelector("i") as HTMLElement).style.background = `linear-gradient(90deg, ${stops.join(", ")})`;
}
