// The part of the run that all charts over time show, and how mouse, keys and fingers choose it.
const KEY_ZOOM = 1.5, KEY_PAN = 0.2;
const whole = [0, report.end || 1];
let charts = []; // over time
let zoomed = null; // [start, end] in s, or null for the whole run

function zoom(limits) {
  if (limits) {
    const span = Math.min(limits[1] - limits[0], whole[1]);
    if (!(span > whole[1] * 1e-7)) return;
    const start = Math.min(Math.max(limits[0], 0), whole[1] - span);
    zoomed = span >= whole[1] * 0.9999 ? null : [start, start + span];
  } else zoomed = null;
  const [min, max] = zoomed || whole;
  for (const u of charts) u.setScale("x", { min, max });
}
function zoomAbout(centre, factor) {
  const [min, max] = zoomed || whole;
  zoom([centre - (centre - min) / factor, centre + (max - centre) / factor]);
}

function keys(event) {
  const [min, max] = zoomed || whole;
  const step = KEY_PAN * (max - min);
  const moves = {
    "+": () => zoomAbout((min + max) / 2, KEY_ZOOM),
    "=": () => zoomAbout((min + max) / 2, KEY_ZOOM),
    "-": () => zoomAbout((min + max) / 2, 1 / KEY_ZOOM),
    ArrowLeft: () => zoom([min - step, max - step]),
    ArrowRight: () => zoom([min + step, max + step]),
    Home: () => zoom(null),
  };
  if (!moves[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
  event.preventDefault();
  moves[event.key]();
}

// Fingers: one reads, two zoom.
function fingers(u) {
  const down = new Map();
  let before = null;
  const spread = () => {
    const [a, b] = [...down.values()];
    return { width: Math.max(Math.abs(a - b), 10), middle: (a + b) / 2 };
  };
  const place = (event) => event.clientX - u.over.getBoundingClientRect().left;
  u.over.addEventListener("pointerdown", (event) => {
    if (event.pointerType !== "touch") return;
    down.set(event.pointerId, place(event));
    before = down.size === 2 ? spread() : null;
  });
  u.over.addEventListener("pointermove", (event) => {
    if (!down.has(event.pointerId)) return;
    down.set(event.pointerId, place(event));
    if (down.size === 1) u.setCursor({ left: place(event), top: 10 });
    if (down.size !== 2 || !before) return;
    const now = spread();
    zoomAbout(u.posToVal(now.middle, "x"), now.width / before.width);
    before = now;
  });
  for (const end of ["pointerup", "pointercancel"])
    u.over.addEventListener(end, (event) => { down.delete(event.pointerId); before = null; });
}

function selected(u) {
  if (u.select.width < 4) return;
  const limits = [u.select.left, u.select.left + u.select.width].map((x) => u.posToVal(x, "x"));
  u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
  zoom(limits);
}
function finish(u, place, isHelper) {
  u.root.querySelectorAll(".u-series").forEach((row, i) => row.classList.toggle("helper", isHelper(row, i)));
  u.over.addEventListener("dblclick", () => zoom(null));
  u.ctx.canvas.setAttribute("aria-hidden", "true");
  fingers(u);
  place.onkeydown = keys;
  charts.push(u);
}
