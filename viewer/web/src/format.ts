// Numbers as people read them.

const THIN = "\u202f";

/** 1 234 567 */
export function count(n: number): string {
  return Math.round(n).toString().replace(/\B(?=(\d{3})+(?!\d))/g, THIN);
}

/** 1.2 M */
export function short(n: number): string {
  if (n < 10000) return count(n);
  if (n < 1e6) return `${(n / 1e3).toFixed(n < 1e5 ? 1 : 0)}${THIN}k`;
  return `${(n / 1e6).toFixed(n < 1e7 ? 2 : 1)}${THIN}M`;
}

export function duration(seconds: number): string {
  if (!Number.isFinite(seconds) || seconds < 0) return "–";
  const s = Math.round(seconds);
  return `${Math.floor(s / 60)}:${String(s % 60).padStart(2, "0")}`;
}

/** A length in the scene's unit; metres where it is known to be that. */
export function length(value: number, unit: string): string {
  const digits = (v: number) => (v >= 100 ? v.toFixed(0) : v >= 10 ? v.toFixed(1) : v.toFixed(2));
  if (unit !== "m") {
    const text = value >= 0.01 || value === 0 ? digits(value) : value.toExponential(1);
    return unit ? `${text}${THIN}${unit}` : text;
  }
  if (value >= 1) return `${digits(value)}${THIN}m`;
  if (value >= 0.01) return `${digits(100 * value)}${THIN}cm`;
  return `${digits(1000 * value)}${THIN}mm`;
}

/** The largest of 1, 2, 5 times a power of ten that is not above the value. */
export function roundDown(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value));
  const lead = value / power;
  return (lead >= 5 ? 5 : lead >= 2 ? 2 : 1) * power;
}
