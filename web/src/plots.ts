// Histories as curves under the scene: the cursor stands at now, a drag zooms, a double click shows everything.
import uPlot from "uplot";
import { el } from "./dom";
import { Pyramid } from "./pyramid";
import { History, Run, short } from "./run";

const SLIGHT = 0.05; // a curve that moves by less of its distance to a limit is drawn beside it: flat, as it is

/** Numbers at the grid lines: as many decimals as tell neighbours apart. */
function ticked(ticks: number[]): string[] {
  const step = ticks.length > 1 ? Math.abs(ticks[1] - ticks[0]) : 0;
  const decimals = step > 0 ? Math.max(0, Math.ceil(-Math.log10(step) - 1e-9)) : 0;
  return ticks.map((t) => (decimals > 6 || Math.abs(t) >= 1e6 ? t.toPrecision(6) : decimals > 0 ? (t === 0 ? "0" : t.toFixed(decimals)) : short(t)));
}

export class Plots {
  readonly element = el("div", { class: "cw-plots" });
  private readonly plots: { plot: uPlot; pyramid: Pyramid; history: History; box: HTMLElement; before: Pyramid | null }[] = [];
  private first = 0;
  private last: number;
  private now = 0;

  constructor(private readonly run: Run, private readonly other: Run | null, private readonly chosen: (sample: number) => void) {
    this.last = run.count - 1;
    for (const history of run.histories.values()) if (history.choice.plot) this.add(history);
    new ResizeObserver(() => this.resize()).observe(this.element);
  }

  private add(history: History): void {
    const { choice } = history;
    const title = `${choice.title}${choice.unit ? ` [${choice.unit}]` : ""}`;
    const body = el("div", {});
    const first = history.values.find((v) => !Number.isNaN(v));
    if (this.run.count < 2 || first === undefined || history.values.every((v) => v === first || Number.isNaN(v))) {
      const said = first !== undefined ? `stays at ${short(first * choice.factor)} ${choice.unit}` : "has no value in this run";
      this.element.append(el("figure", { class: "cw-plot cw-flat" }, el("figcaption", {}, `${choice.title} ${said}`)));
      return;
    }
    const box = el("figure", { class: "cw-plot", role: "group", "aria-label": `${title} over ${this.run.header.clock.is}` }, el("figcaption", {}, title), body);
    this.element.append(box);
    const pyramid = new Pyramid(history.values);
    const colours = () => getComputedStyle(this.element);
    const axis = (): uPlot.Axis => ({
      stroke: () => colours().getPropertyValue("--cw-soft"),
      grid: { stroke: () => colours().getPropertyValue("--cw-line"), width: 1 },
      ticks: { stroke: () => colours().getPropertyValue("--cw-line"), width: 1 },
      font: "11px system-ui, sans-serif",
    });
    const { clock } = this.run.header;
    const old = this.other?.histories.get(history.name);
    const before = old && this.other!.header.clock.is === clock.is ? new Pyramid(old.values) : null;
    const plot = new uPlot(
      {
        width: 320,
        height: 150,
        legend: { show: false },
        cursor: { drag: { x: true, y: false, setScale: false }, points: { show: false }, y: false },
        scales: { x: { time: false } },
        axes: [{ ...axis(), size: 30, values: (_, ticks) => ticks.map((t, k) => (k === ticks.length - 1 ? `${short(t)} ${clock.unit}` : short(t))) }, { ...axis(), size: (_, shown) => 18 + 6.5 * Math.max(3, ...(shown ?? []).map((one) => one.length)), values: (_, ticks) => ticked(ticks) }],
        series: [{}, ...(before ? [{ stroke: () => colours().getPropertyValue("--cw-soft"), width: 1, dash: [4, 3], points: { show: false }, spanGaps: false }] : []), { stroke: () => colours().getPropertyValue("--cw-curve"), width: 1, points: { show: false }, spanGaps: false }],
        hooks: {
          draw: [(u) => this.marks(u, history)],
          setSelect: [
            (u) => {
              if (u.select.width < 4) return;
              const from = u.posToVal(u.select.left, "x") / clock.factor;
              const to = u.posToVal(u.select.left + u.select.width, "x") / clock.factor;
              u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
              this.zoom(this.run.sampleAt(from), this.run.sampleAt(to));
            },
          ],
        },
      },
      before ? [[], [], []] : [[], []],
      body,
    );
    plot.over.addEventListener("dblclick", (event) => {
      event.stopPropagation();
      this.zoom(0, this.run.count - 1);
    });
    plot.over.addEventListener("click", (event) => {
      const at = plot.posToVal(event.offsetX, "x") / clock.factor;
      this.chosen(this.run.sampleAt(at));
    });
    this.plots.push({ plot, pyramid, history, box, before });
    this.fill(this.plots.length - 1);
  }

