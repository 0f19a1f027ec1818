// Colours of the style sheet, and elements. Texts of the report go into the page as text, never as
// markup.
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

function heading(place, title, unit, note) {
  place.replaceChildren();
  const head = make("h3", title, place);
  make("span", ` ${unit ? `[${unit}]` : ""}${note ? ` ${note}` : ""}`, head);
  place.tabIndex = 0;
  place.setAttribute("role", "group");
  place.setAttribute("aria-label", `${title}${unit ? ` in ${unit}` : ""}, chart`);
}
// A line below a chart that tells what the mouse is on.
function notice(text, place) {
  const told = make("p", text, place);
  told.className = "told";
  told.setAttribute("role", "status");
  return told;
}
