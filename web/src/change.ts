// Turning knobs: the levers of the process, checked and run by the server; nothing of this is in a report.
import { el, replace } from "./dom";
import { inflated } from "./file";

export interface Field {
  key: string;
  text: string;
  meaning: string;
  unit: string;
  source: string;
  status: string;
  lever: boolean;
  usual: [string, string] | null;
  file: boolean;
}

interface Fault {
  key: string;
  text: string;
}

interface State {
  name: string;
  fields: Field[];
  run: number | null;
  faults: Fault[];
  live_below_s: number;
  can_save: boolean;
}

interface Told {
  state: string;
  progress?: number;
  run?: number;
  text?: string;
  faults?: Fault[];
  files?: Record<string, string>;
}

const HEAD = { "X-Cutwise": "1", "Content-Type": "application/json" };
const LIVE_AFTER = 300; // ms
const TAB = `${Date.now()}-${Math.random()}`; // a job of this tab is superseded by the next one, that of another is not

export class Change {
  readonly element = el("div", { role: "group", class: "cw-change", "aria-label": "change and run" });
  private readonly fieldset = el("div", { class: "cw-fields" });
  private readonly told = el("p", { class: "cw-told", role: "status" });
  private readonly progress = el("progress", { max: "1", value: "0", hidden: true });
  private readonly edits = new Map<string, string>();
  private readonly live = el("input", { type: "checkbox" });
  private run: number | null;
  private took = Infinity; // ms, the last run
  private liveBelow = 0;
  private timer = 0;
  private events: EventSource | null = null;
  private show: (buffer: ArrayBuffer) => unknown = () => undefined;

  constructor(number: string) {
    this.run = number === "" ? null : Number(number);
  }

  async begin(show: (buffer: ArrayBuffer) => unknown, root: HTMLElement): Promise<void> {
    this.show = show;
    const state = await this.post("/api/check", {});
    this.build(state);
    if (this.run !== null) await this.open(this.run);
    else {
      replace(root, this.element);
      root.classList.add("cw");
      if (!state.faults.length) await this.start();
    }
  }

  private async open(number: number): Promise<void> {
    const buffer = await this.fetched(number);
    this.run = number;
    this.show(buffer);
  }

  /** The view file of a run. */
  async fetched(number: number): Promise<ArrayBuffer> {
    const reply = await fetch(`/api/run/${number}/view`, { credentials: "same-origin" });
    if (!reply.ok) throw new Error(await reply.text());
    return inflated(new Uint8Array(await reply.arrayBuffer()));
  }

  /** Runs a case of a study and shows it; the command that does the same, or why it cannot be run. */
  async runCase(number: number): Promise<string> {
    this.told.textContent = "running …";
    this.progress.hidden = false;
    const begun = performance.now();
    const reply = await fetch(`/api/case/${number}`, { method: "POST", headers: HEAD, body: JSON.stringify({ tab: TAB }), credentials: "same-origin" });
    if (!reply.ok) {
      this.progress.hidden = true;
      return (this.told.textContent = await reply.text());
    }
    const said = (await reply.json()) as { edits: Record<string, string>; command: string };
    this.take(said.edits);
    this.follow(begun);
    return said.command;
  }

  /** Puts values into the fields, as if they had been typed. */
  private take(values: Record<string, string>): void {
    this.edits.clear();
    for (const [key, value] of Object.entries(values)) this.edits.set(key, value);
    for (const input of this.element.querySelectorAll<HTMLInputElement>("input[data-key]")) {
      const value = this.edits.get(input.dataset.key ?? "");
      input.value = value ?? input.defaultValue;
      const slider = input.closest(".cw-field")?.querySelector<HTMLInputElement>("input[type=range]");
      if (slider && Number.isFinite(parseFloat(input.value))) slider.value = String(parseFloat(input.value));
    }
  }

  /** For a study: fields are there, nothing is run until a case is chosen. */
  async wait(show: (buffer: ArrayBuffer) => unknown): Promise<void> {
    this.show = show;
    this.build(await this.post("/api/check", {}));
  }

