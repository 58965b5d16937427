# SPDX-License-Identifier: Apache-2.0
"""Opens a report page in Chromium, headless and offline, and uses it like a person.

    look_at_page.py PAGE [FOLDER]

Moves every image comparison by mouse and keyboard events, sent over the browser's debugging pipe, that the browser
treats as real ones; a click switches on its difference. Prints one JSON document: the browser's complaints, every
chart, every comparison before and after, every download. FOLDER: receives screenshots of the page, one per window
height.
"""
import base64
import json
import os
import subprocess
import sys
import tempfile

WIDTH, HEIGHT = 1100, 900

LOOK = """(() => {
  const found = {charts: [], downloads: []};
  for (const canvas of document.querySelectorAll('canvas')) {
    const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
    const colors = new Set();
    let drawn = 0;
    for (let i = 0; i < data.length; i += 4) {
      if (data[i + 3] === 0) continue;
      ++drawn;
      if (data[i + 3] === 255) colors.add(data[i] << 16 | data[i + 1] << 8 | data[i + 2]);
    }
    const chart = Chart.getChart(canvas);
    found.charts.push({drawn, width: canvas.width, colors: colors.size, title: chart.options.plugins.title.text,
      lines: chart.data.datasets.length, points: chart.data.datasets[0].data.length,
      tick: chart.scales.y.ticks[0].label});
  }
  for (const data of document.querySelectorAll('script.attachment')) {
    const link = document.getElementById(data.dataset.link);
    found.downloads.push({name: link.download, blob: link.href.startsWith('blob:'), text: data.textContent});
  }
  return found;
})()"""

# The positions of the parts of comparison N in the window, and its state.
STATE = """(() => {
  const figure = document.querySelectorAll('figure.images')[%d];
  const box = part => { const r = figure.querySelector(part).getBoundingClientRect();
    return [r.left, r.top, r.width, r.height]; };
  const range = figure.querySelector('input[type=range]');
  return {range: box('input[type=range]'), area: box('.compare'), box: box('.show-difference'),
    clip: figure.querySelector('.left').style.clipPath, handle: figure.querySelector('.handle').style.left,
    value: Number(range.value), focused: document.activeElement === range,
    sizes: [...figure.querySelectorAll('img')].map(image => image.naturalWidth),
    difference: getComputedStyle(figure.querySelector('img.difference')).display};
})()"""


