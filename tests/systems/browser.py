"""A page in headless Chromium, driven by the WebDriver protocol."""

from __future__ import annotations

import base64
import json
import os
import shutil
import socket
import subprocess
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

FLAGS = (
    "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync --hide-scrollbars --window-size=1280,900"
)
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
DRIVER = shutil.which("chromedriver")
_PATIENCE = 300  # s: a busy machine is slow, and only a hang is to end a test


class Browser:
    """One session of the driver at a port."""

    def __init__(self, port: int, profile: Path) -> None:
        self.base = f"http://127.0.0.1:{port}"
        options = {"binary": CHROMIUM, "args": [*FLAGS.split(), f"--user-data-dir={profile}"]}
        wanted = {"goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"}}
        self.session = self("/session", {"capabilities": {"alwaysMatch": wanted}})["sessionId"]
        self(f"/session/{self.session}/timeouts", {"script": 1000 * _PATIENCE, "pageLoad": 1000 * _PATIENCE})

    def __call__(self, path: str, data: dict[str, Any] | None = None, method: str | None = None) -> Any:
        body = None if data is None else json.dumps(data).encode()
        kind = {"Content-Type": "application/json"}
        request = urllib.request.Request(self.base + path, body, kind, method=method)
        opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
        with opener.open(request, timeout=_PATIENCE) as answer:
            return json.load(answer)["value"]

    def quit(self) -> None:
        """End the session, and with it the browser, which its driver does not end."""
        self(f"/session/{self.session}", method="DELETE")

    def run(self, script: str) -> Any:
        return self(f"/session/{self.session}/execute/sync", {"script": script, "args": []})

    def devtools(self, command: str, **parameters: Any) -> Any:
        """Send a command of the DevTools protocol."""
        return self(f"/session/{self.session}/goog/cdp/execute", {"cmd": command, "params": parameters})

    def show(self, page: Path, width: int = 1280, dark: bool = False, medium: str = "screen") -> None:
        """Load a page in a window of a width [px], in a light or dark theme, on the screen or on paper."""
        size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 700}
        self.devtools("Emulation.setDeviceMetricsOverride", **size)
        theme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.devtools("Emulation.setEmulatedMedia", media=medium, features=[theme])
        self(f"/session/{self.session}/url", {"url": page.resolve().as_uri()})

    def scripts(self, *, run: bool) -> None:
        """Let pages that are loaded from now on run scripts, or not."""
        self.devtools("Emulation.setScriptExecutionDisabled", value=not run)

    def picture(self, path: Path) -> Path:
        """Save what the window shows."""
        path.write_bytes(base64.b64decode(self(f"/session/{self.session}/screenshot", None)))
        return path

    def log(self) -> list[dict[str, Any]]:
        entries: list[dict[str, Any]] = self(f"/session/{self.session}/se/log", {"type": "browser"})
        return entries


@contextmanager
def opened(profile: Path) -> Iterator[Browser]:
    """Start a browser; where there is none the test is skipped, in CI it fails."""
    if CHROMIUM is None or DRIVER is None:
        message = "no Chromium with its driver: Debian packages chromium and chromium-driver"
        if os.environ.get("CI"):
            pytest.fail(message)
        pytest.skip(message)
    port = _free_port()
    driver = subprocess.Popen(
        [DRIVER, f"--port={port}"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        browser = _when_ready(port, profile)
        try:
            yield browser
        finally:
            browser.quit()
    finally:
        driver.terminate()
        driver.wait(timeout=20)


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _when_ready(port: int, profile: Path) -> Browser:
    for _ in range(100):
        try:
            return Browser(port, profile)
        except ConnectionRefusedError:
            time.sleep(0.1)
        except urllib.error.URLError as error:
            if not isinstance(error.reason, ConnectionRefusedError):
                raise
            time.sleep(0.1)
    pytest.fail("the browser's driver does not answer")
