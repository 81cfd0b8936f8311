// State is one sample; everything on the page follows it.
import { Change } from "./change";
import { el, replace } from "./dom";
import { Legend } from "./legend";
import { Plots } from "./plots";
import { ProgramPane } from "./program";
import { Run } from "./run";
import { PRESETS, Preset, View3D } from "./view3d";

const SPEEDS = [0.1, 0.2, 0.5, 1, 2, 5, 10, 100];
const WORDS = { pass: "PASS", fail: "FAIL", none: "NO VERDICT" };

export class App {
  sample = 0;
  readonly view: View3D | null;
  private readonly canvas = el("canvas", { class: "cw-canvas", tabindex: "0", role: "img", "aria-label": "part, tool and path in 3D" });
  private readonly stage: HTMLElement;
  private readonly slider: HTMLInputElement;
  private readonly clock = el("output", { class: "cw-clock" });
  private readonly readings = el("div", { class: "cw-readings" });
  private readonly said = el("div", { class: "cw-picked", role: "status" });
  private readonly plots: Plots;
  private readonly program: ProgramPane | null;
  private readonly legend: Legend;
  private readonly playButton = el("button", { type: "button", class: "cw-play", title: "play (space)", "aria-label": "play", click: () => this.play(!this.playing) }, "▶");
  private playing = false;
  private speed = 1;
  private coloured: string;
  private fixed: [number, number, number] | null = null;

  /** `other`: the run that this one is held against; `before`: what was shown, whose place and view are kept. */
  constructor(readonly run: Run, readonly root: HTMLElement, private readonly change: Change | null, private readonly other: Run | null, before: App | null) {
    const { header } = run;
    this.coloured = header.colour.first;
    this.legend = new Legend(run);
    this.slider = el("input", { type: "range", min: "0", max: String(run.count - 1), value: "0", class: "cw-slider", "aria-label": header.clock.is === "time" ? "time" : "way along the path", input: () => this.goto(Number(this.slider.value)) });
    this.plots = new Plots(run, other, (sample) => this.goto(sample));
    this.program = header.program ? new ProgramPane(run, (line) => this.gotoLine(line)) : null;
    this.view = this.open();
    this.stage = el("div", { class: "cw-stage" }, this.view ? this.canvas : this.without3d(), this.view ? this.tools() : null, this.legend.element, this.said);
    root.classList.add("cw");
    const active = document.activeElement; // the panel moves to the new page, and who is typing in it types on
    replace(root, this.heading(), el("div", { class: "cw-body" }, this.stage, this.side()), this.timeline(), this.plots.element);
    if (active instanceof HTMLElement && change?.element.contains(active)) active.focus();
    this.listen();
    this.view?.colour(this.coloured);
    this.legend.show(this.coloured);
    const size = () => this.view?.resize(this.canvas.clientWidth, this.canvas.clientHeight);
    new ResizeObserver(size).observe(this.stage);
    size();
    this.view?.look("fit");
    if (before) {
      if (before.view && this.view) this.view.standAt(before.view.stand);
      before.leave();
      if (run.histories.has(before.coloured)) this.colourBy(before.coloured);
      this.goto(run.sampleAt(before.run.clock[before.sample]));
      return;
    }
    const { sample, colour } = this.fromAddress();
    if (colour && run.histories.has(colour)) this.colourBy(colour);
    this.goto(sample ?? run.header.worst[0]?.sample ?? 0, false);
  }

  private open(): View3D | null {
    try {
      return new View3D(this.run, this.other, this.canvas);
    } catch (error) {
      console.info(`no 3D: ${String(error)}`);
      return null;
    }
  }

  private without3d(): HTMLElement {
    return el("p", { class: "cw-no3d" }, "This browser gives no 3D (WebGL 2). Curves, program and places work without it; the report has its pictures.");
  }