  private build(state: State): void {
    this.liveBelow = 1000 * state.live_below_s;
    const levers = state.fields.filter((one) => one.lever);
    const others = state.fields.filter((one) => !one.lever);
    replace(this.fieldset, ...levers.map((one) => this.field(one)));
    const all = el("details", {}, el("summary", {}, `all ${state.fields.length} values`), ...others.map((one) => this.field(one)));
    const live = el("label", {}, this.live, " live");
    replace(
      this.element,
      el("h3", {}, "Change and run"),
      this.fieldset,
      others.length ? all : null,
      el(
        "div",
        { class: "cw-buttons" },
        el("button", { type: "button", class: "cw-run", click: () => void this.start() }, "Run"),
        el("button", { type: "button", click: () => void this.cancel() }, "Cancel"),
        live,
        state.can_save && el("button", { type: "button", click: () => void this.save(null) }, "Save"),
        el("button", { type: "button", click: () => void this.saveAs() }, "Save as …"),
        el("button", { type: "button", click: () => void this.keep() }, "Keep run"),
      ),
      this.progress,
      this.told,
    );
    this.faults(state.faults);
  }

  private field(one: Field): HTMLElement {
    const input = el("input", { type: "text", value: one.text, id: `cw-${one.key}`, "data-key": one.key, autocomplete: "off", spellcheck: "false" });
    input.addEventListener("input", () => {
      if (input.value === one.text) this.edits.delete(one.key);
      else this.edits.set(one.key, input.value);
      this.changed();
    });
    const slider = this.slider(one, input);
    return el(
      "div",
      { class: "cw-field", title: one.meaning },
      el("label", { for: `cw-${one.key}` }, words(one.key), el("small", {}, `${one.key} · ${one.status}`)),
      input,
      slider,
      one.file && this.bringing(one, input),
      el("p", { class: "cw-fault", "data-fault": one.key }),
    );
  }

  /** A file of the user for this key: it goes to the server, and its name stands in the field from then on. */
  private bringing(one: Field, input: HTMLInputElement): HTMLElement {
    const chosen = el("input", { type: "file", "aria-label": `${one.key}, a file of yours`, "data-file": one.key });
    chosen.addEventListener("change", async () => {
      const file = chosen.files?.[0];
      if (!file) return;
      const reply = await fetch(`/api/files?name=${encodeURIComponent(file.name)}`, { method: "POST", headers: { "X-Cutwise": "1" }, body: file, credentials: "same-origin" });
      if (!reply.ok) {
        this.told.textContent = await reply.text();
        return;
      }
      input.value = file.name;
      this.edits.set(one.key, ((await reply.json()) as { file: string }).file);
      this.changed();
    });
    return chosen;
  }

  private slider(one: Field, input: HTMLInputElement): HTMLElement | null {
    const number = (text: string) => /^\s*([-+\d.eE]+)\s*(.*)$/.exec(text);
    const now = number(one.text);
    const ends = one.usual?.map(number);
    if (!now || !ends || !ends[0] || !ends[1] || ends.some((end) => end![2] !== now[2])) return null;
    const [low, high] = [Number(ends[0][1]), Number(ends[1][1])];
    const slider = el("input", { type: "range", min: String(Math.min(low, Number(now[1]))), max: String(Math.max(high, Number(now[1]))), step: "any", value: now[1], "aria-label": `${one.key}, slider` });
    slider.addEventListener("input", () => {
      input.value = `${Number(Number(slider.value).toPrecision(3))} ${now[2]}`.trim();
      input.dispatchEvent(new Event("input"));
    });
    return slider;
  }

  private changed(): void {
    window.clearTimeout(this.timer);
    this.timer = window.setTimeout(async () => {
      const state = await this.post("/api/check", this.given());
      this.faults(state.faults);
      if (this.live.checked && !state.faults.length && this.took < this.liveBelow) await this.start();
    }, LIVE_AFTER);
  }

  private given(): { edits: Record<string, string> } {
    return { edits: Object.fromEntries(this.edits) };
  }

