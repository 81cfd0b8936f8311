// The program as the user wrote it: the rows that can be seen, the line at now, marks of the worst lines.
import { el } from "./dom";
import { Worst } from "./file";
import { Run } from "./run";

const ROW = 20; // px
const TALLEST = 8_000_000; // px; elements end near 17 million

export class ProgramPane {
  readonly element: HTMLElement;
  private readonly scroller: HTMLElement;
  private readonly rows: HTMLElement;
  private readonly spacer: HTMLElement;
  private readonly modal = el("p", { class: "cw-modal" });
  private readonly bad: Map<number, Worst>;
  private line = 0;

  constructor(private readonly run: Run, private readonly chosen: (line: number) => void) {
    this.bad = new Map(run.header.worst.filter((one) => one.line > 0).map((one) => [one.line, one]));
    this.rows = el("div", { class: "cw-rows" });
    this.spacer = el("div", { class: "cw-spacer" });
    this.spacer.style.height = `${this.height}px`;
    this.scroller = el("div", { class: "cw-scroller", tabindex: "0", role: "region", "aria-label": "program", scroll: () => this.draw() }, this.spacer, this.rows);
    this.element = el("div", { role: "group", class: "cw-program" }, el("h3", {}, "Program ", el("small", {}, run.header.program?.file ?? "")), this.scroller, this.modal);
    new ResizeObserver(() => this.draw()).observe(this.scroller);
  }

  private get height(): number {
    return Math.min(TALLEST, this.run.lines.length * ROW);
  }

  goto(line: number): void {
    this.line = line;
    const words = this.run.inForce(line);
    this.modal.textContent = words ? `in force: ${words}` : "";
    if (line > 0) {
      const room = this.scroller.clientHeight;
      const all = this.run.lines.length * ROW;
      const at = (line - 1) * ROW;
      const top = this.top();
      if (at < top + ROW || at > top + room - 2 * ROW) {
        const wanted = Math.max(0, at - 0.4 * room);
        const most = Math.max(1, all - room);
        this.scroller.scrollTop = this.height === all ? wanted : (wanted / most) * Math.max(1, this.height - room);
      }
    }
    this.draw();
  }

  /** How far the rows are scrolled, also where the element is shorter than all of them. */
  private top(): number {
    const all = this.run.lines.length * ROW;
    if (this.height === all) return this.scroller.scrollTop;
    const room = this.scroller.clientHeight;
    return (this.scroller.scrollTop / Math.max(1, this.height - room)) * Math.max(0, all - room);
  }

  private draw(): void {
    const top = this.top();
    const first = Math.max(0, Math.floor(top / ROW) - 2);
    const count = Math.min(60, Math.ceil(this.scroller.clientHeight / ROW) + 4);
    this.rows.style.transform = `translateY(${this.scroller.scrollTop - (top - first * ROW)}px)`;
    const shown: HTMLElement[] = [];
    for (let n = first; n < Math.min(this.run.lines.length, first + count); n++) {
      const line = n + 1;
      const bad = this.bad.get(line);
      shown.push(
        el(
          "div",
          {
            class: `cw-row${line === this.line ? " cw-now" : ""}${bad ? " cw-bad" : ""}`,
            "data-line": String(line),
            click: () => this.chosen(line),
            ...(line === this.line ? { "aria-current": "true" } : {}),
          },
          el("span", { class: "cw-number" }, String(line)),
          el("span", { class: "cw-text" }, this.run.lines[n]),
          bad ? el("span", { class: bad.beyond ? "cw-mark cw-beyond" : "cw-mark" }, bad.text) : null,
        ),
      );
    }
    this.rows.replaceChildren(...shown);
  }
}
