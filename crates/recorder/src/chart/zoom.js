// Zoom of time series: drag selects, Ctrl + wheel zooms, a double click shows all again. Pictures of one
// group share their time axis. Coordinates are those of the drawn points; y fits what is visible.
(() => {
  const NS = "http://www.w3.org/2000/svg";
  const nums = s => s.split(" ").map(Number);
  const charts = [...document.querySelectorAll("svg.zoom")].map(svg => {
    const c = {svg, box: nums(svg.dataset.box), x: nums(svg.dataset.x), y: nums(svg.dataset.y),
      scale: nums(svg.dataset.unit), logy: svg.dataset.logy === "1", group: svg.dataset.group};
    c.shapes = [...svg.querySelectorAll(".d")].map(el => ({el,
      pts: el.getAttribute("points").split(" ").map(p => p.split(",").map(Number)), html: el.getAttribute("points")}));
    c.ticks = svg.querySelector(".ticks"); c.original = c.ticks.innerHTML;
    return c;
  });
  const make = (name, attrs, text) => {
    const el = document.createElementNS(NS, name);
    for (const k in attrs) el.setAttribute(k, attrs[k]);
    if (text !== undefined) el.textContent = text;
    return el;
  };
  const nice = r => { const p = 10 ** Math.floor(Math.log10(r)), f = r / p; return (f <= 1.5 ? 1 : f <= 3.5 ? 2 : f <= 7.5 ? 5 : 10) * p; };
  const ticks = (lo, hi, n) => {
    const s = nice((hi - lo) / n), out = [];
    for (let i = Math.ceil(lo / s - 1e-9); i * s <= hi + s * 1e-9; i++) out.push(i * s);
    return [out, Math.min(12, Math.max(0, -Math.floor(Math.log10(s) + 1e-9)))];
  };
  const label = (v, d) => v.toFixed(d).replace("-", "\u2212");
  const show = (c, lo, hi) => {
    const [bx, by, bw, bh] = c.box, [x0, x1] = c.x;
    if (lo <= x0 && hi >= x1) {
      c.view = null; c.shapes.forEach(s => s.el.setAttribute("points", s.html)); c.ticks.innerHTML = c.original; return;
    }
    c.view = [lo, hi];
    const a = bx + (lo - x0) / (x1 - x0) * bw, b = bx + (hi - x0) / (x1 - x0) * bw;
    let top = Infinity, low = -Infinity;
    for (const s of c.shapes) for (const [x, y] of s.pts) if (x >= a && x <= b) { top = Math.min(top, y); low = Math.max(low, y); }
    if (!(top < low)) { top = by; low = by + bh; }
    const pad = 0.05 * (low - top); top -= pad; low += pad;
    const mx = x => bx + (x - a) / (b - a) * bw, my = y => by + (y - top) / (low - top) * bh;
    for (const s of c.shapes) s.el.setAttribute("points", s.pts.map(([x, y]) => mx(x).toFixed(1) + "," + my(y).toFixed(1)).join(" "));
    const [y0, y1] = c.y, value = p => y1 - (p - by) / bh * (y1 - y0), pos = v => my(by + (y1 - v) / (y1 - y0) * bh);
    c.ticks.replaceChildren();
    const [xs, xd] = ticks(lo / c.scale[0], hi / c.scale[0], Math.max(3, bw / 90));
    for (const v of xs) {
      const x = bx + (v * c.scale[0] - lo) / (hi - lo) * bw;
      c.ticks.append(make("line", {x1: x, x2: x, y1: by, y2: by + bh, class: "gr"}),
        make("text", {x, y: by + bh + 17, "text-anchor": "middle", class: "tick"}, label(v, xd)));
    }
    if (!c.logy) {
      const [ys, yd] = ticks(value(low) / c.scale[1], value(top) / c.scale[1], Math.max(3, bh / 45));
      for (const v of ys) {
        const y = pos(v * c.scale[1]);
        c.ticks.append(make("line", {x1: bx, x2: bx + bw, y1: y, y2: y, class: "gr"}),
          make("text", {x: bx - 7, y: y + 4, "text-anchor": "end", class: "tick"}, label(v, yd)));
      }
    }
  };
  const apply = (c, lo, hi) => {
    if (hi - lo < 1e-6 * (c.x[1] - c.x[0])) return;
    for (const o of charts) if (o === c || (c.group && o.group === c.group)) show(o, Math.max(lo, o.x[0]), Math.min(hi, o.x[1]));
  };
  for (const c of charts) {
    const at = e => {
      const r = c.svg.getBoundingClientRect(), vb = c.svg.viewBox.baseVal, [lo, hi] = c.view || c.x;
      const x = (e.clientX - r.left) / r.width * vb.width;
      return [Math.min(c.box[0] + c.box[2], Math.max(c.box[0], x)), lo + Math.min(1, Math.max(0, (x - c.box[0]) / c.box[2])) * (hi - lo)];
    };
    let from = null, rect = null;
    c.svg.addEventListener("pointerdown", e => { from = at(e); rect = make("rect", {class: "sel", y: c.box[1], height: c.box[3], x: from[0], width: 0}); c.svg.append(rect); c.svg.setPointerCapture(e.pointerId); });
    c.svg.addEventListener("pointermove", e => { if (!from) return; const to = at(e); rect.setAttribute("x", Math.min(from[0], to[0])); rect.setAttribute("width", Math.abs(to[0] - from[0])); });
    const done = e => { if (!from) return; const to = at(e); rect.remove(); if (e.type === "pointerup" && Math.abs(to[0] - from[0]) > 6) apply(c, Math.min(from[1], to[1]), Math.max(from[1], to[1])); from = null; };
    c.svg.addEventListener("pointerup", done); c.svg.addEventListener("pointercancel", done);
    c.svg.addEventListener("dblclick", () => apply(c, c.x[0], c.x[1]));
    c.svg.addEventListener("wheel", e => {
      if (!e.ctrlKey && !e.metaKey) return;
      e.preventDefault();
      const [lo, hi] = c.view || c.x, v = at(e)[1], f = e.deltaY > 0 ? 1.25 : 0.8;
      apply(c, v - (v - lo) * f, v + (hi - v) * f);
    }, {passive: false});
  }
})();
