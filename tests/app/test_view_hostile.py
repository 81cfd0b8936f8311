"""A hostile page on another port of this machine, in a real browser in which the page of cutwise is open."""

import functools
import http.server
import shutil
import threading

import pytest

from app.test_browser import CHROMIUM, HERE, REQUIRED, SETTINGS, sync_playwright
from app.viewed import viewing

pytestmark = pytest.mark.skipif(not HERE and not REQUIRED, reason="no chromium, or no playwright to lead it")

_TRIES = """async (address) => {
  const tried = {};
  const attempt = async (name, options, path = '/api/check') => {
    try { const r = await fetch(address + path, options); tried[name] = r.type === 'opaque' ? 'opaque' : r.status; }
    catch (error) { tried[name] = 'failed'; }
  };
  const post = { method: 'POST', body: JSON.stringify({ edits: {}, as: 'stolen.yaml' }) };
  await attempt('read', { credentials: 'include' }, '/');
  await attempt('simple post', { ...post, mode: 'no-cors', credentials: 'include' }, '/api/save');
  const headers = { 'X-Cutwise': '1', 'Content-Type': 'application/json' };
  await attempt('post', { ...post, credentials: 'include', headers }, '/api/save');
  await attempt('without cookies', { ...post, mode: 'no-cors', credentials: 'omit' }, '/api/save');
  tried.script = await new Promise((done) => {
    const one = document.createElement('script');
    one.src = address + '/static/view.js'; one.onload = () => done('loaded'); one.onerror = () => done('failed');
    document.body.append(one);
  });
  tried.frame = await new Promise((done) => {
    const one = document.createElement('iframe');
    one.src = address + '/';
    const look = () => { try { done(String(one.contentDocument.body.innerHTML)); } catch { done('closed'); } };
    one.onload = () => setTimeout(look, 200);
    document.body.append(one);
  });
  tried.socket = await new Promise((done) => {
    const one = new WebSocket(address.replace('http', 'ws') + '/api/job/events');
    one.onopen = () => done('open'); one.onerror = () => done('failed');
  });
  tried.form = await new Promise((done) => {
    const one = document.createElement('form');
    one.action = address + '/api/save'; one.method = 'post'; one.target = 'aside'; one.enctype = 'text/plain';
    const aside = document.createElement('iframe'); aside.name = 'aside'; document.body.append(aside, one);
    aside.onload = () => setTimeout(() => done('sent'), 100);
    one.submit();
  });
  return tried;
}"""


@pytest.fixture
def hostile(tmp_path):
    """Another server of this machine."""
    (tmp_path / "index.html").write_text("<!doctype html><title>other</title><body></body>")
    handler = functools.partial(http.server.SimpleHTTPRequestHandler, directory=str(tmp_path))
    handler.log_message = lambda *_: None
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_address[1]}"
    server.shutdown()
    server.server_close()


def test_a_page_of_another_port_gets_nothing(examples, tmp_path_factory, hostile):
    assert HERE, "CUTWISE_BROWSER=required, and there is no chromium or no playwright"
    folder = tmp_path_factory.mktemp("desk")
    shutil.copy(examples / "deburr_compliant_spindle.yaml", folder / "edge.yaml")
    with viewing("edge.yaml", cwd=folder) as server, sync_playwright() as led:
        browser = led.chromium.launch(executable_path=str(CHROMIUM), headless=True, args=SETTINGS)
        address = f"http://127.0.0.1:{server.port}"
        context = browser.new_context()
        own = context.new_page()
        own.goto(f"{address}/?token={server.token}", wait_until="domcontentloaded")
        own.wait_for_url(f"{address}/")
        asked = (
            "fetch('/api/job/cancel', {method: 'POST', headers: {'X-Cutwise': '1'}, body: '{}'}).then(r => r.status)"
        )
        assert own.evaluate(asked) == 200
        other = context.new_page()
        other.goto(hostile)
        tried = other.evaluate(_TRIES, address)
        browser.close()
        assert tried["read"] == tried["post"] == tried["script"] == tried["socket"] == "failed"
        assert {tried["simple post"], tried["without cookies"]} <= {"opaque", "failed"}  # refused, and not to be read
        assert tried["frame"] in ("closed", "")
        assert sorted(file.name for file in folder.glob("*.yaml")) == ["edge.yaml"]  # nothing was written
        assert server.ask("GET", "/").status == 200
