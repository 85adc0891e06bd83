// The page of the live chain: settings, time, and pictures on canvases. The chain is in chain.js.
const root = [...document.querySelectorAll(".live")].at(-1);
const { law, second: UNIT, presets, block: BLOCK } =
  JSON.parse(document.querySelector(".live-settings").textContent);
const part = (selector) => root.querySelector(selector);
const inputs = [...root.querySelectorAll("[data-set]")];
const stage = part(".live-stage"), play = part('[data-do="play"]'), speed = part('[data-set="speed"]');
const panels = Object.fromEntries([...root.querySelectorAll("[data-panel]")].map((canvas) =>
  [canvas.dataset.panel, canvas]));

const APART = 1e-6; // between the two chains at the start
const BUDGET = 12; // milliseconds of a picture that steps may take
const TRACE = 2048; // samples that are drawn: 205 units of time, 16 s in real time
const COILS = 7, STRONG = 60, MARKS = 100, BELT = 96, GAP = 18;
const QUIET = 0.5; // seconds between two pictures of the section and the spectrum
const still = matchMedia("(prefers-reduced-motion: reduce)");

const view = { settings: {}, records: [], distance: [], playing: false, last: 0, owed: 0, drawn: 0, slow: 1, note: 0 };

// --- settings: in the controls, and in the link -------------------------------------------------

function read() {
  return Object.fromEntries(inputs.map((input) =>
    [input.dataset.set, input.type === "range" ? Number(input.value) : input.value]));
}

function show(settings) {
  for (const input of inputs) {
    const value = settings[input.dataset.set];
    if (value === undefined) continue;
    input.value = value;
    if (!input.value) input.selectedIndex = 0; // a value that the list lacks
  }
}

function label() {
  for (const input of inputs) {
    const output = input.parentElement.querySelector("output");
    if (output) output.textContent = `= ${input.value}`;
  }
}

const toHash = (settings) =>
  `#live?${Object.entries(settings).map(([name, value]) => `${name}=${value}`).join("&")}`;

function fromHash() {
  const [name, rest] = location.hash.split("?");
  return name === "#live" && rest ? Object.fromEntries(new URLSearchParams(rest)) : null;
}

// --- the chains ---------------------------------------------------------------------------------

function begin() {
  label();
  const settings = read(), preset = presets.find((one) => one.name === view.preset);
  const setup = { blocks: settings.n, velocity: settings.u, noise: settings.sigma, ratio: settings.f };
  const chains = [new Chain(setup, law)];
  const other = presets.find((one) => one.start);
  if (settings.second === "apart") {
    const positions = chains[0].positions();
    positions[0] += APART;
    chains.push(new Chain(setup, law, { positions }));
  } else if (settings.second === "branch") {
    const fits = settings.n === other.start.positions.length;
    chains.push(new Chain(setup, law, fits ? moved(other, settings.u) : {}));
  }
  Object.assign(view, { settings, distance: [], owed: 0, slow: 1, drawn: 0 });
  view.records = chains.map((chain) => new Record(chain));
  view.visible = 1.3 * balanceLength(setup.blocks, setup.ratio, law);
  root.classList.toggle("pair", chains.length > 1);
  part(".live-words").textContent = preset ? preset.words : chosen(settings);
  part(".live-level").textContent = view.records[0].level;
  for (const button of root.querySelectorAll("[data-preset]")) {
    button.setAttribute("aria-pressed", button.dataset.preset === view.preset);
  }
  draw(true);
}

const chosen = ({ n, u, sigma }) => `Blocks: ${n}. Belt velocity: ${u}. ${sigma ? `Noise: ${sigma}.` : "No noise."}`;

// The start on the low branch; its blocks that are stuck move with this belt.
function moved({ start, settings }, velocity) {
  return { positions: start.positions,
    velocities: start.velocities.map((v) => (v === settings.u ? velocity : v)) };
}