class Browser:
    def __init__(self, profile):
        to_browser, self.out = os.pipe()
        self.back, from_browser = os.pipe()

        def pipes():   # Chromium reads commands from 3 and writes to 4
            read, write = os.dup(to_browser), os.dup(from_browser)
            os.dup2(read, 3)
            os.dup2(write, 4)

        self.process = subprocess.Popen(
            ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-dev-shm-usage",
             f"--window-size={WIDTH},{HEIGHT}", "--host-resolver-rules=MAP * ~NOTFOUND", "--remote-debugging-pipe",
             f"--user-data-dir={profile}", "about:blank"],
            preexec_fn=pipes, close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_browser)
        os.close(from_browser)
        self.number, self.rest, self.session, self.faults, self.seen = 0, b"", None, [], set()

    def read(self):
        while b"\0" not in self.rest:
            more = os.read(self.back, 1 << 16)
            if not more:
                raise RuntimeError("the browser ended")
            self.rest += more
        message, self.rest = self.rest.split(b"\0", 1)
        message = json.loads(message)
        name, params = message.get("method"), message.get("params", {})
        self.seen.add(name)
        if name == "Runtime.exceptionThrown":
            details = params["exceptionDetails"]
            self.faults.append(details.get("exception", {}).get("description", details["text"]))
        elif name == "Runtime.consoleAPICalled" and params["type"] in ("error", "warning", "assert"):
            self.faults.append(params["type"] + ": " + " ".join(str(a.get("value", "")) for a in params["args"]))
        elif name == "Log.entryAdded" and params["entry"]["level"] in ("error", "warning"):
            self.faults.append(params["entry"]["level"] + ": " + params["entry"]["text"])
        return message

    def call(self, method, **params):
        self.number += 1
        command = {"id": self.number, "method": method, "params": params}
        if self.session:
            command["sessionId"] = self.session
        os.write(self.out, json.dumps(command).encode() + b"\0")
        while (message := self.read()).get("id") != self.number:
            pass
        if "error" in message:
            raise RuntimeError(f"{method}: {message['error']}")
        return message["result"]

    def evaluate(self, script):
        result = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            raise RuntimeError(result["exceptionDetails"])
        return result["result"].get("value")

    def open(self, page):
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self.call(domain + ".enable")
        self.seen.clear()
        self.call("Page.navigate", url="file://" + os.path.abspath(page))
        while "Page.loadEventFired" not in self.seen:
            self.read()

    def settle(self):   # waits two frames, so that the effect of the input is drawn
        self.evaluate("new Promise(f => requestAnimationFrame(() => requestAnimationFrame(() => f(0))))")

    def mouse(self, kind, x, y, buttons=0):
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left" if buttons or kind != "mouseMoved" else "none",
                  buttons=buttons, clickCount=0 if kind == "mouseMoved" else 1)

    def drag(self, x0, x1, y):
        self.mouse("mouseMoved", x0, y)
        self.mouse("mousePressed", x0, y, 1)
        for i in range(1, 9):
            self.mouse("mouseMoved", x0 + (x1 - x0) * i / 8, y, 1)
        self.mouse("mouseReleased", x1, y)
        self.settle()

    def key(self, name, code):
        for kind in ("rawKeyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=name, code=name, windowsVirtualKeyCode=code)
        self.settle()


def use(browser, number):
    """One comparison: the slider by mouse, by keyboard, the image itself by mouse, the difference by a click."""
    script = STATE % number
    browser.evaluate(f"document.querySelectorAll('figure.images')[{number}].scrollIntoView({{block: 'center'}}); 0")
    browser.settle()
    seen = {"start": (now := browser.evaluate(script))}
    x, y, width, height = now["range"]
    browser.drag(x + width / 2, x + width / 4, y + height / 2)
    seen["dragged"] = browser.evaluate(script)
    browser.key("ArrowRight", 39)
    seen["key"] = browser.evaluate(script)
    x, y, width, height = now["area"]
    top = max(y, 10) + min(height, HEIGHT / 2) / 2
    browser.drag(x + 0.3 * width, x + 0.8 * width, top)
    seen["image"] = browser.evaluate(script)
    x, y, width, height = now["box"]
    for kind in ("mousePressed", "mouseReleased"):
        browser.mouse(kind, x + width / 2, y + height / 2, int(kind == "mousePressed"))
    browser.settle()
    seen["difference"] = browser.evaluate(script)
    return seen


def main():
    page, folder = sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else None
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:   # a process of its may still write
        browser = Browser(profile)
        try:
            browser.open(page)
            browser.settle()
            found = browser.evaluate(LOOK)
            count = browser.evaluate("document.querySelectorAll('figure.images').length")
            found["images"] = [use(browser, i) for i in range(count)]
            if folder:
                os.makedirs(folder, exist_ok=True)
                tall = browser.evaluate("document.documentElement.scrollHeight")
                for i, top in enumerate(range(0, tall, HEIGHT)):
                    shot = browser.call("Page.captureScreenshot", captureBeyondViewport=True, clip={
                        "x": 0, "y": top, "width": WIDTH, "height": min(HEIGHT, tall - top), "scale": 1})
                    with open(f"{folder}/page-{i:02}.png", "wb") as file:
                        file.write(base64.b64decode(shot["data"]))
            found["faults"] = browser.faults
            print(json.dumps(found))
        finally:
            browser.process.terminate()
            browser.process.wait()


main()
