// The view file: a header and arrays, as src/cutwise/app/scene/packed.py writes them.

export interface Entry {
  offset: number;
  bytes: number;
  dtype: "u1" | "u2" | "u4" | "f4" | "f8";
  shape: number[];
  zero: number;
  scale: number;
  coding: "plain" | "delta";
  title: string;
  unit: string;
  factor: number;
}

export interface Choice {
  title: string;
  table: "diverging" | "sequential";
  low: number;
  high: number;
  ticks: { at: number; text: string }[];
  limits: number[];
  unit: string;
  factor: number;
  ends: [string, string];
  path: boolean;
  plot: boolean;
}

export interface Requirement {
  measure: string;
  title: string;
  text: string;
  asked: string;
  meaning: string;
  pass: boolean | null;
  implied: boolean;
}

export interface Worst {
  sample: number;
  value: number;
  text: string;
  at: string;
  line: number;
  beyond: boolean;
}

/** A tool by its profiles (height above the tip, radius), what stands round it, and the joint about which it tilts; mm. */
export interface Turned {
  cutter: [number, number][];
  holder: [number, number][];
  fixed: [number, number][];
  rods: number[][]; // both ends and radius
  bodies: boolean[]; // triangles that move with it; true: they hold what cuts
  pivot: number; // height of the joint; 0: the tool is shifted
}

export interface Header {
  version: number;
  name: string;
  process: string;
  verdict: "pass" | "fail" | "none";
  verdict_text: string;
  certainty: string;
  requirements: Requirement[];
  measures: Record<string, { value: number; text: string; title: string; meaning: string; group: string }>;
  warnings: string[];
  clock: { is: "time" | "way"; unit: string; factor: number; n: number; t0: number | null; dt: number | null };
  program: { file: string; text: string; modal?: string[] } | null;
  scene: {
    surfaces: { title: string; tint: string; coloured: string; faces: Record<string, string> }[];
    map: { x: number; y: number; dx: number; dy: number; top: number; bottom: number; coloured: string; removed: string } | null;
    outlines: number;
    links: [number, number] | null;
    links_are: "arm" | "bodies";
    focus: [number[], number[]] | null;
    path: boolean;
    front: [number, number, number];
    said: string[];
    unit: string;
  };
  tools: Turned[];
  deflection: { k: number; largest: string } | null;
  colour: {
    tables: { diverging: string; sequential: string; missing: [number, number, number] };
    choices: Record<string, Choice>;
    first: string;
    judged: string;
  };
  worst: Worst[];
  arrays: Record<string, Entry>;
}

export type Numbers = Uint8Array | Uint16Array | Uint32Array | Float32Array | Float64Array;

export type Values = Float32Array | Float64Array;

const MAGIC = "CWVIEW1\n";
const WIDE = 0.01; // range over size: 65,534 steps of it are 1.5e-7 of the size, a number of four bytes is off by 6e-8 at most

export class ViewFile {
  readonly header: Header;
  private readonly start: number;

  constructor(private readonly buffer: ArrayBuffer) {
    const magic = new TextDecoder().decode(new Uint8Array(buffer, 0, 8));
    if (magic !== MAGIC) throw new Error("this is not a view file of cutwise");
    const length = new DataView(buffer).getUint32(8, true);
    this.header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 12, length))) as Header;
    if (this.header.version !== 1) throw new Error(`view file of version ${this.header.version}; this page reads version 1`);
    this.start = 12 + length;
  }

  has(name: string): boolean {
    return name in this.header.arrays;
  }

  entry(name: string): Entry {
    const entry = this.header.arrays[name];
    if (!entry) throw new Error(`the view file has no ${name}`);
    return entry;
  }

  /** Numbers as they are kept: quantised ones stay quantised. */
  raw(name: string): Numbers {
    const entry = this.entry(name);
    const at = this.start + entry.offset;
    if (entry.coding === "delta") return undone(new Uint8Array(this.buffer, at, entry.bytes));
    const kinds = { u1: Uint8Array, u2: Uint16Array, u4: Uint32Array, f4: Float32Array, f8: Float64Array };
    const kind = kinds[entry.dtype];
    return new kind(this.buffer, at, entry.bytes / kind.BYTES_PER_ELEMENT);
  }

  /** Values; missing ones are NaN. In four bytes each, where their range is wide enough that 16 bits of it show no difference. */
  values(name: string): Values {
    const raw = this.raw(name);
    const { zero, scale, coding } = this.entry(name);
    if (coding === "plain") return Float64Array.from(raw);
    const range = 65534 * scale;
    const wide = range > WIDE * Math.max(Math.abs(zero), Math.abs(zero + range));
    const out = wide ? new Float32Array(raw.length) : new Float64Array(raw.length);
    for (let i = 0; i < out.length; i++) out[i] = raw[i] === 65535 ? NaN : zero + scale * raw[i];
    return out;
  }
}

function undone(bytes: Uint8Array): Uint16Array {
  const count = bytes.length / 2;
  const out = new Uint16Array(count);
  let sum = 0;
  for (let i = 0; i < count; i++) {
    sum = (sum + bytes[i] + (bytes[count + i] << 8)) & 0xffff;
    out[i] = sum;
  }
  return out;
}

export async function inflated(bytes: Uint8Array<ArrayBuffer>): Promise<ArrayBuffer> {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Response(stream).arrayBuffer();
}

export function fromBase64(text: string): Uint8Array<ArrayBuffer> {
  const chars = atob(text.trim());
  const out = new Uint8Array(chars.length);
  for (let i = 0; i < chars.length; i++) out[i] = chars.charCodeAt(i);
  return out;
}
