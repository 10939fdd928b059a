"use strict";
// Curves over φ with a common cursor. Makes window.charts: { add(root, plot, onPick), show(phi) }.
window.charts = (() => {
  const all = [];
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const text = (v) => v === null || v === undefined ? "–" : Math.abs(v) >= 100 ? v.toFixed(0) : Math.abs(v) >= 1 ? v.toFixed(2) : v.toPrecision(3);

  function options(plot, width, height) {
    const axis = { stroke: css("--quiet"), grid: { stroke: css("--line"), width: 1 }, ticks: { stroke: css("--line") }, font: "12px system-ui, sans-serif" };
    const range = (u, low, high) => {
      if (plot.from_zero) { low = Math.min(low, 0); high = Math.max(high, 0); }
      const pad = (high - low || 1) * 0.08;
      return [low < 0 || !plot.from_zero ? low - pad : 0, high > 0 || !plot.from_zero ? high + pad : 0];
    };
    return {
      width, height,
      padding: [8, 18, 0, 0],
      legend: { show: false },
      cursor: { drag: { x: false, y: false, setScale: false }, points: { size: 6 }, y: false },
      scales: { x: { time: false }, y: { range } },
      axes: [
        { ...axis, values: (u, ticks) => ticks.map((t) => t + "°"), incrs: [5, 10, 15, 30, 45, 60, 90, 180], size: 28 },
        { ...axis, size: 52 },
      ],
      series: [{}, ...plot.series.map((s) => ({ label: s.label, stroke: s.color, width: 2, points: { show: false } }))],
    };
  }

  function add(root, plot, onPick) {
    const box = root.querySelector(".chart");
    const data = [plot.phi_deg, ...plot.series.map((s) => s.values)];
    const chart = { plot, now: root.querySelector(".now"), u: null, line: null };
    const build = () => {
      if (chart.u) chart.u.destroy();
      chart.u = new uPlot(options(plot, Math.max(box.clientWidth, 120), box.clientHeight), data, box);
      chart.line = document.createElement("div");
      chart.line.className = "at";
      chart.u.over.append(chart.line);
      const pick = (e) => {
        const x = e.clientX - chart.u.over.getBoundingClientRect().left;
        const [first, last] = [plot.phi_deg[0], plot.phi_deg[plot.phi_deg.length - 1]];
        onPick(Math.min(Math.max(chart.u.posToVal(x, "x"), first), last));
      };
      chart.u.over.addEventListener("pointerdown", (e) => { chart.u.over.setPointerCapture(e.pointerId); pick(e); });
      chart.u.over.addEventListener("pointermove", (e) => { if (e.buttons & 1) pick(e); });
      place(chart, chart.phi ?? plot.phi_deg[0]);
    };
    build();
    all.push(chart);
    let width = box.clientWidth;
    new ResizeObserver(() => { if (box.clientWidth !== width) { width = box.clientWidth; chart.u.setSize({ width: Math.max(width, 120), height: box.clientHeight }); place(chart, chart.phi); } }).observe(box);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", build);
    return chart;
  }

  function nearest(plot, phi) {
    const x = plot.phi_deg;
    let low = 0, high = x.length - 1;
    while (high - low > 1) { const mid = (low + high) >> 1; if (x[mid] > phi) high = mid; else low = mid; }
    return phi - x[low] < x[high] - phi ? low : high;
  }

  function place(chart, phi) {
    chart.phi = phi;
    const x = Math.min(Math.max(phi, chart.plot.phi_deg[0]), chart.plot.phi_deg[chart.plot.phi_deg.length - 1]);
    chart.line.style.left = chart.u.valToPos(x, "x") + "px";
    const i = nearest(chart.plot, phi);
    chart.now.replaceChildren(...chart.plot.series.map((s) => {
      const span = document.createElement("span"), dot = document.createElement("i");
      dot.style.background = s.color;
      span.append(dot, s.label + " " + text(s.values[i]) + (chart.plot.unit ? " " + chart.plot.unit : ""));
      return span;
    }));
  }

  return { add, show: (phi) => all.forEach((c) => place(c, phi)), all };
})();
