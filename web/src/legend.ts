// What the colours mean: a bar with ticks and words for its ends, and notes on what is drawn larger than it is.
import { el, replace } from "./dom";
import { Choice } from "./file";
import { Run } from "./run";

export class Legend {
  readonly element = el("div", { class: "cw-legend" });
  private shown: string[] = [];

  constructor(private readonly run: Run) {}

  show(path: string): void {
    const { scene, colour } = this.run.header;
    const named = new Map<string, string[]>();
    const add = (name: string, what: string) => {
      if (colour.choices[name]) named.set(name, [...(named.get(name) ?? []), what]);
    };
    for (const surface of scene.surfaces) if (surface.coloured) add(surface.coloured, surface.title);
    if (scene.map?.coloured) add(scene.map.coloured, "stock");
    if (scene.path) add(path, "path");
    this.shown = [...named.keys()];
    replace(this.element, ...[...named].map(([name, what]) => this.bar(colour.choices[name], what)), ...this.notes.map((text) => el("p", {}, text)));
  }

  private get notes(): string[] {
    const { deflection, scene } = this.run.header;
    const notes = [...scene.said];
    if (deflection && deflection.k > 1) notes.unshift(`deflection drawn ${deflection.k} times`);
    return notes;
  }

  private bar(choice: Choice, what: string[]): HTMLElement {
    const table = this.run.table(choice);
    const stops = Array.from({ length: 17 }, (_, k) => {
      const i = 3 * Math.round((k * 255) / 16);
      return `rgb(${table[i]},${table[i + 1]},${table[i + 2]})`;
    });
    const strip = el("div", { class: "cw-strip" });
    strip.style.background = `linear-gradient(90deg, ${stops.join(",")})`;
    const inner = choice.ticks.slice(1, -1);
    const ticks = inner.map((tick) => {
      const share = choice.high > choice.low ? (tick.at - choice.low) / (choice.high - choice.low) : 0.5;
      const mark = el("span", { class: "cw-limit" }, tick.text);
      mark.style.left = `${100 * share}%`;
      return mark;
    });
    const [first, last] = [choice.ticks[0].text, choice.ticks[choice.ticks.length - 1].text];
    const ends = el("div", { class: "cw-ends" }, el("span", {}, `${first} ${choice.ends[0]}`.trim()), el("span", {}, `${choice.ends[1]} ${last}`.trim()));
    return el("div", { class: "cw-bar" }, el("b", {}, `${choice.title}${choice.unit ? ` [${choice.unit}]` : ""} `, el("small", {}, what.join(", "))), strip, inner.length ? el("div", { class: "cw-ticks" }, ...ticks) : null, ends);
  }

  /** The same on a picture. */
  drawOn(canvas: HTMLCanvasElement, ratio: number): void {
    const ctx = canvas.getContext("2d")!;
    ctx.globalCompositeOperation = "destination-over";
    ctx.fillStyle = "#f2f4f7";
    ctx.fillRect(0, 0, canvas.width, canvas.height);
    ctx.globalCompositeOperation = "source-over";
    const [left, width] = [12 * ratio, 220 * ratio];
    let y = canvas.height - 14 * ratio - 16 * ratio * this.notes.length - 52 * ratio * this.shown.length;
    ctx.font = `${12 * ratio}px system-ui, sans-serif`;
    for (const name of this.shown) {
      const choice = this.run.header.colour.choices[name];
      const table = this.run.table(choice);
      ctx.fillStyle = "#1d2733";
      ctx.textAlign = "left";
      ctx.fillText(`${choice.title}${choice.unit ? ` [${choice.unit}]` : ""}`, left, y + 12 * ratio);
      for (let k = 0; k < 256; k++) {
        ctx.fillStyle = `rgb(${table[3 * k]},${table[3 * k + 1]},${table[3 * k + 2]})`;
        ctx.fillRect(left + (k * width) / 256, y + 17 * ratio, width / 256 + 1, 10 * ratio);
      }
      ctx.fillStyle = "#1d2733";
      for (const tick of choice.ticks) {
        const share = choice.high > choice.low ? (tick.at - choice.low) / (choice.high - choice.low) : 0.5;
        ctx.textAlign = share < 0.02 ? "left" : share > 0.98 ? "right" : "center";
        ctx.fillText(tick.text, left + share * width, y + 40 * ratio);
      }
      y += 52 * ratio;
    }
    ctx.textAlign = "left";
    for (const text of this.notes) {
      ctx.fillText(text, left, y + 12 * ratio);
      y += 16 * ratio;
    }
  }
}
