// Load against slip: where the drive ran, and what the model says of this belt.
const RAMP_STEPS = 32;

function mix(share) {
  const parse = (name) => [1, 3, 5].map((i) => parseInt(colour(name).slice(i, i + 2), 16));
  const stops = ["t0", "t1", "t2"].map(parse);
  const place = Math.min(Math.max(share, 0), 1) * 2, i = Math.min(Math.floor(place), 1);
  return stops[i].map((v, k) => Math.round(v + (stops[i + 1][k] - v) * (place - i)));
}
const curveInk = (k) => (k === 0 ? "c1" : "h1");

// Loads and slips at which the drive ran, on a grid.
function loadCells(load) {
  const cells = {};
  for (const key of ["column", "row", "count", "time"]) cells[key] = unpack(load[key]);
  const at = new Map();
  cells.column.forEach((c, i) => at.set(c * load.rows + cells.row[i], i));
  const size = [(load.torque[1] - load.torque[0]) / load.columns, (load.slip[1] - load.slip[0]) / load.rows];
  const ramp = Array.from({ length: RAMP_STEPS + 1 }, (_, i) => mix(i / RAMP_STEPS).join(","));
  return { ...cells, at, size, ramp, most: Math.max(1, ...cells.count) };
}
function drawCells(u, load, cells) {
  const { ctx, bbox } = u, { size } = cells, least = 4 * devicePixelRatio;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  for (let i = 0; i < cells.count.length; i++) {
    const x = load.torque[0] + cells.column[i] * size[0], y = load.slip[0] + cells.row[i] * size[1];
    const left = u.valToPos(x, "x", true), right = u.valToPos(x + size[0], "x", true);
    const bottom = u.valToPos(y, "y", true), top = u.valToPos(y + size[1], "y", true);
    const dark = 0.45 + 0.55 * Math.log1p(cells.count[i]) / Math.log1p(cells.most);
    const age = Math.round(RAMP_STEPS * Math.min(cells.time[i] / whole[1], 1));
    ctx.fillStyle = `rgba(${cells.ramp[age]},${dark})`;
    ctx.fillRect(left, top, Math.max(right - left, least), Math.max(bottom - top, least));
  }
  ctx.restore();
}
// What is to be said of the cell at the cursor, or of one beside it; undefined if there is none.
function cellWords(u, load, cells) {
  const { size } = cells;
  const c = Math.floor((u.posToVal(u.cursor.left, "x") - load.torque[0]) / size[0]);
  const r = Math.floor((u.posToVal(u.cursor.top, "y") - load.slip[0]) / size[1]);
  for (const [dc, dr] of [[0, 0], [0, 1], [0, -1], [1, 0], [-1, 0]]) {
    const i = cells.at.get((c + dc) * load.rows + r + dr);
    if (i === undefined) continue;
    return `${plain(load.torque[0] + (c + dc + 0.5) * size[0])} N m, slip ` +
      `${plain(load.slip[0] + (r + dr + 0.5) * size[1])} %: ${cells.count[i]} measurements, ` +
      `on average at ${clock(cells.time[i])}`;
  }
}

