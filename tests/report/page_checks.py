"""What must hold for every page: scripts that look for what does not, and what the browser complained of."""

import subprocess

# Elements that stick out of the window, other than inside of what scrolls by itself.
OVERFLOWING = """[...document.querySelectorAll("body *")].filter((e) => !e.closest(".scroll *, script, style, .plot *") &&
    e.checkVisibility() && (e.getBoundingClientRect().right > innerWidth + 0.5 ||
    e.getBoundingClientRect().left < -0.5)).map((e) => e.outerHTML.slice(0, 80))"""

# Pairs of blocks of text, plots and pictures that cover each other.
OVERLAPPING = """(() => {
  const boxes = [...document.querySelectorAll("h1, h2, h3, p, .facts, .scroll, .plot, figcaption, img[alt^=Overlay], button")]
      .filter((e) => e.checkVisibility()).map((e) => [e, e.getBoundingClientRect()]);
  const pairs = [];
  boxes.forEach(([a, r], i) => boxes.slice(i + 1).forEach(([b, s]) => {
    if (a.contains(b) || b.contains(a)) return;
    const x = Math.min(r.right, s.right) - Math.max(r.left, s.left);
    const y = Math.min(r.bottom, s.bottom) - Math.max(r.top, s.top);
    if (x > 1 && y > 1) pairs.push(a.outerHTML.slice(0, 60) + " / " + b.outerHTML.slice(0, 60));
  }));
  return pairs;
})()"""

# Texts whose contrast with what is behind them is below the 4.5 of WCAG AA.
FAINT_TEXTS = """(() => {
  const canvas = document.createElement("canvas").getContext("2d", {willReadFrequently: true});
  const rgb = (color) => {
    canvas.clearRect(0, 0, 1, 1);
    canvas.fillStyle = color;
    canvas.fillRect(0, 0, 1, 1);
    return canvas.getImageData(0, 0, 1, 1).data;
  };
  const luminance = (color) => {
    const [r, g, b] = [...rgb(color)].map((c) => c / 255).map((c) => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const behind = (e) => {
    for (; e; e = e.parentElement) {
      const color = getComputedStyle(e).backgroundColor;
      if (rgb(color)[3] > 0) return color;
    }
    return "white";
  };
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const faint = [];
  let looked = 0;
  for (let node; (node = walker.nextNode());) {
    const e = node.parentElement;
    if (!node.data.trim() || e.closest("script, style, noscript") || !e.checkVisibility()) continue;
    ++looked;
    const [a, b] = [luminance(getComputedStyle(e).color), luminance(behind(e))];
    const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (contrast < 4.5) faint.push(node.data.trim().slice(0, 40) + " " + contrast.toFixed(2));
  }
  return {looked, faint};
})()"""


def complaints(browser):
    """Errors and messages since the page was opened."""
    return [e for e in browser.events
            if e.get("method") in ("Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded")]


def requests(browser):
    """What was asked for since the page was opened, without what is in the page itself."""
    urls = [e["params"]["request"]["url"] for e in browser.events if e.get("method") == "Network.requestWillBeSent"]
    return [url for url in urls if not url.startswith("data:")]


def tidied(program, page):
    """What is no valid HTML in a file; empty when all is well."""
    checked = subprocess.run([program, "-errors", "-quiet", page], capture_output=True, text=True, check=False)
    return checked.stderr or ("" if checked.returncode == 0 else f"exit code {checked.returncode}")
