"""What a page must keep in a real browser; faults are returned with the view that shows them."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import Any

from tests.systems.browser import Browser

PHONE, DESK = 390, 1280
AXE = "axe_playwright_python"  # ships axe-core; its own driver is not used

_SPLIT_WORDS = """
const found = [];
for (const cell of document.querySelectorAll('td, th, li, p, figcaption, h1, h2, h3, button')) {
  const walker = document.createTreeWalker(cell, NodeFilter.SHOW_TEXT);
  for (let node = walker.nextNode(); node; node = walker.nextNode())
    for (const match of node.data.matchAll(/[^\\s-]+/g)) {
      if (match[0].length > 14) continue;
      const range = document.createRange();
      range.setStart(node, match.index); range.setEnd(node, match.index + match[0].length);
      if (new Set([...range.getClientRects()].map(r => Math.round(r.top))).size > 1) found.push(match[0]);
    }
}
return found;"""
_OUTSIDE = """
const inside = e => { for (let p = e; p; p = p.parentElement) {
  if (['auto', 'scroll'].includes(getComputedStyle(p).overflowX)) return true; } return false; };
const shown = [...document.querySelectorAll('main *')].filter(e => e.getClientRects().length);
const free = shown.filter(e => !inside(e) && !e.closest('.u-wrap'));
return free.filter(e => e.getBoundingClientRect().right > innerWidth + 1)
  .map(e => e.outerHTML.slice(0, 80));"""
_AXE_RUN = """
const done = await axe.run(document, {resultTypes: ['violations']});
return done.violations.flatMap(v => v.nodes.map(n => v.id + ': ' + n.target.join(' ') + ': ' +
  n.failureSummary.replace(/\\s+/g, ' ')));"""
_REACHABLE = """
const wanted = 'a[href], button, summary, [tabindex="0"]';
return [...document.querySelectorAll(wanted)].filter(e => e.getClientRects().length
  && !e.closest('details:not([open]) > :not(summary)')).map((e, i) => (e.dataset.stop = i)).length;"""
_FOCUSED = """
const e = document.activeElement, style = getComputedStyle(e);
const visible = style.outlineStyle !== 'none' && parseFloat(style.outlineWidth) >= 1;
return [e.dataset.stop === undefined ? -1 : Number(e.dataset.stop), visible, e.outerHTML.slice(0, 80)];"""


def faults(browser: Browser, page: Path) -> list[str]:
    """All faults of a page: on a phone and a desk, light and dark, on paper, without scripts, by keyboard."""
    found: list[str] = []
    for width in (PHONE, DESK):
        for dark in (False, True):
            browser.show(page, width, dark)
            view = f"{page.name}, {width} px, {'dark' if dark else 'light'}"
            found += [f"{view}: {fault}" for fault in (*_layout(browser, width), *_axe(browser))]
    found += [f"{page.name}, keyboard: {fault}" for fault in _keyboard(browser)]
    found += [f"{page.name}, print: {fault}" for fault in _paper(browser, page)]
    found += [f"{page.name}, no scripts: {fault}" for fault in _without_scripts(browser, page)]
    found += [f"{page.name}, log: {e['message']}" for e in browser.log() if e["level"] == "SEVERE"]
    return found


def _layout(browser: Browser, width: int) -> list[str]:
    scroll = browser.run("return document.documentElement.scrollWidth")
    found = [] if scroll == width else [f"scrolls sideways: {scroll} px wide"]
    found += [f"outside the window: {e}" for e in browser.run(_OUTSIDE)]
    return found + [f"word split over lines: {word}" for word in browser.run(_SPLIT_WORDS)]


def _axe(browser: Browser) -> list[str]:
    source = resources.files(AXE).joinpath("axe.min.js").read_text(encoding="utf-8")
    browser.run(source)
    found: list[str] = browser.run(f"return (async () => {{ {_AXE_RUN} }})()")
    return found


def _keyboard(browser: Browser) -> list[str]:
    """Tab reaches everything that does something, in its order, and shows where it is."""
    count = browser.run(_REACHABLE)
    browser.run("document.activeElement.blur(); window.scrollTo(0, 0)")
    stops: list[int] = []
    found: list[str] = []
    for _ in range(count):
        _press(browser, "Tab", 9)
        place, is_visible, html = browser.run(_FOCUSED)
        stops.append(place)
        if not is_visible:
            found.append(f"no outline: {html}")
    if stops != list(range(count)):
        found.append(f"order of the tabulator key, got {stops}, expected 0 to {count - 1}")
    return found + _reads_by_arrows(browser) + _label_by_space(browser)


def _reads_by_arrows(browser: Browser) -> list[str]:
    if not browser.run(
        "const f = document.querySelector('.field'); if (!f) return false; f.focus(); return true"
    ):
        return []
    _press(browser, "ArrowRight", 39)
    read = browser.run(
        "return (async () => { await new Promise(r => setTimeout(r, 60));"
        "return document.querySelector('.at').textContent; })()"
    )
    return [] if read else ["an arrow key reads no value"]


def _label_by_space(browser: Browser) -> list[str]:
    if not browser.run(
        "const b = document.querySelector('.labels button'); if (!b) return false; b.focus(); return true"
    ):
        return []
    _press(browser, " ", 32)
    pressed = browser.run("return document.querySelector('.labels button').getAttribute('aria-pressed')")
    return [] if pressed == "false" else ["the space key does not hide a curve"]


def _press(browser: Browser, key: str, code: int) -> None:
    more: dict[str, Any] = {"text": key} if len(key) == 1 else {}
    named = {"key": key, "code": "Space" if key == " " else key, "windowsVirtualKeyCode": code}
    browser.devtools("Input.dispatchKeyEvent", type="keyDown", **named, **more)
    browser.devtools("Input.dispatchKeyEvent", type="keyUp", **named)


def _paper(browser: Browser, page: Path) -> list[str]:
    browser.show(page, medium="print", dark=True)
    hidden = browser.run(
        "return [...document.querySelectorAll('.picture')].filter(e => !e.getClientRects().length).length"
    )
    drawn = browser.run(
        "return [...document.querySelectorAll('canvas')].filter(e => e.getClientRects().length).length"
    )
    colour = browser.run("return getComputedStyle(document.body).backgroundColor")
    found = [f"{hidden} pictures are not printed"] if hidden else []
    found += [f"{drawn} plots are printed next to their pictures"] if drawn else []
    return found + ([] if colour == "rgb(255, 255, 255)" else [f"printed on {colour}"])


def _without_scripts(browser: Browser, page: Path) -> list[str]:
    browser.scripts(run=False)
    try:
        browser.show(page, PHONE)
        ready = browser.run("return document.body.dataset.ready || ''")
        found = [f"scripts ran: {ready}"] if ready else []
        small = browser.run(
            "const isSeen = i => i.getClientRects().length && i.naturalWidth >= 300;"
            "return [...document.images].filter(i => !isSeen(i)).length"
        )
        n_plots = browser.run(
            "return document.querySelectorAll('.plots:not([data-still]) .plot, [data-still]').length"
        )
        n_pictures = browser.run("return document.querySelectorAll('.plot .picture').length")  # or one of all
        found += [f"{small} pictures are not seen"] if small else []
        found += [] if n_plots == n_pictures else [f"{n_plots} plots and {n_pictures} pictures"]
        return found + _layout(browser, PHONE)
    finally:
        browser.scripts(run=True)
