'use strict';
const data = JSON.parse(document.getElementById('data').textContent);
const SVG = 'http://www.w3.org/2000/svg';
const rows = data.rows;
const names = [...data.variables, ...new Set([...data.objectives, ...data.constraints].map((o) => o.measure))];
const units = Object.fromEntries(data.objectives.map((o) => [o.measure, o.unit]));
const value = (row, name) => (name in row.set ? row.set[name] : row.figures[name]);
const show = (v) => (v === null || v === undefined ? '–' : typeof v === 'number' ? String(+v.toPrecision(4)) : String(v));
const label = (name) => (units[name] ? `${name.replace(/_(mm|g|h|nmm|deg|cm3|mpa|n)$/, '')} (${units[name]})` : name);

function element(tag, attributes = {}, parent = null, text = null) {
  const node = ['svg', 'g', 'circle', 'line', 'path', 'rect', 'text', 'title'].includes(tag)
    ? document.createElementNS(SVG, tag) : document.createElement(tag);
  for (const [name, v] of Object.entries(attributes)) node.setAttribute(name, v);
  if (text !== null) node.textContent = text;
  if (parent) parent.append(node);
  return node;
}

// What is shown: a row is out when a filter or a brush excludes it.
const state = { brushes: {}, text: '', rung: 'all', gears: true, sort: null, down: false };
const marks = rows.map(() => []);
const text = (row) => [row.key, data.rungs[row.rung], row.state, row.reason, ...names.map((n) => `${n}=${show(value(row, n))}`)].join(' ').toLowerCase();
const texts = rows.map(text);

function isIn(i) {
  const row = rows[i];
  if (state.gears && row.state !== 'complete') return false;
  if (state.rung !== 'all' && String(row.rung) !== state.rung) return false;
  if (!state.text.split(/\s+/).every((word) => matches(row, i, word))) return false;
  return Object.entries(state.brushes).every(([name, [low, high]]) => {
    const at = scales[name](value(row, name));
    return at !== null && at >= low && at <= high;
  });
}

// A word is a comparison with a figure or a variable, or has to be in the row.
function matches(row, i, word) {
  const found = word.match(/^([^<>=]+)(<=|>=|<|>)(-?[\d.]+)$/);
  if (!found) return texts[i].includes(word);
  const name = names.find((n) => n.toLowerCase() === found[1]) ?? names.find((n) => n.toLowerCase().includes(found[1]));
  const v = name === undefined ? null : value(row, name);
  if (typeof v !== 'number') return false;
  const limit = Number(found[3]);
  return { '<': v < limit, '>': v > limit, '<=': v <= limit, '>=': v >= limit }[found[2]];
}

// Place of a value between 0 and 1; null where it has none.
function scale(name) {
  const all = rows.filter((r) => r.state === 'complete' || name in r.set).map((r) => value(r, name)).filter((v) => v !== null && v !== undefined);
  if (all.some((v) => typeof v !== 'number')) {
    const kinds = [...new Set(all.map(String))].sort();
    const at = (v) => (v === null || v === undefined ? null : kinds.length < 2 ? 0.5 : kinds.indexOf(String(v)) / (kinds.length - 1));
    return Object.assign(at, { ticks: kinds.map((k) => [at(k), k]) });
  }
  let low = Math.min(...all), high = Math.max(...all);
  if (!(high > low)) { low -= 0.5; high += 0.5; }
  const at = (v) => (typeof v === 'number' ? (v - low) / (high - low) : null);
  const step = 10 ** Math.floor(Math.log10((high - low) / 4));
  const good = [1, 2, 5, 10].map((m) => m * step).find((s) => (high - low) / s <= 5);
  const ticks = [];
  for (let t = Math.ceil(low / good) * good; t <= high + 1e-9 * good; t += good) ticks.push([at(t), show(t)]);
  return Object.assign(at, { ticks, low, high });
}
const scales = Object.fromEntries(names.map((n) => [n, scale(n)]));

