"""The viewer in a real browser: Debian's chromium through playwright; skipped without, unless CUTWISE_BROWSER=required."""

import dataclasses
import difflib
import json
import os
import re
import subprocess
import sys
from contextlib import contextmanager, suppress
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

from app.view_file import read
from app.viewed import viewing
from cutwise.app.report import render
from cutwise.app.scene import rows, view
from cutwise.app.scene.in_force import in_force
from cutwise.app.scene.packed import as_text
from cutwise.app.scene.view import view_file

CHROMIUM = Path("/usr/bin/chromium")
SETTINGS = [
    "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
]  # fmt: skip
READY = 'html[data-ready="1"]'
LOADED = 60_000  # ms
try:
    from playwright.sync_api import sync_playwright
except ImportError:
    sync_playwright = None
HERE = sync_playwright is not None and CHROMIUM.exists()
REQUIRED = os.environ.get("CUTWISE_BROWSER") == "required"
pytestmark = pytest.mark.skipif(not HERE and not REQUIRED, reason="no chromium, or no playwright to lead it")


@pytest.fixture(scope="module")
def playwright():
    assert HERE, "CUTWISE_BROWSER=required, and there is no chromium or no playwright"
    with sync_playwright() as led:
        yield led


@pytest.fixture(scope="module")
def browser(playwright):
    led = playwright.chromium.launch(executable_path=str(CHROMIUM), headless=True, args=SETTINGS)
    yield led
    led.close()


@pytest.fixture(scope="module")
def reports(reference, small_pocket, tmp_path_factory):
    """Reports of two runs, as files."""
    folder = tmp_path_factory.mktemp("reports")
    found = {}
    for name, result in (("deburr", reference), ("pocket", small_pocket)):
        found[name] = folder / f"{name}.html"
        found[name].write_text(render(result), encoding="utf-8")
    return found


CONTRAST = """() => {
  const ctx = document.createElement('canvas').getContext('2d', {willReadFrequently: true});
  const rgb = c => {
    ctx.clearRect(0, 0, 1, 1); ctx.fillStyle = c; ctx.fillRect(0, 0, 1, 1);
    return [...ctx.getImageData(0, 0, 1, 1).data]; };
  const one = v => { v /= 255; return v <= .04045 ? v / 12.92 : ((v + .055) / 1.055) ** 2.4; };
  const lum = ([r, g, b]) => .2126 * one(r) + .7152 * one(g) + .0722 * one(b);
  const found = [];
  for (const e of document.querySelectorAll('.cw *')) {
    const own = [...e.childNodes].some(n => n.nodeType === 3 && n.textContent.trim());
    if (!own || !e.getClientRects().length || e.closest('.cw-hidden, .cw-legend, .cw-picked, option')) continue;
    let at = e, back = null;
    while (at && !back) { const c = rgb(getComputedStyle(at).backgroundColor); if (c[3] === 255) back = c; at = at.parentElement; }
    if (!back) continue;
    const [a, b] = [lum(rgb(getComputedStyle(e).color)), lum(back)];
    const ratio = (Math.max(a, b) + .05) / (Math.min(a, b) + .05);
    if (ratio < 4.5) found.push([e.className, e.textContent.slice(0, 30), ratio.toFixed(2)]);
  }
  return found; }"""
COLOURED = """() => {
  const app = cutwise.app, box = document.querySelector('.cw-canvas').getBoundingClientRect();
  const {width, height, data} = app.pixels();
  const coloured = [];
  for (let i = 0; i < app.count; i++) if (app.colourOf(i)) coloured.push(i);
  let seen = 0, right = 0;
  for (let k = 0; k < coloured.length; k += 7) {
    const i = coloured[k], p = app.project(i);
    const x = Math.round((p.x - box.left) / box.width * width - .5);
    const y = Math.round((1 - (p.y - box.top) / box.height) * height - .5);
    let near = false;
    for (let a = -1; a <= 1; a++) for (let b = -1; b <= 1; b++) {
      const q = 4 * ((y + b) * width + x + a);
      for (let j = Math.max(0, i - 25); j <= Math.min(app.count - 1, i + 25) && !near; j++) {
        const c = app.colourOf(j);
        near = !!c && [0, 1, 2].every(m => Math.abs(c[m] - data[q + m]) <= 3);
      }
    }
    seen++;
    if (near) right++;
  }
  return [seen, right]; }"""


