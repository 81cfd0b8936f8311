// The cases of a study as points: a click runs one again and shows it, with the command that does the same.
import { Change } from "./change";
import { el, replace } from "./dom";

interface Column {
  title: string;
  unit: string;
  values: (number | string | null)[];
  name?: string;
  limits?: number[];
}

interface Told {
  name: string;
  lines: string[];
  done: number;
  cases: number;
  case: number[];
  state: string[];
  levers: Column[];
  measures: Column[];
  worst: { case: number; command: string }[];
}

const STATES: Record<string, string> = { good: "--cw-curve", bad: "--cw-bad", infeasible: "--cw-odd", failed: "--cw-soft" };
const NEAR = 14; // px
const ROOM = { left: 62, right: 14, top: 10, bottom: 40 };

export class StudyPage {
  private readonly canvas = el("canvas", { class: "cw-cases", role: "img", "aria-label": "cases of the study; the list below opens them by keyboard" });
  private readonly hovered = el("p", { class: "cw-told", role: "status" });
  private readonly command = el("code", { class: "cw-command" });
  private readonly place = el("div", {});
  private readonly columns: Column[];
  private across: number;
  private up: number;
  private shown: number | null = null;
  private points: { x: number; y: number; k: number }[] = [];

  constructor(private readonly told: Told, root: HTMLElement, private readonly change: Change) {
    this.columns = [...told.levers, ...told.measures];
    this.across = 0;
    this.up = told.measures.length ? told.levers.length : Math.min(1, this.columns.length - 1);
    root.classList.add("cw", "cw-study");
    replace(root, this.heading(), this.scatter(), this.list(), el("div", { class: "cw-opened" }, this.command), this.place);
    new ResizeObserver(() => this.draw()).observe(this.canvas);
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
    this.draw();
  }

  /** Where the case that is opened is shown. */
  get viewer(): HTMLElement {
    return this.place;
  }

  private heading(): HTMLElement {
    const link = el("a", { class: "cw-link" }, "report of the study");
    link.href = "/study";
    return el("div", { class: "cw-head" }, el("div", { class: "cw-name" }, el("h2", {}, this.told.name), el("p", {}, `${this.told.done.toLocaleString("en")} of ${this.told.cases.toLocaleString("en")} cases · `, link)), el("div", { class: "cw-lines" }, ...this.told.lines.map((one) => el("p", {}, one))));
  }

