"use strict";
// Draws the charts of a report. The numbers stand in the element #data; texts of the report go
// into the page as text, never as markup.
(() => {
  const report = JSON.parse(document.getElementById("data").textContent);
  const SIGMAS_95 = 1.96;
  const FLOATS = { f4: Float32Array, f8: Float64Array, u2: Uint16Array, u4: Uint32Array };
  const KEY_ZOOM = 1.5, KEY_PAN = 0.2, PRINT_WIDTH = 680;

  const unpack = ({ type, bytes }) =>
    new FLOATS[type](Uint8Array.from(atob(bytes), (c) => c.charCodeAt(0)).buffer);
  const column = (packed) => Array.from(unpack(packed), (v) => (Number.isFinite(v) ? v : null));
  const colour = (name) =>
    getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  const faded = (name, alpha) => // colours have six digits
    colour(name) + Math.round(255 * alpha).toString(16).padStart(2, "0");
  const make = (kind, text, parent) => {
    const element = document.createElement(kind);
    element.textContent = text;
    if (parent) parent.append(element);
    return element;
  };

  // Numbers: rounded by half the width of their interval, with a true minus sign.
  const signed = (text) => (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "−");
  const decimalsFor = (half) =>
    Math.min(Math.max(half > 0 ? 1 - Math.floor(Math.log10(half)) : 4, 0), 9);
  const rounded = (value, half) => signed(value.toFixed(decimalsFor(half)));
  const plain = (value) => signed(String(Number(value.toPrecision(4))));
  const range = (low, high) => {
    const half = (high - low) / 2;
    return `${rounded(low, half)} to ${rounded(high, half)}`;
  };
  // Times from a thousand seconds on are read as hours, minutes and seconds.
  const LONG = 1000;
  const hours = (t, decimals = 0) => {
    const past = Math.floor(t), rest = decimals ? (t - past).toFixed(decimals).slice(1) : "";
    const two = (v) => String(v).padStart(2, "0");
    return `${Math.floor(past / 3600)}:${two(Math.floor((past % 3600) / 60))}:${two(past % 60)}${rest}`;
  };
  const clock = (t) => (t < LONG ? `${t.toFixed(2)} s` : `${hours(t)} h`);

  // The curves of each source, unpacked once.
  const sources = {};
  for (const [name, source] of Object.entries(report.sources)) {
    const curves = {};
    for (const [key, packed] of Object.entries(source.curves)) {
      const curve = { least: column(packed.least), low: column(packed.low), high: column(packed.high) };
      curve.greatest = packed.greatest ? column(packed.greatest) : curve.least;
      curve.middle = packed.greatest
        ? curve.least.map((v, i) => (v === null ? null : (v + curve.greatest[i]) / 2))
        : curve.least;
      curves[key] = curve;
    }
    sources[name] = { time: Array.from(unpack(source.time)), every: source.every, curves };
  }

  let mode = "filtered";
  let charts = [];
  let zoomed = null; // [start, end] in s, or null for the whole run
  let width = 0;
  const whole = [0, report.end || 1];

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

  const axis = (more) => ({
    stroke: () => colour("soft"),
    grid: { stroke: () => colour("line"), width: 1 },
    ticks: { stroke: () => colour("line"), width: 1 },
    font: "12px system-ui, sans-serif",
    ...more,
  });
  // Ticks of a logarithmic scale: 1, 2, 3, 5 or 7 of each power of ten that is seen.
  function even(low, high) {
    const step = 10 ** Math.floor(Math.log10((high - low) / 2)), found = [];
    for (let i = Math.ceil(low / step); i * step <= high; i++) found.push(i * step);
    return found.filter((_, i) => i % Math.ceil(found.length / 6) === 0);
  }
  function powers(_u, _axis, low, high) {
    const ratio = high / low, found = [];
    if (ratio < 2) return even(low, high);
    for (let k = Math.floor(Math.log10(low)); k <= Math.log10(high); k++)
      for (const m of ratio > 30 ? [1, 3] : [1, 2, 3, 5, 7]) {
        const v = m * 10 ** k;
        if (v >= low && v <= high) found.push(v);
      }
    return found;
  }
  // Ticks of a scale that is straight about zero, and logarithmic beyond one.
  function bothWays(_u, _axis, low, high) {
    if (high - low < 2) return even(low, high);
    const up = [1, 3, 10, 30, 100, 300];
    return [...up.map((v) => -v).reverse(), 0, ...up].filter((v) => v >= low && v <= high);
  }
  const tick = (_, values) => values.map((v) => (v === null ? "" : plain(v)));
  const STEPS = [60, 120, 300, 600, 1200, 1800, 3600, 7200, 10800, 21600, 43200, 86400, 172800, 432000];
  const fineSteps = [-4, -3, -2, -1, 0].flatMap((k) => [1, 2, 5].map((m) => Number(`${m}e${k}`)));
  const timeAxis = () => axis({
    labelSize: 18, labelFont: "12px system-ui, sans-serif", size: 34,
    ...(whole[1] < LONG
      ? { values: tick, label: "time [s]" }
      : {
        incrs: [...fineSteps, 10, 20, 30, ...STEPS, ...STEPS.map((v) => v * 14)], space: 80,
        values: (_u, values, _axis, _space, step) =>
          values.map((v) => hours(v, step < 1 ? Math.ceil(-Math.log10(step)) : 0)),
        label: "time [h:min:s]",
      }),
  });

  function shadeAlarms(u) {
    const { ctx, bbox } = u;
    for (const { severity, start, end } of report.alarms.intervals) {
      if (!severity) continue;
      const left = Math.max(u.valToPos(start, "x", true), bbox.left);
      const right = Math.min(u.valToPos(end, "x", true), bbox.left + bbox.width);
      if (right < bbox.left || left > bbox.left + bbox.width) continue;
      ctx.fillStyle = faded(`s${Math.min(severity, 3)}`, 0.07);
      ctx.fillRect(left, bbox.top, Math.max(right - left, 1), bbox.height);
    }
  }
  function drawLimits(u, limits) {
    const { ctx, bbox } = u;
    ctx.save();
    ctx.lineWidth = devicePixelRatio;
    ctx.setLineDash([6 * devicePixelRatio, 4 * devicePixelRatio]);
    for (const { value, severity } of limits) {
      const y = u.valToPos(value, "y", true);
      if (y < bbox.top || y > bbox.top + bbox.height) continue;
      ctx.strokeStyle = colour(`s${severity}`);
      ctx.beginPath();
      ctx.moveTo(bbox.left, y);
      ctx.lineTo(bbox.left + bbox.width, y);
      ctx.stroke();
    }
    ctx.restore();
  }

  // Tables of a chart's columns, and how each is drawn. Helpers are bands about a curve.
  function plan(chart) {
    const shown = mode === "both" ? ["filtered", "smoothed"] : [mode];
    const tables = [], series = [{ label: "time", value: (_, v) => (v === null ? "–" : clock(v)) }];
    const bands = [], mains = [];
    for (const name of shown) {
      const source = sources[name], table = [source.time];
      const hue = name === "smoothed" && mode === "both" ? "h" : "c";
      chart.series.forEach((told, place) => {
        const curve = source.curves[told.name], ink = `${hue}${place + 1}`;
        const first = series.length, helper = { show: told.shown, width: 0, points: { show: false } };
        series.push({ ...helper, label: "" }, { ...helper, label: "" });
        table.push(curve.high, curve.low);
        bands.push({ series: [first, first + 1], fill: () => faded(ink, 0.2) });
        if (!source.every) {
          const edge = { ...helper, stroke: () => colour(ink), width: 1, label: "" };
          series.push({ ...edge }, { ...edge });
          table.push(curve.greatest, curve.least);
          bands.push({ series: [first + 2, first + 3], fill: () => faded(ink, 0.75) });
        }
        const main = series.length;
        mains.push({ main, first, curve, told });
        series.push({
          label: told.label + (shown.length > 1 && name === "smoothed" ? ", hindsight" : ""),
          show: told.shown, stroke: () => colour(ink), width: source.every ? 1.5 : 0, points: { show: false },
          dash: told.name === "predicted_creep" ? [5, 4] : undefined,
          value: (u, v) => words(u, v, main, first, source.every, chart),
        });
        table.push(curve.middle);
      });
      tables.push(table);
    }
    return { data: tables.length > 1 ? uPlot.join(tables) : tables[0], series, bands, mains };
  }
  function words(u, value, main, first, every, chart) {
    const i = u.cursor.idx;
    if (value === null || value === undefined || i === null || i === undefined) return "–";
    const high = u.data[first][i], low = u.data[first + 1][i], unit = ` ${chart.unit}`;
    if (!every) {
      const most = u.data[first + 2][i], least = u.data[first + 3][i];
      return `${range(least, most)}, 95 % ${range(low, high)}${unit}`;
    }
    const log = chart.scale === "log", half = (high - low) / 2;
    if (log) return `${rounded(value, half)} (95 % ${range(low, high)})${unit}`;
    return `${rounded(value, half / SIGMAS_95)} ± ${rounded(half / SIGMAS_95, half / SIGMAS_95)}${unit}`;
  }

  // The ordinate fits what is seen: all values, and nine tenths of the bands.
  function fit(chart, mains) {
    return (u) => {
      const [from, to] = u.series[0].idxs || [0, u.data[0].length - 1];
      const step = Math.max(1, Math.floor((to - from) / 3000));
      let low = Infinity, high = -Infinity;
      for (const { main, first } of mains) {
        if (!u.series[main].show) continue;
        const tops = [], bottoms = [];
        for (let i = from; i <= to; i += step) {
          const value = u.data[main][i];
          if (value === null || value === undefined) continue;
          low = Math.min(low, value);
          high = Math.max(high, value);
          tops.push(u.data[first][i]);
          bottoms.push(u.data[first + 1][i]);
        }
        if (!tops.length) continue;
        tops.sort((a, b) => a - b);
        bottoms.sort((a, b) => a - b);
        high = Math.max(high, tops[Math.floor(0.9 * (tops.length - 1))]);
        low = Math.min(low, bottoms[Math.ceil(0.1 * (bottoms.length - 1))]);
      }
      if (!(low <= high)) return chart.scale === "log" ? [1, 10] : [0, 1];
      if (chart.scale === "log") {
        const floor = Math.max(low, high * 1e-6, 1e-12), reach = Math.max(high, floor);
        return [floor / 1.08, reach * 1.08];
      }
      const pad = 0.06 * (high - low) || Math.abs(high) * 0.05 || 1;
      low -= pad;
      high += pad;
      if (chart.floor !== undefined) low = Math.max(low, chart.floor);
      if (chart.ceiling !== undefined) high = Math.min(high, chart.ceiling);
      return high > low ? [low, high] : [low - 1, low + 1];
    };
  }

  function heading(place, title, unit, note) {
    place.replaceChildren();
    const head = make("h3", title, place);
    make("span", ` ${unit ? `[${unit}]` : ""}${note ? ` ${note}` : ""}`, head);
    place.tabIndex = 0;
    place.setAttribute("role", "group");
    place.setAttribute("aria-label", `${title}${unit ? ` in ${unit}` : ""}, chart`);
  }

  const distributions = { log: { distr: 3 }, asinh: { distr: 4 } };

  function timeChart(chart) {
    const place = document.getElementById(`chart-${chart.id}`);
    heading(place, chart.title, chart.unit, chart.note);
    const { data, series, bands, mains } = plan(chart);
    const scale = { ...(distributions[chart.scale] || {}), range: fit(chart, mains) };
    if (chart.scale === "asinh") scale.asinh = chart.linear;
    const u = new uPlot({
      width, height: 210, series, bands, legend: { markers: { width: 2 } },
      scales: { x: { time: false, range: () => zoomed || whole }, y: scale },
      axes: [timeAxis(), axis({
        values: tick, size: 56,
        ...(chart.scale ? {
          splits: chart.scale === "log" ? powers : bothWays, filter: (_, values) => values,
        } : {}),
      })],
      cursor: { sync: { key: "run" }, drag: { x: true, y: false, setScale: false }, y: false },
      hooks: {
        drawClear: [shadeAlarms],
        draw: [(u) => drawLimits(u, chart.limits)],
        setSelect: [selected],
        setSeries: [(u, i, told) => {
          const found = mains.find(({ main }) => main === i);
          if (!found || told.show === undefined) return;
          for (let k = found.first; k < found.main; k++) u.setSeries(k, { show: told.show }, false);
        }],
      },
    }, data, place);
    finish(u, place, (row, i) => i > 0 && !mains.some(({ main }) => main === i));
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

  function alarmChart() {
    const place = document.getElementById("chart-alarms");
    const { lanes: names, intervals, severities } = report.alarms;
    heading(place, "Alarms", "", names.length ? "by condition; the colour tells the severity" : "none");
    if (!names.length) return;
    const told = make("p", "Point at an alarm to read it.", place);
    told.className = "told";
    told.setAttribute("role", "status");
    const lane = (i) => names.length - 1 - i + 0.5;
    const narrow = width < 500;
    const u = new uPlot({
      width, height: 70 + 26 * names.length, legend: { show: false },
      series: [{}, { show: false }],
      scales: { x: { time: false, range: () => zoomed || whole }, y: { range: () => [0, names.length] } },
      axes: [timeAxis(), axis({
        splits: () => names.map((_, i) => lane(i)), values: () => names, size: narrow ? 110 : 130,
        grid: { show: false },
      })],
      cursor: { sync: { key: "run" }, drag: { x: true, y: false, setScale: false }, y: false },
      hooks: {
        setSelect: [selected],
        draw: [(u) => {
          const { ctx, bbox } = u, thickness = 16 * devicePixelRatio;
          ctx.save();
          ctx.beginPath();
          ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
          ctx.clip();
          for (const item of intervals) {
            const left = u.valToPos(item.start, "x", true), right = u.valToPos(item.end, "x", true);
            const y = u.valToPos(lane(item.lane), "y", true);
            const high = item.severity ? thickness : thickness / 4;
            ctx.fillStyle = colour(`s${Math.min(item.severity, 3)}`);
            ctx.fillRect(left, y - high / 2, Math.max(right - left, 2 * devicePixelRatio), high);
          }
          ctx.restore();
        }],
        setCursor: [(u) => {
          if (!(u.cursor.left >= 0) || !(u.cursor.top >= 0) || !u.over.matches(":hover")) return;
          const t = u.posToVal(u.cursor.left, "x");
          const row = names.length - 1 - Math.floor(u.posToVal(u.cursor.top, "y"));
          const near = (4 / u.over.clientWidth) * (u.scales.x.max - u.scales.x.min);
          const found = intervals.filter((item) =>
            item.lane === row && item.start - near <= t && t <= item.end + near);
          const item = found.sort((a, b) => b.severity - a.severity)[0];
          if (item) told.textContent =
            `${names[item.lane]}, ${severities[Math.min(item.severity, 3)]}, ` +
            `${clock(item.start)} to ${clock(item.end)}: ${item.message}`;
        }],
      },
    }, [whole, [null, null]], place);
    place.append(told);
    const key = make("p", "", place);
    key.className = "ramp";
    [1, 2, 3, 0].forEach((severity) => {
      const dot = make("b", "■", key);
      dot.style.color = colour(`s${severity}`);
      make("span", severities[severity], key);
    });
    finish(u, place, () => false);
  }

  function mix(share) {
    const parse = (name) => [1, 3, 5].map((i) => parseInt(colour(name).slice(i, i + 2), 16));
    const stops = ["t0", "t1", "t2"].map(parse);
    const place = Math.min(Math.max(share, 0), 1) * 2, i = Math.min(Math.floor(place), 1);
    return stops[i].map((v, k) => Math.round(v + (stops[i + 1][k] - v) * (place - i)));
  }

  function loadChart() {
    const place = document.getElementById("chart-load"), load = report.load;
    heading(place, "Slip over load", "% over N m", "");
    const cells = {};
    for (const key of ["column", "row", "count", "time"]) cells[key] = unpack(load[key]);
    const most = Math.max(1, ...cells.count);
    const at = new Map();
    cells.column.forEach((c, i) => at.set(c * load.rows + cells.row[i], i));
    const size = [(load.torque[1] - load.torque[0]) / load.columns, (load.slip[1] - load.slip[0]) / load.rows];
    const ramp = Array.from({ length: 33 }, (_, i) => mix(i / 32).join(","));
    let axes2 = { x: null, y: null };
    const grid = load.curves.length ? Array.from(unpack(load.curves[0].torque)) : load.torque;
    const data = [grid], series = [{ label: "load", value: (_, v) => (v === null ? "–" : `${plain(v)} N m`) }], bands = [];
    load.curves.forEach((curve, k) => {
      const ink = k === 0 ? "c1" : "h1", first = series.length;
      const beyond = 100 * load.slip[1];
      const low = column(curve.low);
      data.push(Array.from(unpack(curve.high), (v, i) => (low[i] === null ? null : Math.min(v, beyond))));
      data.push(low, column(curve.slip));
      bands.push({ series: [first, first + 1], fill: () => faded(ink, 0.18) });
      const helper = { width: 0, points: { show: false }, label: "" };
      series.push({ ...helper }, { ...helper }, {
        label: `model ${curve.when}`, stroke: () => colour(ink), width: 2, points: { show: false },
        value: (u, v) => {
          const i = u.cursor.idx;
          if (v === null || v === undefined || i === null || i === undefined) return "–";
          const top = u.data[first][i], bottom = u.data[first + 1][i];
          const half = (top - bottom) / 2;
          return top >= beyond ? `${rounded(v, v / 10)} % (may slip)` : `${rounded(v, half)} (95 % ${range(bottom, top)}) %`;
        },
      });
    });
    if (!load.curves.length) { data.push([null, null]); series.push({ show: false, label: "" }); }
    const told = make("p", "Point at a cell to read it.", place);
    told.className = "told";
    told.setAttribute("role", "status");
    const u = new uPlot({
      width, height: Math.max(300, Math.min(440, width * 0.6)), series, bands,
      scales: {
        x: { time: false, range: () => axes2.x || load.torque },
        y: { range: () => axes2.y || load.slip },
      },
      axes: [
        axis({ label: "load: torque on the driven pulley [N m]", labelSize: 18, labelFont: "12px system-ui, sans-serif", size: 34, values: tick }),
        axis({ label: "slip [%]", labelSize: 18, labelFont: "12px system-ui, sans-serif", values: tick, size: 50 }),
      ],
      cursor: { drag: { x: true, y: true, uni: 20, setScale: false } },
      hooks: {
        drawClear: [(u) => {
          const { ctx, bbox } = u;
          ctx.save();
          ctx.beginPath();
          ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
          ctx.clip();
          for (let i = 0; i < cells.count.length; i++) {
            const x = load.torque[0] + cells.column[i] * size[0], y = load.slip[0] + cells.row[i] * size[1];
            const left = u.valToPos(x, "x", true), right = u.valToPos(x + size[0], "x", true);
            const bottom = u.valToPos(y, "y", true), top = u.valToPos(y + size[1], "y", true);
            const dark = 0.45 + 0.55 * Math.log1p(cells.count[i]) / Math.log1p(most);
            ctx.fillStyle = `rgba(${ramp[Math.round(32 * Math.min(cells.time[i] / whole[1], 1))]},${dark})`;
            const least = 4 * devicePixelRatio;
            ctx.fillRect(left, top, Math.max(right - left, least), Math.max(bottom - top, least));
          }
          ctx.restore();
        }],
        draw: [(u) => load.curves.forEach((curve, k) => capacity(u, curve, k === 0 ? "c1" : "h1", k))],
        setSelect: [(u) => {
          const { left, top, width: w, height: h } = u.select;
          if (w < 4 || h < 4) return;
          axes2 = {
            x: [u.posToVal(left, "x"), u.posToVal(left + w, "x")],
            y: [u.posToVal(top + h, "y"), u.posToVal(top, "y")],
          };
          u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
          u.setScale("x", {});
          u.redraw(true, true);
        }],
        setCursor: [(u) => {
          if (!(u.cursor.left >= 0)) return;
          const c = Math.floor((u.posToVal(u.cursor.left, "x") - load.torque[0]) / size[0]);
          const r = Math.floor((u.posToVal(u.cursor.top, "y") - load.slip[0]) / size[1]);
          for (const [dc, dr] of [[0, 0], [0, 1], [0, -1], [1, 0], [-1, 0]]) {
            const i = at.get((c + dc) * load.rows + r + dr);
            if (i === undefined) continue;
            told.textContent =
              `${plain(load.torque[0] + (c + dc + 0.5) * size[0])} N m, slip ` +
              `${plain(load.slip[0] + (r + dr + 0.5) * size[1])} %: ${cells.count[i]} measurements, ` +
              `on average at ${clock(cells.time[i])}`;
            return;
          }
        }],
      },
    }, data, place);
    u.root.querySelectorAll(".u-series").forEach((row, i) => row.classList.toggle("helper", i > 0 && i % 3 !== 0));
    u.ctx.canvas.setAttribute("aria-hidden", "true");
    u.over.addEventListener("dblclick", () => { axes2 = { x: null, y: null }; u.redraw(true, true); });
    place.append(told);
    const key = make("p", "", place);
    key.className = "ramp";
    key.setAttribute("aria-label", "colour of the cells");
    make("span", "start of the run", key);
    make("i", "", key);
    make("span", "its end", key);
    return u;
  }
  function capacity(u, curve, ink, order) {
    const { ctx, bbox } = u, right = bbox.left + bbox.width;
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
      ctx.font = `${12 * devicePixelRatio}px system-ui, sans-serif`;
      ctx.textAlign = "right";
      const error = curve.capacity_stddev;
      const text = `capacity ${rounded(curve.capacity, error)} ± ${rounded(error, error)} N m`;
      const end = x - 6 * devicePixelRatio, base = bbox.top + (18 + 20 * order) * devicePixelRatio;
      const long = ctx.measureText(text).width;
      ctx.fillStyle = faded("paper", 0.8);
      ctx.fillRect(end - long - 4, base - 13 * devicePixelRatio, long + 8, 17 * devicePixelRatio);
      ctx.fillStyle = colour(ink);
      ctx.fillText(text, end, base);
    }
    ctx.restore();
  }

  let loadPicture = null;
  function build(wide) {
    for (const u of charts) u.destroy();
    if (loadPicture) loadPicture.destroy();
    charts = [];
    width = wide || Math.max(document.querySelector("#time").clientWidth, 280);
    report.charts.forEach(timeChart);
    alarmChart();
    loadPicture = loadChart();
    document.querySelectorAll("[data-mode]").forEach((button) =>
      button.setAttribute("aria-pressed", String(button.dataset.mode === mode)));
  }

  document.querySelectorAll("[data-mode]").forEach((button) =>
    button.addEventListener("click", () => { mode = button.dataset.mode; build(); }));
  document.getElementById("whole").addEventListener("click", () => zoom(null));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => build());
  addEventListener("beforeprint", () => build(PRINT_WIDTH));
  addEventListener("afterprint", () => build());
  let waiting = 0;
  addEventListener("resize", () => {
    clearTimeout(waiting);
    waiting = setTimeout(() => {
      if (Math.abs(document.querySelector("#time").clientWidth - width) > 1) build();
    }, 150);
  });
  build();
  document.documentElement.dataset.ready = "yes";
})();
