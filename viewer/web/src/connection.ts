// The WebSocket: opens it, hands on its records, and opens it again where it was cut, going on
// with the record that comes next.

import { UNNUMBERED, records, type Rec } from "./protocol";

export type LinkState = "connecting" | "open" | "cut" | "refused";

export interface Listener {
  record(record: Rec): void;
  link(state: LinkState): void;
}

const FIRST_DELAY_MS = 250;
const LONGEST_DELAY_MS = 4000;

export class Connection {
  next = 0;
  reconnects = 0;
  bytes = 0;
  private session = "";
  private socket: WebSocket | null = null;
  private delay = FIRST_DELAY_MS;
  private everOpen = false;

  constructor(private readonly listener: Listener) {}

  /** The stream's name as the server gave it; of another stream everything begins anew. */
  adopt(session: string): boolean {
    const changed = this.session !== "" && this.session !== session;
    this.session = session;
    if (changed) this.next = 0;
    return changed;
  }

  open(): void {
    if (!this.everOpen) this.listener.link("connecting"); // later it is cut until it is open again
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const resume = this.session ? `?session=${this.session}&from=${this.next}` : "";
    const socket = new WebSocket(`${scheme}://${location.host}/stream${resume}`);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    let opened = false;
    socket.onopen = () => {
      opened = true;
      if (this.everOpen) ++this.reconnects;
      this.everOpen = true;
      this.delay = FIRST_DELAY_MS;
      this.listener.link("open");
    };
    socket.onmessage = (event: MessageEvent<ArrayBuffer>) => {
      this.bytes += event.data.byteLength;
      for (const record of records(event.data)) this.take(record);
    };
    socket.onclose = () => {
      this.socket = null;
      this.listener.link("cut");
      void this.again(opened);
    };
  }

  private take(record: Rec): void {
    if (record.sequence !== UNNUMBERED) {
      if (record.sequence < this.next) return; // had it
      this.next = record.sequence + 1;
    }
    this.listener.record(record);
  }

  // A server that answers, but no longer lets us in, is of another run.
  private async again(opened: boolean): Promise<void> {
    await new Promise((done) => setTimeout(done, this.delay));
    this.delay = Math.min(2 * this.delay, LONGEST_DELAY_MS);
    if (!opened) {
      const answer = await fetch("/app.css", { method: "HEAD" }).catch(() => null);
      if (answer && (answer.status === 403 || answer.status === 421)) {
        this.listener.link("refused");
        return;
      }
    }
    this.open();
  }

  ask(verb: "pause" | "resume" | "finish"): void {
    this.socket?.send(JSON.stringify({ do: verb }));
  }

  /** Cuts the line, as a network would. */
  cut(): void {
    this.socket?.close();
  }
}