function choose(name) {
  const preset = presets.find((one) => one.name === name);
  view.preset = name;
  show(preset.settings);
  begin();
  for (const record of view.records) record.advance(Math.round((preset.ahead || 0) / DT));
  draw(true);
  remember();
}

// The link in the address bar; not where the page is read from a place that refuses it.
function remember() {
  if (fromHash() || view.touched) try { history.replaceState(null, "", toHash(read())); } catch { /* a frame */ }
}

// --- time ---------------------------------------------------------------------------------------

// Steps of all chains in small pieces, so that the distance is noted, at most for BUDGET.
function advance(steps) {
  const started = performance.now(), [first, second] = view.records, piece = first.every;
  let left = steps;
  while (left > 0) {
    const count = Math.min(left, piece - first.chain.steps % piece);
    for (const record of view.records) record.advance(count);
    left -= count;
    if (second && first.chain.steps % piece === 0) note(first.chain, second.chain);
    if (performance.now() - started > BUDGET) break;
  }
  return steps - left;
}

function note(one, other) {
  const last = one.count - 1;
  view.distance.push(Math.abs(one.x(last) - other.x(last)));
  if (view.distance.length > 8 * TRACE) view.distance = view.distance.filter((_, i) => i >= 4 * TRACE);
}

function tick(now) {
  if (!view.playing) return;
  const passed = view.last ? Math.min((now - view.last) / 1000, 0.1) : 0;
  view.last = now;
  view.owed += Number(speed.value) * passed / UNIT / DT;
  if (!still.matches || now - view.drawn > 1000) {
    const wanted = Math.floor(view.owed), done = advance(wanted);
    view.slow = 0.95 * view.slow + 0.05 * (wanted ? done / wanted : 1);
    view.owed -= wanted; // what is not done in time is not caught up
    draw(now - view.note > 1000 * QUIET);
    if (now - view.note > 1000 * QUIET) view.note = now;
    view.drawn = now;
  }
  requestAnimationFrame(tick);
}

function run(on) {
  view.playing = on;
  play.textContent = on ? "Pause" : "Play";
  root.dataset.playing = on;
  view.last = 0;
  if (on) requestAnimationFrame(tick);
}

// --- pictures -----------------------------------------------------------------------------------

