// Works the player as a reader would, in a page that it is appended to, and writes what it saw.
const seen = { errors: [] };
addEventListener("error", (event) => seen.errors.push(event.message));
addEventListener("unhandledrejection", (event) => seen.errors.push(String(event.reason)));
for (const name of ["error", "warn"]) {
  console[name] = (...words) => seen.errors.push(words.join(" "));
}
const root = document.getElementById("player");
const part = (name) => root.querySelector(`[data-part="${name}"]`);
const [play, scrub, speed, clock, stage, strip] =
  ["play", "scrub", "speed", "clock", "stage", "strip"].map(part);
const frame = () => Number(scrub.value);
const time = () => Number(clock.textContent.replace("t = ", ""));
const press = (key, target = stage, more = {}) =>
  target.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true, ...more }));
const places = () => [...root.querySelectorAll(".block")].map((block) =>
  Number(block.getAttribute("x")) + Number(block.getAttribute("width")) / 2);
const slipping = () => [...root.querySelectorAll(".block")].map((b) => b.classList.contains("slips"));
const wait = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));
const scrubTo = (value) => { scrub.value = value; scrub.dispatchEvent(new Event("input", { bubbles: true })); };

async function work() {
  seen.hidden = root.hidden;
  seen.motions = [];
  const radios = [...root.querySelectorAll("[type=radio]")];
  for (const radio of radios) {
    radio.click();
    const motion = { still: frame(), last: Number(scrub.max), speed: speed.value, pictures: [] };
    for (const at of [0, 17, motion.last]) {
      scrubTo(at);
      motion.pictures.push({ frame: frame(), time: time(), places: places(), slipping: slipping(),
        dot: [Number(root.querySelector(".dot").getAttribute("cx")), Number(root.querySelector(".dot").getAttribute("cy"))] });
    }
    motion.width = Number(stage.getAttribute("viewBox").split(" ")[2]);
    motion.words = part("words").textContent;
    seen.motions.push(motion);
  }
  scrubTo(20);
  press("ArrowRight"); seen.right = frame();
  press("ArrowLeft", stage, { shiftKey: true }); seen.left = frame();
  press("End"); seen.end = frame();
  press("Home"); seen.home = frame();
  const before = speed.value;
  press("+"); seen.faster = [before, speed.value];
  press("-"); press("-"); seen.slower = speed.value;
  press("x"); press("ArrowRight", stage, { ctrlKey: true }); seen.other = frame();
  part("forward").click(); seen.forward = frame();
  part("back").click(); seen.back = frame();

  const box = strip.getBoundingClientRect();
  strip.dispatchEvent(new PointerEvent("pointerdown", {
    clientX: box.left + box.width / 2, clientY: box.top + 10, bubbles: true, isPrimary: true, pointerType: "touch" }));
  seen.touched = frame() / Number(scrub.max);

  speed.value = "4";
  scrubTo(0);
  press(" "); seen.pressed = play.textContent;
  const began = performance.now();
  await wait(700);
  seen.played = frame();
  seen.seconds = (performance.now() - began) / 1000;
  play.click(); seen.paused = play.textContent;
  const stopped = frame();
  await wait(200);
  seen.stood = frame() === stopped;
  scrubTo(Number(scrub.max) - 5);
  play.click();
  await wait(500);
  seen.stopped = [play.textContent, frame() === Number(scrub.max)];
  play.click(); seen.again = frame() < 50; play.click();

  seen.names = [...root.querySelectorAll("button, select, input, svg")].map((each) =>
    (each.getAttribute("aria-label") || each.textContent
      || (each.labels && each.labels[0] && each.labels[0].textContent) || "").trim());
  seen.small = [...root.querySelectorAll("button, select, .choice")].map((each) =>
    Math.min(each.getBoundingClientRect().height, each.getBoundingClientRect().width));
  seen.overflow = root.scrollWidth - root.clientWidth;
  seen.requests = performance.getEntriesByType("resource").map((each) => each.name);
}

work().catch((error) => seen.errors.push(error.stack)).then(() => {
  const result = document.createElement("pre");
  result.id = "seen";
  result.textContent = JSON.stringify(seen);
  document.body.append(result);
});