// Columns of the model's curves, and how each is drawn. Before each curve stand those of its band.
function modelPlan(load) {
  const grid = load.curves.length ? Array.from(unpack(load.curves[0].torque)) : load.torque;
  const data = [grid], bands = [];
  const series = [{ label: "load", value: (_, v) => (v === null ? "–" : `${plain(v)} N m`) }];
  const beyond = 100 * load.slip[1];
  load.curves.forEach((curve, k) => {
    const ink = curveInk(k), first = series.length, low = column(curve.low);
    const high = Array.from(unpack(curve.high), (v, i) => (low[i] === null ? null : Math.min(v, beyond)));
    data.push(high, low, column(curve.slip));
    bands.push({ series: [first, first + 1], fill: () => faded(ink, 0.18) });
    const helper = { width: 0, points: { show: false }, label: "" };
    series.push({ ...helper }, { ...helper }, {
      label: `model ${curve.when}`, stroke: () => colour(ink), width: 2, points: { show: false },
      value: (u, v) => modelWords(u, v, first, beyond),
    });
  });
  if (!load.curves.length) { data.push([null, null]); series.push({ show: false, label: "" }); }
  return { data, series, bands };
}
function modelWords(u, value, first, beyond) {
  const i = u.cursor.idx;
  if (value === null || value === undefined || i === null || i === undefined) return "–";
  const top = u.data[first][i], bottom = u.data[first + 1][i], half = (top - bottom) / 2;
  if (top >= beyond) return `${rounded(value, value / 10)} % (may slip)`;
  return `${rounded(value, half)} (95 % ${range(bottom, top)}) %`;
}
function drawCapacity(u, curve, k) {
  const { ctx, bbox } = u, right = bbox.left + bbox.width, ink = curveInk(k);
  const inside = (v) => Math.min(Math.max(u.valToPos(v, "x", true), bbox.left), right);
  const x = u.valToPos(curve.capacity, "x", true);
  ctx.save();
  ctx.fillStyle = faded(ink, 0.08);
  const [from, to] = curve.capacity_interval.map(inside);
  ctx.fillRect(from, bbox.top, to - from, bbox.height);
  if (x >= bbox.left && x <= right) {
    ctx.strokeStyle = ctx.fillStyle = colour(ink);
    ctx.lineWidth = 1.5 * devicePixelRatio;
    ctx.setLineDash([7 * devicePixelRatio, 4 * devicePixelRatio]);
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    nameCapacity(u, curve, ink, x, bbox.top + (18 + 20 * k) * devicePixelRatio);
  }
  ctx.restore();
}
function nameCapacity(u, curve, ink, x, base) {
  const { ctx } = u, error = curve.capacity_stddev, end = x - 6 * devicePixelRatio;
  const text = `capacity ${rounded(curve.capacity, error)} ± ${rounded(error, error)} N m`;
  ctx.font = `${12 * devicePixelRatio}px system-ui, sans-serif`;
  ctx.textAlign = "right";
  const long = ctx.measureText(text).width;
  ctx.fillStyle = faded("paper", 0.8);
  ctx.fillRect(end - long - 4, base - 13 * devicePixelRatio, long + 8, 17 * devicePixelRatio);
  ctx.fillStyle = colour(ink);
  ctx.fillText(text, end, base);
}

function loadAxes() {
  const named = { labelSize: 18, labelFont: "12px system-ui, sans-serif", values: tick };
  return [
    axis({ ...named, label: "load: torque on the driven pulley [N m]", size: 34 }),
    axis({ ...named, label: "slip [%]", size: 50 }),
  ];
}
function rampKey(place) {
  const key = make("p", "", place);
  key.className = "ramp";
  key.setAttribute("aria-label", "colour of the cells");
  make("span", "start of the run", key);
  make("i", "", key);
  make("span", "its end", key);
}
function loadChart() {
  const place = document.getElementById("chart-load"), load = report.load;
  heading(place, "Slip over load", "% over N m", "");
  const cells = loadCells(load), { data, series, bands } = modelPlan(load);
  const told = notice("Point at a cell to read it.", place);
  let part = {}; // limits of what is zoomed to
  const u = new uPlot({
    width, height: Math.max(300, Math.min(440, width * 0.6)), series, bands, axes: loadAxes(),
    scales: {
      x: { time: false, range: () => part.x || load.torque },
      y: { range: () => part.y || load.slip },
    },
    cursor: { drag: { x: true, y: true, uni: 20, setScale: false } },
    hooks: {
      drawClear: [(u) => drawCells(u, load, cells)],
      draw: [(u) => load.curves.forEach((curve, k) => drawCapacity(u, curve, k))],
      setSelect: [(u) => {
        const { left, top, width: w, height: h } = u.select;
        if (w < 4 || h < 4) return;
        part = {
          x: [u.posToVal(left, "x"), u.posToVal(left + w, "x")],
          y: [u.posToVal(top + h, "y"), u.posToVal(top, "y")],
        };
        u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
        u.setScale("x", {});
        u.redraw(true, true);
      }],
      setCursor: [(u) => {
        const said = u.cursor.left >= 0 && cellWords(u, load, cells);
        if (said) told.textContent = said;
      }],
    },
  }, data, place);
  u.root.querySelectorAll(".u-series").forEach((row, i) => row.classList.toggle("helper", i > 0 && i % 3 !== 0));
  u.ctx.canvas.setAttribute("aria-hidden", "true");
  u.over.addEventListener("dblclick", () => { part = {}; u.redraw(true, true); });
  place.append(told);
  rampKey(place);
  return u;
}
