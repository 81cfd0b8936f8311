// Least and greatest of 4, 16, 64 ... samples, so that any window of a long history is drawn by few numbers.

import { Values } from "./file";

const MOST = 1200;

export class Pyramid {
  private readonly levels: { low: Values; high: Values }[] = [];

  constructor(private readonly values: Values) {
    const made = (n: number): Values => (values instanceof Float32Array ? new Float32Array(n) : new Float64Array(n)).fill(NaN);
    let low = values;
    let high = values;
    while (low.length > MOST) {
      const n = Math.ceil(low.length / 4);
      const nextLow = made(n);
      const nextHigh = made(n);
      for (let i = 0; i < low.length; i++) {
        const k = i >> 2;
        if (!(nextLow[k] <= low[i]) && !Number.isNaN(low[i])) nextLow[k] = low[i];
        if (!(nextHigh[k] >= high[i]) && !Number.isNaN(high[i])) nextHigh[k] = high[i];
      }
      this.levels.push({ low: nextLow, high: nextHigh });
      low = nextLow;
      high = nextHigh;
    }
  }

  /** Samples and values from one sample to another, two for each of at most 1,200 buckets that enclose the history. */
  window(first: number, last: number): { sample: number[]; value: (number | null)[] } {
    const sample: number[] = [];
    const value: (number | null)[] = [];
    const push = (at: number, one: number) => {
      sample.push(at);
      value.push(Number.isNaN(one) ? null : one);
    };
    let level = 0;
    while ((last - first + 1) / 4 ** level > MOST && level < this.levels.length) level++;
    if (level === 0) {
      for (let i = first; i <= last; i++) push(i, this.values[i]);
      return { sample, value };
    }
    const width = 4 ** level;
    const { low, high } = this.levels[level - 1];
    for (let k = Math.floor(first / width); k * width <= last; k++) {
      const from = Math.max(first, k * width);
      push(from, low[k]);
      push(Math.min(last, from + width / 2), high[k]);
    }
    return { sample, value };
  }
}