const tip = document.getElementById('tip');
function point(i, event) {
  for (const other of document.querySelectorAll('.on')) other.classList.remove('on');
  if (i === null) { tip.hidden = true; return; }
  for (const node of marks[i]) node.classList.add('on');
  const row = rows[i];
  tip.textContent = [`${data.rungs[row.rung]} ${row.key.slice(0, 8)}${row.front ? ', on the front' : ''}${row.holds ? '' : ', breaks a constraint'}`,
    ...names.map((n) => `${n}: ${show(value(row, n))}`)].join('\n');
  tip.hidden = false;
  tip.style.left = `${Math.min(event.clientX + 14, innerWidth - 300)}px`;
  tip.style.top = `${Math.max(4, Math.min(event.clientY + 14, innerHeight - tip.offsetHeight - 4))}px`;
}
function watch(node, i) {
  marks[i].push(node);
  node.addEventListener('pointerenter', (event) => point(i, event));
  node.addEventListener('pointerleave', () => point(null));
  if (rows[i].page) node.addEventListener('click', () => open(rows[i].page));
}
const kind = (row) => `${row.rung ? 'design' : 'draft'}${row.front ? ' front' : ''}${row.holds ? '' : ' broken'}`;

function plot(x, y) {
  const W = 352, H = 300, left = 60, bottom = 44, top = 12, right = 12;
  const svg = element('svg', { width: W, height: H, viewBox: `0 0 ${W} ${H}`, role: 'img', 'aria-label': `${y.measure} over ${x.measure}` });
  const px = (t) => left + t * (W - left - right), py = (t) => H - bottom - t * (H - bottom - top);
  for (const [t, name] of scales[x.measure].ticks) {
    element('line', { x1: px(t), x2: px(t), y1: py(0), y2: py(1), class: 'axis' }, svg);
    element('text', { x: px(t), y: H - bottom + 16, 'text-anchor': 'middle' }, svg, name);
  }
  for (const [t, name] of scales[y.measure].ticks) {
    element('line', { x1: px(0), x2: px(1), y1: py(t), y2: py(t), class: 'axis' }, svg);
    element('text', { x: left - 6, y: py(t) + 4, 'text-anchor': 'end' }, svg, name);
  }
  for (const c of data.constraints) for (const end of [c.least, c.most]) {
    if (end === null) continue;
    const at = scales[c.measure](end);
    if (at < 0 || at > 1) continue;
    if (c.measure === x.measure) element('line', { x1: px(at), x2: px(at), y1: py(0), y2: py(1), class: 'limit' }, svg);
    if (c.measure === y.measure) element('line', { x1: px(0), x2: px(1), y1: py(at), y2: py(at), class: 'limit' }, svg);
  }
  element('text', { x: px(0.5), y: H - 8, 'text-anchor': 'middle', class: 'name' }, svg, `${label(x.measure)}, ${x.up ? 'more is better →' : '← less is better'}`);
  element('text', { transform: `translate(14 ${py(0.5)}) rotate(-90)`, 'text-anchor': 'middle', class: 'name' }, svg, `${label(y.measure)}, ${y.up ? 'more is better →' : '← less is better'}`);
  rows.forEach((row, i) => {
    const a = scales[x.measure](value(row, x.measure)), b = scales[y.measure](value(row, y.measure));
    if (row.state !== 'complete' || a === null || b === null) return;
    watch(element('circle', { cx: px(a), cy: py(b), r: row.rung ? 4.5 : 3, class: `dot ${kind(row)}` }, svg), i);
  });
  document.getElementById('plots').append(svg);
}

