// The panel's page. It holds no rules of its own: what it may not do, the server refuses.
"use strict";

const BEAT = 100;          // ms between two keep-alives of a page that commands
let lostAfter = 1000;      // ms without a word of the server after which the connection counts as lost
const RETRY = 1000;        // ms between two attempts to get it back
const MINUTE = 60;         // s that the plots show
const DEGREE = 180 / Math.PI;
const AXES = ["x", "y", "z", "rx", "ry", "rz"];
const COLOURS = ["#5aa2e6", "#3fbf7f", "#ffaa28", "#e5383b", "#b98bf0", "#4fd1d9"];
const $ = (id) => document.getElementById(id);

let socket = null, hello = null, state = null, seldom = {}, heardAt = performance.now(), lostAt = 0, seen = 0;
let held = null;           // the button that is held down
let token = "";
let aimed = false;         // whether the sliders were touched since they were set to the arm
let history = [];          // [time by a clock of the server, joint speeds × 6, tool speed, force, lag]

if (location.hash.startsWith("#token=")) {
  token = location.hash.slice(7);
  try { token = decodeURIComponent(token); } catch { /* a token that was written by hand */ }
  window.history.replaceState(null, "", location.pathname);  // out of sight, and of the history
}

// -- the connection ---------------------------------------------------------------------------------

function send(message) {
  if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
}

