"use strict";
// Hands the charts of the page's data to uPlot; each takes the place of its picture on the screen.
(() => {
  const style = getComputedStyle(document.documentElement);
  const colour = name => style.getPropertyValue("--" + name).trim();
  const nameOfColour = curve => curve.colour !== null ? "curve-" + curve.colour : curve.style === "event" ? "soft" : "reference";
  const WIDTHS = { reference: 5, event: 1 };
  const isMarks = curve => curve.style === "cross" || curve.style === "circle";
  const FONT = "13px system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif";
  const HEIGHT = 290, FRACTION = 0.2;
  const Y_AXIS = { size: widthOfNumbers, labelSize: 20, gap: 3 }, X_AXIS = { size: 28, labelSize: 20, labelGap: 0, gap: 3 };

  function widthOfNumbers(u, texts) {
    u.ctx.font = FONT;
    return Math.max(52, ...(texts || []).map(text => 18 + Math.ceil(u.ctx.measureText(text).width)));
  }

  function decoded(array) {
    if ("n" in array) return Array.from({ length: array.n }, (_, k) => array.first + k * array.step);
    const bytes = Uint8Array.from(atob(array.f8 || array.f4), c => c.charCodeAt(0)).buffer;
    const values = array.f8 ? new Float64Array(bytes) : new Float32Array(bytes);
    const middle = array.middle || 0;
    return Array.from(values, v => v === v ? v + middle : null);
  }

  // uPlot wants one ascending x for all curves: null breaks a line, undefined leaves it alone.
  function aligned(curves, arrays) {
    const xs = [...new Set(curves.map(c => c.x))];
    const ascends = x => x.every((v, k) => v !== null && (k === 0 || v > x[k - 1]));
    if (xs.every(place => ascends(arrays[place])))
      return uPlot.join(xs.map(place => [arrays[place], ...curves.filter(c => c.x === place).map(c => arrays[c.y])]))
        .reduce((found, column, k) => (found.columns.push(column), found),
          { columns: [], order: xs.flatMap(place => curves.filter(c => c.x === place)) });
    const rows = curves.flatMap((c, i) => arrays[c.x].map((x, k) => [x, i, arrays[c.y][k]]));
    rows.sort((a, b) => a[0] - b[0]);
    const column = (_, i) => {
      let last;  // a gap lasts over the rows of other curves, up to the next value
      return rows.map(r => r[1] === i ? (last = r[2]) : last === null ? null : undefined);
    };
    return { columns: [rows.map(r => r[0]), ...curves.map(column)], order: curves };
  }

  function extent(values, isLogarithmic) {
    let low = Infinity, high = -Infinity;
    for (const column of values)
      for (const v of column)
        if (v != null && (v > 0 || !isLogarithmic)) { if (v < low) low = v; if (v > high) high = v; }
    return high >= low ? [low, high] : isLogarithmic ? [1, 10] : [0, 1];
  }

  function padded([low, high], share, isLogarithmic) {
    if (isLogarithmic) return [low / 1.5 ** (share > 0), high * 1.5 ** (share > 0)];
    const flat = high - low <= 1e-12 * Math.max(Math.abs(low), Math.abs(high));
    const room = flat ? 0.1 * Math.abs(high) || 1 : share * (high - low);
    return [low - room, high + room];
  }

  function shown(value) {
    return value == null ? "" : String(Number(value.toPrecision(6)));
  }

  function tickTexts(isLogarithmic) {
    return (_, ticks) => {
      if (isLogarithmic)
        return ticks.map(v => v && Math.abs(Math.log10(v) - Math.round(Math.log10(v))) < 1e-9 ? v.toPrecision(1).replace("e+", "e") : "");
      const step = Math.abs(ticks[1] - ticks[0]) || 1, largest = Math.max(...ticks.map(Math.abs));
      const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
      if (largest >= 1e6 || digits > 5)
        return ticks.map(v => Math.abs(v) < 1e-9 * step ? "0" : String(Number(v.toPrecision(4))).replace("e+", "e"));
      return ticks.map(v => v.toFixed(digits).replace(/^-(0(\.0*)?)$/, "$1"));
    };
  }

  function crosses(u, place, first, last) {
    const path = new Path2D(), size = 5 * devicePixelRatio;
    const x = u.data[0], y = u.data[place];
    for (let k = first; k <= last; k++) {
      if (y[k] == null) continue;
      const px = u.valToPos(x[k], "x", true), py = u.valToPos(y[k], "y", true);
      path.moveTo(px - size, py - size); path.lineTo(px + size, py + size);
      path.moveTo(px - size, py + size); path.lineTo(px + size, py - size);
    }
    return { stroke: path, fill: null, flags: 0 };
  }

  // Bars and events stand on one x: uPlot would cut them off with the gaps beside them.
  function upright(u, place, first, last) {
    const path = new Path2D(), x = u.data[0], y = u.data[place];
    let isOpen = false;
    for (let k = first; k <= last; k++) {
      if (y[k] === undefined) continue;
      if (y[k] !== null) {
        const px = u.valToPos(x[k], "x", true), py = u.valToPos(y[k], "y", true);
        isOpen ? path.lineTo(px, py) : path.moveTo(px, py);
      }
      isOpen = y[k] !== null;
    }
    return { stroke: path, fill: null, flags: 0 };
  }

  function seriesOf(curve) {
    const stroke = () => colour(nameOfColour(curve));
    if (!isMarks(curve))
      return {
        label: curve.label, stroke, width: WIDTHS[curve.style] || 1.6, dash: curve.dashes,
        points: { show: false }, ...(curve.style === "event" ? { paths: upright } : {}),
      };
    const points = { show: true, stroke, width: 1.8 };
    Object.assign(points, curve.style === "cross" ? { paths: crosses } : { size: 11, fill: () => colour("page") });
    return { label: curve.label, stroke, paths: () => null, points };
  }

  function element(parent, name, className, text) {
    const made = parent.appendChild(document.createElement(name));
    if (className) made.className = className;
    if (text !== undefined) made.textContent = text;
    return made;
  }

  function swatch(curve) {
    const space = "http://www.w3.org/2000/svg", svg = document.createElementNS(space, "svg");
    svg.setAttribute("width", 40); svg.setAttribute("height", 14); svg.setAttribute("aria-hidden", "true");
    const path = svg.appendChild(document.createElementNS(space, "path"));
    const shape = { cross: "M15 2l10 10M15 12l10 -10", circle: "M15 7a5 5 0 1 0 10 0a5 5 0 1 0 -10 0" };
    path.setAttribute("d", shape[curve.style] || "M0 7h40");
    path.setAttribute("fill", "none");
    path.setAttribute("stroke-width", WIDTHS[curve.style] || 2);
    path.setAttribute("stroke-dasharray", curve.dashes.join(" "));
    path.style.stroke = "var(--" + nameOfColour(curve) + ")";
    return svg;
  }

  // Rings that are filled, holes left out, and lines of equal value with their labels; null is between them.
  function paint(u, regions, arrays) {
    const c = u.ctx;
    c.save();
    c.beginPath(); c.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height); c.clip();
    for (const region of regions) {
      const xs = arrays[region.x], ys = arrays[region.y], lines = [[]], path = new Path2D();
      xs.forEach((x, k) => x == null ? lines.push([]) :
        lines[lines.length - 1].push([u.valToPos(x, "x", true), u.valToPos(ys[k], "y", true)]));
      for (const line of lines) {
        line.forEach(([x, y], k) => k ? path.lineTo(x, y) : path.moveTo(x, y));
        if (region.fill) path.closePath();
      }
      if (region.fill) { c.fillStyle = region.fill; c.fill(path, "evenodd"); continue; }
      c.strokeStyle = c.fillStyle = colour(region.bold ? "ink" : "soft");
      c.lineWidth = (region.bold ? 2 : 1) * devicePixelRatio;
      c.setLineDash(region.bold ? [] : [5 * devicePixelRatio, 3 * devicePixelRatio]);
      c.stroke(path);
      c.font = 12 * devicePixelRatio + "px system-ui, sans-serif";
      for (const line of lines)
        if (line.length > 4 && region.label) c.fillText(region.label, ...line[Math.floor(line.length / 2)]);
    }
    c.restore();
  }

  function plot(host, chart, arrays) {
    const log = chart.logarithmic;
    const { columns, order } = aligned(chart.curves, arrays);
    const home = {
      x: chart.x_range || padded(extent([columns[0]], log), order.some(isMarks) ? 0.05 : 0, log),
      y: chart.y_range || padded(extent(columns.slice(1), log), 0.05, log),
    };
    const view = { x: home.x, y: home.y };

    const tools = element(host, "div", "tools");
    element(tools, "b", "", chart.title);
    const field = element(host, "div", "field");
    field.tabIndex = 0;
    field.setAttribute("role", "application");
    field.setAttribute("aria-label", chart.title + ": " + chart.y_label + " over " + chart.x_label + ". Arrow keys read values.");
    const at = element(host, "div", "at");
    const labels = element(host, "ul", "labels");

    const scale = key => ({ time: false, distr: log ? 3 : 1, range: () => view[key] });
    const axis = label => ({
      label, font: FONT, labelFont: FONT, stroke: () => colour("ink"), values: tickTexts(log),
      grid: { stroke: () => colour("line"), width: 1 }, ticks: { stroke: () => colour("line"), width: 1 },
    });
    const readings = [];
    function read(u) {
      const k = u.cursor.idx;
      at.textContent = k == null || u.cursor.left < 0 ? "" : chart.x_label + ": " + shown(u.data[0][k]);
      order.forEach((curve, i) => {
        const near = at.textContent && !isMarks(curve) ? nearest(u.data[i + 1], k) : null;
        readings[i].value = near == null ? "" : shown(u.data[i + 1][near]);
      });
    }
    function nearest(column, k) {
      for (let d = 0; d < column.length; d++) {
        if (column[k - d] !== undefined && k - d >= 0) return k - d;
        if (column[k + d] !== undefined && k + d < column.length) return k + d;
      }
      return null;
    }
    const u = new uPlot({
      width: field.clientWidth, height: HEIGHT, pxAlign: 0, legend: { show: false },
      cursor: { drag: { x: true, y: true, uni: 16, setScale: false }, points: { show: false } },
      scales: { x: scale("x"), y: scale("y") },
      axes: [{ ...axis(chart.x_label), ...X_AXIS }, { ...axis(chart.y_label), ...Y_AXIS }],
      series: [{}, ...order.map(seriesOf)],
      hooks: { drawClear: [u => paint(u, chart.regions, arrays)], setCursor: [read], setSelect: [selected], ready: [u => { u.over.ondblclick = () => look(home.x, home.y); }] },
    }, columns, field);

    function look(x, y) {
      [view.x, view.y] = [x, y];
      u.batch(() => {
        u.setScale("x", { min: x[0], max: x[1] });
        u.setScale("y", { min: y[0], max: y[1] });
      });
    }
    function selected(u) {
      const { left, top, width, height } = u.select;
      if (width < 4 && height < 4) return;
      const whole = u.over.getBoundingClientRect();
      const x = width > 4 && width < whole.width - 1 ? [u.posToVal(left, "x"), u.posToVal(left + width, "x")] : view.x;
      const y = height > 4 && height < whole.height - 1 ? [u.posToVal(top + height, "y"), u.posToVal(top, "y")] : view.y;
      u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
      look(x, y);
    }
    function moved([low, high], left, right) {
      if (log) return [low * (high / low) ** left, high * (high / low) ** right];
      return [low + left * (high - low), high + right * (high - low)];
    }
    const actions = [
      ["\u2212", "zoom out", () => look(moved(view.x, -0.5, 0.5), moved(view.y, -0.5, 0.5))],
      ["+", "zoom in", () => look(moved(view.x, 0.25, -0.25), moved(view.y, 0.25, -0.25))],
      ["\u2190", "to the left", () => look(moved(view.x, -FRACTION, -FRACTION), view.y)],
      ["\u2192", "to the right", () => look(moved(view.x, FRACTION, FRACTION), view.y)],
      ["all", "show all", () => look(home.x, home.y)],
    ];
    for (const [text, name, action] of actions) {
      const button = element(tools, "button", "", text);
      button.type = "button"; button.title = name; button.onclick = action;
      button.setAttribute("aria-label", name + ", " + chart.title);
    }
    order.forEach((curve, i) => {
      const button = element(element(labels, "li"), "button");
      button.type = "button";
      button.setAttribute("aria-pressed", "true");
      button.append(swatch(curve));
      element(button, "span", "", curve.label);
      readings.push(element(button, "output"));
      button.onclick = () => {
        const show = button.getAttribute("aria-pressed") !== "true";
        button.setAttribute("aria-pressed", String(show));
        u.setSeries(i + 1, { show });
      };
    });
    field.onkeydown = event => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!step) return;
      event.preventDefault();
      const width = u.over.clientWidth, left = u.cursor.left < 0 ? 0.5 * width : u.cursor.left + 0.01 * step * width;
      u.setCursor({ left: Math.max(0, Math.min(width, left)), top: 0.5 * u.over.clientHeight });
    };
    new ResizeObserver(() => {
      if (field.clientWidth && field.clientWidth !== u.width) u.setSize({ width: field.clientWidth, height: HEIGHT });
    }).observe(field);
    host.classList.add("drawn");
    return u;
  }

  const data = JSON.parse(document.getElementById("data").textContent);
  const arrays = data.arrays.map(decoded), drawn = [];
  for (const group of document.querySelectorAll("[data-plots]"))
    data.charts[group.dataset.plots].forEach((chart, i) => drawn.push(plot(group.children[i], chart, arrays)));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => drawn.forEach(u => u.redraw(false)));
  document.body.dataset.ready = "true";
})();
