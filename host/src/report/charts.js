// Plots over frames, which share what they show, and histograms, on top of dygraphs.

// The range of x that one or more plots show, and the row that is being read.
class View {
  constructor(xs, halfStep) {
    this.xs = xs;
    this.all = [xs[0] - halfStep, xs[xs.length - 1] + halfStep];
    this.range = this.all;
    this.row = null;
    this.plots = [];
    this.onRead = () => {};
  }

  // Shows [low, high], moved inside of what there is. Drawing waits for the next picture of the screen, so that plots that
  // follow a finger are drawn once each.
  show(low, high) {
    const whole = this.all[1] - this.all[0];
    const width = Math.min(Math.max(high - low, whole / 1e5), whole);
    const start = Math.min(Math.max(low, this.all[0]), this.all[1] - width);
    this.range = [start, start + width];
    if (this.waiting) return;
    this.waiting = requestAnimationFrame(() => {
      this.waiting = 0;
      for (const plot of this.plots) plot.draw();
    });
  }

  // Zooms by a factor around x, or around the middle.
  zoom(factor, x = (this.range[0] + this.range[1]) / 2) {
    this.show(x - (x - this.range[0]) * factor, x + (this.range[1] - x) * factor);
  }

  // Moves by a share of what is shown.
  move(share) {
    const by = share * (this.range[1] - this.range[0]);
    this.show(this.range[0] + by, this.range[1] + by);
  }

  showAll() { this.show(...this.all); }

  // Reads the values at a row in all plots, and moves there where it is out of sight.
  read(row, plot) {
    this.row = row;
    const x = this.xs[row];
    if (x < this.range[0] || x > this.range[1]) {
      const half = (this.range[1] - this.range[0]) / 2;
      this.show(x - half, x + half);
    }
    for (const each of this.plots) each.mark(row);
    this.onRead(row, plot);
  }

  nearest(x) { return nearestIndex(this.xs, x); }
}

// Of ascending values the one nearest to x.
function nearestIndex(values, x) {
  let low = 0;
  let high = values.length - 1;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] < x) low = middle + 1; else high = middle;
  }
  return low > 0 && x - values[low - 1] < values[low] - x ? low - 1 : low;
}

const color = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();

function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

// Digits enough to tell the values of a plot apart, without an exponent where people would not write one.
function shortNumber(value) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  return String(Number(value.toPrecision(6)));
}

// One plot. `series`: {name, color, values, low, high, width, dashes, rim}, all arrays with an entry (null: a gap) per x of the view;
// low and high, where given, are drawn as a band; dashes: lengths in pixels; rim: this is the edge of a band; key: false for none in the legend. Further options: title, unit, note, wide, plotter, range, least,
// fromZero, ticker, describe.
class Plot {
  constructor(view, container, options) {
    this.view = view;
    this.options = options;
    const {title, unit, note, series, wide} = options;
    const caption = element("figcaption", {}, element("span", {class: "name"}, unit ? `${title} [${unit}]` : title));
    for (const one of series.length > 1 || series[0].low ? series.filter(({key}) => key !== false) : []) {
      caption.append(element("span", {class: "key", style: `--key: var(--${one.color})`}, one.name));
    }
    if (note) caption.append(element("span", {class: "note"}, note));
    this.box = element("div", {class: "plot", tabindex: "0", role: "application", "aria-roledescription": "plot",
                               "aria-label": `${title}${unit ? ` in ${unit}` : ""}. ${this.extent()}`});
    container.append(element("figure", {class: wide ? "chart wide" : "chart"}, caption, this.box));
    view.plots.push(this);
    listen(this);
  }

  extent() {
    if (this.options.range) return "";
    return this.options.series.map((one) => {
      const [low, high] = extremes(one.values, 0, one.values.length);
      return low > high ? `${one.name}: no values.` : `${one.name} from ${shortNumber(low)} to ${shortNumber(high)}.`;
    }).join(" ");
  }

  // Rows in sight, one more on either side.
  rows() {
    const {xs, range} = this.view;
    return [Math.max(this.view.nearest(range[0]) - 1, 0), Math.min(this.view.nearest(range[1]) + 2, xs.length)];
  }

