// Axes and their ticks.
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