  private marks(u: uPlot, history: History): void {
    const { ctx } = u;
    const style = getComputedStyle(this.element);
    const ratio = devicePixelRatio || 1;
    ctx.save();
    ctx.beginPath();
    ctx.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height);
    ctx.clip();
    ctx.lineWidth = ratio;
    ctx.strokeStyle = style.getPropertyValue("--cw-bad");
    ctx.setLineDash([4 * ratio, 4 * ratio]);
    for (const limit of history.choice.limits) {
      const y = u.valToPos(limit * history.choice.factor, "y", true);
      ctx.beginPath();
      ctx.moveTo(u.bbox.left, y);
      ctx.lineTo(u.bbox.left + u.bbox.width, y);
      ctx.stroke();
    }
    ctx.setLineDash([]);
    ctx.strokeStyle = style.getPropertyValue("--cw-ink");
    const x = u.valToPos(this.run.clock[this.now] * this.run.header.clock.factor, "x", true);
    ctx.beginPath();
    ctx.moveTo(x, u.bbox.top);
    ctx.lineTo(x, u.bbox.top + u.bbox.height);
    ctx.stroke();
    const value = history.values[this.now];
    if (!Number.isNaN(value)) {
      ctx.fillStyle = ctx.strokeStyle;
      ctx.beginPath();
      ctx.arc(x, u.valToPos(value * history.choice.factor, "y", true), 3 * ratio, 0, 7);
      ctx.fill();
    }
    ctx.restore();
  }

  zoom(first: number, last: number): void {
    if (last - first < 2) return;
    this.first = first;
    this.last = last;
    this.plots.forEach((_, k) => this.fill(k));
  }

  private fill(k: number): void {
    const { plot, pyramid, history, before } = this.plots[k];
    const { factor } = this.run.header.clock;
    const found = pyramid.window(this.first, this.last);
    const shown = ({ sample, value }: { sample: number[]; value: (number | null)[] }, run: Run): [number[], (number | null)[]] => [
      sample.map((one) => {
        const i = Math.floor(one);
        const next = Math.min(run.count - 1, i + 1);
        return (run.clock[i] + (one - i) * (run.clock[next] - run.clock[i])) * factor;
      }),
      value.map((v) => (v === null ? null : v * history.choice.factor)),
    ];
    const now = shown(found, this.run);
    let values = now[1].filter((v): v is number => v !== null);
    if (before && this.other) {
      const [from, to] = [this.run.clock[this.first], this.run.clock[this.last]];
      const old = shown(before.window(this.other.sampleAt(from), this.other.sampleAt(to)), this.other);
      values = values.concat(old[1].filter((v): v is number => v !== null));
      plot.setData(uPlot.join([old, now]), false);
    } else plot.setData(now, false);
    const near = history.choice.limits.map((v) => v * history.choice.factor);
    let [low, high] = [Math.min(...values), Math.max(...values)];
    const span = high - low || Math.abs(high) || 1;
    for (const limit of near) {
      const off = Math.max(low - limit, limit - high, 0);
      if (off < 2 * span || span < SLIGHT * off) [low, high] = [Math.min(low, limit), Math.max(high, limit)];
    }
    const room = 0.06 * (high - low || 1);
    plot.batch(() => {
      plot.setScale("x", { min: this.run.clock[this.first] * factor, max: this.run.clock[this.last] * factor });
      if (values.length) plot.setScale("y", { min: low - room, max: high + room });
    });
  }

  goto(sample: number): void {
    this.now = sample;
    for (const { plot } of this.plots) plot.redraw(false);
  }

  private resize(): void {
    for (const { plot, box } of this.plots) {
      const width = Math.floor(box.clientWidth);
      if (width > 40 && width !== plot.width) plot.setSize({ width, height: 150 });
    }
  }
}
