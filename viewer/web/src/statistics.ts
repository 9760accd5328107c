// What tests and curious people find under window.__stats.

import type { Connection } from "./connection";
import type { Dial } from "./dial";
import { describe, type Live, type RunState } from "./hud";
import type { Inset } from "./inset";
import type { Splats } from "./splats";
import type { Stage } from "./stage";
import type { Store } from "./store";

declare global {
  interface Window {
    __stats: Record<string, unknown>;
    __livemvs: Record<string, unknown>;
  }
}

const MOST_LATENCIES = 5000;

export class Statistics {
  records = 0;
  malformed = 0;
  rate = 0;
  messages: string[] = [];
  private readonly arrivals = new Map<number, number>();
  private readonly latencies: number[] = [];
  private readonly times: [number, number][] = [];

  /** Points of a frame are here. */
  arrived(frame: number): void {
    this.arrivals.set(frame, Date.now() / 1000);
    if (this.arrivals.size > 500) this.arrivals.delete(this.arrivals.keys().next().value!);
  }

  /** When the engine had handed over frames: pairs of frame and time. */
  handed(pairs: unknown): void {
    if (!Array.isArray(pairs)) return;
    for (const [frame, time] of pairs as [number, number][]) {
      const arrival = this.arrivals.get(frame);
      if (arrival === undefined) continue;
      this.arrivals.delete(frame);
      this.latencies.push(1000 * (arrival - time));
      if (this.latencies.length > MOST_LATENCIES) this.latencies.shift();
    }
  }

  /** Frames a second over the last two seconds. */
  frames(count: number): void {
    const now = performance.now() / 1000;
    this.times.push([now, count]);
    while (this.times.length > 2 && now - this.times[0][0] > 2) this.times.shift();
    const [time, first] = this.times[0];
    this.rate = now - time > 0.3 ? (count - first) / (now - time) : 0;
  }

  private latency(q: number): number {
    const sorted = [...this.latencies].sort((a, b) => a - b);
    return sorted.length ? sorted[Math.min(sorted.length - 1, Math.floor(q * sorted.length))] : NaN;
  }

  publish(of: {
    store: Store;
    stage: Stage;
    splats: Splats;
    connection: Connection;
    state: RunState;
    live: Live | null;
    inset: Inset;
    dial: Dial;
    triangles: number;
  }): void {
    window.__stats = {
      points: of.store.visible,
      frames: of.live?.frames ?? 0,
      triangles: of.triangles,
      records: this.records,
      malformed: this.malformed,
      next: of.connection.next,
      bytes: of.connection.bytes,
      reconnects: of.connection.reconnects,
      link: of.state.link,
      status: describe(of.state).text,
      ended: of.state.ended,
      mode: of.splats.mode,
      previews: of.inset.frames,
      coverage: of.dial.coverage,
      drawn: of.stage.drawn,
      frame_ms: of.stage.frameMs,
      rate: this.rate,
      latencies: this.latencies.length,
      latency_p50_ms: this.latency(0.5),
      latency_p99_ms: this.latency(0.99),
      messages: this.messages.slice(-20),
    };
  }
}
