"use strict";
// Shows what /events says. The picture is asked for only while the page can be seen, one at a time, so that a slow
// viewer sees fewer of them.

const byId = (id) => document.getElementById(id);
const picture = byId("picture");
const history = [];  // of the last seconds: [seconds of the run, frames delivered]
let paused = false;
let loading = false;
let shownPicture = null;  // its frame

function element(tag, attributes, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

// Only what changes is touched: selections and the places of scrolling stay.
function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

// Rows of texts; the first one of each heads it.
function fillTable(table, rows) {
  const body = table.tBodies[0] ?? table.createTBody();
  while (body.rows.length > rows.length) body.deleteRow(-1);
  rows.forEach((texts, i) => {
    if (!body.rows[i]) {
      body.append(element("tr", {}, element("th", {scope: "row"}), ...texts.slice(1).map(() => element("td", {}))));
    }
    texts.forEach((text, k) => setText(body.rows[i].cells[k], text));
  });
}

const fixed = (value, digits) => value === null || value === undefined ? "–" : value.toFixed(digits).replace(/^-(?=[0.]+$)/, "");
const count = (value) => value.toLocaleString("en");

function showState(state, text) {
  setText(byId("state"), text);
  byId("state").className = state;
}

function showRate(now) {
  const {seconds, frames} = now;
  if (history.length > 0 && history[history.length - 1][1] > frames.delivered) history.length = 0;  // another run
  history.push([seconds, frames.delivered]);
  while (seconds - history[0][0] > 3 && history.length > 2) history.shift();
  const span = seconds - history[0][0];
  const rate = span > 0 ? `${fixed((frames.delivered - history[0][1]) / span, 1)} frames/s, ` : "";
  const all = now.state === "ended" && seconds > 0 ? `${fixed(frames.delivered / seconds, 1)} frames/s in all, ` : rate;
  setText(byId("rate"), `${all}${count(frames.dropped)} dropped, latest frame took ${fixed(now.latency_ms, 1)} ms`);
}

function partBox(part) {
  const label = `Pose of ${part.part}`;
  return element("div", {}, element("h3", {}, part.part + " ", element("span", {class: "status"})),
                 element("p", {class: "reason"}),
                 element("div", {class: "scroll", tabindex: "0", role: "region", "aria-label": label},
                         element("table", {}, element("caption", {}, label))));
}

function showPart(box, part) {
  const status = box.querySelector(".status");
  setText(status, part.status);
  status.className = `status ${part.status}`;
  setText(box.querySelector(".reason"), part.reason);
  const place = (i) => part.center_m ? [fixed(part.center_m[i], 4), `± ${fixed(1000 * part.sigma_center_m[i], 2)} mm`] : ["–", ""];
  fillTable(box.querySelector("table"), [
    ["Centre x [m]", ...place(0)],
    ["Centre y [m]", ...place(1)],
    ["Centre z [m]", ...place(2)],
    ["Axis", part.axis ? part.axis.map((a) => fixed(a, 4)).join(" ") : "–",
     part.axis ? `± ${fixed(part.sigma_axis_deg, 3)}°` : ""],
    ["Residual [px]", fixed(part.rms_px, 3), ""],
    ["Ok", count(part.frames.ok), "frames"],
    ["Predicted", count(part.frames.predicted), "frames"],
    ["None", count(part.frames.none), "frames"],
  ]);
}

function showParts(parts) {
  const boxes = byId("parts");
  const names = parts.map(({part}) => part).join("\n");
  if (boxes.dataset.names !== names) {
    boxes.dataset.names = names;
    boxes.replaceChildren(...parts.map(partBox));
  }
  parts.forEach((part, i) => showPart(boxes.children[i], part));
}

function showPipeline(now) {
  fillTable(byId("frames"), [
    ["Accepted", count(now.frames.accepted)],
    ["Delivered", count(now.frames.delivered)],
    ["Dropped, for newer ones", count(now.frames.dropped)],
    ["Unreadable or failed", count(now.frames.failed)],
    ["Searched again as a whole", count(now.frames.searched_again)],
  ]);
  const times = (name, t) => [name, fixed(t.median_ms, 3), fixed(t.p95_ms, 3), fixed(t.p99_ms, 3), fixed(t.max_ms, 3), count(t.count)];
  fillTable(byId("times"), [...now.nodes.map((node) => times(node.node, node)), times("put to sink", now.put_to_sink)]);
}

function showCluster(cluster) {
  byId("cluster").hidden = cluster === null;
  if (cluster === null) return;
  const nodes = cluster.nodes.map((n) => [n.node, count(n.slots), fixed(n.mpixel_per_s, 1), count(n.used), count(n.failed)]);
  fillTable(byId("nodes"), nodes.length > 0 ? nodes : [["none", "", "", "", ""]]);
  const {tiles} = cluster;
  fillTable(byId("tiles"), [["Sent", count(tiles.sent)], ["Used", count(tiles.used)], ["Late", count(tiles.late)],
                            ["Refused", count(tiles.refused)], ["Taken back", count(tiles.taken_back)]]);
}

function showMessages(messages, inAll) {
  byId("messages").hidden = messages.length === 0;
  const texts = messages.map(({text, times}) => times > 1 ? `${text} (${count(times)} times)` : text).reverse();
  const shown = messages.reduce((sum, {times}) => sum + times, 0);
  if (inAll > shown) texts.push(`and ${count(inAll - shown)} older ones`);
  const list = byId("messages").querySelector("ul");
  while (list.children.length > texts.length) list.lastChild.remove();
  texts.forEach((text, i) => setText(list.children[i] ?? list.appendChild(element("li", {})), text));
}

// Resolves once the picture of the frame, or a newer one, is shown.
async function showPicture(frame) {
  if (loading || frame === null || frame === shownPicture || document.hidden) return;
  loading = true;
  try {
    picture.src = `picture.jpg?frame=${frame}`;
    await picture.decode();
    picture.alt = `Overlay of frame ${frame}: the part's sides, cylinder, axis and centre`;
    picture.width = picture.naturalWidth;
    picture.height = picture.naturalHeight;
    shownPicture = frame;
  } catch {
    shownPicture = null;  // the next event tries again
  } finally {
    loading = false;
  }
}

function show(now) {
  showState(now.state, now.state);
  const facts = byId("facts");
  if (facts.children.length === 0) {
    facts.append(...now.facts.map(({label, value}) => element("li", {}, element("span", {}, `${label}: `), value)));
  }
  showRate(now);
  setText(byId("caption"), now.frame === null ? "No frame yet" :
          `Frame ${now.frame} at ${fixed(now.timestamp_s, 2)} s${now.failure ? `: ${now.failure}` : ""}`);
  showParts(now.parts);
  showPipeline(now);
  showCluster(now.cluster);
  showMessages(now.messages, now.messages_in_all);
}

const events = new EventSource("events");
events.onmessage = async ({data}) => {
  const now = JSON.parse(data);
  if (now.state === "ended") {
    show(now);
    await showPicture(now.picture);
    if (shownPicture === now.picture || now.picture === null) events.close();
    return;
  }
  if (paused) return;
  show(now);
  showPicture(now.picture);
};
events.onerror = () => showState("lost", "connection lost");
byId("pause").addEventListener("click", () => {
  paused = !paused;
  byId("pause").setAttribute("aria-pressed", String(paused));
  setText(byId("pause"), paused ? "Go on" : "Pause");
});