  private heading(): HTMLElement {
    const { header } = this.run;
    const was = new Map(this.other?.header.requirements.map((one) => [one.measure, one.text]));
    const tiles = header.requirements.map((one) => {
      const state = one.pass === null ? "none" : one.pass ? "pass" : "fail";
      return el(
        "div",
        { class: `cw-tile cw-${state}`, title: one.meaning },
        el("b", {}, one.title),
        el("small", {}, one.measure),
        el("span", { class: "cw-value" }, one.text, one.asked ? el("span", { class: "cw-asked" }, ` ${one.asked}`) : null),
        this.other && was.has(one.measure) ? el("small", {}, `${this.heldAgainst}: ${was.get(one.measure)}`) : null,
        el("span", { class: "cw-hidden" }, one.pass === null ? "" : one.pass ? "met" : "not met"),
      );
    });
    return el(
      "div",
      { class: "cw-head" },
      el("div", { class: "cw-name" }, el("h2", {}, header.name), el("span", { class: `cw-verdict cw-${header.verdict}`, "aria-live": "polite", title: header.verdict_text }, WORDS[header.verdict]), el("p", {}, header.verdict_text.replace(/^(PASS|FAIL)[:,] ?/, ""))),
      el("div", { class: "cw-tiles" }, ...tiles),
    );
  }

  private get heldAgainst(): string {
    if (this.other && this.other.header.name !== this.run.header.name) return this.other.header.name;
    return this.root.dataset.other ? "second run" : "before";
  }

  private tools(): HTMLElement {
    const view = this.view!;
    const names: Record<Preset, string> = { fit: "Fit", all: "All", iso: "Iso", top: "Top", front: "Front", right: "Right", tool: "Tool", worst: "Worst" };
    const button = (preset: Preset, key: number) => el("button", { type: "button", title: `key ${key}`, click: () => this.look(preset) }, names[preset]);
    const presets = [button("fit", 0), ...PRESETS.map((preset, k) => button(preset, k + 1))];
    if (this.run.header.scene.links) presets.push(button("all", 7)); // with what carries the tool
    const tool = el("button", { type: "button", "aria-pressed": "true", title: "show or hide the tool (t)", click: () => this.toggleTool() }, "Tool on");
    tool.dataset.toggle = "tool";
    const more: HTMLElement[] = this.run.header.tools.length ? [tool] : [];
    if (view.map) {
      const before = el("button", { type: "button", "aria-pressed": "false", title: "stock before or after (b)", click: () => this.toggleBefore() }, "Before");
      before.dataset.toggle = "before";
      more.push(before);
    }
    const share = el("input", { type: "range", min: "0", max: "1", step: "0.005", value: "0.5", "aria-label": "where it is cut", hidden: true });
    const axis = el("select", { "aria-label": "cut away" }, ...[["none", "Whole"], ["x", "Cut x"], ["y", "Cut y"], ["z", "Cut z"], ["view", "Cut view"]].map(([value, text]) => el("option", { value }, text)));
    const clip = () => {
      share.hidden = axis.value === "none";
      view.clip(axis.value as "none", Number(share.value));
    };
    axis.addEventListener("change", clip);
    share.addEventListener("input", clip);
    more.push(axis, share);
    const ribbons = [...this.run.histories.values()].filter((one) => one.choice.path);
    if (this.run.header.scene.path && ribbons.length > 1) {
      const by = el("select", { "aria-label": "colour the path by", change: () => this.colourBy(by.value) }, ...ribbons.map((one) => el("option", { value: one.name }, one.choice.title)));
      by.value = this.coloured;
      by.dataset.by = "path";
      more.push(by);
    }
    more.push(el("button", { type: "button", title: "save the picture with its legend", click: () => this.picture() }, "PNG"));
    return el("div", { class: "cw-tools" }, el("div", {}, ...presets), el("div", {}, ...more));
  }

