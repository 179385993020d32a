// The plots of this page, from the numbers in <script id="data">.

const data = JSON.parse(document.getElementById("data").textContent);
const frames = data.frame.length > 0 ? new View(data.frame, 0.5) : null;
const plots = [];

const negative = (values) => values.map((value) => value === null ? null : -value);
const combined = (a, b, join) => a.map((value, i) => value === null || b[i] === null ? null : join(value, b[i]));

// Lanes, so that nobody needs to tell colours apart.
const lanes = [["missing", "faint"], ["none", "bad"], ["predicted", "second"], ["ok", "first"]];

function drawLanes(event, values) {
  const context = event.drawingContext;
  const graph = event.dygraph;
  const colors = lanes.map(([, name]) => color(name));
  for (let first = 0, next; first < values.length; first = next) {
    const lane = values[first];
    for (next = first + 1; next < values.length && values[next] === lane;) ++next;
    const left = graph.toDomXCoord(data.frame[first] - 0.5);
    const right = graph.toDomXCoord(data.frame[next - 1] + 0.5);
    const top = graph.toDomYCoord(lane + 0.35);
    context.fillStyle = colors[lane];
    context.fillRect(left, top, Math.max(right - left, 2), graph.toDomYCoord(lane - 0.35) - top);
  }
}

function addStatus(container, part) {
  const values = part.status.map((status) => lanes.findIndex(([name]) => name === (status ?? "missing")));
  plots.push(new Plot(frames, container, {
    title: "Found, predicted, none or missing", wide: true, series: [{name: "status", color: "first", values}],
    plotter: (event) => drawLanes(event, values), range: [-0.5, 3.5],
    ticker: () => lanes.map(([label], v) => ({v, label})),
    describe: (row) => part.status[row] ?? "missing",
  }));
}

// On top, with gaps: where it hides the estimate, the two are one.
function truthLine(values) {
  return {name: "truth", color: "second", values, width: 1.6, dashes: [5, 5]};
}

function withBand(name, values, sigma) {
  return {name, color: "first", values, width: 1.8, low: combined(values, sigma, (v, s) => v - 2 * s),
          high: combined(values, sigma, (v, s) => v + 2 * s)};
}

function addPositions(container, part) {
  container.append(element("h3", {}, "Position of the centre"));
  for (const axis of ["x", "y", "z"]) {
    const series = [withBand("estimate", part["c" + axis], part["sigma_c" + axis])];
    if (part.truth) series.push(truthLine(part.truth["c" + axis]));
    plots.push(new Plot(frames, container, {title: axis, unit: "m", series, least: 1e-3}));
  }
}

function addPositionErrors(container, part) {
  container.append(element("h3", {}, "Error of the centre: estimate minus truth, and two stated σ around zero"));
  for (const axis of ["x", "y", "z"]) {
    const error = combined(part["c" + axis], part.truth["c" + axis], (estimate, truth) => 1000 * (estimate - truth));
    const two = combined(error, part["sigma_c" + axis], (_, sigma) => 2000 * sigma);
    plots.push(new Plot(frames, container, {title: "Error of " + axis, unit: "mm", series: [
      {name: "zero", color: "second", values: two.map((v) => v === null ? null : 0), low: negative(two), high: two, width: 0.8, key: false},
      {name: "error", color: "first", values: error},
      {name: "±2σ", color: "second", values: two, rim: true},
      {name: "−2σ", color: "second", values: negative(two), rim: true, key: false},
    ], describe: (row) => `Error of ${axis}: ${shortNumber(error[row])} mm, two σ ${shortNumber(two[row])} mm`}));
  }
}

// A cylinder's axis has no sign: the truth is drawn with the one that lies nearer to the estimate.
function truthSigns(part) {
  return part.ax.map((_, i) => {
    const dot = ["ax", "ay", "az"].reduce((sum, key) => sum + (part[key][i] ?? 0) * (part.truth[key][i] ?? 0), 0);
    return dot < 0 ? -1 : 1;
  });
}

function addAxes(container, part) {
  container.append(element("h3", {}, "Direction of the axis"));
  const signs = part.truth ? truthSigns(part) : null;
  const radians = part.sigma_axis_deg.map((degrees) => degrees === null ? null : degrees * Math.PI / 180);
  for (const axis of ["x", "y", "z"]) {
    const values = part["a" + axis];
    const series = [withBand("estimate", values, combined(values, radians, (a, s) => s * Math.sqrt(Math.max(0, 1 - a * a))))];
    if (signs) {
      series.push(truthLine(combined(part.truth["a" + axis], signs, (a, s) => a * s)));
    }
    plots.push(new Plot(frames, container, {title: "a" + axis, series, least: 1e-2}));
  }
}

