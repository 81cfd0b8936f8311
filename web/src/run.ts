// A run as the page knows it: clock, places, histories, lines; no unit and no physics is made here.
import { Choice, Header, Values, ViewFile } from "./file";

export interface History {
  name: string;
  values: Values; // SI
  choice: Choice;
}

export class Run {
  readonly header: Header;
  readonly count: number;
  readonly clock: Float64Array;
  readonly place: Values; // mm: all x, all y, all z
  readonly trace: Values; // where the ribbon is drawn; the places of the tool, where nothing else is said
  readonly axis: Values;
  readonly line: Uint32Array | null;
  readonly kind: Uint8Array | null;
  readonly deflection: Values | null;
  readonly tool: Uint8Array | null;
  readonly histories: Map<string, History>;
  readonly lines: string[];
  private readonly modal: Uint32Array | null;
  private readonly firstOfLine = new Map<number, number>();
  private readonly sortedLines: number[];
  private readonly tables: Record<string, Uint8Array>;

  constructor(readonly file: ViewFile) {
    const header = file.header;
    this.header = header;
    this.count = header.clock.n;
    this.clock = file.has("time") ? Float64Array.from(file.values("time")) : even(header.clock.t0 ?? 0, header.clock.dt ?? 0, this.count);
    this.place = file.values("place");
    this.trace = file.has("trace") ? file.values("trace") : this.place;
    this.axis = file.values("axis");
    this.line = file.has("line") ? (file.raw("line") as Uint32Array) : null;
    this.kind = file.has("kind") ? (file.raw("kind") as Uint8Array) : null;
    this.tool = file.has("tool_of") ? (file.raw("tool_of") as Uint8Array) : null;
    this.modal = file.has("modal") ? (file.raw("modal") as Uint32Array) : null;
    this.deflection = file.has("deflection") ? file.values("deflection") : null;
    this.histories = new Map(
      Object.entries(header.colour.choices).map(([name, choice]) => [name, { name, choice, values: file.values(`h/${name}`) }]),
    );
    this.lines = header.program ? header.program.text.split(/\r\n|\n|\r/) : [];
    if (this.line) for (let i = this.count - 1; i >= 0; i--) if (this.line[i] > 0) this.firstOfLine.set(this.line[i], i);
    this.sortedLines = [...this.firstOfLine.keys()].sort((a, b) => a - b);
    const hex = header.colour.tables;
    this.tables = { diverging: unhex(hex.diverging), sequential: unhex(hex.sequential) };
  }

  /** The last sample that is not later. */
  sampleAt(clock: number): number {
    let low = 0;
    let high = this.count - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.clock[middle] <= clock) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  at(i: number): [number, number, number] {
    const n = this.count;
    return [this.place[i], this.place[n + i], this.place[2 * n + i]];
  }

  traceAt(i: number): [number, number, number] {
    const n = this.count;
    return [this.trace[i], this.trace[n + i], this.trace[2 * n + i]];
  }

  axisAt(i: number): [number, number, number] {
    const n = this.axis.length / 3;
    const k = n === 1 ? 0 : i;
    return [this.axis[k], this.axis[n + k], this.axis[2 * n + k]];
  }

  deflectionAt(i: number): [number, number, number] {
    if (!this.deflection) return [0, 0, 0];
    const n = this.count;
    const found: [number, number, number] = [this.deflection[i], this.deflection[n + i], this.deflection[2 * n + i]];
    return found.some(Number.isNaN) ? [0, 0, 0] : found;
  }

  lineOf(i: number): number {
    return this.line ? this.line[i] : 0;
  }

  /** The words in force behind a line of the program; nothing where it does not run. */
  inForce(line: number): string {
    const number = this.modal?.[line] ?? 0;
    return number > 0 ? (this.header.program?.modal?.[number - 1] ?? "") : "";
  }

  /** The first sample of a line; of the next line that has one where it has none. */
  sampleOfLine(line: number): number | null {
    const next = this.sortedLines.find((one) => one >= line);
    return next === undefined ? null : (this.firstOfLine.get(next) ?? null);
  }

  /** Where the next block begins, forwards or back. */
  block(i: number, forwards: boolean): number {
    if (!this.line) return i + (forwards ? 100 : -100);
    const here = this.line[i];
    let k = i;
    if (forwards) {
      while (k < this.count - 1 && this.line[k] === here) k++;
      return k;
    }
    while (k > 0 && this.line[k - 1] === here) k--;
    if (k < i) return k;
    const before = this.line[Math.max(0, k - 1)];
    k = Math.max(0, k - 1);
    while (k > 0 && this.line[k - 1] === before) k--;
    return k;
  }

  table(choice: Choice): Uint8Array {
    return this.tables[choice.table];
  }

  index(choice: Choice, value: number): number {
    if (!(choice.high > choice.low)) return 128;
    return Math.min(255, Math.max(0, Math.floor((256 * (value - choice.low)) / (choice.high - choice.low))));
  }

  colour(choice: Choice, value: number): [number, number, number] {
    if (Number.isNaN(value)) return this.header.colour.tables.missing;
    const k = 3 * this.index(choice, value);
    const table = this.table(choice);
    return [table[k], table[k + 1], table[k + 2]];
  }

  clockText(i: number): string {
    const { factor, unit, dt } = this.header.clock;
    const step = dt && dt > 0 ? dt * factor : 0.001;
    const decimals = Math.min(6, Math.max(0, Math.ceil(-Math.log10(step) - 1e-9)));
    return `${(this.clock[i] * factor).toFixed(decimals)} ${unit}`;
  }

  valueText(history: History, i: number): string {
    const value = history.values[i];
    return Number.isNaN(value) ? "–" : `${short(value * history.choice.factor)} ${history.choice.unit}`.trim();
  }
}

export function short(value: number): string {
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-4) return value.toExponential(2);
  return String(Number(value.toPrecision(4)));
}

function even(t0: number, dt: number, n: number): Float64Array {
  const out = new Float64Array(n);
  for (let i = 0; i < n; i++) out[i] = t0 + dt * i;
  return out;
}

function unhex(text: string): Uint8Array {
  return Uint8Array.from({ length: text.length / 2 }, (_, i) => parseInt(text.slice(2 * i, 2 * i + 2), 16));
}
