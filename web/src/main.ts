// Where the page begins: the view file stands in the page (report, notebook), or a server gives it.
import { App } from "./app";
import { Change } from "./change";
import { el } from "./dom";
import { fromBase64, inflated, ViewFile } from "./file";
import { Run } from "./run";
import { opened, StudyPage } from "./study";

declare global {
  interface Window {
    cutwise?: { app?: ReturnType<App["face"]>; study?: StudyPage };
  }
}

async function begin(): Promise<void> {
  const root = document.getElementById("cutwise-view");
  if (!root) return;
  const inside = document.getElementById("cutwise-data");
  const number = root.dataset.run;
  const change = number !== undefined ? new Change(number) : null;
  let last: App | null = null;
  let other: Run | null = null; // what the run is held against: the second of two, or the one before it
  const show = (buffer: ArrayBuffer, place: HTMLElement) => {
    const before = last;
    const app = new App(new Run(new ViewFile(buffer)), place, change, other ?? before?.run ?? null, before);
    last = app;
    window.cutwise = { ...window.cutwise, app: app.face() };
    app.view?.render();
    return app;
  };
  try {
    if (inside) {
      show(await inflated(fromBase64(inside.textContent ?? "")), root);
    } else if (change && root.dataset.study) {
      const study = await opened(root, change);
      await change.wait((buffer) => show(buffer, study.viewer));
      study.viewer.append(change.element);
      window.cutwise = { app: window.cutwise?.app, study };
    } else if (change) {
      if (root.dataset.other) other = new Run(new ViewFile(await change.fetched(Number(root.dataset.other))));
      await change.begin((buffer) => show(buffer, root), root);
    } else {
      return;
    }
    document.documentElement.dataset.viewer = "1";
    offerPictures(root);
    requestAnimationFrame(() => (document.documentElement.dataset.ready = "1"));
  } catch (error) {
    root.textContent = `The viewer could not be opened (${error instanceof Error ? error.message : String(error)}); the report below has its pictures.`;
    document.documentElement.dataset.failed = "1";
  }
}

/** The pictures of a report, which the viewer stands for, can be had all the same. */
function offerPictures(root: HTMLElement): void {
  const pictures = document.querySelector<HTMLElement>(".pictures");
  if (!pictures?.childElementCount) return;
  const button = el("button", { type: "button", "aria-expanded": "false" }, "Show all pictures");
  button.addEventListener("click", () => {
    const shown = pictures.classList.toggle("shown");
    button.setAttribute("aria-expanded", String(shown));
    button.textContent = shown ? "Hide the pictures" : "Show all pictures";
  });
  root.append(el("div", { class: "cw-pictures" }, button));
}

void begin();
