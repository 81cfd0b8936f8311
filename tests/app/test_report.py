"""The report: one file that asks for nothing, says everything, and can be run again."""

import base64
import doctest
import hashlib
import re
from datetime import UTC, datetime
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from ruamel.yaml import YAML

from cutwise.app import inputs, pages
from cutwise.app.plots import PLOTS
from cutwise.app.plots.figures import COLOURS, decimate
from cutwise.app.report import render
from cutwise.io.scenario import load, parse, revised

EXAMPLES = sorted((Path(__file__).parent.parent.parent / "examples").glob("*.yaml"))
VOID = {"meta", "link", "br", "hr", "img", "input", "col", "wbr", "area", "base", "embed", "source", "track"}


class Outline(HTMLParser):
    """Elements, ids and links of a page; unclosed or crossed elements are found."""

    def __init__(self, text):
        super().__init__()
        self.open, self.elements, self.ids, self.crossed = [], [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        self.ids += [value for name, value in attrs if name == "id"]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        self.ids += [value for name, value in attrs if name == "id"]

    def handle_endtag(self, tag):
        if tag == "p" and "p" not in self.open:
            self.crossed.append(tag)
        elif self.open and self.open[-1] == tag:
            self.open.pop()
        else:
            self.crossed.append((tag, self.open[-3:]))


@pytest.fixture(scope="module")
def outline(html):
    return Outline(html)


def test_page_is_well_formed(outline):
    well_formed(outline)


def test_nothing_is_loaded_from_outside(outline, html):
    asks_for_nothing(outline, html)


@pytest.mark.slow
@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_report_of_every_example(example, run_of):
    """Whatever the process draws: a page that is well formed, asks for nothing and holds its scenario."""
    result = run_of(example.stem)
    page = render(result)
    well_formed(Outline(page))
    asks_for_nothing(Outline(page), page)
    assert page.count("<figure>") == sum(plot.applies(result) for plot in PLOTS.get(result.scenario.process, ()))
    assert parse(inputs.as_yaml(result.scenario)) == result.scenario
    assert 'id="cutwise-view"' in page
    assert len(page.encode()) <= 3_000_000


def test_report_without_the_viewer(reference, html):
    """--static: no script, no policy, and everything else as in the report with it."""
    still = render(reference, written=datetime(2026, 1, 2, 3, 4, tzinfo=UTC), viewer=False)
    assert "<script>" not in still
    assert "Content-Security-Policy" not in still
    assert "cutwise-view" not in still
    figures = [re.findall(r"<figcaption><b>.*?</b>", page) for page in (still, html)]
    assert figures[0] == figures[1] != []


def well_formed(outline):
    assert outline.crossed == []
    assert outline.open == []
    assert len(outline.ids) == len(set(outline.ids))


_STATIC = [{"type": "application/json", "id": "scenario"}]
_WITH_VIEWER = [*_STATIC, {"type": "text/plain", "id": "cutwise-data"}, {}]


def asks_for_nothing(outline, html):
    """Links that a reader follows are no requests; everything else that names an address is one."""
    for tag, attributes in outline.elements:
        for name in ("src", "href", "xlink:href", "data", "action", "poster", "srcset"):
            value = attributes.get(name)
            if value is not None and tag != "a":
                # a map of many cells is a picture that stands in the page itself
                assert value == "data:," or value.startswith(("#", "data:image/png;base64,")), (tag, value[:80])
    icon = '<link rel="icon" href="data:,">'  # an empty one, or the browser asks its server for one
    assert not re.search(r"url\((?!#)|@import|<link|<img|<iframe", html.replace(icon, ""))
    scripts = [attributes for tag, attributes in outline.elements if tag == "script"]
    assert scripts in (_STATIC, _WITH_VIEWER)
    policy = [
        a["content"]
        for tag, a in outline.elements
        if tag == "meta" and a.get("http-equiv") == "Content-Security-Policy"
    ]
    if scripts == _WITH_VIEWER:  # nothing but the one script may run, and nothing may be fetched
        script = html.rpartition("<script>")[2].partition("</script>")[0]
        digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
        assert policy == [
            f"default-src 'none'; script-src 'sha256-{digest}'; style-src 'unsafe-inline'; img-src data: blob:"
        ]


def test_references_within_the_page_lead_somewhere(outline, html):
    wanted = re.findall(r'href="#([^"]+)"', html) + re.findall(r"url\(#([^)]+)\)", html)
    assert wanted
    assert set(wanted) <= set(outline.ids)
    labels = [attributes["aria-labelledby"] for _, attributes in outline.elements if "aria-labelledby" in attributes]
    assert set(labels) <= set(outline.ids)


def test_every_plot_has_a_title_for_those_who_do_not_see_it(outline, html):
    images = [attributes for tag, attributes in outline.elements if attributes.get("role") == "img"]
    assert len(images) == len(PLOTS["deburr"])
    for number, plot in enumerate(PLOTS["deburr"], start=1):
        assert f'<title id="plot{number}-title">{plot.title}. ' in html


def test_every_table_has_headers(html):
    tables = re.findall(r"<table.*?</table>", html, re.DOTALL)
    assert len(tables) > 5
    for table in tables:
        assert '<th scope="col"' in table
        assert '<th scope="row"' in table


def test_everything_is_said(html, reference):
    for heading in ("Requirements", "Measures", "Inputs, and where each value comes from", "Convergence of this run",
                    "Limits of the model", "References", "Run again", "Worst places"):  # fmt: skip
        assert f">{heading}<" in html, heading
    text = re.sub(r"<wbr>", "", html)
    for name in reference.measures:
        assert re.sub(r"_[xyz]$", "", name) in text, name
    for row in inputs.inputs(reference.scenario):
        assert f">{row.key}</th>" in text
    assert text.count('<tr class="assumed">') == len(reference.assumed)
    for limit in reference.limits:
        assert limit.partition("'")[0] in html


def test_scenario_in_the_report_is_the_scenario(html, reference, tmp_path):
    place = tmp_path / "report.html"
    place.write_text(html, encoding="utf-8")
    again = load(place)
    assert again == reference.scenario
    assert dict(again.origins) == dict(reference.scenario.origins)


def test_readable_scenario_is_the_scenario_too(reference):
    again = parse(inputs.as_yaml(reference.scenario))
    assert again == reference.scenario
    assert dict(again.origins) == dict(reference.scenario.origins)


def test_text_of_the_engineer_is_text(made_up, tmp_path):
    """A name and a source that look like markup do nothing in the page, and come back as written."""
    evil = "</script><script>alert(1)</script>&amp;"
    scenario = revised(made_up().scenario, [f"operation.feed={{value: 80 mm/s, source: '{evil}'}}"])
    page = render(made_up(scenario=scenario.model_copy(update={"name": "<b>bold"}).with_origins(scenario.origins)))
    assert page.count("<script") == 1
    assert "<b>bold" not in page
    place = tmp_path / "report.html"
    place.write_text(page, encoding="utf-8")
    assert load(place).origins["operation.feed"].source == evil


def test_plots_hold_the_data(reference):
    """Curves of the first two plots against the arrays: their peaks, their ends."""
    force, error = (plot.draw(reference).axes[0] for plot in PLOTS["deburr"][:2])
    burr = reference["cutting"]["burr_force"]
    for axis, line in zip("xyz", force.lines, strict=True):
        assert line.get_ydata().max() == pytest.approx(float(burr.sel(axis=axis).max()))
        assert line.get_ydata()[-1] == pytest.approx(float(burr.sel(axis=axis)[-1]))
        assert line.get_xdata()[-1] == pytest.approx(float(burr["time"][-1]))
    at_tool = max(error.lines, key=lambda line: len(line.get_xdata()))
    assert at_tool.get_ydata()[0] == pytest.approx(1.0)  # [mm] the whole burr
    assert at_tool.get_ydata()[-1] == pytest.approx(-0.0094689, rel=1e-4)


def test_static_characteristic_shows_the_forces_of_the_spindle(reference):
    axes = next(p for p in PLOTS["deburr"] if p.title.startswith("Static")).draw(reference).axes[0]
    texts = " ".join(text.get_text() for text in axes.texts)
    for force in ("13.8 N", "12.5 N", "5.82 N", "4.52 N", "stop"):
        assert force in texts


def test_plots_without_their_data_are_left_out(made_up):
    page = render(made_up())
    assert "Edge error over time" in page
    assert "Burr force over time" not in page
    assert page.count('role="img"') == 1


def test_colours_are_those_of_the_page(html):
    drawn = "".join(re.findall(r"<svg role.*?</svg>", html, re.DOTALL))
    assert not set(re.findall(r"#[0-9a-f]{6}\b", drawn)) - {"#000000"}
    dark = re.search(r"prefers-color-scheme: dark\) \{(.*?)\n\}", html, re.DOTALL).group(1)
    for variable in COLOURS:
        assert f"{variable}:" in dark, variable


def test_thinned_curves_keep_every_peak():
    x = np.linspace(0.0, 1.0, 100_000)
    y = np.sin(40.0 * x)
    y[12_345], y[77_777] = 50.0, -60.0
    few_x, few_y = decimate(x, y, bins=100)
    assert few_x.size <= 400
    assert (few_y.max(), few_y.min()) == (50.0, -60.0)
    assert (few_x[0], few_x[-1]) == (0.0, 1.0)
    assert (np.diff(few_x) > 0).all()


def test_report_is_not_too_large(html):
    """The script of the viewer is 0.67 MB of it."""
    assert len(html) < 1_500_000


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ({"error": 8e-5}, ("FAIL", "1 of 3 requirements not met", "fail</span> <span class=\"dim\">by 0.03 mm")),
        ({"infeasible": ("no room",)}, ("FAIL", "Infeasible:</b> no room")),
        ({"warnings": ("mind the gap",)}, ("1 warning;", "mind the gap")),
        ({"notes": {"worst": ["here", "there"]}}, ("<li>here</li><li>there</li>",)),
        ({"convergence": {"surface_error_max": 1e-8}}, ("1e-05 mm", "0.1 %")),
        ({"advice": ("change the feed",)}, ("Change the feed.",)),
    ],
)  # fmt: skip
def test_outcomes_in_words(made_up, parts, words):
    page = render(made_up(**parts))
    for word in words:
        assert word in page


def test_a_doubted_pass_is_said_as_one(html, reference):
    """Seen to fail: the words "but not by every history" were cut away, and a key at the beginning was capitalised."""
    from cutwise.app.verdict_text import verdict_line

    assert verdict_line(reference).startswith("PASS, but not by every history: ")
    headline = re.search(r'<section id="verdict".*?<h2>(.*?)</h2>', html, re.DOTALL)[1]
    assert headline.startswith("But not by every history: friction leaves")
    assert doctest.testmod(pages).failed == 0


def test_a_whole_program_stands_in_the_scenario_as_it_is():
    text = 'G1 X1 (a "quoted" \\ word)\r\n\tG1 <X2>: #3\n' * 800
    document = {"program": {"file": "a.nc", "text": text}, "note": "µ" * 12_000, "flow": [text, 1.0]}
    assert YAML(typ="safe").load(inputs.as_yaml(SimpleNamespace(document=lambda: document))) == document