  private side(): HTMLElement {
    const { header } = this.run;
    const worst = header.worst.map((one) =>
      el("li", {}, el("button", { type: "button", class: one.beyond ? "cw-beyond" : "", click: () => this.goto(one.sample) }, el("b", {}, one.text), ` at ${one.at}`, one.line ? `, line ${one.line}` : "")),
    );
    const judged = header.colour.choices[header.colour.judged];
    return el(
      "aside",
      { class: "cw-side" },
      this.program?.element,
      worst.length ? el("div", { role: "group", class: "cw-worst" }, el("h3", {}, "Worst places ", el("small", {}, header.colour.choices[header.colour.first]?.title ?? judged?.title ?? "")), el("ol", {}, ...worst)) : null,
      el("div", { role: "group", class: "cw-here" }, el("h3", {}, "At this place"), this.readings),
      this.change?.element,
      header.warnings.length
        ? el("details", { class: "cw-warnings" }, el("summary", {}, `${header.warnings.length} warning${header.warnings.length === 1 ? "" : "s"}`), el("ul", {}, ...header.warnings.map((one) => el("li", {}, one))))
        : null,
    );
  }

  private timeline(): HTMLElement {
    const speed = el("select", { "aria-label": "speed of the play", change: () => (this.speed = Number(speed.value)) }, ...SPEEDS.map((one) => el("option", { value: String(one) }, `×${one}`)));
    speed.value = "1";
    return el("div", { class: "cw-time" }, this.playButton, this.run.header.clock.is === "time" ? speed : null, this.slider, this.clock);
  }

  /** Moves to a sample: scene, clock, program, curves and readings follow. */
  goto(i: number, remembered = true): void {
    const sample = Math.min(this.run.count - 1, Math.max(0, Math.round(i)));
    this.sample = sample;
    this.slider.value = String(sample);
    this.slider.setAttribute("aria-valuetext", this.run.clockText(sample));
    this.clock.textContent = this.run.clockText(sample);
    this.view?.goto(sample);
    this.program?.goto(this.run.lineOf(sample));
    this.plots.goto(sample);
    this.read();
    if (remembered && !this.playing) this.remember();
  }

  gotoLine(line: number): void {
    const sample = this.run.sampleOfLine(line);
    if (sample !== null) this.goto(sample);
  }

  look(preset: Preset): void {
    if (preset === "worst" && this.run.header.worst.length) this.goto(this.run.header.worst[0].sample);
    this.view?.look(preset, this.sample);
  }

  colourBy(name: string): void {
    this.coloured = name;
    this.view?.colour(name);
    this.legend.show(name);
    const select = this.root.querySelector<HTMLSelectElement>("[data-by=path]");
    if (select) select.value = name;
    this.remember();
  }

  private read(): void {
    const rows = [...this.run.histories.values()].map((one) => {
      const [r, g, b] = this.run.colour(one.choice, one.values[this.sample]);
      const spot = el("i", { class: "cw-spot" });
      spot.style.background = `rgb(${r},${g},${b})`;
      const old = this.other?.histories.get(one.name);
      const then = old && this.other ? el("td", { class: "cw-was" }, this.other.valueText(old, this.other.sampleAt(this.run.clock[this.sample]))) : null;
      return el("tr", {}, el("th", { scope: "row" }, spot, one.choice.title), el("td", {}, this.run.valueText(one, this.sample)), then);
    });
    const head = this.other ? el("thead", {}, el("tr", {}, el("th", { scope: "col" }), el("th", { scope: "col" }, "now"), el("th", { scope: "col" }, this.heldAgainst))) : null;
    const place = this.run.at(this.sample).map((v) => v.toFixed(2)).join(", ");
    const where = el("tr", {}, el("th", { scope: "row" }, el("i", { class: "cw-spot cw-none" }), "tool"), el("td", {}, `${place} ${this.run.header.scene.unit}`));
    replace(this.readings, el("table", {}, head, el("tbody", {}, where, ...rows)));
  }

