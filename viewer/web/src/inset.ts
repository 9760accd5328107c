// The camera's picture with what is known of its pixels.

import type { PreviewInfo } from "./protocol";

interface Look {
  color: string;
  size: number;
}
// By kind: converging, converged, no texture, out of the window.
const LOOKS: Look[] = [
  { color: "#ffffff", size: 1.5 },
  { color: "#5b8cff", size: 2 },
  { color: "", size: 0 },
  { color: "#ff9d5c", size: 1.5 },
];

export class Inset {
  frames = 0;
  private readonly context: CanvasRenderingContext2D;
  private busy = false;
  private waiting: PreviewInfo | null = null;
  showMarks = true;

  constructor(private readonly canvas: HTMLCanvasElement) {
    this.context = canvas.getContext("2d")!;
  }

  show(preview: PreviewInfo): void {
    // Copied: the message that it came in is gone by the time that it is drawn.
    const copy = {
      ...preview,
      jpeg: preview.jpeg.slice(),
      marks: new DataView(preview.marks.buffer.slice(preview.marks.byteOffset, preview.marks.byteOffset + preview.marks.byteLength) as ArrayBuffer),
    };
    if (this.busy) {
      this.waiting = copy; // the latest counts
      return;
    }
    void this.draw(copy);
  }

  private async draw(preview: PreviewInfo): Promise<void> {
    this.busy = true;
    const image = await createImageBitmap(new Blob([preview.jpeg as BlobPart], { type: "image/jpeg" })).catch(() => null);
    if (image) {
      if (this.canvas.width !== image.width || this.canvas.height !== image.height) {
        this.canvas.width = image.width;
        this.canvas.height = image.height;
      }
      this.context.drawImage(image, 0, 0);
      image.close();
      if (this.showMarks) this.drawMarks(preview);
      ++this.frames;
    }
    this.busy = false;
    const next = this.waiting;
    this.waiting = null;
    if (next) void this.draw(next);
  }

  private drawMarks(preview: PreviewInfo): void {
    const { width, height } = this.canvas;
    const c = this.context;
    const block = Math.max(3, width / 32);
    c.lineWidth = 1;
    c.strokeStyle = "rgb(10 12 16 / 55%)";
    c.beginPath();
    for (let i = 0; i < preview.markCount; ++i) {
      if (preview.marks.getUint8(8 * i + 4) !== 2) continue;
      const x = (preview.marks.getUint16(8 * i, true) / 65535) * width;
      const y = (preview.marks.getUint16(8 * i + 2, true) / 65535) * height;
      for (const shift of [-block / 4, block / 4]) {
        c.moveTo(x + shift - block / 4, y + block / 2);
        c.lineTo(x + shift + block / 4, y - block / 2);
      }
    }
    c.stroke();
    for (let i = 0; i < preview.markCount; ++i) {
      const look = LOOKS[preview.marks.getUint8(8 * i + 4)];
      if (!look || look.size === 0) continue;
      const x = (preview.marks.getUint16(8 * i, true) / 65535) * width;
      const y = (preview.marks.getUint16(8 * i + 2, true) / 65535) * height;
      c.globalAlpha = look === LOOKS[0] ? 0.25 + (0.65 * preview.marks.getUint8(8 * i + 5)) / 255 : 0.9;
      c.fillStyle = look.color;
      c.fillRect(x - look.size / 2, y - look.size / 2, look.size, look.size);
    }
    c.globalAlpha = 1;
  }
}
