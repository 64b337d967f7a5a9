"use strict";
// Light or dark: the system's wish until the button is used.
const colour = name => getComputedStyle(root).getPropertyValue(name).trim();
const views = [];
const shapes = [];
function setTheme(theme) {
  root.dataset.theme = theme;
  document.getElementById("theme").textContent = theme === "dark" ? "Light" : "Dark";
  for (const view of views) {
    view.signal("ink", colour("--ink")).signal("muted", colour("--muted")).signal("grid", colour("--grid")).runAsync().catch(countError);
  }
  for (const shape of shapes) shape.repaint();
}

// Plots: a specification each, drawn as SVG.
async function drawPlot(element) {
  if (typeof vega === "undefined") {
    element.textContent = "This plot needs Vega, which was not found when the report was made. Its numbers are in the tables.";
    element.className = "plot muted";
    return;
  }
  const specification = JSON.parse(document.getElementById(element.dataset.spec).textContent);
  const warnings = [];
  const logger = {level() { return this; }, error(...e) { countError(e.join(" ")); return this; },
                  warn(...w) { warnings.push(w.join(" ")); return this; }, info() { return this; }, debug() { return this; }};
  const view = new vega.View(vega.parse(specification), {renderer: "svg", container: element, hover: true, logger});
  view.signal("ink", colour("--ink")).signal("muted", colour("--muted")).signal("grid", colour("--grid"));
  await view.runAsync();
  views.push(view);
  if (warnings.length) element.dataset.warnings = warnings.join("; ");
  // Something was drawn: marks with a real extent, beyond axes and frame.
  const marks = element.querySelectorAll("svg .mark-symbol path, svg .mark-rect path, svg .mark-line path");
  const drawn = [...marks].some(path => { const box = path.getBBox(); return box.width > 0 && box.height > 0; });
  element.dataset.plotOk = String(drawn);
}

async function main() {
  const button = document.getElementById("theme");
  button.addEventListener("click", () => setTheme(root.dataset.theme === "dark" ? "light" : "dark"));
  setTheme(matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
  for (const element of document.querySelectorAll(".plot[data-spec]")) {
    try { await drawPlot(element); } catch (error) { element.dataset.plotOk = "false"; countError(error); }
  }
  for (const element of document.querySelectorAll(".shape")) {
    try { shapes.push(showShape(element)); } catch (error) { element.dataset.viewOk = "false"; countError(error); }
  }
  for (const image of document.querySelectorAll("figure img")) {
    image.addEventListener("click", () => image.classList.toggle("open"));
  }
  for (const input of document.querySelectorAll("input[data-filters]")) {
    const rows = document.querySelectorAll("#" + input.dataset.filters + " tbody tr");
    input.addEventListener("input", () => {
      const words = input.value.toLowerCase().split(/\s+/).filter(Boolean);
      for (const row of rows) {
        const text = row.textContent.toLowerCase();
        row.hidden = !words.every(word => text.includes(word));
      }
    });
  }
  await Promise.all([...document.images].map(image => image.decode().catch(() => countError("image " + image.alt + " does not decode"))));
  root.dataset.ready = "true";
}
main().catch(countError);
