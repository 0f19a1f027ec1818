// Alarms over time, a lane for each condition.
function drawLanes(u, intervals, lane) {
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
}
// The worst alarm at the cursor; undefined if there is none.
function alarmAt(u, { lanes, intervals }) {
  const t = u.posToVal(u.cursor.left, "x");
  const row = lanes.length - 1 - Math.floor(u.posToVal(u.cursor.top, "y"));
  const near = (4 / u.over.clientWidth) * (u.scales.x.max - u.scales.x.min);
  const found = intervals.filter((item) =>
    item.lane === row && item.start - near <= t && t <= item.end + near);
  return found.sort((a, b) => b.severity - a.severity)[0];
}
const alarmWords = (item, { lanes, severities }) =>
  `${lanes[item.lane]}, ${severities[Math.min(item.severity, 3)]}, ` +
  `${clock(item.start)} to ${clock(item.end)}: ${item.message}`;

function severityKey(place, severities) {
  const key = make("p", "", place);
  key.className = "ramp";
  [1, 2, 3, 0].forEach((severity) => {
    const dot = make("b", "■", key);
    dot.style.color = colour(`s${severity}`);
    make("span", severities[severity], key);
  });
}
function alarmChart() {
  const place = document.getElementById("chart-alarms"), { alarms } = report, names = alarms.lanes;
  heading(place, "Alarms", "", names.length ? "by condition; the colour tells the severity" : "none");
  if (!names.length) return;
  const told = notice("Point at an alarm to read it.", place);
  const lane = (i) => names.length - 1 - i + 0.5;
  const u = new uPlot({
    width, height: 70 + 26 * names.length, legend: { show: false },
    series: [{}, { show: false }],
    scales: { x: { time: false, range: () => zoomed || whole }, y: { range: () => [0, names.length] } },
    axes: [timeAxis(), axis({
      splits: () => names.map((_, i) => lane(i)), values: () => names, size: width < 500 ? 110 : 130,
      grid: { show: false },
    })],
    cursor: { sync: { key: "run" }, drag: { x: true, y: false, setScale: false }, y: false },
    hooks: {
      setSelect: [selected],
      draw: [(u) => drawLanes(u, alarms.intervals, lane)],
      setCursor: [(u) => {
        if (!(u.cursor.left >= 0) || !(u.cursor.top >= 0) || !u.over.matches(":hover")) return;
        const item = alarmAt(u, alarms);
        if (item) told.textContent = alarmWords(item, alarms);
      }],
    },
  }, [whole, [null, null]], place);
  place.append(told);
  severityKey(place, alarms.severities);
  finish(u, place, () => false);
}
