// The numbers of the report, which stand in the element #data, unpacked once.
const report = JSON.parse(document.getElementById("data").textContent);
const FLOATS = { f4: Float32Array, f8: Float64Array, u2: Uint16Array, u4: Uint32Array };

const unpack = ({ type, bytes }) =>
  new FLOATS[type](Uint8Array.from(atob(bytes), (c) => c.charCodeAt(0)).buffer);
const column = (packed) => Array.from(unpack(packed), (v) => (Number.isFinite(v) ? v : null));

// The curves of each source.
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
