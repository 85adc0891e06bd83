// Plays recorded motions of the chain: positions at equal intervals of time, read from the page.
(() => {
  "use strict";
  const root = document.getElementById("player");
  const find = (name) => root.querySelector(`[data-part="${name}"]`);
  const [stage, strip, play, scrub, speed, clock, words] =
    ["stage", "strip", "play", "scrub", "speed", "clock", "words"].map(find);
  const motions = JSON.parse(document.getElementById("player-data").textContent).map(decoded);
  const still = matchMedia("(prefers-reduced-motion: reduce)");

  const BLOCK = 28.6, COILS = 7, STRONG = 60, BELT_MARKS = 100; // model lengths; see player.html.j2
  const HEIGHT = { stage: 120, strip: 130 }, EDGE = { left: 44, right: 12, top: 10, bottom: 22 };
  const LONGEST_GAP = 0.25; // seconds between two pictures after which time is not caught up
  let motion, frame, playing = false, last = 0, held = 0;

  // --- data ---

  function decoded(told) {
    const bytes = Uint8Array.from(atob(told.positions), (letter) => letter.charCodeAt(0));
    const view = new DataView(bytes.buffer);
    const position = (row, block) =>
      told.low + told.step * view.getUint16(2 * (row * told.n_blocks + block), true);
    return { ...told, position, last: told.samples - 1 };
  }

  // Positions at a frame, which may lie between two samples.
  function places(at) {
    const row = Math.min(Math.floor(at), motion.last - 1), share = at - row;
    return Array.from({ length: motion.n_blocks }, (_, block) =>
      (1 - share) * motion.position(row, block) + share * motion.position(row + 1, block));
  }

  function signs(at) {
    const row = Math.floor(at), begin = row * motion.n_blocks;
    return motion.signs.slice(begin, begin + motion.n_blocks);
  }

  const time = (at) => motion.begin + motion.interval * at;

  // --- picture ---

  function element(parent, name, attributes) {
    const made = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    return parent.appendChild(made);
  }

  let artists = {};

  // What does not move, and the elements that do; again when the motion or the width changes.
  function compose() {
    const width = Math.max(root.clientWidth, 240);
    for (const [svg, height] of [[stage, HEIGHT.stage], [strip, HEIGHT.strip]]) {
      svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
      svg.replaceChildren();
    }
    const x = (length) => 8 + (width - 16) * length / motion.visible;
    element(stage, "rect", { class: "belt", x: 8, y: 14, width: width - 16, height: 92 });
    element(stage, "rect", { class: "wall", x: 2, y: 14, width: 6, height: 92 });
    const marks = element(stage, "path", { class: "marks" });
    const each = (name, shape) =>
      Array.from({ length: motion.n_blocks }, () => element(stage, name, { class: shape }));
    const springs = each("path", "spring"), blocks = each("rect", "block"), tops = each("path", "sign");
    blocks.at(-1).classList.add("last");
    artists = { x, marks, springs, blocks, tops, ...composeStrip(width) };
    draw();
  }

  function composeStrip(width) {
    const [low, high] = motion.range, inner = width - EDGE.left - EDGE.right;
    const foot = HEIGHT.strip - EDGE.bottom;
    const across = (at) => EDGE.left + inner * at / motion.last;
    const up = (length) => foot - (foot - EDGE.top) * (length - low) / (high - low);
    const text = (words, attributes) => { element(strip, "text", attributes).textContent = words; };
    for (const length of [low, (low + high) / 2, high]) {
      element(strip, "path", { class: "grid", d: `M${EDGE.left} ${up(length)}h${inner}` });
      text(Math.round(length), { x: EDGE.left - 6, y: up(length) + 4, "text-anchor": "end" });
    }
    for (const share of [0, 0.5, 1]) {
      const anchor = ["start", "middle", "end"][2 * share];
      const at = share * motion.last;
      text(Math.round(time(at)), { x: across(at), y: HEIGHT.strip - 6, "text-anchor": anchor });
    }
    const points = [];
    for (let row = 0; row <= motion.last; row++) {
      const length = motion.position(row, motion.n_blocks - 1);
      points.push(`${across(row).toFixed(1)} ${up(length).toFixed(1)}`);
    }
    element(strip, "path", { class: "curve", d: `M${points.join("L")}` });
    const cursor = element(strip, "path", { class: "cursor" });
    const dot = element(strip, "circle", { class: "dot", r: 4.5 });
    return { across, up, cursor, dot };
  }

  function draw() {
    const { x, marks, springs, blocks, tops, across, up, cursor, dot } = artists;
    const now = places(frame), state = signs(frame), width = x(BLOCK) - x(0);
    now.forEach((place, block) => {
      const slips = state[block] !== "s", middle = x(place);
      blocks[block].setAttribute("x", middle - width / 2);
      blocks[block].setAttribute("y", 36);
      blocks[block].setAttribute("width", width);
      blocks[block].setAttribute("height", 58);
      blocks[block].classList.toggle("slips", slips);
      tops[block].setAttribute("d", signPath(state[block], middle));
      tops[block].classList.toggle("slips", slips);
      const begin = block ? now[block - 1] + BLOCK / 2 : 0, end = place - BLOCK / 2;
      springs[block].setAttribute("d", springPath(x(begin), x(end)));
      springs[block].style.stroke = springColour(place - (block ? now[block - 1] : 0) - motion.rest);
    });
    const moved = motion.u * time(frame) % BELT_MARKS;
    const lines = [];
    for (let place = moved; place < motion.visible; place += BELT_MARKS) lines.push(`M${x(place)} 14v92`);
    marks.setAttribute("d", lines.join(""));
    const at = across(frame);
    cursor.setAttribute("d", `M${at} ${EDGE.top}V${HEIGHT.strip - EDGE.bottom}`);
    dot.setAttribute("cx", at);
    dot.setAttribute("cy", up(now.at(-1)));
    const said = `t = ${time(frame).toFixed(1)}`;
    clock.textContent = said;
    scrub.value = Math.round(frame);
    scrub.setAttribute("aria-valuetext", said);
  }

  function signPath(state, x) {
    if (state === "s") return `M${x - 4} 21h8v8h-8z`;
    const way = state === "<" ? -1 : 1;
    return `M${x + 5 * way} 25l${-9 * way} -5.5v11z`;
  }

  function springPath(begin, end) {
    const lead = 0.12 * (end - begin), coil = (end - begin - 2 * lead) / (2 * COILS);
    const turns = Array.from({ length: 2 * COILS }, (_, turn) =>
      `L${begin + lead + (turn + 0.5) * coil} ${65 + (turn % 2 ? 9 : -9)}`);
    return `M${begin} 65H${begin + lead}${turns.join("")}L${end - lead} 65H${end}`;
  }

  // From violet (compressed) over light grey to green (stretched).
  function springColour(deformation) {
    const share = Math.min(Math.abs(deformation) / STRONG, 1);
    const full = deformation < 0 ? [181, 123, 255] : [34, 196, 139];
    return `rgb(${full.map((part) => Math.round(232 + (part - 232) * share))})`;
  }

  // --- time ---

  function show(at) {
    frame = Math.max(0, Math.min(motion.last, at));
    draw();
  }

  function run(on) {
    if (on && frame >= motion.last) show(0);
    playing = on;
    play.textContent = on ? "Pause" : "Play";
    root.dataset.playing = on;
    last = 0;
    if (on) requestAnimationFrame(tick);
  }

  function tick(now) {
    if (!playing) return;
    const passed = last ? Math.min((now - last) / 1000, LONGEST_GAP) : 0;
    last = now;
    held += passed * Number(speed.value) / motion.second / motion.interval;
    // those who asked for less motion see a picture a second instead
    const due = !still.matches || held >= Number(speed.value) / motion.second / motion.interval;
    if (due) {
      show(frame + held);
      held = 0;
    }
    if (frame >= motion.last) run(false);
    else requestAnimationFrame(tick);
  }

  function step(frames) {
    run(false);
    show(Math.round(frame) + frames);
  }

  function change(by) {
    const next = speed.selectedIndex + by;
    if (next >= 0 && next < speed.options.length) speed.selectedIndex = next;
  }

  function choose(number) {
    run(false);
    motion = motions[number];
    scrub.max = motion.last;
    frame = motion.still;
    held = 0;
    words.textContent = motion.words;
    stage.setAttribute("aria-label", `Chain of ${motion.n_blocks} blocks on the belt. ${motion.words}`);
    speed.value = motion.speed;
    compose();
  }

  // --- controls ---

  const keys = {
    " ": () => run(!playing), k: () => run(!playing),
    ArrowLeft: (event) => step(event.shiftKey ? -10 : -1),
    ArrowRight: (event) => step(event.shiftKey ? 10 : 1),
    Home: () => step(-motion.last), End: () => step(motion.last),
    "+": () => change(1), "-": () => change(-1),
  };
  // Controls keep the keys that they have by themselves.
  const own = (target, key) =>
    target.matches("select, [type=radio]") || (target.matches("button") && key === " ")
    || (target.matches("[type=range]") && key.length > 1);

  root.addEventListener("keydown", (event) => {
    const action = keys[event.key];
    if (!action || own(event.target, event.key) || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    action(event);
  });
  play.addEventListener("click", () => run(!playing));
  find("back").addEventListener("click", () => step(-1));
  find("forward").addEventListener("click", () => step(1));
  scrub.addEventListener("input", () => { run(false); show(Number(scrub.value)); });
  for (const radio of root.querySelectorAll("[type=radio]")) {
    radio.addEventListener("change", () => choose(Number(radio.value)));
  }
  // A finger or the mouse on the curve goes to that instant.
  function drag(event) {
    if (event.type === "pointermove" && !strip.hasPointerCapture(event.pointerId)) return;
    if (event.type === "pointerdown") {
      if (event.isPrimary && event.pointerId) try { strip.setPointerCapture(event.pointerId); } catch { /* gone */ }
      run(false);
    }
    const box = strip.getBoundingClientRect();
    const scale = strip.viewBox.baseVal.width / box.width;
    const inner = strip.viewBox.baseVal.width - EDGE.left - EDGE.right;
    show(Math.round(motion.last * ((event.clientX - box.left) * scale - EDGE.left) / inner));
  }
  strip.addEventListener("pointerdown", drag);
  strip.addEventListener("pointermove", drag);
  new ResizeObserver(() => compose()).observe(root);

  choose(0);
  root.hidden = false;
})();
