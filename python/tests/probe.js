// Uses the page as a person does and writes what it saw into the document, for `--dump-dom`.
'use strict';
addEventListener('load', () => {
  const all = (selector) => [...document.querySelectorAll(selector)];
  const opened = [];
  window.open = (address) => opened.push(address);
  const seen = { errors: window.errors, opened };
  const tell = (node, type, more = {}) => node.dispatchEvent(new PointerEvent(type, { bubbles: true, ...more }));
  const shown = () => all('#table tbody tr').filter((line) => !line.hidden);
  const look = () => ({
    rows: shown().length,
    told: document.getElementById('count').textContent,
    dots: all('#plots circle:not(.out)').length,
    paths: all('#parallel path:not(.out)').length,
  });
  const [words, gears] = all('#filters input');
  const stage = document.querySelector('#filters select');
  const set = (field, key, value, type) => { field[key] = value; field.dispatchEvent(new Event(type, { bubbles: true })); };

  seen.all = look();
  seen.plots = all('#plots svg').map((svg) => svg.getAttribute('aria-label'));
  seen.axes = all('#parallel rect.hit').length;
  seen.bars = all('#importance svg').map((svg) => svg.querySelectorAll('rect').length);
  seen.picks = all('#picks h3 a').map((link) => link.getAttribute('href'));
  for (const dot of all('#plots circle.draft')) tell(dot, 'click');
  seen.draftsOpened = opened.length;
  for (const dot of all('#plots circle.design')) tell(dot, 'click');

  const dot = document.querySelector('#plots circle.front');
  tell(dot, 'pointerenter', { bubbles: false, clientX: 100, clientY: 100 });
  seen.linked = { dots: all('#plots circle.on').length, paths: all('#parallel path.on').length, lines: all('tr.on').length };
  seen.tip = document.getElementById('tip').hidden ? '' : document.getElementById('tip').textContent;
  tell(dot, 'pointerleave', { bubbles: false });

  set(words, 'value', 'payload_g>=500', 'input');
  seen.words = look();
  set(words, 'value', '', 'input');
  set(stage, 'value', '1', 'change');
  seen.designs = look();
  set(stage, 'value', 'all', 'change');
  set(gears, 'checked', false, 'change');
  seen.noGears = look();
  set(gears, 'checked', true, 'change');

  // The lower half of the first axis.
  Element.prototype.setPointerCapture = () => {};
  const hit = document.querySelector('#parallel rect.hit'), box = hit.getBoundingClientRect();
  tell(hit, 'pointerdown', { clientY: box.bottom });
  tell(hit, 'pointermove', { clientY: (box.top + box.bottom) / 2 });
  tell(hit, 'pointerup');
  seen.brushed = look();
  tell(hit, 'pointerdown', { clientY: box.top });
  tell(hit, 'pointerup');
  seen.cleared = look();

  const column = all('#table th').findIndex((head) => head.textContent === 'payload_g');
  const values = () => shown().map((line) => Number(line.children[column].textContent));
  all('#table th')[column].click();
  seen.up = values();
  all('#table th')[column].click();
  seen.down = values();
  seen.requests = performance.getEntriesByType('resource').map((entry) => entry.name);

  document.body.replaceChildren();
  document.body.append('<<' + btoa(unescape(encodeURIComponent(JSON.stringify(seen)))) + '>>');
});