  // The range of y for what is in sight: all values, and of the bands as much as leaves the values a fifth of the height.
  // `least` keeps the last digits of a part at rest from filling the plot.
  yRange() {
    if (this.options.range) return this.options.range;
    const [first, last] = this.rows();
    let low = Infinity, high = -Infinity, bandLow = Infinity, bandHigh = -Infinity;
    for (const one of this.options.series) {
      const [a, b] = extremes(one.values, first, last);
      if (one.rim) {
        bandLow = Math.min(bandLow, a);
        bandHigh = Math.max(bandHigh, b);
        continue;
      }
      low = Math.min(low, a);
      high = Math.max(high, b);
      if (!one.low) continue;
      bandLow = Math.min(bandLow, extremes(one.low, first, last)[0]);
      bandHigh = Math.max(bandHigh, extremes(one.high, first, last)[1]);
    }
    if (low > high) return [0, 1];
    const room = 2 * (high - low) || Infinity;
    low = Math.max(Math.min(low, bandLow), low - room);
    high = Math.min(Math.max(high, bandHigh), high + room);
    const rim = Math.max((high - low) * 0.04, ((this.options.least ?? 0) - (high - low)) / 2) || Math.abs(high) / 10 || 1;
    return [this.options.fromZero ? 0 : low - rim, high + rim];
  }

  // Rows to draw: all in sight, or, where there are more than the screen has columns, of every few columns those with the
  // lowest and highest value of each series and those where a gap begins. The picture stays the same.
  drawnRows() {
    const [first, last] = this.rows();
    const step = Math.ceil((last - first) / Math.max(this.box.clientWidth, 200));
    const drawn = [];
    for (let start = first; start < last; start += step) {
      const end = Math.min(start + step, last);
      if (step <= 2) {
        for (let row = start; row < end; ++row) drawn.push(row);
        continue;
      }
      const chosen = new Set([start]);
      for (const one of this.options.series) {
        for (const values of one.low ? [one.values, one.low, one.high] : [one.values]) addTelling(chosen, values, start, end);
      }
      drawn.push(...[...chosen].sort((a, b) => a - b));
    }
    return drawn;
  }

  cells() {
    const {series} = this.options;
    const banded = series.some((one) => one.low);
    const cell = (one, row) => {
      const value = one.values[row];
      if (!banded) return value;
      return value === null ? null : [one.low ? one.low[row] : value, value, one.high ? one.high[row] : value];
    };
    this.drawn = this.drawnRows();
    return this.drawn.map((row) => [this.view.xs[row], ...series.map((one) => cell(one, row))]);
  }

  start() {
    const {series, plotter, ticker} = this.options;
    const perSeries = {};
    for (const one of series) {
      perSeries[one.name] = {color: color(one.color), strokeWidth: one.width ?? 1.3, strokePattern: one.dashes ?? null};
    }
    this.graph = new Dygraph(this.box, this.cells(), {
      labels: ["x", ...series.map((one) => one.name)],
      series: perSeries,
      customBars: series.some((one) => one.low),
      fillAlpha: 0.3,
      legend: "never",
      showLabelsOnHighlight: false,
      axisLabelFontSize: 12,
      axisLineColor: color("faint"),
      gridLineColor: color("line"),
      gridLineWidth: 0.6,
      rightGap: 8,
      pointSize: 2.5,  // of points without neighbours
      pixelRatio: document.documentElement.classList.contains("printing") ? 3 : null,
      dateWindow: this.view.range,
      valueRange: this.yRange(),
      interactionModel: mouseModel(this),
      axes: {
        x: {drawGrid: false, valueFormatter: shortNumber, axisLabelFormatter: tickLabel, pixelsPerLabel: 45,
            ticker: this.view.wholeNumbers ? wholeTicks : Dygraph.numericTicks},
        y: {axisLabelWidth: 58, valueFormatter: shortNumber, axisLabelFormatter: tickLabel, pixelsPerLabel: 28,
            ...(ticker ? {ticker} : {})},
      },
      ...(plotter ? {plotter} : {}),
      highlightCallback: (event, x, points, row) => {
        if (!this.marking) this.view.read(this.drawn[row], this);
      },
      zoomCallback: () => this.view.show(...this.graph.xAxisRange()),
    });
    if (this.view.row !== null) this.mark(this.view.row);
  }

  draw() {
    this.graph?.updateOptions({file: this.cells(), dateWindow: this.view.range, valueRange: this.yRange()});
  }

  // Marks the drawn row that is nearest.
  mark(row) {
    if (!this.graph) return;
    this.marking = true;
    this.graph.setSelection(nearestIndex(this.drawn, row));
    this.marking = false;
  }

  // What it says at a row, in words.
  values(row) {
    const {title, unit, series, describe} = this.options;
    if (describe) return describe(row);
    const parts = series.map((one) => `${series.length > 1 ? one.name + " " : ""}${shortNumber(one.values[row])}`);
    return `${title}: ${parts.join(", ")}${unit ? " " + unit : ""}`;
  }

