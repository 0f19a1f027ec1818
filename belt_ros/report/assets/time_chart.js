// A chart over time: curves with bands, limits, and alarms behind them.
const distributions = { log: { distr: 3 }, asinh: { distr: 4 } };

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