function parallel() {
  const W = Math.max(1100, 84 * names.length), H = 370, top = 80, bottom = 22, side = 62;
  const svg = element('svg', { width: W, height: H, viewBox: `0 0 ${W} ${H}`, role: 'img', 'aria-label': 'all variables and objectives' });
  const px = (i) => side + (i * (W - 2 * side)) / Math.max(names.length - 1, 1), py = (t) => H - bottom - t * (H - bottom - top);
  rows.forEach((row, i) => {
    if (row.state !== 'complete') return;
    const points = names.map((n, k) => [px(k), scales[n](value(row, n))]).filter(([, t]) => t !== null);
    const d = points.map(([x, t], k) => `${k ? 'L' : 'M'}${x.toFixed(1)} ${py(t).toFixed(1)}`).join('');
    watch(element('path', { d, class: `path ${kind(row)}` }, svg), i);
  });
  names.forEach((name, k) => {
    const x = px(k);
    element('line', { x1: x, x2: x, y1: py(0), y2: py(1), class: 'axis' }, svg);
    const parts = name.split('.');
    // Neighbours' names would meet, so every other stands higher.
    const high = k % 2 ? 14 : 46;
    parts.slice(-2).forEach((part, row) => element('text', { x, y: high + 14 * row, 'text-anchor': 'middle', class: 'name' }, svg, part));
    for (const [t, text] of scales[name].ticks) element('text', { x: x + 5, y: py(t) + 4, class: 'tick' }, svg, text);
    const brush = element('rect', { x: x - 9, width: 18, y: 0, height: 0, class: 'brush' }, svg);
    const hit = element('rect', { x: x - 12, width: 24, y: py(1), height: py(0) - py(1), class: 'hit' }, svg);
    let from = null;
    const at = (event) => {
      const box = svg.getBoundingClientRect();
      return Math.max(0, Math.min(1, (H - bottom - ((event.clientY - box.top) * H) / box.height) / (H - bottom - top)));
    };
    const drag = (event) => {
      if (from === null) return;
      const ends = [from, at(event)].sort((a, b) => a - b);
      const wide = ends[1] - ends[0] > 0.01;
      if (wide) state.brushes[name] = ends; else delete state.brushes[name];
      brush.setAttribute('y', wide ? py(ends[1]) : 0);
      brush.setAttribute('height', wide ? py(ends[0]) - py(ends[1]) : 0);
      update();
    };
    hit.addEventListener('pointerdown', (event) => { from = at(event); hit.setPointerCapture(event.pointerId); drag(event); });
    hit.addEventListener('pointermove', drag);
    hit.addEventListener('pointerup', () => { from = null; });
  });
  const holder = document.getElementById('parallel');
  holder.className = 'scroll';
  holder.append(svg);
}

function importance() {
  const holder = document.getElementById('importance');
  const all = Object.entries(data.importance);
  if (!all.length) { element('p', { class: 'hint' }, holder, 'Too few gears to say.'); return; }
  for (const [measure, shares] of all) {
    const entries = Object.entries(shares).sort((a, b) => b[1] - a[1]);
    const H = 30 + 22 * entries.length, W = 352;
    const svg = element('svg', { width: W, height: H, viewBox: `0 0 ${W} ${H}` });
    element('text', { x: 0, y: 16, class: 'name' }, svg, `for ${label(measure)}`);
    entries.forEach(([name, share], k) => {
      const y = 28 + 22 * k;
      element('text', { x: 190, y: y + 12, 'text-anchor': 'end' }, svg, name.replace('motion.constants.', 'constant '));
      element('rect', { x: 198, y, width: Math.max(1, 120 * share), height: 15, class: 'bar' }, svg);
      element('text', { x: 204 + 120 * share, y: y + 12 }, svg, `${(100 * share).toFixed(0)} %`);
    });
    holder.append(svg);
  }
  element('p', { class: 'hint' }, holder, 'From the drafts: what sets the best quarter apart from the rest (PED-ANOVA).');
}

function picks() {
  const holder = document.getElementById('picks');
  if (!data.picks.length) element('p', { class: 'hint' }, holder, 'No design that works keeps all constraints yet.');
  data.picks.forEach((pick, k) => {
    const i = rows.findIndex((r) => r.key === pick.key && r.rung === data.rungs.length - 1);
    const card = element('article', {}, holder);
    const head = element('h3', {}, card, `${k + 1}. `);
    element('a', { href: rows[i].page }, head, pick.key.slice(0, 8));
    element('p', {}, card, pick.why);
    const list = element('dl', {}, card);
    for (const name of names) {
      element('dt', {}, list, name);
      element('dd', {}, list, show(value(rows[i], name)));
    }
    const t = pick.tolerances;
    if (t) {
      const range = (p) => (p ? `${show(p.p5)} to ${show(p.p95)}` : '–');
      element('p', { class: 'hint' }, card, `Made with ordinary errors: ${show(100 * t.works)} % of ${t.draws} work; play ${range(t.play_mm)} mm, min Q ${range(t.q_min)} (5th to 95th percentile).`);
    }
    marks[i].push(card);
  });
}

