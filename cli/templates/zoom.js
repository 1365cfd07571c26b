// Zoom, cursor and legend of the plots: drag over a part, double-click for the whole, click a name to hide its curve; CSV and
// SVG save what is shown. On a narrow screen a wide plot is laid out anew, as high as before and with letters that can be read.
"use strict";
for (const plot of document.querySelectorAll(".plot")) {
  const svg = plot.querySelector("svg.drawing"), area = svg.querySelector("svg.area");
  const grid = svg.querySelector("g.grid"), readout = plot.querySelector(".cursor");
  const numbers = (name) => svg.dataset[name].split(" ").map(Number);
  const [left, top, right, bottom] = numbers("box"), wide = svg.getAttribute("viewBox");
  let end = right; // of the axis, which is not that of the curves' own box on a narrow screen
  const whole = { x: numbers("x"), y: numbers("y") };
  const percent = svg.dataset.percent, still = { grid: grid.innerHTML };
  const curves = [...area.querySelectorAll("path.curve")].map((path) => {
    const raw = atob(path.dataset.points), points = [];
    const word = (i) => raw.charCodeAt(i) + 256 * raw.charCodeAt(i + 1);
    const value = (share, [a, b]) => a + (b - a) * ((share / 65535 - 0.25) / 0.5);
    for (let i = 0; i + 3 < raw.length; i += 4)
      points.push([value(word(i), whole.x), value(word(i + 2), whole.y)]);
    const rising = points.every((p, i) => i === 0 || p[0] >= points[i - 1][0]);
    return { path, points, rising, d: path.getAttribute("d"), cls: path.getAttribute("class") };
  });
  const rising = curves.length > 0 && curves.every((c) => c.rising && !c.path.classList.contains("dots"));
  let view = { x: [...whole.x], y: [...whole.y] };
  // Points are kept in 16 bits: a view is no narrower than a share of the whole at which their steps do not show.
  const noLess = ([a, b], [from, to]) => { const more = Math.max(0, ((to - from) / 300 - (b - a)) / 2); return [a - more, b + more]; };
  const px = (v) => left + (right - left) * (v - view.x[0]) / (view.x[1] - view.x[0]);
  const py = (v) => bottom - (bottom - top) * (v - view.y[0]) / (view.y[1] - view.y[0]);
  // As few digits as tell all of them apart.
  const labels = (all) => {
    const least = 1e-9 * Math.max(...all.map(Math.abs));
    for (let more = 0; ; more++) {
      const text = all.map((v) => { const a = Math.abs(v); return a <= least ? "0" : a < 1e-3 || a >= 1e6 ? v.toExponential(1 + more) : String(+v.toPrecision(5 + more)); });
      if (more > 9 || new Set(text).size === text.length) return text;
    }
  };
  const ticks = ([a, b], most) => {
    const coarse = (b - a) / most, power = 10 ** Math.floor(Math.log10(coarse));
    const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= coarse), all = [];
    for (let k = Math.ceil(a / step); k <= Math.floor(b / step); k++) all.push(k * step);
    return all;
  };
  // Logarithms of shares: whole decades where two are in sight, else round values.
  const heights = () => {
    const all = ticks(view.y, 6), decades = all.filter((v) => v % 1 === 0);
    if (!percent || decades.length > 1) return percent ? decades : all;
    return ticks(view.y.map((v) => 10 ** v), 6).filter((v) => v > 0).map(Math.log10);
  };
  const axes = () => {
    let marks = "";
    const across = ticks(view.x, end - left < 500 ? 6 : 11), up = heights();
    const [below, beside] = [labels(across), labels(percent ? up.map((v) => 100 * 10 ** v) : up)];
    for (const [k, v] of across.entries()) {
      const x = left + (px(v) - left) * (end - left) / (right - left);
      marks += `<path d="M${x} ${bottom}V${top}"/><text class="x" x="${x}" y="${bottom + 18}">${below[k]}</text>`;
    }
    for (const [k, v] of up.entries()) {
      marks += `<path d="M${left} ${py(v)}H${end}"/><text class="y" x="${left - 7}" y="${py(v) + 4.5}">${beside[k]}</text>`;
    }
    grid.innerHTML = marks;
  };
  const draw = () => {
    axes();
    for (const c of curves) {
      let d = "", n = 0;
      for (let i = 0; i < c.points.length; i++) {
        const outside = (k) => k in c.points && (c.points[k][0] < view.x[0] || c.points[k][0] > view.x[1]);
        if (c.rising && outside(i) && outside(i - 1) && outside(i + 1)) continue;
        const dots = c.path.classList.contains("dots");
        d += `${n++ && !dots ? "L" : "M"}${px(c.points[i][0]).toFixed(1)} ${py(c.points[i][1]).toFixed(1)}${dots ? "h0" : ""}`;
      }
      c.path.setAttribute("d", d || "M0 0");
      c.path.classList.remove("band");
    }
  };
  const reset = () => {
    view = { x: [...whole.x], y: [...whole.y] };
    if (end === right) grid.innerHTML = still.grid; else axes();
    for (const c of curves) { c.path.setAttribute("d", c.d); c.path.setAttribute("class", c.cls); }
  };
  const fit = (narrow) => {
    const [, , width, height] = wide.split(" ").map(Number), shown = narrow && width > 600 ? 400 : width;
    end = right - width + shown;
    svg.setAttribute("viewBox", `0 0 ${shown} ${height}`);
    area.setAttribute("width", end - left);
    if (plot.classList.contains("zoomed")) axes(); else if (end === right) grid.innerHTML = still.grid; else axes();
  };
  const look = () => fit(svg.clientWidth > 0 && svg.clientWidth < 600);
  addEventListener("resize", look);
  addEventListener("beforeprint", () => fit(false));
  addEventListener("afterprint", look);
  look();
  const at = (event) => {
    const p = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    const clamp = (v, a, b) => Math.min(Math.max(v, a), b), x = clamp(p.x, left, end), y = clamp(p.y, top, bottom);
    return { px: x, py: y, x: view.x[0] + (view.x[1] - view.x[0]) * (x - left) / (end - left),
      y: view.y[0] + (view.y[1] - view.y[0]) * (bottom - y) / (bottom - top) };
  };
  const shape = (name) => document.createElementNS("http://www.w3.org/2000/svg", name);
  const frame = svg.appendChild(shape("rect")), line = svg.appendChild(shape("path"));
  frame.setAttribute("class", "frame"); line.setAttribute("class", "hair");
  let from = null;
  svg.addEventListener("pointerdown", (e) => { from = at(e); svg.setPointerCapture(e.pointerId); });
  svg.addEventListener("pointermove", (e) => {
    const here = at(e), named = curves.filter((c) => !c.path.classList.contains("off"));
    if (rising) {
      line.setAttribute("d", `M${here.px} ${top}V${bottom}`);
      const values = named.map((c) => {
        let a = 0, b = c.points.length - 1;
        while (a < b) { const m = (a + b) >> 1; if (c.points[m][0] < here.x) a = m + 1; else b = m; }
        const name = plot.querySelector(`.key[data-curve="${c.path.dataset.curve}"]`);
        const value = c.points[a][1];
        return (name ? name.textContent + " " : "") + (percent ? (100 * 10 ** value).toPrecision(3) + " %" : value.toPrecision(3));
      });
      readout.textContent = `${+here.x.toPrecision(5)}: ${values.join(", ")}`;
    } else readout.textContent = `${here.x.toPrecision(3)}, ${here.y.toPrecision(3)}`;
    if (!from) return;
    const box = { x: Math.min(from.px, here.px), y: rising ? top : Math.min(from.py, here.py),
      width: Math.abs(here.px - from.px), height: rising ? bottom - top : Math.abs(here.py - from.py) };
    for (const key in box) frame.setAttribute(key, box[key]);
  });
  svg.addEventListener("pointerup", (e) => {
    const to = at(e), x = [from.x, to.x].sort((a, b) => a - b), moved = Math.abs(to.px - from.px) > 6;
    if (moved) {
      let y = [from.y, to.y].sort((a, b) => a - b);
      if (rising) {
        const inside = curves.filter((c) => !c.path.classList.contains("off"))
          .flatMap((c) => c.points.filter((p) => p[0] >= x[0] && p[0] <= x[1]).map((p) => p[1]));
        const low = inside.reduce((m, v) => Math.min(m, v), Infinity), high = inside.reduce((m, v) => Math.max(m, v), -Infinity);
        const room = 0.06 * (high - low);
        y = inside.length ? [low - room, high + room] : view.y;
      }
      view = { x: noLess(x, whole.x), y: noLess(y, whole.y) };
      draw();
      plot.classList.add("zoomed");
    }
    from = null;
    for (const key of ["width", "height"]) frame.setAttribute(key, 0);
  });
  svg.addEventListener("pointerleave", () => { line.setAttribute("d", ""); readout.textContent = ""; });
  svg.addEventListener("dblclick", () => { reset(); plot.classList.remove("zoomed"); });
  const shown = () => curves.filter((c) => !c.path.classList.contains("off"));
  const nameOf = (c) => plot.querySelector(`.key[data-curve="${c.path.dataset.curve}"]`)?.textContent ?? label_y;
  const label_y = plot.querySelector(".head b").textContent, label_x = plot.querySelector(".unit").textContent;
  const csv = () => {
    const cell = (text) => `"${text.replaceAll('"', '""')}"`, inside = (p) => p[0] >= view.x[0] && p[0] <= view.x[1];
    const rows = shown().flatMap((c) => c.points.filter(inside).map((p) => `${cell(nameOf(c))},${+p[0].toPrecision(6)},${+(percent ? 100 * 10 ** p[1] : p[1]).toPrecision(5)}`));
    return [`"curve",${cell(label_x)},${cell(label_y)}`, ...rows].join("\n") + "\n";
  };
  const drawing = () => {
    const copy = svg.cloneNode(true), style = shape("style"), [, , width, height] = svg.getAttribute("viewBox").split(" ").map(Number);
    style.textContent = document.querySelector("style").textContent;
    const text = (words, x, y, at) => {
      const line = shape("text");
      line.setAttribute("x", x); line.setAttribute("y", y); line.setAttribute("style", `text-anchor: ${at}`);
      line.textContent = words;
      copy.append(line);
    };
    text([label_y, ...(curves.length > 1 ? shown().map(nameOf) : [])].join("   "), left, -8, "start");
    text(label_x, end, height + 14, "end");
    copy.prepend(style);
    for (const [name, value] of [["xmlns", "http://www.w3.org/2000/svg"], ["class", "plot drawing"], ["width", width], ["height", height + 48],
      ["viewBox", `0 -26 ${width} ${height + 48}`]]) copy.setAttribute(name, value);
    return new XMLSerializer().serializeToString(copy);
  };
  for (const [name, kind, content] of [["CSV", "text/csv", csv], ["SVG", "image/svg+xml", drawing]]) {
    const button = document.createElement("button");
    button.textContent = name;
    button.title = `save what this plot shows as ${name}`;
    button.addEventListener("click", () => {
      const link = document.createElement("a");
      link.href = URL.createObjectURL(new Blob([content()], { type: kind }));
      link.download = `${label_y.replace(/[^a-zA-Z0-9]+/g, "-").replace(/^-|-$/g, "")}.${name.toLowerCase()}`;
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    });
    plot.querySelector(".save").append(button);
  }
  for (const key of plot.querySelectorAll(".key")) key.addEventListener("click", () => {
    const off = key.classList.toggle("off");
    area.querySelector(`path[data-curve="${key.dataset.curve}"]`).classList.toggle("off", off);
  });
}