  private scatter(): HTMLElement {
    const choose = (now: number, label: string, chosen: (k: number) => void) => {
      const select = el("select", { "aria-label": label, change: () => chosen(Number(select.value)) }, ...this.columns.map((one, k) => el("option", { value: String(k) }, one.title)));
      select.value = String(now);
      return select;
    };
    const x = choose(this.across, "across", (k) => this.axes(k, this.up));
    const y = choose(this.up, "up", (k) => this.axes(this.across, k));
    const number = el("input", { type: "number", min: "0", max: String(this.told.done - 1), "aria-label": "number of a case", placeholder: "case" });
    const form = el("form", { class: "cw-case" }, number, el("button", { type: "submit" }, "Open case"));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      if (number.value !== "") void this.open(Number(number.value));
    });
    this.canvas.addEventListener("pointermove", (event) => this.hover(event));
    this.canvas.addEventListener("click", (event) => {
      const k = this.nearest(event);
      if (k !== null) void this.open(this.told.case[k]);
    });
    const key = Object.keys(STATES).filter((one) => this.told.state.includes(one)).map((one) => {
      const spot = el("i", { class: "cw-spot" });
      spot.style.background = `var(${STATES[one]})`;
      return el("span", {}, spot, one);
    });
    return el("div", { class: "cw-scatter" }, el("div", { class: "cw-axes" }, el("label", {}, "across ", x), el("label", {}, "up ", y), form, el("span", { class: "cw-key" }, ...key)), this.canvas, this.hovered);
  }

  private list(): HTMLElement {
    const rows = this.told.worst.map((one) => {
      const k = this.told.case.indexOf(one.case);
      const values = this.told.measures.slice(0, 4).map((column) => `${column.title} ${this.text(column, k)}`);
      return el("li", {}, el("button", { type: "button", "data-case": String(one.case), title: one.command, click: () => void this.open(one.case) }, el("b", {}, `case ${one.case}`), ` ${values.join(" · ")}`));
    });
    return el("div", { class: "cw-worst", role: "group" }, rows.length ? el("h3", {}, "The worst cases: a click runs one and shows it") : null, el("ol", {}, ...rows));
  }

  private async open(number: number): Promise<void> {
    this.shown = number;
    this.draw();
    this.command.textContent = `case ${number}: is run again …`;
    const said = await this.change.runCase(number);
    this.command.textContent = said;
  }

  private axes(x: number, y: number): void {
    this.across = x;
    this.up = y;
    this.draw();
  }

  private text(column: Column, k: number): string {
    const value = column.values[k];
    return value === null || value === undefined ? "none" : `${typeof value === "number" ? Number(value.toPrecision(4)) : value} ${column.unit}`.trim();
  }

  /** Numbers of a column; words by their rank. */
  private numbers(column: Column): (number | null)[] {
    if (column.values.every((v) => typeof v !== "string")) return column.values as (number | null)[];
    const words = [...new Set(column.values.map(String))].sort();
    return column.values.map((v) => words.indexOf(String(v)));
  }

  private draw(): void {
    const ratio = devicePixelRatio || 1;
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    if (width < 10 || height < 10) return;
    this.canvas.width = width * ratio;
    this.canvas.height = height * ratio;
    const ctx = this.canvas.getContext("2d")!;
    ctx.scale(ratio, ratio);
    const style = getComputedStyle(this.canvas);
    const colour = (name: string) => style.getPropertyValue(name);
    const [cx, cy] = [this.columns[this.across], this.columns[this.up]];
    const [vx, vy] = [this.numbers(cx), this.numbers(cy)];
    const span = (values: (number | null)[], limits: number[] = []): [number, number] => {
      const known = values.filter((v): v is number => v !== null);
      let [low, high] = [Math.min(...known), Math.max(...known)];
      const wide = high - low || Math.abs(high) || 1;
      for (const one of limits) if (one > low - 2 * wide && one < high + 2 * wide) [low, high] = [Math.min(low, one), Math.max(high, one)];
      const room = 0.05 * (high - low || Math.abs(high) || 1);
      return [low - room, high + room];
    };
    const [x0, x1] = span(vx, cx.limits);
    const [y0, y1] = span(vy, cy.limits);
    const px = (v: number) => ROOM.left + ((v - x0) / (x1 - x0)) * (width - ROOM.left - ROOM.right);
    const py = (v: number) => height - ROOM.bottom - ((v - y0) / (y1 - y0)) * (height - ROOM.top - ROOM.bottom);
    ctx.clearRect(0, 0, width, height);
    ctx.font = "11px system-ui, sans-serif";
    ctx.fillStyle = colour("--cw-soft");
    ctx.strokeStyle = colour("--cw-line");
    ctx.textAlign = "center";
    for (const t of steps(x0, x1, Math.max(2, Math.floor(width / 110)))) {
      line(ctx, px(t), ROOM.top, px(t), height - ROOM.bottom);
      ctx.fillText(String(t), px(t), height - ROOM.bottom + 14);
    }
    ctx.textAlign = "right";
    for (const t of steps(y0, y1, 5)) {
      line(ctx, ROOM.left, py(t), width - ROOM.right, py(t));
      ctx.fillText(String(t), ROOM.left - 5, py(t) + 4);
    }
    ctx.textAlign = "center";
    ctx.fillText(named(cx), ROOM.left + (width - ROOM.left - ROOM.right) / 2, height - 6);
    ctx.save();
    ctx.translate(11, ROOM.top + (height - ROOM.top - ROOM.bottom) / 2);
    ctx.rotate(-Math.PI / 2);
    ctx.fillText(named(cy), 0, 0);
    ctx.restore();
    ctx.strokeStyle = colour("--cw-bad");
    ctx.setLineDash([5, 4]);
    for (const one of cx.limits ?? []) if (one > x0 && one < x1) line(ctx, px(one), ROOM.top, px(one), height - ROOM.bottom);
    for (const one of cy.limits ?? []) if (one > y0 && one < y1) line(ctx, ROOM.left, py(one), width - ROOM.right, py(one));
    ctx.setLineDash([]);
    this.points = [];
    const size = this.told.case.length > 600 ? 2 : 3.5;
    for (let k = 0; k < this.told.case.length; k++) {
      const [a, b] = [vx[k], vy[k]];
      if (a === null || b === null) continue;
      const at = { x: px(a), y: py(b), k };
      this.points.push(at);
      ctx.fillStyle = colour(STATES[this.told.state[k]] ?? "--cw-soft");
      ctx.beginPath();
      ctx.arc(at.x, at.y, size, 0, 7);
      ctx.fill();
      if (this.told.case[k] === this.shown) {
        ctx.strokeStyle = colour("--cw-ink");
        ctx.lineWidth = 2;
        ctx.beginPath();
        ctx.arc(at.x, at.y, size + 4, 0, 7);
        ctx.stroke();
        ctx.lineWidth = 1;
      }
    }
  }

  private nearest(event: MouseEvent): number | null {
    let best: number | null = null;
    let least = NEAR * NEAR;
    for (const { x, y, k } of this.points) {
      const d = (x - event.offsetX) ** 2 + (y - event.offsetY) ** 2;
      if (d < least) [least, best] = [d, k];
    }
    return best;
  }

  private hover(event: PointerEvent): void {
    const k = this.nearest(event);
    this.canvas.style.cursor = k === null ? "" : "pointer";
    this.hovered.textContent = k === null ? "" : [`case ${this.told.case[k]}, ${this.told.state[k]}`, ...this.columns.map((one) => `${one.title} ${this.text(one, k)}`)].join(" · ");
  }

  /** Where a case is drawn, in pixels of the page: for tests. */
  at(number: number): { x: number; y: number } | null {
    const found = this.points.find((one) => this.told.case[one.k] === number);
    const box = this.canvas.getBoundingClientRect();
    return found ? { x: box.left + found.x, y: box.top + found.y } : null;
  }
}

function named(column: Column): string {
  return column.unit ? `${column.title} [${column.unit}]` : column.title;
}

function line(ctx: CanvasRenderingContext2D, x0: number, y0: number, x1: number, y1: number): void {
  ctx.beginPath();
  ctx.moveTo(x0, y0);
  ctx.lineTo(x1, y1);
  ctx.stroke();
}

/** About so many round numbers between two. */
function steps(low: number, high: number, count: number): number[] {
  const rough = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((one) => one * power).find((one) => one >= rough) ?? rough;
  const found = [];
  for (let t = Math.ceil(low / step) * step; t <= high; t += step) found.push(Number(t.toPrecision(12)));
  return found;
}

/** The points, as the server has them. */
export async function opened(root: HTMLElement, change: Change): Promise<StudyPage> {
  const reply = await fetch("/api/study", { credentials: "same-origin" });
  if (!reply.ok) throw new Error(await reply.text());
  return new StudyPage((await reply.json()) as Told, root, change);
}