  restart() {
    this.graph?.destroy();
    this.start();
  }

  // Canvases that were drawn while the print was being made ready come out empty; images do not.
  freeze() {
    for (const canvas of this.box.querySelectorAll("canvas")) {
      canvas.replaceWith(element("img", {src: canvas.toDataURL(), style: canvas.getAttribute("style"), alt: ""}));
    }
  }
}

// [lowest, highest] of the numbers in values[first, last); [Infinity, -Infinity] for none.
function extremes(values, first, last) {
  let low = Infinity, high = -Infinity;
  for (let i = first; i < last; ++i) {
    const value = values[i];
    if (value === null) continue;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return [low, high];
}

// Adds the rows of the lowest and the highest of values[first, last), and of the first gap.
function addTelling(rows, values, first, last) {
  let low = -1, high = -1, gap = -1;
  for (let row = first; row < last; ++row) {
    if (values[row] === null) {
      if (gap < 0) gap = row;
      continue;
    }
    if (low < 0 || values[row] < values[low]) low = row;
    if (high < 0 || values[row] > values[high]) high = row;
  }
  for (const row of [low, high, gap]) if (row >= 0) rows.add(row);
}

// Frames have no halves.
function wholeTicks(...request) {
  return Dygraph.numericTicks(...request).filter((tick) => Number.isInteger(tick.v));
}

function tickLabel(value) {
  return String(Number(value.toPrecision(8)));
}

// Dygraphs' own mouse, without its touch: that takes the page's scrolling away.
function mouseModel(plot) {
  const original = Dygraph.defaultInteractionModel;
  return {
    mousedown(event, graph, context) {
      original.mousedown(event, graph, context);
      // A pan has no callback of its own.
      if (!event.shiftKey) return;
      const follow = () => plot.view.show(...graph.xAxisRange());
      document.addEventListener("mousemove", follow);
      document.addEventListener("mouseup", () => document.removeEventListener("mousemove", follow), {once: true});
    },
    willDestroyContextMyself: true,
    dblclick() { plot.view.showAll(); },
  };
}

// Wheel, keyboard and fingers.
function listen(plot) {
  const {box, view} = plot;
  const xAt = (clientX) => plot.graph.toDataXCoord(clientX - box.getBoundingClientRect().left);

  box.addEventListener("wheel", (event) => {
    if (!event.ctrlKey) return;  // the page scrolls
    event.preventDefault();
    view.zoom(event.deltaY < 0 ? 0.8 : 1.25, xAt(event.clientX));
  }, {passive: false});

  box.addEventListener("keydown", (event) => {
    const last = view.xs.length - 1;
    const step = event.shiftKey ? 10 : 1;
    const row = view.row ?? view.nearest(view.range[0]);
    const center = view.row === null ? undefined : view.xs[view.row];
    const actions = {
      ArrowLeft: () => view.read(Math.max(row - step, 0), plot),
      ArrowRight: () => view.read(Math.min(row + step, last), plot),
      Home: () => view.read(0, plot),
      End: () => view.read(last, plot),
      "+": () => view.zoom(0.5, center),
      "=": () => view.zoom(0.5, center),
      "-": () => view.zoom(2, center),
      0: () => view.showAll(),
    };
    if (!actions[event.key] || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    actions[event.key]();
  });

  let touch = null;  // at the start: places of the fingers, range of x
  const places = (event) => [...event.touches].slice(0, 2).map((finger) => finger.clientX);
  box.addEventListener("touchstart", (event) => {
    touch = {at: places(event), range: view.range, width: plot.graph.getArea().w};
    if (touch.at.length === 1) view.read(view.nearest(xAt(touch.at[0])), plot);
  }, {passive: true});
  box.addEventListener("touchmove", (event) => {
    if (!touch || event.touches.length < touch.at.length) return;
    const now = places(event);
    const [low, high] = touch.range;
    const perPixel = (high - low) / touch.width;
    if (touch.at.length === 1) {
      const by = (touch.at[0] - now[0]) * perPixel;
      view.show(low + by, high + by);
      return;
    }
    event.preventDefault();
    const apart = (at) => Math.max(Math.abs(at[0] - at[1]), 10);
    const left = box.getBoundingClientRect().left + plot.graph.getArea().x;
    const middle = (at) => (at[0] + at[1]) / 2 - left;
    const scale = apart(touch.at) / apart(now);
    const start = low + middle(touch.at) * perPixel - middle(now) * perPixel * scale;
    view.show(start, start + (high - low) * scale);
  }, {passive: false});
  box.addEventListener("touchend", (event) => { if (event.touches.length === 0) touch = null; });
}