function connect() {
  const mine = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/socket`);
  socket = mine;
  mine.onmessage = (event) => { if (socket === mine) take(JSON.parse(event.data)); };
  mine.onclose = () => {
    if (socket !== mine) return;
    lose();
    setTimeout(connect, RETRY);
  };
}

function lose() {
  if (!$("lost").hidden) return;
  lostAt = Date.now();
  release();
  state = null;
  if ($("ask").open) $("ask").close("no");
  $("lost").hidden = false;
  document.title = "CONNECTION LOST";
}

setInterval(() => {
  const silent = performance.now() - heardAt;
  if (silent > lostAfter) {
    lose();
    if (silent > 5 * lostAfter && socket.readyState === WebSocket.OPEN) socket.close();
  }
  if (!$("lost").hidden) $("lost-since").textContent = `for ${Math.round((Date.now() - lostAt) / 1000)} s; trying again`;
}, 100);

function take(message) {
  heardAt = performance.now();
  if (!$("lost").hidden) { $("lost").hidden = true; document.title = `${hello ? hello.name : ""} · aioduco panel`; }
  if (message.tell === "state") { saw(message); }
  else if (message.tell === "hello") { begin(message); }
  else if (message.tell === "seldom") { seldom = message; showSeldom(); }
  else if (message.tell === "event") { showEvent(message); }
  else if (message.tell === "measured") { showMeasured(message); }
  else if (message.tell === "refused") { notice(message.reason); release(); }
}

// A page that is slow draws the newest state, and not one after the other.
let drawing = false;
function saw(message) {
  state = message; seen = message.n;
  if (held !== null && !commanding()) release();
  const now = state.sample;
  if (now !== null) {
    if (now.moving !== false) seldom.work_pose = null;  // told once a second: it is where the tool was
    const force = now.force === null || now.force.slice(0, 3).includes(null) ? null : Math.hypot(...now.force.slice(0, 3));
    history.push([state.now, ...now.speeds, now.tool_speed, force, state.late]);
    while (history.length && history[0][0] < state.now - MINUTE) history.shift();
  }
  if (!drawing) { drawing = true; requestAnimationFrame(() => { drawing = false; if (state !== null) showState(); }); }
}

const commanding = () => state !== null && hello !== null && state.holder === hello.page && state.phase === "held";

setInterval(() => {
  if (state !== null && hello !== null && state.holder === hello.page) send({ask: "beat", seen, down: held !== null});
}, BEAT);

// -- stop: on pressing, not on letting go -------------------------------------------------------------

function stop() { send({ask: "stop"}); release(); }
$("stop").addEventListener("pointerdown", (event) => { event.preventDefault(); stop(); });
$("stop").addEventListener("keydown", (event) => { if (!event.repeat && (event.key === " " || event.key === "Enter")) { event.preventDefault(); stop(); } });
// a screen reader clicks without a pointer
$("stop").addEventListener("click", (event) => { if (event.detail === 0) stop(); });
window.addEventListener("keydown", (event) => { if (event.key === "Escape" && !event.repeat && !$("ask").open) stop(); }, true);

// -- press and hold ---------------------------------------------------------------------------------

function holds(button, motion) {
  button.classList.add("hold");
  button.addEventListener("contextmenu", (event) => event.preventDefault());
  button.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || held !== null || !commanding()) return;
    const made = motion();
    if (made === null) return;
    event.preventDefault();
    button.setPointerCapture(event.pointerId);
    held = button;
    button.classList.add("down");
    send({ask: "press", motion: made, seen});
  });
  for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
    button.addEventListener(end, () => { if (held === button) release(); });
  }
}

function release() {
  if (held === null) return;
  held.classList.remove("down");
  held = null;
  send({ask: "let_go"});
}
window.addEventListener("blur", release);
document.addEventListener("visibilitychange", () => { if (document.hidden) release(); });
window.addEventListener("pagehide", () => { if (socket) socket.close(); });

// -- what is made once ------------------------------------------------------------------------------

function cell(row, name, text) { const made = row.insertCell(); made.className = name; if (text !== undefined) made.textContent = text; return made; }

const jogRows = [];
function jogRow(table, label, axis, bar) {
  const row = table.insertRow();
  cell(row, "", label);
  const button = (text, direction) => {
    const made = document.createElement("button");
    made.type = "button"; made.textContent = text; made.disabled = true;
    made.dataset.jog = `${axis}${direction > 0 ? "+" : "-"}`;
    made.setAttribute("aria-label", `jog ${label} ${direction > 0 ? "plus" : "minus"}`);
    holds(made, () => ({kind: "jog", axis, direction, percent: +$("jog-speed").value, frame: $("jog-frame").value}));
    return made;
  };
  cell(row, "").append(button("−", -1));
  let fill = null;
  const middle = cell(row, "bar");
  if (bar) { const track = document.createElement("div"); track.className = "track"; fill = document.createElement("i"); track.append(fill); middle.append(track); }
  const value = cell(row, "value", "–");
  cell(row, "").append(button("+", 1));
  const rate = cell(row, "rate");
  jogRows.push({value, fill, rate});
}
for (let joint = 1; joint <= 6; joint++) jogRow($("jog-joints"), `J${joint}`, joint, true);
AXES.forEach((axis) => jogRow($("jog-tool"), axis.toUpperCase(), axis, false));
document.querySelectorAll(".axes thead tr").forEach((row) => { row.cells[0].colSpan = 5; });

const targets = [];
for (let index = 0; index < 6; index++) {
  const row = document.createElement("div"), label = document.createElement("span"), slider = document.createElement("input"), number = document.createElement("input"), unit = document.createElement("em");
  row.className = "target"; slider.type = "range"; number.type = "number"; slider.step = number.step = "0.1"; slider.disabled = number.disabled = true;
  slider.addEventListener("input", () => { number.value = slider.value; touched(); });
  number.addEventListener("input", () => { if (number.value !== "") slider.value = number.value; touched(); });
  row.append(label, slider, number, unit);
  $("targets").append(row);
  targets.push({label, slider, number, unit});
}
const space = () => document.querySelector("input[name=space]:checked").value;
// what the sliders show, in radians and metres; null while a number is missing, which would count as 0
const aim = () => (targets.some((target) => target.number.value === "") ? null : targets.map((target, index) => +target.number.value / (space() === "joints" || index > 2 ? DEGREE : 1000)));

function touched() { const target = aim(); aimed = target !== null; if (space() === "joints") send({ask: "aim", joints: target}); }
function noTarget() { aimed = false; for (const target of targets) target.number.value = ""; }
function fromHere() {
  noTarget();
  send({ask: "aim", joints: null});
  const joints = space() === "joints", known = state !== null && state.sample !== null && hello !== null;
  const values = !known ? null : joints ? state.sample.joints : state.sample.moving === false ? seldom.work_pose : null;
  if (!values || values.includes(null)) {
    notice("It is not known where the arm is; the place of the tool not while it moves. Press From here again.");
    return;
  }
  targets.forEach((target, index) => {
    const turns = joints || index > 2, shown = values[index] * (turns ? DEGREE : 1000);
    target.label.textContent = joints ? `J${index + 1}` : AXES[index].toUpperCase();
    target.unit.textContent = turns ? "°" : "mm";
    const [low, high] = joints ? [hello.lower[index] * DEGREE, hello.upper[index] * DEGREE] : turns ? [-180, 180] : [-1500, 1500];
    for (const input of [target.slider, target.number]) { input.min = low.toFixed(1); input.max = high.toFixed(1); input.value = shown.toFixed(1); }
  });
}
document.querySelectorAll("input[name=space]").forEach((input) => input.addEventListener("change", () => { fromHere(); showSpeeds(); }));
$("from-here").addEventListener("click", fromHere);
holds($("move"), () => (aimed ? {kind: space(), to: aim(), percent: +$("move-speed").value} : null));

function showSpeeds() {
  const jog = +$("jog-speed").value, move = +$("move-speed").value;
  $("jog-speed-value").textContent = `${jog} % of jogs`;
  $("move-speed-value").textContent = space() === "joints" ? `${(move / 100 * DEGREE).toFixed(0)} °/s` : `${Math.max(10, move * 2.5).toFixed(0)} mm/s`;
}
$("jog-speed").addEventListener("input", showSpeeds);
$("move-speed").addEventListener("input", showSpeeds);

$("tabs").addEventListener("click", (event) => {
  const chosen = event.target.dataset.tab;
  if (!chosen) return;
  document.querySelectorAll("nav button").forEach((tab) => tab.setAttribute("aria-selected", tab.dataset.tab === chosen));
  document.querySelectorAll(".tab").forEach((page) => { page.hidden = page.dataset.page !== chosen; });
  if (chosen === "move") fromHere(); else if (commanding()) send({ask: "aim", joints: null});
});

function lamps(box, count, make) {
  if (box.childElementCount === count) return;
  box.replaceChildren(...Array.from({length: count}, (_, index) => make(index + 1)));
}
const lamp = (number) => { const made = document.createElement("div"); made.className = "lamp"; made.textContent = number; return made; };
const switchOf = (tool) => (number) => {
  const made = document.createElement("button");
  made.type = "button"; made.className = "lamp"; made.textContent = number;
  made.addEventListener("click", () => send({ask: "output", num: number, on: !made.classList.contains("on"), tool, seen}));
  return made;
};
function light(box, bits, make) { lamps(box, bits.length, make); for (let i = 0; i < bits.length; i++) box.children[i].classList.toggle("on", bits[i] === "1"); }

// -- questions --------------------------------------------------------------------------------------

function question(title, text, withToken, yes) {
  const dialog = $("ask");
  $("ask-title").textContent = title; $("ask-text").textContent = text;
  $("token-row").hidden = !withToken; $("token").value = withToken ? token : "";
  dialog.onclose = () => { if (dialog.returnValue === "yes") yes(); $("token").value = ""; };
  dialog.returnValue = "no";
  dialog.show();  // not modal: the stop button stays in reach
  (withToken && !token ? $("token") : $("ask-no")).focus();
}
$("ask").addEventListener("keydown", (event) => { if (event.key === "Escape") $("ask").close("no"); });
$("token").addEventListener("keydown", (event) => { if (event.key === "Enter") { event.preventDefault(); $("ask").close("yes"); } });
$("take").addEventListener("click", () => question(
  "Take control of the arm", "This page alone will command it. Each motion lasts as long as a button is held down, and ends with this page.", true,
  () => { token = $("token").value; send({ask: "take", token}); }));
$("give-back").addEventListener("click", () => send({ask: "give_back"}));
document.querySelectorAll("[data-verb]").forEach((button) => button.addEventListener("click", () => {
  const act = () => send({ask: "do", verb: button.dataset.verb, seen});
  if (button.dataset.asks) question(`${button.textContent}?`, button.dataset.asks, false, act); else act();
}));
document.querySelectorAll("[data-line]").forEach((button) => button.addEventListener("click", () => send({ask: "simulator", line: button.dataset.line})));
document.querySelectorAll("[data-push]").forEach((button) => button.addEventListener("click", () => {
  const force = button.dataset.push.split(" ").map((part) => part * +$("push").value);
  send({ask: "simulator", line: `push ${force.join(" ")}`});
}));

document.querySelectorAll("[data-step]").forEach((button) => button.addEventListener("click", () => send({ask: "measure", step: button.dataset.step, sensor: $("sensor").value})));
document.querySelectorAll("[data-write]").forEach((button) => button.addEventListener("click", () => {
  const what = button.dataset.write, name = $("tool-name").value.trim();
  if (what !== "held" && !name) { notice("give the tool a name first"); return; }
  const texts = {tip: `The controller will define the tool "${name}" with the measured tip and the load of the tool in use, and use it from now on.`, load: `The controller will define the tool "${name}" with the measured load and the tip of the tool in use, and use it from now on.`, held: "The controller will take what was measured beyond the tool's load for what the tool holds."};
  question("Write it?", texts[what], false, () => send({ask: "write", what, name}));
}));

// -- what is shown ----------------------------------------------------------------------------------

let noticeTimer = 0;
function notice(text) { $("notice").textContent = text; $("notice").hidden = false; clearTimeout(noticeTimer); noticeTimer = setTimeout(() => { $("notice").hidden = true; }, 6000); }

function begin(message) {
  hello = message;
  lostAfter = Math.max(1000, 1000 * message.hold_limit);
  history = message.history;
  noTarget();  // the arm may be elsewhere by now, or another one
  document.title = `${message.name} · aioduco panel`;
  $("name").textContent = message.name;
  $("take").hidden = message.watch_only;
  document.querySelector("[data-tab=simulator]").hidden = !message.simulator;
  $("limits").replaceChildren(...message.limits.map((name) => { const item = document.createElement("li"); item.textContent = name; return item; }));
  $("events").replaceChildren();
  message.events.forEach(showEvent);
  seldom = message.seldom;
  showSeldom(); showSpeeds(); showMeasured(message.measured);
  pictureSays("The picture of the arm is loading…");
  // By this computer's other name the picture is another site's to the browser, which draws it in
  // a process of its own: however long that takes, the stop does not wait for it.
  const names = {"127.0.0.1": "localhost", "localhost": "127.0.0.1"};
  const host = location.host.replace(location.hostname, names[location.hostname] ?? location.hostname);
  const where = `ws://${host}/picture`;
  $("scene").src = `${location.protocol}//${host}/scene?darkMode&websocket=${encodeURIComponent(where)}`;
}
addEventListener("message", (event) => {
  if (event.source !== $("scene").contentWindow) return;
  if (event.data === "Escape") stop();  // the picture takes the keys once it was clicked
  else if (event.data === "drawn") $("scene-wait").hidden = true;
  else if (event.data === "no WebGL") { pictureSays("This browser draws no picture of the arm: it has no WebGL."); }
});
function pictureSays(text) { $("scene-wait").hidden = false; $("scene-wait").textContent = text; }

