'use strict';
const byId = id => document.getElementById(id);
const colours = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#e69f00', '#56b4e9', '#8c6bb1', '#888888'];
// Names come from a rig file: they are set as text, never as HTML.
function element(name, text, kind) {
  const e = document.createElement(name);
  if (text !== undefined) e.textContent = text;
  if (kind) e.className = kind;
  return e;
}
function fill(table, head, rows) {
  table.replaceChildren();
  const line = element('tr');
  for (const h of head) line.append(element('th', h));
  table.append(line);
  for (const row of rows) {
    const tr = element('tr');
    for (const cell of row) tr.append(Array.isArray(cell) ? element('td', cell[0], cell[1]) : element('td', cell));
    table.append(tr);
  }
}
function drawSigma(state) {
  const svg = byId('sigma');
  svg.replaceChildren();
  const make = (name, attributes, text) => {
    const e = document.createElementNS('http://www.w3.org/2000/svg', name);
    for (const key in attributes) e.setAttribute(key, attributes[key]);
    if (text !== undefined) e.textContent = text;
    svg.append(e);
    return e;
  };
  const all = state.estimates || [];
  const most = Math.max(2, ...all.map(e => e.stops));
  const values = all.flatMap(e => e.lidars.map(l => l.translation_bound_mm)).filter(v => v > 0);
  const low = Math.floor(Math.log10(Math.max(1e-3, Math.min(1, ...values))));
  const high = Math.max(low + 1, Math.ceil(Math.log10(Math.max(10, ...values))));
  const x = stops => 58 + 366 * (stops - 1) / (most - 1);
  const y = mm => 12 + 180 * (high - Math.log10(mm)) / (high - low);
  for (let p = low; p <= high; ++p) {
    make('line', {x1: 58, x2: 424, y1: y(10 ** p), y2: y(10 ** p), stroke: 'var(--line)'});
    make('text', {x: 54, y: y(10 ** p) + 4, 'text-anchor': 'end', 'font-size': 11, fill: 'var(--dim)'}, 10 ** p + ' mm');
  }
  make('text', {x: 424, y: 212, 'text-anchor': 'end', 'font-size': 11, fill: 'var(--dim)'}, most + ' stops');
  if (state.goal_mm) make('line', {x1: 58, x2: 424, y1: y(state.goal_mm), y2: y(state.goal_mm), stroke: 'var(--good)',
                                  'stroke-dasharray': '5 4'});
  const names = all.length ? all[all.length - 1].lidars.map(l => l.sensor) : [];
  names.forEach((name, i) => {
    const points = all.map(e => [e.stops, e.lidars[i] ? e.lidars[i].translation_bound_mm : 0]).filter(p => p[1] > 0);
    if (!points.length) return;
    make('polyline', {points: points.map(p => x(p[0]) + ',' + y(p[1])).join(' '), fill: 'none', 'stroke-width': 2,
                      stroke: colours[i % colours.length]});
    for (const p of points) make('circle', {cx: x(p[0]), cy: y(p[1]), r: 3, fill: colours[i % colours.length]});
  });
}
function drawPanorama(state) {
  const canvas = byId('panorama');
  const pen = canvas.getContext('2d');
  pen.clearRect(0, 0, canvas.width, canvas.height);
  const p = state.panorama;
  pen.fillStyle = getComputedStyle(document.body).getPropertyValue('--line');
  pen.fillRect(0, 0, canvas.width, canvas.height);
  if (!p) { byId('panorama_text').textContent = 'nothing yet'; return; }
  const w = canvas.width / p.columns, h = canvas.height / p.rows;
  let seen = 0, shared = 0;
  const parts = p.columns * p.rows, digits = p.cells.length / parts;
  for (let k = 0; k < parts; ++k) {
    const mask = parseInt(p.cells.substr(digits * k, digits), 16);
    if (!mask) continue;
    ++seen;
    const who = [...p.lidars.keys()].filter(i => mask & (1 << i));
    if (who.length > 1) ++shared;
    const column = k % p.columns, row = Math.floor(k / p.columns);
    who.forEach((i, n) => {
      pen.fillStyle = colours[i % colours.length];
      pen.fillRect(column * w, row * h + n * h / who.length, w, h / who.length);
    });
  }
  byId('panorama_text').textContent = Math.round(100 * seen / parts) + ' % of all directions seen, ' +
    Math.round(100 * shared / parts) + ' % by more than one LiDAR: ' + p.lidars.join(', ');
}
let pictures = {};
function show(state) {
  if (!state) return;
  byId('state').textContent = state.state;
  byId('numbers').textContent = ' ' + state.stops + ' stops, ' + Math.round(state.seconds) + ' s, ' +
    (state.bytes / 1e6).toFixed(0) + ' MB';
  byId('advice').textContent = state.advice;
  const last = state.estimates && state.estimates.length ? state.estimates[state.estimates.length - 1] : null;
  const sure = state.result ? state.result.sensors : last ? last.lidars : [];
  fill(byId('known'), ['', 'status', 'mm', 'degrees'], sure.map(l =>
    [l.sensor, [l.status, l.status], l.translation_bound_mm ? l.translation_bound_mm.toFixed(1) : '',
     l.rotation_bound_deg ? l.rotation_bound_deg.toFixed(3) : '']));
  fill(byId('sensors'), ['', 'state', 'packets/s', 'lost', 'drift ppm', 'sync'], state.sensors.map(s =>
    [s.sensor, s.state, Math.round(s.packets_per_s), s.lost, s.drift_ppm.toFixed(1), s.sync]));
  byId('disk').textContent = state.disk;
  byId('camera_part').hidden = !state.cameras.length;
  fill(byId('cameras'), ['', 'state', 'frames/s', 'images', 'damaged or missing'], state.cameras.map(c =>
    [c.sensor, c.state, c.frames_per_s.toFixed(1), c.written, c.lost]));
  for (const c of state.cameras) {
    if (!c.picture || pictures[c.sensor] === c.picture) continue;
    pictures[c.sensor] = c.picture;
    const id = 'picture ' + c.sensor;
    let figure = byId(id);
    if (!figure) {
      figure = element('figure');
      figure.id = id;
      figure.append(element('img'), element('figcaption', c.sensor));
      figure.firstChild.alt = 'the last image of ' + c.sensor;
      byId('pictures').append(figure);
    }
    figure.firstChild.src = 'picture/' + encodeURIComponent(c.picture_name) + '?' + c.picture;
  }
  const events = byId('events');
  events.replaceChildren();
  for (const line of state.events.slice().reverse()) events.append(element('li', line));
  drawSigma(state);
  drawPanorama(state);
}
function complain() {
  byId('state').textContent = 'no connection';
  byId('state').className = 'failed';
}
fetch('state' + location.search).then(r => r.json()).then(show).catch(complain);
addEventListener('load', () => {
  if (location.hash === '#once') return;
  const events = new EventSource('events' + location.search);
  events.onmessage = e => { byId('state').className = ''; show(JSON.parse(e.data)); };
  events.onerror = complain;
});
