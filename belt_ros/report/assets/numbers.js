// Numbers and times as they are written: rounded by half the width of their interval, with a true
// minus sign.
const SIGMAS_95 = 1.96;
const LONG = 1000; // [s]; times from here on are read as hours, minutes and seconds

const signed = (text) => (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "−");
const decimalsFor = (half) =>
  Math.min(Math.max(half > 0 ? 1 - Math.floor(Math.log10(half)) : 4, 0), 9);
const rounded = (value, half) => signed(value.toFixed(decimalsFor(half)));
const plain = (value) => signed(String(Number(value.toPrecision(4))));
const range = (low, high) => {
  const half = (high - low) / 2;
  return `${rounded(low, half)} to ${rounded(high, half)}`;
};
const hours = (t, decimals = 0) => {
  const past = Math.floor(t), rest = decimals ? (t - past).toFixed(decimals).slice(1) : "";
  const two = (v) => String(v).padStart(2, "0");
  return `${Math.floor(past / 3600)}:${two(Math.floor((past % 3600) / 60))}:${two(past % 60)}${rest}`;
};
const clock = (t) => (t < LONG ? `${t.toFixed(2)} s` : `${hours(t)} h`);
