# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""A headless Chromium, driven through chromedriver by the WebDriver protocol.

Python's standard library alone. Events are real: they pass through the browser's input pipeline.
"""

import base64
import json
import shutil
import subprocess
import tempfile
import time
import urllib.error
import urllib.request

ELEMENT_KEY = "element-6066-11e4-a52e-4f735466cecf"
FLAGS = [
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--disable-dev-shm-usage", "--force-color-profile=srgb", "--hide-scrollbars",
]
# What a key's name in JavaScript is in the WebDriver protocol (section 17.4.2).
KEYS = {"ArrowLeft": "\ue012", "ArrowUp": "\ue013", "ArrowRight": "\ue014", "ArrowDown": "\ue015",
        "Home": "\ue011", "End": "\ue010", "Tab": "\ue004", "Enter": "\ue007"}


class WebDriverError(Exception):
    """What the driver answered instead of a value."""


def missing_programs():
    """Names of the programs that are needed and not installed."""
    return [name for name in ("chromium", "chromedriver") if shutil.which(name) is None]


class Browser:
    """One browser window with a new, empty profile. Use as a context manager."""

    def __init__(self, width, height, dark=False):
        self.profile = tempfile.mkdtemp(prefix="stillray-browser-")
        self.driver = subprocess.Popen(
            ["chromedriver", "--port=0"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
            text=True)
        self.session = None
        try:
            self.address = f"http://127.0.0.1:{self._read_port()}"
            self._start()
            self.cdp("Emulation.setDeviceMetricsOverride", width=width, height=height,
                     deviceScaleFactor=1, mobile=False)
            scheme = "dark" if dark else "light"
            self.cdp("Emulation.setEmulatedMedia",
                     features=[{"name": "prefers-color-scheme", "value": scheme}])
        except BaseException:
            self.close()
            raise

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        """Ends the browser and its driver and removes the profile."""
        try:
            if self.session is not None:
                self._call("DELETE", "")
        except (OSError, WebDriverError):
            pass
        self.driver.terminate()
        try:
            self.driver.wait(timeout=10)
        except subprocess.TimeoutExpired:
            self.driver.kill()
            self.driver.wait()
        self.driver.stdout.close()
        shutil.rmtree(self.profile, ignore_errors=True)

    def _read_port(self):
        for line in self.driver.stdout:
            if "was started successfully on port" in line:
                return int(line.rsplit(" ", 1)[1].strip(". \n"))
        raise WebDriverError("chromedriver ended without naming its port")

    def _start(self):
        options = {"binary": shutil.which("chromium"),
                   "args": FLAGS + [f"--user-data-dir={self.profile}"]}
        answer = self._request("POST", "/session", {"capabilities": {"alwaysMatch": {
            "browserName": "chrome", "goog:chromeOptions": options,
            "goog:loggingPrefs": {"browser": "ALL", "performance": "ALL"}}}})
        self.session = answer["sessionId"]

    def _request(self, method, path, body):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.address + path, data, method=method,
                                         headers={"Content-Type": "application/json"})
        # Never through a proxy of the environment: the driver is on this machine.
        opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
        try:
            with opener.open(request, timeout=120) as answer:
                return json.load(answer)["value"]
        except urllib.error.HTTPError as error:
            value = json.load(error)["value"]
            raise WebDriverError(f"{method} {path}: {value['error']}: {value['message']}") from None

    def _call(self, method, path, body=None):
        return self._request(method, f"/session/{self.session}{path}", body)

    def cdp(self, command, **parameters):
        """A command of the Chrome DevTools protocol."""
        return self._call("POST", "/goog/cdp/execute", {"cmd": command, "params": parameters})

    def open(self, url):
        self._call("POST", "/url", {"url": url})

    def script(self, text, *arguments):
        """The value that a function body returns."""
        return self._call("POST", "/execute/sync", {"script": text, "args": list(arguments)})

    def wait_for(self, text, what, seconds=20):
        """Waits until the JavaScript expression is true."""
        end = time.monotonic() + seconds
        while not self.script(f"return Boolean({text});"):
            if time.monotonic() > end:
                raise AssertionError(f"waited {seconds} s in vain for: {what}")
            time.sleep(0.02)

    def find(self, selector):
        found = self._call("POST", "/element", {"using": "css selector", "value": selector})
        return {ELEMENT_KEY: found[ELEMENT_KEY]}

    def click(self, selector):
        self._call("POST", f"/element/{self.find(selector)[ELEMENT_KEY]}/click", {})

    def box(self, selector):
        """x, y, width, height of an element in the window."""
        return self.script(
            "const b = document.querySelector(arguments[0]).getBoundingClientRect();"
            "return [b.x, b.y, b.width, b.height];", selector)

    def choose(self, selector, value):
        """Chooses the option of a select element by its value, with the mouse's events."""
        self._call("POST", f"/element/{self.find(f'{selector} option[value={value!r}]')[ELEMENT_KEY]}"
                           "/click", {})

    def pointer(self, steps, kind="mouse"):
        """Moves a pointer. Steps: (x, y) in window pixels, "down", "up"."""
        self.pointers([steps], kind)

    def pointers(self, paths, kind):
        """Moves several pointers at once, each along steps as above; all as many."""
        sources = []
        for number, steps in enumerate(paths):
            actions = []
            for step in steps:
                if step == "down":
                    actions.append({"type": "pointerDown", "button": 0})
                elif step == "up":
                    actions.append({"type": "pointerUp", "button": 0})
                else:
                    actions.append({"type": "pointerMove", "duration": 20, "x": round(step[0]),
                                    "y": round(step[1])})
            sources.append({"type": "pointer", "id": f"{kind}{number}",
                            "parameters": {"pointerType": kind}, "actions": actions})
        self._call("POST", "/actions", {"actions": sources})

    def wheel(self, x, y, delta_y):
        self._call("POST", "/actions", {"actions": [
            {"type": "wheel", "id": "wheel",
             "actions": [{"type": "scroll", "x": round(x), "y": round(y), "deltaX": 0,
                          "deltaY": delta_y, "duration": 0}]}]})

    def keys(self, *names):
        """Presses keys one after the other: names such as "ArrowLeft", or characters."""
        actions = []
        for name in names:
            value = KEYS.get(name, name)
            actions += [{"type": "keyDown", "value": value}, {"type": "keyUp", "value": value}]
        self._call("POST", "/actions",
                   {"actions": [{"type": "key", "id": "keyboard", "actions": actions}]})

    def screenshot(self, selector=None):
        """The bytes of a PNG picture of the window or of one element."""
        path = ("/screenshot" if selector is None
                else f"/element/{self.find(selector)[ELEMENT_KEY]}/screenshot")
        return base64.b64decode(self._call("GET", path))

    def console(self):
        """Messages since the last call, [(level, text)]."""
        entries = self._call("POST", "/se/log", {"type": "browser"})
        return [(entry["level"], entry["message"]) for entry in entries]

    def requests(self):
        """Addresses that the page asked for since the last call."""
        urls = []
        for entry in self._call("POST", "/se/log", {"type": "performance"}):
            message = json.loads(entry["message"])["message"]
            if message["method"] == "Network.requestWillBeSent":
                urls.append(message["params"]["request"]["url"])
        return urls