const columns = [['key', (r) => r.key.slice(0, 8)], ['stage', (r) => data.rungs[r.rung]], ['state', (r) => r.state],
  ['constraints', (r) => (r.holds ? 'kept' : 'broken')], ...names.map((n) => [n, (r) => value(r, n)]), ['reason', (r) => r.reason]];

function table() {
  const head = element('tr', {}, document.querySelector('#table thead'));
  columns.forEach(([name, get], k) => {
    const kind = rows.some((r) => typeof get(r) === 'number') ? '' : 'text';
    element('th', { class: kind }, head, name).addEventListener('click', () => {
      state.down = state.sort === k ? !state.down : false;
      state.sort = k;
      update();
    });
  });
  const body = document.querySelector('#table tbody');
  rows.forEach((row, i) => {
    const line = element('tr', { class: row.front ? 'front' : '' }, body);
    columns.forEach(([name, get], k) => {
      const v = get(row);
      const cell = element('td', { class: typeof v === 'number' ? '' : 'text' }, line, k === 0 && row.page ? null : show(v));
      if (k === 0 && row.page) element('a', { href: row.page }, cell, v);
    });
    marks[i].push(line);
    line.addEventListener('pointerenter', (event) => { point(i, event); tip.hidden = true; });
    lines.push(line);
  });
  const filters = document.getElementById('filters');
  const words = element('label', {}, filters, 'Only ');
  const field = element('input', { type: 'text', placeholder: 'words, payload_g>=800, teeth<12', 'aria-label': 'filter' }, words);
  field.addEventListener('input', () => { state.text = field.value.trim().toLowerCase(); update(); });
  const stage = element('label', {}, filters, 'of ');
  const choice = element('select', { 'aria-label': 'stage' }, stage);
  [['all', 'all stages'], ...data.rungs.map((r, k) => [k, r])].forEach(([v, name]) => element('option', { value: v }, choice, name));
  choice.addEventListener('change', () => { state.rung = choice.value; update(); });
  const gears = element('label', {}, filters);
  const box = element('input', { type: 'checkbox', checked: '' }, gears);
  gears.append(' gears only ');
  box.addEventListener('change', () => { state.gears = box.checked; update(); });
  element('span', { id: 'count' }, filters);
}
const lines = [];

function update() {
  let count = 0;
  rows.forEach((row, i) => {
    const inside = isIn(i);
    count += inside;
    lines[i].hidden = !inside;
    for (const node of marks[i]) if (node instanceof SVGElement) node.classList.toggle('out', !inside);
  });
  document.getElementById('count').textContent = `${count} of ${rows.length}`;
  if (state.sort !== null) {
    const get = columns[state.sort][1], sign = state.down ? -1 : 1;
    const order = rows.map((_, i) => i).sort((a, b) => {
      const [x, y] = [get(rows[a]), get(rows[b])];
      const missing = (x === null || x === undefined) - (y === null || y === undefined);
      return missing || sign * (typeof x === 'number' && typeof y === 'number' ? x - y : String(x).localeCompare(String(y)));
    });
    document.querySelector('#table tbody').append(...order.map((i) => lines[i]));
  }
}

const gears = rows.filter((r) => r.rung === 0 && r.state === 'complete').length;
const drafts = rows.filter((r) => r.rung === 0).length;
const designs = rows.filter((r) => r.rung > 0);
const limits = data.constraints.map((c) => [c.least !== null ? `${c.measure} ≥ ${c.least}` : '', c.most !== null ? `${c.measure} ≤ ${c.most}` : ''].filter(Boolean).join(', '));
document.getElementById('lead').textContent = `${data.motion}: ${drafts} drafts (${gears} gears), ${designs.length} designs, of which `
  + `${designs.filter((r) => r.holds).length} work and keep ${limits.length ? `all constraints (${limits.join('; ')})` : 'all constraints'}; `
  + `${data.failed} could not be computed. ${data.cpu_hours.toFixed(2)} hours of one core.`;
picks();
const three = data.objectives;
for (let a = 0; a < three.length; a++) for (let b = a + 1; b < three.length; b++) plot(three[a], three[b]);
if (three.length === 1) plot(three[0], three[0]);
parallel();
importance();
table();
update();