  play(on: boolean): void {
    this.playing = on;
    this.playButton.textContent = on ? "❚❚" : "▶";
    this.playButton.setAttribute("aria-label", on ? "pause" : "play");
    if (!on) {
      this.remember();
      return;
    }
    if (this.sample >= this.run.count - 1) this.goto(0);
    const { clock } = this.run;
    const whole = clock[clock.length - 1] - clock[0];
    const rate = this.run.header.clock.is === "time" ? this.speed : whole / 10;
    let at = clock[this.sample];
    let before = performance.now();
    const step = (time: number) => {
      if (!this.playing) return;
      at += ((time - before) / 1000) * (this.run.header.clock.is === "time" ? this.speed : rate);
      before = time;
      if (at >= clock[clock.length - 1]) {
        this.goto(this.run.count - 1);
        this.play(false);
        return;
      }
      this.goto(this.run.sampleAt(at));
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  private toggleTool(): void {
    if (!this.view) return;
    this.view.showTool(!this.view.toolShown);
    this.root.querySelector("[data-toggle=tool]")?.setAttribute("aria-pressed", String(this.view.toolShown));
  }

  private toggleBefore(): void {
    const map = this.view?.map;
    if (!map) return;
    map.showBefore(!map.showsBefore);
    this.root.querySelector("[data-toggle=before]")?.setAttribute("aria-pressed", String(map.showsBefore));
    this.view?.invalidate();
  }

  private listen(): void {
    this.root.addEventListener("keydown", this.onKey);
    this.canvas.addEventListener("lost", () => {
      this.said.textContent = "The picture was taken away by the browser: click to show it again.";
      this.said.addEventListener("click", () => location.reload(), { once: true });
    });
    let moved = 0;
    this.canvas.addEventListener("pointerdown", () => (moved = 0));
    this.canvas.addEventListener("pointermove", (event) => {
      moved += Math.abs(event.movementX) + Math.abs(event.movementY);
      if (event.buttons === 0) this.hover(event);
    });
    this.canvas.addEventListener("pointerleave", () => (this.said.textContent = ""));
    this.canvas.addEventListener("click", (event) => {
      if (moved > 4) return;
      const found = this.view?.pick(event);
      if (!found) return;
      if (found.sample !== null) this.goto(found.sample);
      this.measure(found.place);
    });
  }

  private readonly onKey = (event: KeyboardEvent) => this.key(event);

  /** Makes room for the next run. */
  private leave(): void {
    this.playing = false;
    this.root.removeEventListener("keydown", this.onKey);
    this.view?.dispose();
  }

  private hovered = 0;

  private hover(event: PointerEvent): void {
    if (performance.now() - this.hovered < 60) return;
    this.hovered = performance.now();
    const found = this.view?.pick(event);
    if (!found) {
      this.said.textContent = "";
      return;
    }
    const parts = [found.place.map((v) => v.toFixed(2)).join(", ") + ` ${this.run.header.scene.unit}`];
    if (found.name) parts.unshift(found.name);
    if (found.sample !== null) {
      parts.push(this.run.clockText(found.sample));
      const line = this.run.lineOf(found.sample);
      if (line) parts.push(`line ${line}: ${this.run.lines[line - 1] ?? ""}`);
      for (const one of this.run.histories.values()) if (one.choice.path) parts.push(`${one.choice.title} ${this.run.valueText(one, found.sample)}`);
    }
    this.said.textContent = parts.join(" · ");
  }

  /** Two clicks one after the other: the distance between them and its components. */
  private measure(place: [number, number, number]): void {
    const unit = this.run.header.scene.unit;
    if (this.fixed) {
      const d = place.map((v, k) => v - this.fixed![k]);
      this.said.textContent = `${Math.hypot(...d).toFixed(3)} ${unit} from the last place (x ${d[0].toFixed(3)}, y ${d[1].toFixed(3)}, z ${d[2].toFixed(3)})`;
    }
    this.fixed = place;
  }

  private key(event: KeyboardEvent): void {
    const target = event.target as HTMLElement;
    if (/^(SELECT|TEXTAREA)$/.test(target.tagName) || (target.tagName === "INPUT" && (target as HTMLInputElement).type !== "range")) return;
    if (event.altKey || event.metaKey) return;
    const step = (sign: number) => {
      if (event.ctrlKey) this.goto(this.run.block(this.sample, sign > 0));
      else this.goto(this.sample + sign * (event.shiftKey ? 100 : 1));
    };
    const { worst } = this.run.header;
    const next = (sign: number) => {
      if (!worst.length) return;
      const at = worst.findIndex((one) => one.sample === this.sample);
      const k = at < 0 ? (sign > 0 ? 0 : worst.length - 1) : (at + sign + worst.length) % worst.length;
      this.goto(worst[k].sample);
    };
    const keys: Record<string, () => void> = {
      ArrowLeft: () => step(-1),
      ArrowRight: () => step(1),
      Home: () => this.goto(0),
      End: () => this.goto(this.run.count - 1),
      n: () => next(1),
      p: () => next(-1),
      b: () => this.toggleBefore(),
      t: () => this.toggleTool(),
      "/": () => this.askLine(),
      "0": () => this.look("fit"),
      "7": () => this.look("all"),
      ...Object.fromEntries(PRESETS.map((preset, k) => [String(k + 1), () => this.look(preset)])),
    };
    if (!/^(BUTTON|SUMMARY)$/.test(target.tagName)) keys[" "] = () => this.play(!this.playing);
    const done = keys[event.key];
    if (!done || (event.ctrlKey && !event.key.startsWith("Arrow"))) return;
    event.preventDefault();
    done();
  }

  private askLine(): void {
    if (!this.program || this.root.querySelector(".cw-ask")) return;
    const input = el("input", { type: "number", min: "1", max: String(this.run.lines.length), "aria-label": "line of the program", placeholder: "line" });
    const form = el("form", { class: "cw-ask" }, input);
    const gone = () => {
      if (form.isConnected && !form.matches(".cw-gone")) {
        form.classList.add("cw-gone"); // removing it takes the focus from the field, which asks for it again
        form.remove();
      }
    };
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      const line = Number(input.value);
      gone();
      if (line > 0) this.gotoLine(line);
      this.canvas.focus();
    });
    input.addEventListener("keydown", (event) => {
      if (event.key === "Escape") gone();
    });
    input.addEventListener("blur", gone);
    this.stage.append(form);
    input.focus();
  }