function pill(id, text, kind) { const box = $(id); if (box.textContent !== text) box.textContent = text; box.parentElement.className = `pill ${kind}`; }
const fixed = (value, digits) => (value === null || value === undefined ? "–" : (Math.round(value * 10 ** digits) / 10 ** digits + 0).toFixed(digits));

function showState() {
  const now = state.sample, mine = commanding();
  document.body.classList.toggle("commanding", mine);
  $("control-state").textContent = mine ? "You command" : state.holder === (hello && hello.page) ? "Opening the robot…" : state.phase === "ending" ? "The lease is ending…" : state.holder ? "Another page commands" : hello && hello.watch_only ? "Watching only" : "Watching; nobody commands";
  $("take").disabled = state.phase !== "free";
  $("take").hidden = (hello && hello.watch_only) || mine;
  $("give-back").hidden = !mine;
  $("alarm").hidden = !state.alarm;
  $("alarm").textContent = state.alarm;
  $("stop").classList.toggle("busy", state.busy.includes("stop"));
  $("doing").textContent = [...(state.motion ? [state.motion] : []), ...state.tasks, ...state.busy.map((name) => name.replace("_", " "))].join(", ") || (now && now.program !== "STOPPED" ? "another program's" : "none");
  $("link-state").textContent = state.age === null ? "no answer from the controller yet" : `the controller answered ${(state.age * 1000).toFixed(0)} ms ago · ${hello ? hello.rate : ""} states a second`;
  document.querySelectorAll(".hold, [data-verb], [data-line], [data-step], [data-write], [data-push], .target input, #outputs button, #tool-outputs button").forEach((control) => {
    const off = !mine || (control.id === "move" && !aimed);
    if (control.disabled !== off && control !== held) control.disabled = off;
  });
  $("move").textContent = held === $("move") ? "Moving: let go to stop" : !mine ? "Take control to move" : !aimed ? "Set a target first" : "Hold to move";
  $("twin").hidden = $("twin-key").hidden = state.twin === null;
  if (state.twin !== null) {
    if ($("twin").textContent !== state.twin.text) $("twin").textContent = state.twin.text;
    $("twin").classList.toggle("parted", state.twin.parted);
  }
  if (now === null) return;
  pill("robot", now.robot, now.robot === "ENABLE" ? "good" : "warn");
  pill("program", now.program, now.program === "STOPPED" ? "" : "on");
  pill("safety", now.safety, /^STOP|FAIL|ERROR/.test(now.safety) ? "bad" : "good");
  pill("mode", now.mode, "");
  pill("moving", now.moving === null ? "NOT TOLD" : now.moving ? "MOVING" : "STANDS", now.moving === null ? "warn" : now.moving ? "on" : "good");
  now.joints.forEach((angle, index) => {
    const row = jogRows[index], low = hello ? hello.lower[index] : -6.28, high = hello ? hello.upper[index] : 6.28;
    row.value.textContent = `${fixed(angle === null ? null : angle * DEGREE, 2)}°`;
    row.rate.textContent = fixed(now.speeds[index] === null ? null : now.speeds[index] * DEGREE, 1);
    const at = Math.min(1, Math.max(0, (angle - low) / (high - low))), zero = Math.min(1, Math.max(0, -low / (high - low)));
    row.fill.style.left = `${100 * Math.min(at, zero)}%`;
    row.fill.style.width = `${Math.max(1.5, 100 * Math.abs(at - zero))}%`;
    row.fill.parentElement.classList.toggle("near", at < 0.05 || at > 0.95);
  });
  now.pose.forEach((value, index) => { jogRows[6 + index].value.textContent = value === null ? "–" : index < 3 ? `${fixed(value * 1000, 1)} mm` : `${fixed(value * DEGREE, 2)}°`; });
  light($("inputs"), now.inputs, lamp); light($("tool-inputs"), now.tool_inputs, lamp);
  light($("outputs"), now.outputs, switchOf(false)); light($("tool-outputs"), now.tool_outputs, switchOf(true));
}

