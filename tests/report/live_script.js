// Works the live chain as a reader would, in a page that it is appended to, and writes what it saw.
const seen = { errors: [] };
addEventListener("error", (event) => seen.errors.push(event.message));
addEventListener("unhandledrejection", (event) => seen.errors.push(String(event.reason)));
const root = document.querySelector(".live"), part = (selector) => root.querySelector(selector);
const set = (name, value) => {
  const input = part(`[data-set="${name}"]`);
  input.value = value;
  input.dispatchEvent(new Event("input", { bubbles: true }));
};
const press = (key) => root.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
const time = () => Number(/t = ([0-9.]+)/.exec(part(".live-clock").textContent)[1]);
const wait = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));
const play = part('[data-do="play"]');

async function work() {
  seen.linked = ["n", "u", "sigma", "f", "speed"].map((name) => part(`[data-set="${name}"]`).value);
  if (play.textContent === "Play") play.click();
  for (let tries = 0; tries < 100 && time() <= 5; tries += 1) await wait(100);
  seen.played = time();
  play.click();
  const before = time();
  await wait(100);
  seen.stood = time() === before;
  press("r");
  seen.restarted = time();
  press("-");
  seen.keys = [play.textContent];
  press(" ");
  seen.keys.push(play.textContent);
  press(" ");
  seen.keys.push(part('[data-set="speed"]').value);
  const buttons = [...root.querySelectorAll("[data-preset]")];
  seen.presets = buttons.map((button) => {
    button.click();
    return part(".live-words").textContent;
  });
  seen.pairs = buttons.map((button) => {
    button.click();
    return root.classList.contains("pair");
  });
  set("n", 7);
  seen.link = location.hash;
  play.click();
  await wait(300);
  play.click();
  seen.drawn = [...root.querySelectorAll("canvas")].filter((canvas) => canvas.clientWidth).map((canvas) =>
    [...canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.filter((_, i) => i % 997 === 3)]);
  const shown = (one) => one.offsetParent !== null;
  seen.small = [...root.querySelectorAll("button, select")].filter(shown).map((one) => one.getBoundingClientRect().height);
  seen.names = [...root.querySelectorAll("button, select, input")].map((one) =>
    (one.getAttribute("aria-label") || one.textContent || one.labels[0].textContent).trim());
  seen.overflow = root.scrollWidth - root.clientWidth;
  seen.requests = performance.getEntriesByType("resource").map((one) => one.name);
}

work().catch((error) => seen.errors.push(String(error))).finally(() => {
  const place = document.createElement("pre");
  place.id = "seen";
  place.textContent = JSON.stringify(seen);
  document.documentElement.replaceChildren(place);
});
