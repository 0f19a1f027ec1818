// Draws the page, anew whenever its width, colours or the estimate that is looked at change.
const PRINT_WIDTH = 680;
let mode = "filtered"; // which estimate is drawn: "smoothed", or "both"
let width = 0; // of the charts [px]
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