@contextmanager
def page_of(browser, address, *, width=900, height=700, ready=True, **context):
    """A page, of which every word on the console and every request to elsewhere is a fault."""
    opened_ = browser.new_context(viewport={"width": width, "height": height}, **context)
    page, wrong = opened_.new_page(), []
    page.on("console", lambda said: wrong.append(said.text) if said.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("request", lambda asked: wrong.append(asked.url) if not allowed(asked.url, address) else None)
    page.goto(address)
    if ready:
        page.wait_for_selector(READY, state="attached", timeout=LOADED)
    yield page
    opened_.close()
    assert wrong == []


def allowed(url, address):
    local = re.match(r"http://127\.0\.0\.1:\d+/", address)
    return url.startswith(("file:", "data:", "blob:")) or (local is not None and url.startswith(local[0]))


def app(page, call):
    """What ``window.cutwise.app`` answers."""
    return page.evaluate(f"cutwise.app.{call}")


@pytest.fixture(scope="module")
def pocket(browser, reports):
    """The pocket, open."""
    with page_of(browser, reports["pocket"].as_uri(), width=1000) as page:
        yield page


@pytest.mark.parametrize("name", ["deburr", "pocket"])
@pytest.mark.parametrize(("dark", "width"), [(False, 1000), (True, 390)], ids=["light, wide", "dark, narrow"])
def test_opens_quietly_and_fits(browser, reports, name, dark, width):
    with page_of(browser, reports[name].as_uri(), width=width, color_scheme="dark" if dark else "light") as page:
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        assert page.locator(".cw-canvas").is_visible()
        legend = page.locator(".cw-bar").first.inner_text()
        assert f"[{'mm' if name == 'deburr' else 'µm'}]" in legend  # as the limit was typed
        assert page.locator(".cw-limit").count() >= 1
        unnamed = page.evaluate(
            """[...document.querySelectorAll('.cw button, .cw select, .cw input')].filter(e => !(e.textContent.trim() ||
            e.getAttribute('aria-label') || document.querySelector(`label[for="${e.id}"]`))).length"""
        )
        assert unnamed == 0


def test_a_long_doubt_and_tables_fit_a_phone(browser, reports):
    """Seen to fail: a verdict about ``hole_position_error_entry`` was 401 px wide, and limits stood outside of the screen."""
    with page_of(browser, reports["pocket"].as_uri(), width=390) as page:
        page.evaluate(
            "document.querySelector('#verdict h2').textContent = 'robot.hole_position_error_entry_along_the_edge 0.5 mm'"
        )
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        cells = "[...document.querySelectorAll('#requirements tr, #requirements td')]"
        assert page.evaluate(f"{cells}.filter(e => e.getBoundingClientRect().right > innerWidth).length") == 0
        label = "getComputedStyle(document.querySelector('#requirements td'), '::before').content"
        assert "Value" in page.evaluate(label)
        wide = (
            "[...document.querySelectorAll('.scroll:not(.plot)')].filter(e => e.scrollWidth > e.clientWidth + 1).length"
        )
        assert page.evaluate(wide) == 0  # seen to fail: tables of measures, inputs and convergence went sideways


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_text_has_contrast(browser, reports, dark):
    """4.5 between text and what is behind it, for every text on a plain background."""
    with page_of(browser, reports["pocket"].as_uri(), color_scheme="dark" if dark else "light") as page:
        low = page.evaluate(CONTRAST)
        assert low == []


def test_tiles_are_requirements_and_focus(pocket, small_pocket):
    shown = pocket.locator(".cw-tile small").all_inner_texts()
    assert shown == [*[check.measure for check in small_pocket.checks], small_pocket.scenario.focus]
    assert pocket.locator(".cw-verdict").inner_text() == small_pocket.verdict.upper()
    assert pocket.locator(".cw-verdict").get_attribute("aria-live") == "polite"


def test_worst_places_set_line_and_time(pocket, small_pocket):
    header, _ = read(view_file(small_pocket))
    buttons = pocket.locator(".cw-worst button")
    assert buttons.count() == len(header["worst"]) > 1
    for k, one in enumerate(header["worst"]):
        buttons.nth(k).click()
        assert app(pocket, "sample") == one["sample"]
        assert pocket.locator(".cw-row.cw-now").get_attribute("data-line") == str(one["line"])
        assert (
            pocket.locator(".cw-clock")
            .inner_text()
            .startswith(f"{small_pocket['motion']['time'].values[one['sample']]:.3f}")
        )
    assert pocket.locator(".cw-row").count() <= 60


def test_program_is_text(pocket):
    app(pocket, "goto(0)")
    row = pocket.locator('.cw-row[data-line="2"] .cw-text')
    assert row.inner_text() == "(a slot, then back along its wall: </script><b>this</b> is text)"
    assert pocket.locator(".cw-row b").count() == 0


def test_lines_lead_to_samples(pocket):
    app(pocket, "gotoLine(9)")
    first = app(pocket, "sample")
    assert app(pocket, f"lineOf({first})") == 9
    assert app(pocket, f"lineOf({first - 1})") == 8
    app(pocket, "gotoLine(1)")  # has none: the next one that has
    assert app(pocket, "lineOf(cutwise.app.sample)") == 6


def test_words_in_force_stand_below_the_program(pocket):
    for line, words in ((7, "G0 G17 G21 G90"), (9, "G1 G17 G21 G90")):
        app(pocket, f"gotoLine({line})")
        assert pocket.locator(".cw-modal").inner_text().startswith(f"in force: {words}")
    assert "F3000" in pocket.locator(".cw-modal").inner_text()


def test_keys(pocket):
    canvas = pocket.locator(".cw-canvas")
    app(pocket, "goto(500)")
    canvas.focus()
    for key, sample in (("ArrowRight", 501), ("ArrowLeft", 500), ("Shift+ArrowRight", 600), ("Home", 0)):
        pocket.keyboard.press(key)
        assert app(pocket, "sample") == sample
    pocket.keyboard.press("End")
    assert app(pocket, "sample") == app(pocket, "count") - 1
    app(pocket, "gotoLine(8)")
    pocket.keyboard.press("Control+ArrowRight")
    assert app(pocket, "lineOf(cutwise.app.sample)") == 9
    pocket.keyboard.press("n")
    first = app(pocket, "sample")
    pocket.keyboard.press("n")
    assert app(pocket, "sample") != first
    pocket.keyboard.press("/")
    pocket.locator(".cw-ask input").fill("10")
    pocket.keyboard.press("Enter")
    assert app(pocket, "lineOf(cutwise.app.sample)") == 10


def test_address_holds_the_state(browser, reports):
    with page_of(browser, reports["pocket"].as_uri() + "#t=0.75&colour=force") as page:
        assert app(page, "timeOf(cutwise.app.sample)") == pytest.approx(0.75)
        assert "force" in page.locator(".cw-legend").inner_text()


def test_pick_is_the_inverse_of_project(pocket):
    app(pocket, "look('top')")
    app(pocket, "showTool(false)")
    for i in range(900, app(pocket, "count") - 300, 97):
        at = app(pocket, f"project({i})")
        found = app(pocket, f"pick({{clientX: {at['x']}, clientY: {at['y']}}})")
        where = np.array(app(pocket, f"place({i})"))
        assert np.linalg.norm(np.array(found["place"]) - where) < 0.2  # mm; samples lie as near to one another


def test_distance_of_the_presets(pocket):
    """Iso stands at 1.1 r / sin(17.5 degrees); fit, which comes first, nearer, so that part and stock fill the picture."""
    radius = 0.5 * np.sqrt(60.0**2 + 40.0**2 + 10.0**2)
    app(pocket, "look('iso')")
    assert app(pocket, "distance()") == pytest.approx(1.1 * radius / np.sin(np.radians(17.5)), rel=1e-6)
    app(pocket, "look('fit')")
    assert 0.4 < app(pocket, "distance()") / (1.1 * radius / np.sin(np.radians(17.5))) < 1.0


@pytest.mark.parametrize(("width", "height", "distance"), [(960, 600, 365.806), (300, 600, 706.368)])
def test_camera_stands_where_the_formula_says(browser, reports, width, height, distance):
    """1.1 r / sin(min(17.5 deg, atan(aspect tan 17.5 deg))) in front of the place, r = 2.5 radii of the tool: scaled to 100."""
    with page_of(browser, reports["pocket"].as_uri(), width=1000, height=700) as page:
        page.evaluate(
            "([w, h]) => { const c = document.querySelector('.cw-canvas');"
            " Object.assign(c.style, {position: 'fixed', left: 0, top: 0, width: w + 'px', height: h + 'px'});"
            " document.querySelector('.cw-stage').style.height = h - 1 + 'px'; }",
            [width, height],
        )
        ratio = "document.querySelector('.cw-canvas').width / document.querySelector('.cw-canvas').height"
        for _ in range(100):  # until the picture has its new size
            if page.evaluate(ratio) == pytest.approx(width / height, rel=1e-9):
                break
            page.wait_for_timeout(50)
        app(page, "look('tool')")
        assert app(page, "distance()") * 100.0 / 25.0 == pytest.approx(distance, rel=2e-6)


def test_path_has_the_colours_of_the_table(pocket):
    """A pixel within one of the place of a sample has the colour of a sample near by, nine times of ten."""
    app(pocket, "look('top')")
    app(pocket, "showTool(false)")
    app(pocket, "goto(cutwise.app.count - 1)")
    seen, right = pocket.evaluate(COLOURED)
    assert seen > 60
    assert right >= 0.9 * seen


def test_reading_pixels_does_not_show_an_empty_scene(pocket):
    app(pocket, "look('fit')")
    app(pocket, "showTool(true)")
    drawn = pocket.evaluate(
        "(() => { const {width, height, data} = cutwise.app.pixels(); let n = 0; for (let i = 3; i < data.length; i += 4) "
        "if (data[i] > 250) n++; return n / (width * height); })()"
    )
    assert 0.15 < drawn < 0.9


def test_without_scripts_the_report_is_as_ever(browser, reports, small_pocket):
    with page_of(browser, reports["pocket"].as_uri(), ready=False, java_script_enabled=False) as page:
        assert page.locator("#verdict .word").inner_text() == small_pocket.verdict.upper()
        assert page.locator(".pictures figure svg").first.is_visible()
        assert page.locator("#measures table").is_visible()
        assert not page.locator("#cutwise-view").is_visible()


def test_pictures_can_be_had_beside_the_viewer(browser, reports):
    with page_of(browser, reports["deburr"].as_uri()) as page:
        assert not page.locator(".pictures").is_visible()
        page.get_by_role("button", name="Show all pictures").click()
        assert page.locator(".pictures figure svg").first.is_visible()
        page.emulate_media(media="print")
        assert page.locator(".pictures figure svg").first.is_visible()
        assert not page.locator("#cutwise-view").is_visible()


def test_without_3d(playwright, reports):
    led = playwright.chromium.launch(
        executable_path=str(CHROMIUM), headless=True, args=[*SETTINGS, "--disable-3d-apis"]
    )
    page = led.new_page()
    page.goto(reports["pocket"].as_uri())
    page.wait_for_selector(READY, state="attached", timeout=LOADED)
    assert "no 3D" in page.locator(".cw-no3d").inner_text()
    assert page.locator(".cw-plot canvas").count() >= 2
    page.locator(".cw-worst button").first.click()
    assert page.locator(".cw-row.cw-now").count() == 1
    led.close()


def test_main_thread_is_not_held_up(browser, reports):
    """CPU seconds of the main thread: ready within 2 s, a step of the slider within 16 ms (prototype: 0.3 s, 4 ms)."""
    opened_ = browser.new_context(viewport={"width": 700, "height": 500})
    page = opened_.new_page()
    session = opened_.new_cdp_session(page)
    session.send("Performance.enable", {"timeDomain": "threadTicks"})

    page.goto(reports["pocket"].as_uri())
    page.wait_for_selector(READY, state="attached", timeout=LOADED)
    assert spent(session) < 2.0
    before = spent(session)
    page.evaluate("(() => { for (let i = 0; i < 12; i++) { cutwise.app.goto(60 * i); cutwise.app.render(); } })()")
    assert (spent(session) - before) / 12 < 0.016
    opened_.close()


def memory(process):
    """Resident memory of the page and of what draws it [MB], among the children of a process."""
    found, waiting = 0.0, [process]
    while waiting:
        number = waiting.pop()
        with suppress(OSError):
            kids = Path(f"/proc/{number}/task/{number}/children").read_text().split()
            waiting += [int(one) for one in kids]
            said = Path(f"/proc/{number}/cmdline").read_text()
            if "--type=gpu-process" in said or ("--type=renderer" in said and "--extension" not in said):
                lines = Path(f"/proc/{number}/smaps_rollup").read_text().splitlines()
                found += sum(int(line.split()[1]) for line in lines if line.startswith("Rss:")) / 1024
    return found


def million(result):
    """The view file of a run with each sample told 330 times or more, so that there are 10^6, and 67,426 lines."""
    scene = rows.of(result)
    count, lines = 1_000_000, 67_426
    at = np.linspace(0.0, scene.clock.size - 1.0, count)
    near = np.rint(at).astype(int)

    def between(values):
        return np.stack([np.interp(at, np.arange(len(values)), column) for column in values.T], axis=1)

    noise = 1.0 + 1e-3 * np.random.default_rng(1).standard_normal(count)
    histories = {name: one._replace(values=one.values[near] * noise) for name, one in list(scene.histories.items())[:4]}
    owner = np.where(scene.map.owner >= 0, np.searchsorted(near, np.maximum(scene.map.owner, 0)), -1)
    long = dataclasses.replace(
        scene, clock=1e-3 * np.arange(count), place=between(scene.place), trace=None, kind=scene.kind[near], deflection=None,
        line=np.arange(count) * lines // count + 1, histories=histories, map=scene.map._replace(owner=owner),
    )  # fmt: skip
    text = "\n".join(f"N{k} G1 X{k % 97}.5 Y{k % 89}.25" for k in range(1, lines + 1))
    program = in_force(result, scene)._replace(text=text, of_line=np.zeros(lines + 1, int))
    return as_text(view._packed(result, long, program))


@pytest.mark.slow
def test_a_million_samples(playwright, small_pocket, tmp_path):
    """Ready within 2 CPU s of the main thread, a step within 16 ms, what is pointed at within 16 ms, 300 MB above an empty page."""
    head = '<!doctype html><meta charset="utf-8"><link rel="icon" href="data:,">'
    bundle = (files("cutwise.app.page") / "static" / "view.js").read_text(encoding="utf-8")
    data = f'<script type="text/plain" id="cutwise-data">{million(small_pocket)}</script>'
    (tmp_path / "long.html").write_text(
        f'{head}<main id="cutwise-view"></main>{data}<script>{bundle}</script>', encoding="utf-8"
    )
    empty = "document.querySelector('canvas').getContext('webgl2').clear(16384); document.documentElement.dataset.ready = '1'"
    (tmp_path / "empty.html").write_text(
        f'{head}<canvas width="700"></canvas><script>{empty}</script>', encoding="utf-8"
    )
    held = {}
    for name in ("empty", "long"):
        led = playwright.chromium.launch(executable_path=str(CHROMIUM), headless=True, args=SETTINGS)
        page = led.new_page(viewport={"width": 1000, "height": 700})
        session = page.context.new_cdp_session(page)
        session.send("Performance.enable", {"timeDomain": "threadTicks"})
        page.goto((tmp_path / f"{name}.html").as_uri())
        page.wait_for_selector(READY, state="attached", timeout=LOADED)
        if name == "long":
            costs = [spent(session)]
            page.evaluate(
                "(() => { for (let i = 0; i < 10; i++) { cutwise.app.goto(1e5 * i); cutwise.app.render(); } })()"
            )
            costs.append(spent(session))
            found = page.evaluate(
                "[...Array(10).keys()].map(k => 5e4 + 9e4 * k).map(i => { "
                "const p = cutwise.app.project(i), at = cutwise.app.place(i);"
                " return cutwise.app.pick({clientX: p.x, clientY: p.y}).place.map((v, c) => v - at[c]); })"
            )
            costs.append(spent(session))
            off = np.linalg.norm(found, axis=1)
        held[name] = memory(os.getpid())
        led.close()
    assert costs[0] < 2.0
    assert (costs[1] - costs[0]) / 10 < 0.016
    assert (costs[2] - costs[1]) / 10 < 0.016
    assert np.median(off) < 0.2  # mm; a place behind another one is met there
    assert held["long"] - held["empty"] < 300.0


def spent(session):
    """CPU seconds of the main thread so far."""
    return {one["name"]: one["value"] for one in session.send("Performance.getMetrics")["metrics"]}["TaskDuration"]


@pytest.fixture(scope="module")
def served(examples, tmp_path_factory):
    """The reference case, open in ``cutwise view``."""
    folder = tmp_path_factory.mktemp("served")
    text = (examples / "deburr_compliant_spindle.yaml").read_text(encoding="utf-8")
    (folder / "deburr.yaml").write_text(text, encoding="utf-8")
    with viewing("deburr.yaml", cwd=folder) as server:
        yield folder, server


def test_change_run_and_save(browser, served, cutwise):
    """4 bar in place of 5: FAIL, and the saved file gives the same numbers on the command line."""
    folder, server = served
    with page_of(browser, f"http://127.0.0.1:{server.port}/?token={server.token}", ready=False) as page:
        page.wait_for_selector(".cw-canvas", timeout=LOADED)
        assert page.locator(".cw-verdict").inner_text() == "PASS"
        field = page.locator('[data-key="spindle.pressure"]')
        field.fill("4 bananas")
        page.locator('[data-fault="spindle.pressure"]', has_text="is not a unit").wait_for()
        assert page.locator("button.cw-run").is_disabled()
        field.fill("4 bar")
        page.wait_for_selector("button.cw-run:not([disabled])")
        page.locator("button.cw-run").click()
        page.wait_for_selector(".cw-verdict.cw-fail", timeout=LOADED)
        tile = page.locator(".cw-tile", has_text="surface_error_max").inner_text()
        assert "0.1698 mm" in tile
        assert "before: -0.0095 mm" in tile
        page.on("dialog", lambda dialog: dialog.accept("turned.yaml"))
        page.get_by_role("button", name="Save as").click()
        page.locator(".cw-told", has_text="saved as turned.yaml").wait_for()
        shown = page.evaluate("fetch('/api/run/2/view').then(r => r.ok)")
        assert shown
    before, after = (folder / "deburr.yaml").read_text(), (folder / "turned.yaml").read_text()
    changed = [line for line in difflib.ndiff(before.splitlines(), after.splitlines()) if line[0] in "+-"]
    assert [line.split() for line in changed] == [["+", "pressure:", "4", "bar"]]
    told = json.loads(cutwise("run", folder / "turned.yaml", "--json", "--no-report", "--no-advice").out)
    assert told["verdict"] == "fail"
    assert f"{1e3 * told['measures']['surface_error_max']['value']:.4f}" == "0.1698"


def test_a_file_is_brought_and_saved_beside_the_scenario(browser, examples, tmp_path):
    shown = (
        (examples / "mill_part.yaml")
        .read_text(encoding="utf-8")
        .replace("program: mill_part.nc", "program: missing.nc")
    )
    (tmp_path / "part.yaml").write_text(shown, encoding="utf-8")
    (tmp_path / "mill_part.step").write_bytes((examples / "mill_part.step").read_bytes())
    brought = tmp_path / "elsewhere" / "mine.nc"
    brought.parent.mkdir()
    brought.write_bytes((examples / "mill_part.nc").read_bytes())
    with viewing("part.yaml", cwd=tmp_path) as server:
        address = f"http://127.0.0.1:{server.port}/?token={server.token}"
        with page_of(browser, address, ready=False) as page:
            page.locator(".cw-told", has_text="nothing runs until mended").wait_for(timeout=LOADED)
            page.locator("details summary").first.click()
            page.locator('[data-file="program"]').set_input_files(str(brought))
            page.wait_for_selector("button.cw-run:not([disabled])", timeout=LOADED)
            page.on("dialog", lambda dialog: dialog.accept("mended.yaml"))
            page.get_by_role("button", name="Save as").click()
            page.locator(".cw-told", has_text="saved as mended.yaml").wait_for(timeout=LOADED)
    assert "program: mine.nc" in (tmp_path / "mended.yaml").read_text()
    assert (tmp_path / "mine.nc").read_bytes() == brought.read_bytes()


def test_a_point_of_a_study_opens_its_case(browser, served):
    """A click on a point runs that case and shows it below, with the command that does the same."""
    folder, _ = served
    (folder / "two.yaml").write_text(
        "name: two\nscenario: deburr.yaml\nvary: {spindle.pressure: {uniform: [4 bar, 5 bar]}}\n"
        "want: {measures: [surface_error_max]}\nmethod: monte_carlo\ncases: 2\nseed: 2\n"
    )
    code = "from cutwise.app.cli import main; main()"
    subprocess.run(
        [sys.executable, "-c", code, "study", "two.yaml", "-o", "two"], cwd=folder, capture_output=True, check=False
    )
    with viewing("two", cwd=folder) as server:
        address = f"http://127.0.0.1:{server.port}/?token={server.token}"
        with page_of(browser, address, width=390, ready=False) as page:
            page.locator(".cw-run").wait_for(timeout=LOADED)
            assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
            place = page.evaluate("cutwise.study.at(1)")
            page.mouse.click(place["x"], place["y"])
            page.locator(".cw-canvas").wait_for(timeout=LOADED)
            command = page.locator(".cw-command").inner_text()
            assert command.startswith("cutwise run deburr.yaml --set spindle.pressure=")
            assert page.locator('[data-key="spindle.pressure"]').input_value() in command
            assert page.locator(".cw-verdict").is_visible()