  private faults(faults: Fault[]): void {
    for (const place of this.element.querySelectorAll<HTMLElement>("[data-fault]")) {
      place.textContent = faults.filter((one) => one.key === place.dataset.fault).map((one) => one.text).join("\n");
    }
    const known = new Set([...this.element.querySelectorAll<HTMLElement>("[data-fault]")].map((one) => one.dataset.fault));
    const rest = faults.filter((one) => !known.has(one.key));
    this.told.textContent = faults.length ? `${faults.length} fault${faults.length === 1 ? "" : "s"}: nothing runs until mended. ${rest.map((one) => one.text).join("; ")}` : "";
    for (const button of this.element.querySelectorAll<HTMLButtonElement>(".cw-run")) button.disabled = faults.length > 0;
  }

  private async start(): Promise<void> {
    this.told.textContent = "running …";
    this.progress.hidden = false;
    const begun = performance.now();
    const reply = await fetch("/api/job", { method: "POST", headers: HEAD, body: JSON.stringify({ ...this.given(), tab: TAB }), credentials: "same-origin" });
    if (!reply.ok && reply.status !== 409) {
      this.progress.hidden = true;
      const text = await reply.text();
      if (reply.headers.get("content-type")?.startsWith("application/json")) this.faults((JSON.parse(text) as { faults: Fault[] }).faults);
      else this.told.textContent = text;
      return;
    }
    this.follow(begun);
  }

  /** Listens how the job goes; the connection is there only while one runs. */
  private follow(begun: number): void {
    this.events?.close();
    const events = new EventSource("/api/job/events");
    this.events = events;
    events.addEventListener("message", (event) => {
      const told = JSON.parse(event.data as string) as Told;
      if (told.progress !== undefined) this.progress.value = told.progress;
      if (told.state === "running" || told.state === "idle") return;
      events.close();
      this.progress.hidden = true;
      this.told.textContent = told.text ?? told.state;
      this.took = performance.now() - begun;
      if (told.state === "done" && told.files) this.told.textContent = `kept: ${Object.values(told.files).join(", ")}`;
      if (told.state === "failed") this.faults(told.faults ?? []);
      if (told.state === "failed" || told.state === "killed") this.told.textContent = told.text ?? told.state;
      if (told.state === "done" && told.run !== undefined) {
        this.told.textContent = `${told.text ?? ""} – Keep run also halves the step and looks for advice.`;
        void this.open(told.run);
      }
    });
    events.addEventListener("error", () => {
      events.close();
      this.progress.hidden = true;
      this.told.textContent = "the connection to cutwise is gone; start cutwise view again, or run again";
    });
  }

  private async cancel(): Promise<void> {
    const reply = await fetch("/api/job/cancel", { method: "POST", headers: HEAD, body: "{}", credentials: "same-origin" });
    this.told.textContent = reply.ok ? "cancelled" : await reply.text();
    this.progress.hidden = true;
  }

  private async save(as: string | null): Promise<void> {
    const body = JSON.stringify({ ...this.given(), ...(as ? { as } : {}) });
    const reply = await fetch("/api/save", { method: "POST", headers: HEAD, body, credentials: "same-origin" });
    this.told.textContent = reply.ok ? `saved${as ? ` as ${as}` : ""}` : await reply.text();
  }

  private async saveAs(): Promise<void> {
    const name = window.prompt("name of the new file, in the folder of the scenario", "changed.yaml");
    if (name) await this.save(name);
  }

  private async keep(): Promise<void> {
    if (this.run === null) return;
    const reply = await fetch(`/api/keep/${this.run}`, { method: "POST", headers: HEAD, body: "{}", credentials: "same-origin" });
    if (!reply.ok) {
      this.told.textContent = await reply.text();
      return;
    }
    this.told.textContent = "writing run and report …";
    this.follow(performance.now());
  }

  private async post(path: string, body: object): Promise<State> {
    const reply = await fetch(path, { method: "POST", headers: HEAD, body: JSON.stringify(body), credentials: "same-origin" });
    if (!reply.ok) throw new Error(await reply.text());
    return (await reply.json()) as State;
  }
}

function words(key: string): string {
  const last = key.split(".").pop() ?? key;
  const text = last.replaceAll("_", " ");
  return text.charAt(0).toUpperCase() + text.slice(1);
}