  private picture(): void {
    if (!this.view) return;
    const copy = this.view.picture();
    this.legend.drawOn(copy, 2 * (devicePixelRatio || 1));
    const link = el("a", { download: `${this.run.header.name}.png` });
    link.href = copy.toDataURL("image/png");
    link.click();
  }

  private remember(): void {
    const { factor } = this.run.header.clock;
    const state = new URLSearchParams({ t: String(Number((this.run.clock[this.sample] * factor).toPrecision(8))), colour: this.coloured });
    try {
      history.replaceState(null, "", `#${state.toString()}`);
    } catch {
      // a frame without an address, as in a notebook
    }
  }

  private fromAddress(): { sample: number | null; colour: string | null } {
    const state = new URLSearchParams(location.hash.replace(/^#/, ""));
    const t = state.get("t");
    const at = t === null || t === "" || !Number.isFinite(Number(t)) ? null : this.run.sampleAt(Number(t) / this.run.header.clock.factor + 1e-9);
    return { sample: at, colour: state.get("colour") };
  }

  /** What tests and notebooks ask. */
  face() {
    const { run } = this;
    const app = this;
    return {
      get count() {
        return run.count;
      },
      get sample() {
        return app.sample;
      },
      goto: (i: number) => this.goto(i),
      timeOf: (i: number) => run.clock[i],
      lineOf: (i: number) => run.lineOf(i),
      gotoLine: (n: number) => this.gotoLine(n),
      place: (i: number) => run.at(i),
      project: (i: number) => this.view?.projected(run.traceAt(i)) ?? null,
      pick: (at: { clientX: number; clientY: number }) => this.view?.pick(at) ?? null,
      colourOf: (i: number) => {
        const one = run.histories.get(this.coloured);
        return one && !Number.isNaN(one.values[i]) && !(run.kind && run.kind[i] === 0) ? run.colour(one.choice, one.values[i]) : null;
      },
      look: (preset: Preset) => this.look(preset),
      showTool: (on: boolean) => this.view?.showTool(on),
      render: () => this.view?.render(),
      pixels: () => this.view?.pixels() ?? null,
      distance: () => this.view?.distance ?? null,
    };
  }
}