function addQuality(container, part) {
  container.append(element("h3", {}, part.truth ? "Errors and residuals" : "Residuals and stated uncertainty"));
  if (part.truth) {
    const millimetres = (values) => values.map((value) => value === null ? null : 1000 * value);
    plots.push(new Plot(frames, container, {title: "Size of the centre's error", unit: "mm", fromZero: true, series: [
      {name: "depth", color: "first", values: millimetres(part.error.depth_m)},
      {name: "lateral", color: "second", values: millimetres(part.error.lateral_m)},
      {name: "along the axis", color: "third", values: millimetres(part.error.along_axis_m)},
    ]}));
  }
  const angles = [{name: "stated σ", color: "second", values: part.sigma_axis_deg}];
  if (part.truth) angles.unshift({name: "error", color: "first", values: part.error.axis_angle_deg});
  plots.push(new Plot(frames, container, {title: "Angle of the axis", unit: "deg", fromZero: true, series: angles}));
  plots.push(new Plot(frames, container, {title: "Residual (rms)", unit: "px", fromZero: true,
                                          series: [{name: "rms", color: "first", values: part.rms_px}]}));
}

function drawBars(step) {
  return (event) => {
    const context = event.drawingContext;
    const graph = event.dygraph;
    const zero = graph.toDomYCoord(0);
    context.fillStyle = event.color;
    for (const point of event.points) {
      const left = graph.toDomXCoord(point.xval - step / 2);
      const width = graph.toDomXCoord(point.xval + step / 2) - left;
      const top = graph.toDomYCoord(point.yval);
      context.fillRect(left, top, Math.max(width - 1, 1), zero - top);
    }
  };
}

function addHistograms(container, part) {
  if (part.histograms.length > 0) container.append(element("h3", {}, "How often which value occurs"));
  for (const {title, unit, step, counts, above, max} of part.histograms) {
    const view = new View(counts.map((_, bin) => (bin + 0.5) * step), step / 2);
    const note = above > 0 ? `${above} more, up to ${shortNumber(max)} ${unit}` : "";
    const plot = new Plot(view, container, {
      title: title, unit, note, fromZero: true, plotter: drawBars(step),
      series: [{name: "frames", color: "first", values: counts}],
      describe: (bin) => `${title} ${shortNumber(bin * step)} to ${shortNumber((bin + 1) * step)} ${unit}: ${counts[bin]} frames`,
    });
    view.onRead = (bin, from) => say((from ?? plot).values(bin));
    plots.push(plot);
  }
}

function say(text) {
  document.getElementById("cursor").textContent = text;
}

function describeFrame(row, plot) {
  const seconds = data.timestamp_s[row];
  const time = seconds === null ? "" : `, ${shortNumber(seconds)} s`;
  say(`Frame ${data.frame[row]}${time}${plot ? " · " + plot.values(row) : ""}`);
}

function addAll() {
  frames.onRead = describeFrame;
  frames.wholeNumbers = true;
  for (const container of document.querySelectorAll("[data-part]")) {
    const part = data.parts[container.dataset.part];
    addStatus(container, part);
    addPositions(container, part);
    if (part.truth) addPositionErrors(container, part);
    addAxes(container, part);
    addQuality(container, part);
    addHistograms(container, part);
  }
  const times = document.querySelector("[data-times]");
  if (times) {
    plots.push(new Plot(frames, times, {title: "From frame to poses", unit: "ms", wide: true, fromZero: true,
                                        series: [{name: "time", color: "first", values: data.frame_ms}]}));
  }
}

const zoomActions = {
  in: () => frames.zoom(0.5), out: () => frames.zoom(2), all: () => frames.showAll(),
  earlier: () => frames.move(-0.5), later: () => frames.move(0.5),
};

// The page can be read while the plots further down are still being drawn.
function startOneByOne(next = 0) {
  if (next < plots.length) {
    if (!plots[next].graph) plots[next].start();
    setTimeout(startOneByOne, 0, next + 1);
  } else {
    document.documentElement.dataset.drawn = plots.length;
  }
}

function restartAll(printing) {
  document.documentElement.classList.toggle("printing", printing);
  for (const plot of plots) {
    plot.restart();
    if (printing) plot.freeze();
  }
}

if (frames) {
  addAll();
  startOneByOne();
  for (const button of document.querySelectorAll("[data-zoom]")) {
    button.addEventListener("click", zoomActions[button.dataset.zoom]);
  }
  if (data.frame.length < data.frames_in_all) {
    const note = document.getElementById("thinned");
    note.hidden = false;
    note.parentElement.open = true;
    note.textContent = `The plots show ${data.frame.length} of ${data.frames_in_all} frames: of every ` +
        `${Math.ceil(data.frames_in_all / data.frame.length)} the one that stands out (not found, else the largest ` +
        "error or residual). Tables and histograms are of all frames.";
  }
  addEventListener("beforeprint", () => restartAll(true));
  addEventListener("afterprint", () => restartAll(false));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => restartAll(false));
} else {
  document.getElementById("zoom").hidden = true;
}
