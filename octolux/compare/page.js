"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const find = id => document.getElementById(id);
  const stage = find("stage"), handle = find("handle");
  const panes = ["left", "right"].map(side => ({ side, box: find(`pane-${side}`), list: find(side) }));
  const most = 32;
  // What is seen: zoom, and the picture's top left corner in units of the pane.
  const eye = { zoom: 1, x: 0, y: 0 };
  let split = 50;

  const chosen = name => document.querySelector(`input[name=${name}]:checked`).value;
  const clamp = (value, low, high) => Math.min(high, Math.max(low, value));
  const uri = number => data.pictures[number];

  function draw() {
    const layer = chosen("layer"), view = chosen("view");
    let mapped = false;
    stage.dataset.layout = chosen("layout");
    for (const { box, list } of panes) {
      const one = data.series[list.value];
      // FLIP's map exists for the layers that are measured only.
      const number = one.layers[layer][view] ?? one.layers[layer].picture;
      const image = box.querySelector("img");
      if (image.dataset.number !== String(number)) {
        image.src = uri(number);
        image.dataset.number = number;
      }
      const shown = view !== "picture" && !one.reference && one.layers[layer][view] !== undefined;
      mapped ||= shown;
      const what = shown ? `, ${data.views[view].title.toLowerCase()}` : "";
      image.alt = `${one.name}: ${layer}${what}`;
      box.querySelector("figcaption").textContent = `${one.reference ? `reference: ${one.name}` : one.name}${what}`;
    }
    drawLegend(data.views[view], mapped);
    drawGallery(layer);
    look();
  }

  function drawLegend(view, mapped) {
    const legend = find("legend");
    legend.hidden = !mapped;
    if (legend.hidden) return;
    legend.querySelector(".bar").style.background = view.gradient;
    legend.querySelector(".ticks").replaceChildren(...view.ticks.map(text => element("span", text)));
    legend.querySelector("p").textContent = view.text;
  }

  function element(kind, text = "") {
    const made = document.createElement(kind);
    made.textContent = text;
    return made;
  }

  function drawGallery(layer) {
    const rows = data.series.slice(1).map((one, index) => {
      const row = element("div"), strip = element("div");
      strip.className = "strip";
      for (const [view, number] of Object.entries(one.layers[layer])) {
        const button = element("button"), image = element("img");
        button.type = "button";
        image.src = uri(number);
        image.alt = `${one.name}: ${layer}, ${data.views[view].title}`;
        [image.width, image.height] = data.size;
        button.append(image, element("span", data.views[view].title));
        button.addEventListener("click", () => show(index + 1, view));
        strip.append(button);
      }
      row.append(element("h3", `${one.name}, ${layer}`), strip);
      return row;
    });
    find("gallery").replaceChildren(...rows);
  }

  function show(number, view) {
    panes[0].list.value = number;
    if (view) document.querySelector(`input[name=view][value=${view}]`).checked = true;
    draw();
    stage.scrollIntoView({ block: "center" });
  }

  // Zoom and position.

  function look() {
    eye.zoom = clamp(eye.zoom, 1, most);
    eye.x = clamp(eye.x, 1 - eye.zoom, 0);
    eye.y = clamp(eye.y, 1 - eye.zoom, 0);
    for (const { box } of panes) {
      box.querySelector("img").style.transform = `translate(${eye.x * 100}%, ${eye.y * 100}%) scale(${eye.zoom})`;
    }
    const pixels = eye.zoom * panes[0].box.clientWidth / data.size[0];
    stage.classList.toggle("zoomed", eye.zoom > 1);
    stage.classList.toggle("sharp", pixels > 2);
    find("zoom").textContent = `${Math.round(eye.zoom * 100)} %`;
  }

  function zoom(factor, x = 0.5, y = 0.5) {
    const before = eye.zoom;
    eye.zoom = clamp(before * factor, 1, most);
    const change = eye.zoom / before;
    eye.x = x - (x - eye.x) * change;
    eye.y = y - (y - eye.y) * change;
    look();
  }

  function within(event) {
    const pane = panes.find(({ box }) => box.contains(event.target)) ?? panes[0];
    const box = (chosen("layout") === "swipe" ? stage : pane.box).getBoundingClientRect();
    return { x: (event.clientX - box.left) / box.width, y: (event.clientY - box.top) / box.height, box };
  }

  function setSplit(percent) {
    split = clamp(percent, 0, 100);
    stage.style.setProperty("--split", `${split}%`);
    handle.setAttribute("aria-valuenow", Math.round(split));
  }

  const pointers = new Map();
  let sliding = false, gap = 0;

  function spread() {
    const [a, b] = [...pointers.values()];
    return Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
  }

  stage.addEventListener("pointerdown", event => {
    if (event.button) return;
    pointers.set(event.pointerId, event);
    stage.setPointerCapture(event.pointerId);
    sliding = chosen("layout") === "swipe" && (event.target === handle || eye.zoom === 1) && pointers.size === 1;
    if (pointers.size === 2) gap = spread();
    if (sliding) setSplit(100 * within(event).x);
    stage.classList.toggle("moving", !sliding);
  });
  stage.addEventListener("pointermove", event => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const { x, y, box } = within(event);
    pointers.set(event.pointerId, event);
    if (pointers.size === 2) {
      const now = spread();
      if (gap > 0 && now > 0) zoom(now / gap, x, y);
      gap = now;
    } else if (sliding) {
      setSplit(100 * x);
    } else {
      eye.x += (event.clientX - before.clientX) / box.width;
      eye.y += (event.clientY - before.clientY) / box.height;
      look();
    }
  });
  for (const end of ["pointerup", "pointercancel"]) {
    stage.addEventListener(end, event => {
      pointers.delete(event.pointerId);
      sliding = false;
      stage.classList.remove("moving");
    });
  }
  stage.addEventListener("wheel", event => {
    if (event.deltaY > 0 && eye.zoom === 1) return; // the page scrolls on
    event.preventDefault();
    const { x, y } = within(event);
    zoom(Math.exp(-event.deltaY * 0.002), x, y);
  }, { passive: false });
  handle.addEventListener("keydown", event => {
    const steps = { ArrowLeft: -2, ArrowRight: 2, PageDown: -10, PageUp: 10, Home: -100, End: 100 };
    if (!(event.key in steps)) return;
    event.preventDefault();
    setSplit(split + steps[event.key]);
  });
  find("zoom-in").addEventListener("click", () => zoom(1.5));
  find("zoom-out").addEventListener("click", () => zoom(1 / 1.5));
  find("zoom-reset").addEventListener("click", () => { Object.assign(eye, { zoom: 1, x: 0, y: 0 }); look(); });
  window.addEventListener("resize", look);

  // The table.

  const body = document.querySelector("#table tbody");
  const headings = [...document.querySelectorAll("#table thead th")];

  function value(row, column) {
    const cell = row.cells[column];
    if (column === 0) return cell.textContent.trim();
    return cell.dataset.value === "" ? NaN : Number(cell.dataset.value);
  }

  function order(a, b, way) {
    if (typeof a === "string") return way * a.localeCompare(b);
    if (Number.isNaN(a) || Number.isNaN(b)) return Number.isNaN(a) - Number.isNaN(b); // what is not known comes last
    return way * (a - b);
  }

  headings.forEach((heading, column) => heading.querySelector("button").addEventListener("click", () => {
    const ascending = heading.getAttribute("aria-sort") !== "ascending";
    headings.forEach(other => other.setAttribute("aria-sort", "none"));
    heading.setAttribute("aria-sort", ascending ? "ascending" : "descending");
    const rows = [...body.rows];
    rows.sort((a, b) => order(value(a, column), value(b, column), ascending ? 1 : -1));
    body.append(...rows);
  }));
  for (const button of body.querySelectorAll(".show")) {
    button.addEventListener("click", () => show(data.series.findIndex((one, i) => i && one.label === button.dataset.label)));
  }

  for (const { list, side } of panes) {
    data.series.forEach((one, number) => {
      const option = element("option", one.reference ? `reference: ${one.name}` : one.name);
      option.value = number;
      list.append(option);
    });
    list.value = side === "left" ? 1 : 0;
    list.addEventListener("change", draw);
  }
  for (const input of document.querySelectorAll(".choice input")) input.addEventListener("change", draw);
  draw();
})();