// A canvas of the size at which it is shown, cleared, in units of CSS pixels.
function sheet(canvas, height = canvas.clientHeight) {
  const width = canvas.clientWidth, scale = devicePixelRatio || 1, pen = canvas.getContext("2d");
  if (canvas.width !== Math.round(width * scale) || canvas.height !== Math.round(height * scale)) {
    canvas.width = Math.round(width * scale);
    canvas.height = Math.round(height * scale);
    if (canvas === stage) canvas.style.height = `${height}px`;
  }
  pen.restore(); // what clipped the last picture
  pen.save();
  pen.setTransform(scale, 0, 0, scale, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = "12px system-ui, sans-serif";
  return { pen, width, height };
}

let colours = {};
function readColours() {
  const style = getComputedStyle(root);
  colours = new Proxy({}, { get: (_, name) => style.getPropertyValue(`--live-${name}`).trim() });
  colours = Object.fromEntries(["ink", "soft", "line", "ground", "belt", "mark", "stuck-colour", "slip-colour",
    "second-colour", "pull", "press"].map((name) => [name, colours[name]]));
}

function draw(all = false) {
  const { records } = view;
  drawStage();
  drawTrace();
  if (records.length > 1) drawDistance();
  if (all) {
    readColours();
    drawSection();
    drawSpectrum();
    say();
  }
  const speedNow = view.slow < 0.9 ? `, only ${(view.slow * Number(speed.value)).toFixed(1)} × on this machine` : "";
  part(".live-clock").textContent = `t = ${records[0].chain.time.toFixed(1)},  ${said()}${speedNow}`;
}

function said() {
  const [{ spread, transient }] = view.records;
  if (spread.count < 100) return `r from t = ${Math.round(transient)} on`;
  return `r = ${view.records.map((record) => record.spread.r.toFixed(4)).join(" and ")}`;
}

function say() {
  const { n, u } = view.settings;
  stage.setAttribute("aria-label", `Chain of ${n} blocks on a belt of velocity ${u}. ${said()}`);
}

function drawStage() {
  const { records, visible } = view;
  const { pen, width } = sheet(stage, records.length * (BELT + GAP) + 4);
  const across = (length) => 8 + (width - 12) * length / visible;
  records.forEach(({ chain }, number) => {
    pen.save();
    pen.translate(0, number * (BELT + GAP) + GAP);
    drawBelt(pen, across, chain, width);
    let left = 0;
    for (let i = 0; i < chain.count; i++) {
      const here = chain.x(i);
      drawSpring(pen, across(left + (i ? BLOCK / 2 : 0)), across(here - BLOCK / 2), here - left - law.rest_length);
      drawBlock(pen, across, here, chain, i);
      left = here;
    }
    pen.restore();
  });
}

function drawBelt(pen, across, chain, width) {
  pen.fillStyle = colours.belt;
  pen.fillRect(8, 0, width - 12, BELT);
  pen.strokeStyle = colours.mark;
  pen.lineWidth = 1.5;
  pen.beginPath();
  for (let place = (chain.setup.velocity * chain.time) % MARKS; across(place) < width - 4; place += MARKS) {
    pen.moveTo(across(place), 0);
    pen.lineTo(across(place), BELT);
  }
  pen.stroke();
  pen.fillStyle = colours.soft;
  pen.fillRect(2, 0, 6, BELT);
}

// Colour and form: a stuck block is a full square, one that slips is open and has an arrow.
function drawBlock(pen, across, place, chain, i) {
  const side = Math.max(across(BLOCK) - across(0), 10), x = across(place), top = BELT / 2 - side / 2;
  const direction = chain.direction[i], last = i === chain.count - 1;
  pen.fillStyle = pen.strokeStyle = colours[direction ? "slip-colour" : "stuck-colour"];
  pen.lineWidth = 3;
  if (!direction) pen.fillRect(x - side / 2, top, side, side);
  pen.strokeRect(x - side / 2, top, side, side);
  if (last) {
    pen.fillStyle = colours.ground;
    pen.fillRect(x - side / 2 + 4, top + 4, side - 8, side - 8);
  }
  if (direction) {
    pen.fillStyle = colours["slip-colour"];
    pen.beginPath();
    pen.moveTo(x + 8 * direction, top - 11);
    pen.lineTo(x - 5 * direction, top - 17);
    pen.lineTo(x - 5 * direction, top - 5);
    pen.fill();
  }
}

function drawSpring(pen, begin, end, deformation) {
  const lead = 0.12 * (end - begin), coil = (end - begin - 2 * lead) / (2 * COILS), middle = BELT / 2;
  const share = Math.min(Math.abs(deformation) / STRONG, 1);
  pen.strokeStyle = mixed(colours.soft, colours[deformation < 0 ? "press" : "pull"], share);
  pen.lineWidth = 1.2 + 1.3 * share;
  pen.beginPath();
  pen.moveTo(begin, middle);
  pen.lineTo(begin + lead, middle);
  for (let turn = 0; turn < 2 * COILS; turn++) {
    pen.lineTo(begin + lead + (turn + 0.5) * coil, middle + (turn % 2 ? 8 : -8));
  }
  pen.lineTo(end - lead, middle);
  pen.lineTo(end, middle);
  pen.stroke();
}

function mixed(one, other, share) {
  const parts = (colour) => [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
  const from = parts(one), to = parts(other);
  return `rgb(${from.map((value, i) => Math.round(value + (to[i] - value) * share))})`;
}

// --- diagrams -----------------------------------------------------------------------------------

// Axes with a few numbers; returns the pen and maps from values to pixels.
function diagram(canvas, horizontal, vertical) {
  const { pen, width, height } = sheet(canvas);
  const box = { left: 52, right: width - 8, top: 8, bottom: height - 34 };
  const across = scale(horizontal, box.left, box.right), up = scale(vertical, box.bottom, box.top);
  pen.strokeStyle = colours.line;
  pen.fillStyle = colours.soft;
  pen.lineWidth = 1;
  pen.strokeRect(box.left, box.top, box.right - box.left, box.bottom - box.top);
  for (const value of ticks(horizontal, 5)) {
    pen.textAlign = "center";
    pen.fillText(written(value, horizontal), across(value), box.bottom + 14);
  }
  for (const value of ticks(vertical, 4)) {
    pen.textAlign = "right";
    pen.fillText(written(value, vertical), box.left - 5, up(value) + 4);
  }
  pen.textAlign = "center";
  pen.fillText(horizontal.label, (box.left + box.right) / 2, height - 5);
  pen.save();
  pen.translate(11, (box.top + box.bottom) / 2);
  pen.rotate(-Math.PI / 2);
  pen.fillText(vertical.label, 0, 0);
  pen.restore();
  pen.beginPath();
  pen.rect(box.left, box.top, box.right - box.left, box.bottom - box.top);
  return { pen, across, up };
}

function scale({ range: [low, high], log }, from, to) {
  const map = log ? Math.log10 : (value) => value, begin = map(low), span = map(high) - begin || 1;
  return (value) => from + (to - from) * (map(value) - begin) / span;
}

function ticks({ range: [low, high], log }, count) {
  if (log) {
    const first = Math.ceil(Math.log10(low)), last = Math.floor(Math.log10(high));
    const each = Math.max(1, Math.ceil((last - first) / count));
    return Array.from({ length: Math.floor((last - first) / each) + 1 }, (_, i) => 10 ** (first + i * each));
  }
  const raw = (high - low) / count, power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].find((one) => one * power >= raw) * power, values = [];
  for (let value = Math.ceil(low / step) * step; value <= high; value += step) values.push(value);
  return values;
}

function written(value, { log }) {
  if (!log) return String(Number(value.toPrecision(6)));
  const digits = "⁰¹²³⁴⁵⁶⁷⁸⁹", power = Math.round(Math.log10(value));
  return `10${power < 0 ? "⁻" : ""}${[...String(Math.abs(power))].map((one) => digits[one]).join("")}`;
}

function line(pen, colour, xs, ys) {
  pen.strokeStyle = colour;
  pen.lineWidth = 1.3;
  pen.beginPath();
  xs.forEach((x, i) => (i ? pen.lineTo(x, ys[i]) : pen.moveTo(x, ys[i])));
  pen.stroke();
}

const inks = () => [colours.ink, colours["second-colour"]];

function drawTrace() {
  const series = view.records.map((record) => record.latest(TRACE));
  const { interval, chain } = view.records[0], end = Math.max(chain.time, TRACE * interval);
  const values = series.flatMap((one) => [...one]);
  const range = values.length ? padded(values) : [0, view.visible];
  const { pen, across, up } = diagram(panels.trace,
    { range: [end - TRACE * interval, end], label: "time" }, { range, label: "position" });
  pen.clip();
  series.forEach((one, number) => {
    const from = chain.time - one.length * interval;
    line(pen, inks()[number], Array.from(one, (_, i) => across(from + i * interval)), Array.from(one, up));
  });
}

function drawDistance() {
  const { distance, records: [{ interval, chain }] } = view, every = Math.ceil(distance.length / 600);
  const { pen, across, up } = diagram(panels.distance,
    { range: [Math.max(0, chain.time - distance.length * interval), Math.max(chain.time, 50)], label: "time" },
    { range: [1e-8, 1e3], log: true, label: "distance" });
  pen.clip();
  const shown = distance.map((value, i) => [i, Math.max(value, 1e-9)]).filter(([i]) => i % every === 0);
  line(pen, colours["second-colour"],
    shown.map(([i]) => across(chain.time - (distance.length - i) * interval)), shown.map(([, value]) => up(value)));
}

function drawSection() {
  const sections = view.records.map((record) => record.section), values = sections.flat();
  const axis = { range: values.length > 1 ? padded(values) : [-view.settings.u, 0] };
  const { pen, across, up } = diagram(panels.section,
    { ...axis, label: "at one fall" }, { ...axis, label: "at the next" });
  pen.clip();
  sections.forEach((section, number) => {
    pen.fillStyle = inks()[number];
    for (let i = 1; i < section.length; i++) pen.fillRect(across(section[i - 1]) - 1, up(section[i]) - 1, 2.4, 2.4);
  });
}

function drawSpectrum() {
  const { pen, across, up } = diagram(panels.spectrum,
    { range: [1e-3, 2], log: true, label: "frequency (1 / unit of time)" }, { range: [1e-4, 1e3], log: true, label: "amplitude" });
  pen.clip();
  view.records.forEach((record, number) => {
    const size = 2 ** Math.floor(Math.log2(record.latest().length || 1));
    if (size < 512) return;
    const shown = amplitudes(record.latest(size)), base = 1 / (size * record.interval);
    line(pen, inks()[number], Array.from(shown, (_, k) => across(base * (k + 1))), Array.from(shown, up));
  });
}

function padded(values) {
  let low = Infinity, high = -Infinity;
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  const room = 0.05 * (high - low) || 1;
  return [low - room, high + room];
}

// --- controls -----------------------------------------------------------------------------------

function changeSpeed(by) {
  const next = speed.selectedIndex + by;
  if (next >= 0 && next < speed.options.length) speed.selectedIndex = next;
  remember();
}

const keys = { " ": () => run(!view.playing), r: begin, "+": () => changeSpeed(1), "-": () => changeSpeed(-1) };

root.addEventListener("keydown", (event) => {
  const action = keys[event.key.toLowerCase()], at = event.target;
  if (!action || event.ctrlKey || event.metaKey || event.altKey) return;
  if (at.matches("select") || (event.key === " " && at.matches("button"))) return;
  event.preventDefault();
  action();
});
for (const input of inputs) {
  input.addEventListener("input", () => {
    view.touched = true;
    if (input !== speed) {
      view.preset = null;
      begin();
    }
    remember();
  });
}
for (const { name, title } of presets) {
  const button = Object.assign(document.createElement("button"), { type: "button", textContent: title });
  button.dataset.preset = name;
  button.addEventListener("click", () => {
    view.touched = true;
    choose(name);
  });
  part(".live-presets").append(button);
}
play.addEventListener("click", () => run(!view.playing));
part('[data-do="restart"]').addEventListener("click", begin);
part('[data-do="link"]').addEventListener("click", async (event) => {
  const link = location.href.split("#")[0] + toHash(read());
  try {
    await navigator.clipboard.writeText(link);
    event.target.textContent = "Link copied";
  } catch {
    prompt("Link to these settings", link);
  }
});

function open() {
  const linked = fromHash();
  if (!linked) return choose(presets[0].name);
  view.preset = null;
  show({ ...presets[0].settings, ...linked });
  begin();
}

addEventListener("hashchange", () => fromHash() && open());
new ResizeObserver(() => view.records.length && draw(true)).observe(root);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => draw(true));
root.hidden = false;
root.tabIndex = 0;
readColours();
open();
// It moves while it is in view, unless the reader asked for less motion.
let paused = still.matches;
play.addEventListener("click", () => { paused = !view.playing; });
new IntersectionObserver(([entry]) => run(entry.isIntersecting && !paused)).observe(stage);