function showSeldom() {
  $("arm").textContent = seldom.arm || (hello ? hello.model : "");
  $("project").textContent = seldom.project || "none";
  $("speed").textContent = seldom.speed === null || seldom.speed === undefined ? "–" : `${fixed(seldom.speed, 0)} %`;
  $("watchers").textContent = seldom.pages === 1 ? "1 page is open" : `${seldom.pages || 0} pages are open`;
}

function showMeasured(message) { $("measured-tool").textContent = message.tool; $("measured-load").textContent = message.load; }

function showEvent(line) {
  const list = $("events"), item = document.createElement("li"), at = document.createElement("time"), text = document.createElement("span");
  at.textContent = line.at; text.textContent = line.text; text.className = line.severity;
  item.append(at, text);
  list.prepend(item);
  while (list.childElementCount > 200) list.lastChild.remove();
}

// -- plots of the last minute -----------------------------------------------------------------------

const PLOTS = {speeds: {from: 1, count: 6, scale: DEGREE, least: 5, digits: 1}, tool: {from: 7, count: 1, scale: 1000, least: 20, digits: 0}, force: {from: 8, count: 1, scale: 1, least: 10, digits: 1}, late: {from: 9, count: 1, scale: DEGREE, least: 0.5, digits: 2}};
// Told when they change: to ask for them would have the whole page laid out at once.
const sizes = new Map();
const resized = new ResizeObserver((entries) => { for (const each of entries) sizes.set(each.target, [each.contentRect.width, each.contentRect.height]); });
function plot(canvas) {
  const {from, count, scale, least, digits} = PLOTS[canvas.dataset.plot], ratio = window.devicePixelRatio || 1;
  const [width, height] = sizes.get(canvas) || [0, 0];
  if (!width || !height) return;
  if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
  if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
  // Drawn by the processor: where the graphics are made in software, long lines held up the page for
  // seconds, and with it the stop's button.
  const draw = canvas.getContext("2d", {willReadFrequently: true});
  draw.setTransform(ratio, 0, 0, ratio, 0, 0);
  draw.clearRect(0, 0, width, height);
  let low = 0, high = least;
  for (const point of history) for (let i = from; i < from + count; i++) if (point[i] !== null) { low = Math.min(low, point[i] * scale); high = Math.max(high, point[i] * scale); }
  const end = state === null ? (history.length ? history[history.length - 1][0] : 0) : state.now;
  const x = (time) => width * (1 - (end - time) / MINUTE), y = (value) => height - 2 - (height - 14) * (value - low) / (high - low);
  draw.strokeStyle = "#2a3644"; draw.lineWidth = 1;
  draw.beginPath(); draw.moveTo(0, y(0)); draw.lineTo(width, y(0)); draw.stroke();
  draw.fillStyle = "#8b9aab"; draw.font = "10px system-ui, sans-serif"; draw.fillText(high.toFixed(high < 2 ? 1 : 0), 2, 10);
  draw.lineWidth = 1.5;
  for (let i = from; i < from + count; i++) {
    draw.strokeStyle = COLOURS[i - from]; draw.beginPath();
    // Of the points within a pixel the one that is furthest from the last: a peak is not left out.
    let pen = false, before = 0, column = -1, far = null;
    const put = () => { if (far === null) return; if (pen) draw.lineTo(far[0], far[1]); else draw.moveTo(far[0], far[1]); pen = true; before = far[1]; far = null; };
    for (const point of history) {
      if (point[i] === null) { put(); pen = false; continue; }
      const px = x(point[0]), py = y(point[i] * scale);
      if (Math.floor(px) !== column) { put(); column = Math.floor(px); }
      if (far === null || Math.abs(py - before) > Math.abs(far[1] - before)) far = [px, py];
    }
    put();
    draw.stroke();
  }
  const last = history[history.length - 1];
  if (last && count === 1) $(`p-${canvas.dataset.plot}`).textContent = last[from] === null ? "–" : (last[from] * scale).toFixed(digits);
}
// One after the other, each five times a second: all at once would hold up the page, and its stop.
const plots = [...document.querySelectorAll("[data-plot]")];
let turn = 0;
plots.forEach((canvas) => resized.observe(canvas));
setInterval(() => { if (!document.hidden) plot(plots[turn++ % plots.length]); }, 200 / plots.length);

connect();
