"use strict";
// Plays one film or two: reads the arrays, draws world, eye and signals, and follows mouse and keyboard.
(async () => {
  const WINDOW = 0.1; // s about the cursor in which spikes count as now
  const COLOURS = 6; // of lines
  const MANY = 6; // lines of a panel from which it is higher
  const GLOW = 0.04; // s for which an event of the eye stays lit
  const SPEEDS = [0.05, 0.1, 0.25, 0.5, 1, 2, 5, 10, 50];
  const TYPES = { u1: Uint8Array, u2: Uint16Array, u4: Uint32Array, f4: Float32Array };
  const element = (name, given = {}, ...children) => {
    const node = Object.assign(document.createElement(name), given);
    node.append(...children);
    return node;
  };
  const ink = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const number = (v) => (v === undefined || Number.isNaN(v) ? "-" : Number(v.toPrecision(4)).toString());
  const PREFIXES = ["a", "f", "p", "n", "u", "m", "", "k"];
  function amount(v, unit) { // with its unit: volts to a millivolt, currents with a prefix
    if (Number.isNaN(v)) return "-";
    if (unit === "V") return `${(Math.abs(v) < 5e-4 ? 0 : v).toFixed(3)}V`;
    if (Math.abs(v) < 1e-18) return `0${unit}`;
    const k = Math.min(7, Math.max(0, Math.floor(Math.log10(Math.abs(v)) / 3 + 1e-9) + 6));
    return `${Number((v / 10 ** (3 * k - 18)).toPrecision(3))}${PREFIXES[k]}${unit}`;
  }

  // ---- the arrays
  async function bytes() {
    const text = atob(document.getElementById("arrays").textContent.trim());
    const packed = new Uint8Array(text.length);
    for (let k = 0; k < text.length; k++) packed[k] = text.charCodeAt(k);
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }
  function array(entry, all) {
    const Type = TYPES[entry.type], width = Type.BYTES_PER_ELEMENT, n = entry.length;
    const raw = new Uint8Array(n * width);
    for (let p = 0; p < width; p++) for (let k = 0; k < n; k++) raw[k * width + p] = all[entry.at + p * n + k];
    const values = new Type(raw.buffer);
    if (entry.quantum === undefined) return values;
    const times = new Float64Array(n);
    for (let k = 0, ticks = 0; k < n; k++) times[k] = entry.from + (ticks += values[k]) * entry.quantum;
    return times;
  }
  const made = new Map(); // arrays that several lines have are made once
  function filled(value, all) {
    if (Array.isArray(value)) return value.map((v) => filled(v, all));
    if (value === null || typeof value !== "object") return value;
    if ("type" in value && "at" in value && "length" in value) {
      const key = `${value.at} ${value.length}`;
      if (!made.has(key)) made.set(key, array(value, all));
      return made.get(key);
    }
    return Object.fromEntries(Object.entries(value).map(([k, v]) => [k, filled(v, all)]));
  }
  const all = await bytes();
  const films = filled(JSON.parse(document.getElementById("films").textContent), all);
  const duration = Math.max(...films.map((f) => f.duration));
  const [second, clocked] = [[1, "s"], [1e-3, "ms"], [1e-6, "us"], [1e-9, "ns"], [1e-12, "ps"]].find(([u]) => duration >= u) || [1, "s"];
  const moment = (t) => `${number(t / second)} ${clocked}`;
  const window_ = Math.min(WINDOW, duration / 100);
  for (let slow = 0.02; slow > duration / 100; slow /= 10) SPEEDS.unshift(slow / 4, slow / 2, slow);
  SPEEDS.forEach((s, k) => { SPEEDS[k] = Number(s.toPrecision(1)); });

  // ---- what is where at a time
  function after(times, t) { // first index whose time is above t
    let low = 0, high = times.length;
    while (low < high) { const mid = (low + high) >> 1; if (times[mid] > t) high = mid; else low = mid + 1; }
    return low;
  }
  function value(line, t) {
    const k = after(line.time, t) - 1;
    if (k < 0) return NaN;
    if (line.step || k + 1 >= line.time.length) return line.value[k];
    const part = (t - line.time[k]) / (line.time[k + 1] - line.time[k] || 1);
    return line.value[k] + part * (line.value[k + 1] - line.value[k]);
  }
  function pose(track, t) {
    const k = Math.max(0, after(track.time, t) - 1), next = Math.min(k + 1, track.time.length - 1);
    const span = track.time[next] - track.time[k], step = Math.hypot(track.x[next] - track.x[k], track.y[next] - track.y[k]);
    const part = span > 0 && !(track.longest > 0 && step > track.longest) ? Math.min(1, Math.max(0, (t - track.time[k]) / span)) : 0;
    const mix = (a) => a[k] + part * (a[next] - a[k]);
    let heading = null;
    if (track.heading) {
      const turn = track.heading[next] - track.heading[k];
      heading = track.heading[k] + part * Math.atan2(Math.sin(turn), Math.cos(turn));
    }
    return { k, x: mix(track.x), y: mix(track.y), heading };
  }

  // ---- state of the page
  const usual = duration >= 1 ? 1 : SPEEDS.findLast((s) => s <= duration / 5) || SPEEDS[0]; // a film of some seconds
  const state = { t: 0, from: 0, to: duration, playing: false, speed: usual, frames: 0, chosen: null };
  const panels = [], scenes = [];
  const page = document.getElementById("page");
  page.replaceChildren();

  function canvas(width, height, label) {
    const node = element("canvas", { tabIndex: 0, role: "img", ariaLabel: label });
    node.style.width = `${width}px`;
    node.style.height = `${height}px`;
    return node;
  }
  function halo(g, text, x, y, colour) { // a text that is readable on what is drawn below it
    g.save();
    g.lineWidth = 3;
    g.lineJoin = "round";
    g.strokeStyle = ink("--back");
    g.strokeText(text, x, y);
    g.fillStyle = colour;
    g.fillText(text, x, y);
    g.restore();
  }
  function sized(node) { // its context in CSS pixels, cleared
    const scale = window.devicePixelRatio || 1, box = node.getBoundingClientRect();
    node.width = Math.max(1, Math.round(box.width * scale));
    node.height = Math.max(1, Math.round(box.height * scale));
    const g = node.getContext("2d");
    g.setTransform(scale, 0, 0, scale, 0, 0);
    return { g, w: box.width, h: box.height };
  }

  // ---- the world from above
  const LOOKS = { floor: "--pale", shade: "--line", obstacle: "--soft", wall: "--ink", goal: "--c2",
    start: "--c3", way: "--soft", moving: "--c1", sound: "--c5" };
  function scene(film, place) {
    const world = film.world, node = canvas(560, 420, `world of ${film.title}, from above`);
    const points = world.shapes.flatMap((s) => s.points.flatMap(([x, y]) =>
      [[x - s.radius, y - s.radius], [x + s.radius, y + s.radius]]));
    for (const track of world.tracks) for (let k = 0; k < track.x.length; k++) points.push([track.x[k], track.y[k]]);
    let [l, r, b, u] = [Infinity, -Infinity, Infinity, -Infinity];
    for (const [x, y] of points) { l = Math.min(l, x); r = Math.max(r, x); b = Math.min(b, y); u = Math.max(u, y); }
    const margin = 0.04 * Math.max(r - l, u - b, 1e-9), span = [r - l + 2 * margin, u - b + 2 * margin];
    const [widest, highest] = films.length > 1 ? [660, 420] : film.eye ? [760, 460] : [1040, 520];
    const narrow = Math.min(widest, document.documentElement.clientWidth - 40), ratio = span[1] / span[0];
    const width = Math.max(220, Math.min(narrow, highest / ratio));
    node.style.width = `${width}px`;
    node.style.height = `${Math.max(110, Math.min(highest, width * ratio))}px`;
    const still = document.createElement("canvas");
    let scale = 1, to = null;
    const shape = (g, s) => {
      g.beginPath();
      if (s.radius > 0) g.arc(...to(...s.points[0]), Math.max(1, s.radius * scale), 0, 7);
      else s.points.forEach(([x, y], k) => (k ? g.lineTo(...to(x, y)) : g.moveTo(...to(x, y))));
      if (s.closed && s.radius === 0) g.closePath();
      const look = s.colour || ink(LOOKS[s.role]);
      if (s.points.length === 1 && s.radius === 0) { g.arc(...to(...s.points[0]), 5, 0, 7); }
      if (s.closed || s.radius > 0) {
        g.globalAlpha = s.role === "goal" || s.role === "start" ? 0.55 : 1;
        g.fillStyle = look;
        g.fill();
        g.globalAlpha = 1;
      }
      if (!s.closed || s.role === "obstacle" || s.role === "floor" || s.colour) {
        g.setLineDash(s.role === "way" ? [3, 3] : []);
        g.strokeStyle = s.closed && !(s.colour && s.role === "shade") ? ink("--soft") : look; // of its own colour without a seam
        g.lineWidth = s.role === "wall" ? 1.6 : 0.7;
        g.stroke();
        g.setLineDash([]);
      }
    };
    const jumps = (track, k) => track.longest > 0 &&
      Math.hypot(track.x[k] - track.x[k - 1], track.y[k] - track.y[k - 1]) > track.longest;
    const way = (g, track, last) => {
      for (let k = 0; k <= last; k++)
        if (k && !jumps(track, k)) g.lineTo(...to(track.x[k], track.y[k]));
        else g.moveTo(...to(track.x[k], track.y[k]));
    };
    const named_ = (g, text, at, y, wide) => { // inside the picture, and readable on whatever is below
      g.font = "11px system-ui, sans-serif";
      halo(g, text, Math.max(2, Math.min(at, wide - g.measureText(text).width - 3)), Math.max(10, y), g.fillStyle);
    };
    const draw = () => { // what stands, and all ways, pale
      const { w, h } = sized(node);
      scale = Math.min(w / span[0], h / span[1]);
      const left = (w - scale * (r - l)) / 2, low = (h - scale * (u - b)) / 2;
      to = (x, y) => [left + (x - l) * scale, world.north ? h - low - (y - b) * scale : low + (y - b) * scale];
      still.width = node.width;
      still.height = node.height;
      const g = still.getContext("2d"), ratio = window.devicePixelRatio || 1;
      g.setTransform(ratio, 0, 0, ratio, 0, 0);
      g.clearRect(0, 0, w, h);
      for (const s of world.shapes) shape(g, s);
      world.tracks.forEach((track) => {
        g.beginPath();
        way(g, track, track.x.length - 1);
        g.strokeStyle = ink(track.role === "robot" ? "--c0" : "--c1");
        g.globalAlpha = 0.4;
        g.lineWidth = 1;
        g.stroke();
        g.globalAlpha = 1;
      });
    };
    const follow = () => {
      const g = node.getContext("2d"), ratio = window.devicePixelRatio || 1;
      g.setTransform(1, 0, 0, 1, 0, 0);
      g.clearRect(0, 0, node.width, node.height);
      g.drawImage(still, 0, 0);
      g.setTransform(ratio, 0, 0, ratio, 0, 0);
      for (const track of world.tracks) {
        const now = pose(track, state.t), colour = ink(track.role === "robot" ? "--c0" : "--c1");
        g.beginPath();
        way(g, track, now.k);
        g.lineTo(...to(now.x, now.y));
        g.strokeStyle = colour;
        g.lineWidth = 2;
        if (track.role === "robot") g.stroke();
        g.beginPath();
        const [x, y] = to(now.x, now.y), up = world.north ? -1 : 1;
        const turned = (a, c) => {
          const s = Math.sin(now.heading || 0), q = Math.cos(now.heading || 0);
          return [x + scale * (a * q - c * s), y + up * scale * (a * s + c * q)];
        };
        const size = Math.max(4, track.radius * scale);
        if (track.outline.length && scale * Math.hypot(...track.outline[0]) > 4)
          track.outline.forEach(([a, c], k) => (k ? g.lineTo(...turned(a, c)) : g.moveTo(...turned(a, c))));
        else g.arc(x, y, size, 0, 7);
        g.closePath();
        g.fillStyle = colour;
        g.fill();
        named_(g, track.name, x + size + 3, y - size - 2, node.clientWidth);
        if (now.heading !== null) {
          g.beginPath();
          g.moveTo(x, y);
          g.lineTo(x + 2.2 * size * Math.cos(now.heading), y + up * 2.2 * size * Math.sin(now.heading));
          g.lineWidth = 2.5;
          g.stroke();
        }
      }
    };
    place.append(element("figure", {}, node, element("figcaption", {},
      `from above, ${number(r - l)} by ${number(u - b)} ${world.unit}`, ...legend(world))));
    scenes.push({ draw, follow });
  }
  function legend(world) { // what stands there, each look once
    const known = new Map();
    for (const s of world.shapes)
      if (s.role !== "floor" && (s.name || !s.colour)) known.set(`${s.role} ${s.colour} ${s.name}`, s);
    return [...known.values()].slice(0, 12).map((s) => {
      const line = !s.closed, mark = element("i", { className: line ? "line" : "area" });
      mark.style.color = s.colour || `var(${LOOKS[s.role]})`;
      if (s.role === "way") mark.style.borderTopStyle = "dashed";
      if (s.role === "goal" || s.role === "start") mark.style.opacity = 0.55;
      return element("span", { className: "key" }, mark, s.name || s.role);
    });
  }

  // ---- what the camera sends
  function eye(film, place) {
    const e = film.eye, node = canvas(300, (300 * e.rows) / e.columns, `${e.name} of ${film.title}`);
    const still = document.createElement("canvas");
    still.width = e.columns;
    still.height = e.rows;
    const g0 = still.getContext("2d"), image = g0.createImageData(e.columns, e.rows);
    const rgb = (name) => { const c = ink(name); return [1, 3, 5].map((k) => parseInt(c.slice(k, k + 2), 16)); };
    let colours = null, context = null;
    const draw = () => {
      context = sized(node);
      colours = { on: rgb("--on"), off: rgb("--off"), back: rgb("--pale") };
    };
    const told = element("span");
    const follow = () => {
      const d = image.data, { on, off, back } = colours;
      for (let k = 0; k < d.length; k += 4) { d[k] = back[0]; d[k + 1] = back[1]; d[k + 2] = back[2]; d[k + 3] = 255; }
      const first = after(e.time, state.t - GLOW), last = after(e.time, state.t);
      for (let k = first; k < last; k++) {
        const at = 4 * ((e.rows - 1 - e.y[k]) * e.columns + e.x[k]), c = e.on[k] ? on : off;
        d[at] = c[0]; d[at + 1] = c[1]; d[at + 2] = c[2];
      }
      g0.putImageData(image, 0, 0);
      context.g.imageSmoothingEnabled = false;
      context.g.drawImage(still, 0, 0, context.w, context.h);
      told.textContent = `${last - first} events in the last ${1e3 * GLOW} ms of ${e.time.length}`;
    };
    place.append(element("figure", {}, node, element("figcaption", {},
      `${e.name}: brighter blue, darker orange; `, told)));
    scenes.push({ draw, follow });
  }

  // ---- signals
  const x = (t, w) => ((t - state.from) / (state.to - state.from)) * w;
  const DECADES = 8; // below the largest magnitude that a logarithmic axis shows; ours
  function limits(panel) { // of the lines that are shown; decades where the axis is logarithmic
    let low = Infinity, high = -Infinity, most = 0;
    for (const line of panel.lines) if (line.shown) for (const v of line.value) if (v === v) {
      if (v < low) low = v;
      if (v > high) high = v;
      most = Math.max(most, Math.abs(v));
    }
    if (panel.log) return most > 0 ? [Math.log10(most) - DECADES, Math.log10(most) + 0.3] : [-1, 1];
    if (!(low <= high)) return [0, 1];
    if (panel.words.length) return [-0.25, panel.words.length - 0.75];
    const room = high > low ? 0.06 * (high - low) : 0.5 * Math.abs(high) || 1;
    return [low - room, high + room];
  }
  function traced(g, line, w, h, low, high, log) { // lowest and highest value of each pixel's width
    const at = log ? (v) => Math.max(low, Math.log10(Math.abs(v) + 1e-40)) : (v) => v;
    const tall = (v) => h - ((v - low) / (high - low)) * h, y = (v) => tall(at(v));
    const first = Math.max(0, after(line.time, state.from) - 1);
    const last = Math.min(line.time.length, after(line.time, state.to) + 1);
    g.beginPath();
    if (last - first > 4 * w) {
      let k = first, before = NaN;
      for (let column = 0; column < w; column++) {
        const until = state.from + ((column + 1) / w) * (state.to - state.from), from = k;
        let a = Infinity, b = -Infinity;
        for (; k < last && line.time[k] <= until; k++) {
          const v = at(line.value[k]);
          if (v < a) a = v;
          if (v > b) b = v;
        }
        if (!(a <= b)) continue;
        if (before === before) g.lineTo(column, tall(line.step ? before : at(line.value[from])));
        g.moveTo(column, tall(a));
        g.lineTo(column, tall(b) - 0.5);
        before = at(line.value[k - 1]);
        g.moveTo(column, tall(before));
      }
    } else {
      let open = false;
      for (let k = first; k < last; k++) {
        const v = line.value[k];
        if (v !== v) { open = false; continue; }
        const across = x(line.time[k], w);
        if (open && line.step) g.lineTo(across, y(line.value[k - 1]));
        if (open) g.lineTo(across, y(v)); else g.moveTo(across, y(v));
        open = true;
      }
      if (line.step && open) g.lineTo(w, y(line.value[last - 1]));
    }
    g.stroke();
  }
  function steps(low, high, most) {
    const raw = (high - low) / most || 1, power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= raw);
    const found = [];
    for (let v = Math.ceil(low / step) * step; v <= high; v += step) found.push(Math.abs(v) < step / 1e6 ? 0 : v);
    return found;
  }
  function panel(film, given, place, own) {
    const FOOT = 15; // px below what is drawn, for the times
    const rows = given.raster ? given.raster.rows.length : 0;
    const many = given.lines.length > MANY;
    const height = given.raster ? Math.min(240, Math.max(rows > 3 ? 60 : 40, (rows > 40 ? 2 : 10) * rows + FOOT)) : many ? 190 : 110;
    const base = element("canvas"), top = element("canvas", { tabIndex: 0, role: "img",
      ariaLabel: `${given.title} of ${film.title} over time` });
    const stack = element("div", { className: "stack" }, base, top);
    stack.style.height = `${height}px`;
    const list = element("dl", { className: "state" });
    list.style.maxHeight = `${Math.max(17 * Math.min(8, given.lines.length + rows + 1), height) + 2}px`; // eight rows, or more by scrolling
    const heading = element("h2", { textContent: given.title + (given.unit ? ` (${given.unit})` : "") });
    if (given.unit === "A") {
      given.log ??= !!film.drawing; // of a circuit, whose currents are of many decades
      const log = element("button", { type: "button", className: "small",
        textContent: "magnitude on a logarithmic axis", ariaPressed: String(given.log) });
      log.onclick = () => {
        given.log = !given.log;
        log.ariaPressed = String(given.log);
        [low, high] = limits(given);
        draw();
        follow();
      };
      heading.append(" ", log);
    }
    given.lines.filter((l) => l.shown).forEach((l, k) => { l.colour ??= k % COLOURS; });
    const box = element("section", {}, heading, element("div", { className: "panel" }, stack, list));
    place.append(box);
    let [low, high] = limits(given), size = null;
    const draw = () => {
      size = sized(base);
      const { g, w, h } = size;
      g.clearRect(0, 0, w, h);
      g.font = "11px system-ui, sans-serif";
      g.strokeStyle = ink("--line");
      g.lineWidth = 0.5;
      const times = steps(state.from, state.to, 8), gap = (times[1] - times[0] || 1) / second;
      const mark = (t) => `${(t / second).toFixed(Math.min(9, Math.max(0, -Math.floor(Math.log10(gap) + 1e-9))))} ${clocked}`;
      for (const t of times) {
        g.beginPath(); g.moveTo(x(t, w), 0); g.lineTo(x(t, w), h); g.stroke();
        g.fillStyle = ink("--soft");
        if (x(t, w) + g.measureText(mark(t)).width < w) g.fillText(mark(t), x(t, w) + 2, h - 3);
      }
      const high_ = h - FOOT, ticks = given.words.length ? [...given.words.keys()] : steps(low, high, 4);
      const across = (v) => high_ - ((v - low) / (high - low)) * high_;
      g.beginPath(); g.moveTo(0, high_); g.lineTo(w, high_); g.stroke();
      if (given.lines.length) for (const v of ticks) {
        g.beginPath(); g.moveTo(0, across(v)); g.lineTo(w, across(v)); g.stroke();
      }
      g.lineWidth = 1.2;
      for (const line of given.lines) if (line.shown) {
        g.strokeStyle = ink(`--c${line.colour}`);
        traced(g, line, w, high_, low, high, given.log);
      }
      let below = Infinity; // of the label before, from below upwards
      if (given.lines.length) for (const v of ticks) {
        const y = Math.min(Math.max(across(v) - 2, 10), high_ - 3);
        if (below - y < 11) continue;
        below = y;
        const text = given.words[v] || (given.unit === "A" ? amount(given.log ? 10 ** v : v, "A") : number(v));
        halo(g, text, 3, y, ink("--soft"));
      }
      if (given.raster) {
        const { time, row, groups } = given.raster, tall = high_ / rows;
        for (const group of groups) {
          g.beginPath(); g.moveTo(0, group.first * tall); g.lineTo(w, group.first * tall); g.stroke();
        }
        g.fillStyle = ink("--ink");
        let held = -1;
        for (let k = after(time, state.from); k < time.length && time[k] <= state.to; k++) {
          const at = (Math.round(x(time[k], w)) << 10) | row[k];
          if (at !== held) g.fillRect(x(time[k], w), row[k] * tall + 1, 1, Math.max(1.2, tall - 1.5));
          held = at;
        }
        for (const group of groups) if (group.count * tall > 9) {
          const wide = g.measureText(group.name).width, y = group.first * tall;
          g.fillStyle = ink("--back");
          g.fillRect(1, y + 1, wide + 5, 13);
          g.fillStyle = ink("--ink");
          g.fillText(group.name, 3, y + 11);
        }
      }
      sized(top);
    };
    const marks = new Map();
    given.toggle = (name) => { // draws a line, or no longer
      const line = given.lines.find((l) => l.name === name);
      line.shown = !line.shown;
      const used = given.lines.filter((l) => l.shown && l !== line).map((l) => l.colour);
      const counts = Array.from({ length: COLOURS }, (_, k) => used.filter((c) => c === k).length);
      line.colour = counts.indexOf(Math.min(...counts));
      marks.get(name)();
      [low, high] = limits(given);
      draw();
      follow();
    };
    const told = [...given.lines].sort((a, b) => b.shown - a.shown).map((line) => {
      const what = given.lines.length > 1
        ? element("button", { textContent: line.name, type: "button", onclick: () => toggleAll(given, line.name) })
        : element("span", { textContent: line.name });
      const shown = element("b"), row = element("div", {}, what, shown);
      marks.set(line.name, () => {
        row.style.borderLeftColor = line.shown ? `var(--c${line.colour})` : "transparent";
        row.classList.toggle("hidden", !line.shown);
        if (given.lines.length > 1) what.ariaPressed = String(line.shown);
      });
      marks.get(line.name)();
      list.append(row);
      let before = null;
      return () => {
        const v = value(line, state.t);
        const text = given.words[v] || (given.unit === "A" ? amount(v, "A") : number(Math.abs(v) < 1e-6 ? 0 : v));
        if (text !== before) shown.textContent = before = text;
      };
    });
    if (given.raster) {
      const counts = new Int32Array(rows), shown = [];
      given.raster.rows.forEach((name, k) => {
        if (rows > 24 && !film.neurons.some((n) => n.name === name)) return;
        const known = film.neurons.find((n) => n.name === name), count = element("b");
        const group = given.raster.groups.find((one) => k >= one.first && k < one.first + one.count);
        const shownAs = group && !name.startsWith(group.name) ? `${group.name} ${name}` : name;
        const what = known
          ? element("button", { textContent: shownAs, type: "button", onclick: () => choose(film, known) })
          : element("span", { textContent: shownAs });
        list.append(element("div", {}, what, count));
        shown.push([k, count]);
      });
      const total = element("b");
      list.append(element("div", {}, element("span", { textContent: `in ${duration >= 1 ? `${number(1e3 * window_)} ms` : moment(window_)}` }), total));
      told.push(() => {
        const { time, row } = given.raster;
        counts.fill(0);
        const first = after(time, state.t - window_), last = after(time, state.t);
        for (let k = first; k < last; k++) counts[row[k]]++;
        for (const [k, node] of shown) node.textContent = counts[k] || "";
        total.textContent = `${last - first} ${last - first === 1 ? "spike" : "spikes"}`;
      });
    }
    const follow = () => {
      const g = top.getContext("2d"), ratio = window.devicePixelRatio || 1;
      g.setTransform(ratio, 0, 0, ratio, 0, 0);
      g.clearRect(0, 0, size.w, size.h);
      const at = x(state.t, size.w);
      g.fillStyle = ink("--cursor");
      g.fillRect(at - 0.75, 0, 1.5, size.h);
      told.forEach((tell) => tell());
    };
    let pressed = null;
    const time = (event) => {
      const box = top.getBoundingClientRect();
      return state.from + ((event.clientX - box.left) / box.width) * (state.to - state.from);
    };
    top.onpointerdown = (event) => { pressed = { at: event.clientX, from: state.from, to: state.to, moved: false };
      top.setPointerCapture(event.pointerId); };
    top.onpointermove = (event) => {
      if (!pressed) return;
      const by = ((pressed.at - event.clientX) / top.clientWidth) * (pressed.to - pressed.from);
      if (Math.abs(event.clientX - pressed.at) < 4 && !pressed.moved) return;
      pressed.moved = true;
      zoom(pressed.from + by, pressed.to + by);
    };
    top.onpointerup = (event) => {
      if (pressed && !pressed.moved) {
        seek(time(event));
        if (given.raster) {
          const box = top.getBoundingClientRect();
          const row = Math.floor((event.clientY - box.top) / ((box.height - FOOT) / rows));
          const known = film.neurons.find((n) => n.name === given.raster.rows[row]);
          if (known) choose(film, known);
        }
      }
      pressed = null;
    };
    top.onwheel = (event) => {
      event.preventDefault();
      const t = time(event), by = Math.exp(0.0015 * event.deltaY);
      zoom(t - (t - state.from) * by, t + (state.to - t) * by);
    };
    top.ondblclick = () => zoom(0, duration);
    const entry = { draw, follow, own };
    panels.push(entry);
    return { entry, box };
  }

  // ---- a neuron's inside
  const inside = element("section", { id: "inside", className: films.some((f) => f.drawing) ? "circuit" : "", hidden: true, tabIndex: -1 });
  inside.setAttribute("aria-live", "polite");
  const named = (film, name) => film.neurons.find((n) => n.name === name);
  function devicesOf(film, neuron, like) { // in the order of those beside it
    const order = new Map(like.devices.map((d, k) => [d.path, k])), at = (d) => order.get(d.path) ?? order.size;
    const devices = [...neuron.devices].sort((a, b) => at(a) - at(b));
    const closer = element("div", { className: "closer" }), tried = neuron.devices.some((d) => d.mended);
    const look = (d) => { // what it would be like without its deviation
      for (let k = panels.length - 1; k >= 0; k--) if (panels[k].own === closer) panels.splice(k, 1);
      closer.replaceChildren();
      panel(film, d.waveform, closer, closer);
      panels.filter((p) => p.own === closer).forEach((p) => p.draw());
      follow();
      closer.scrollIntoView({ block: "nearest" });
    };
    const rows = devices.map((d) => {
      const name = element("code", { textContent: d.path });
      const path = d.waveform ? element("button", { type: "button", onclick: () => look(d) }, name) : name;
      return element("tr", {}, element("td", {}, path), ...(tried ? [element("td", { textContent: d.mended })] : []),
        element("td", { textContent: d.deviation }), element("td", { className: "number", textContent: number(d.sigma) }),
        element("td", { textContent: d.what }));
    });
    const heads = ["device", ...(tried ? ["what healing it alone would do"] : []), "deviation on this die", "sigma", "what"];
    const head = heads.map((text) => element("th", { textContent: text, className: text === "sigma" ? "number" : "" }));
    const table = element("table", {}, element("thead", {}, element("tr", {}, ...head)), element("tbody", {}, ...rows));
    return element("div", {}, closer, table);
  }
  function visit(film, moment) {
    zoom(moment.begin, moment.end);
    seek(moment.time);
    const neuron = named(film, moment.neuron);
    if (neuron) choose(film, neuron);
  }
  function choose(film, neuron) { // of the film beside it too, where that has one of this name
    state.chosen = neuron.name;
    for (let k = panels.length - 1; k >= 0; k--) if (panels[k].own) panels.splice(k, 1);
    const count = neuron.devices.length > 1 ? `: ${neuron.devices.length} devices` : "";
    const close = element("button", { textContent: "close", type: "button", onclick: () => {
      inside.hidden = true;
      state.chosen = null;
      follow();
    } });
    inside.replaceChildren(close, element("h2", { textContent: neuron.name + count }));
    inside.hidden = false;
    const grid = element("div", { className: "films" });
    const both = films.filter((each) => named(each, neuron.name));
    grid.style.setProperty("--films", both.length);
    inside.append(grid);
    for (const each of both) {
      const own = named(each, neuron.name), place = element("div");
      grid.append(place);
      if (both.length > 1) place.append(element("p", { textContent: each.title }));
      if (own.waveform) {
        const [begin, end] = [Math.min, Math.max].map((f) => f(...own.waveform.lines.flatMap((l) => [l.time[0], l.time[l.time.length - 1]])));
        if (end - begin < duration / 10) place.append(element("button", { type: "button", className: "small",
          textContent: `go to ${moment(begin)} to ${moment(end)}`, onclick: () => { zoom(begin, end); seek(begin); } }));
        panel(each, own.waveform, place, true);
      }
      else place.append(element("p", { textContent: "no waveform of this neuron is in the file; a run with --inside and its name has one" }));
      place.append(devicesOf(each, own, named(both[0], neuron.name)));
    }
    panels.filter((p) => p.own).forEach((p) => p.draw());
    follow();
    inside.scrollIntoView({ block: "nearest" });
  }
  function toggleAll(given, name) { // in the films beside it too
    for (const film of films) for (const each of film.panels)
      if (each === given || (each.title === given.title && film.panels.every((p) => p !== given)))
        if (each.lines.some((l) => l.name === name)) each.toggle(name);
    if (!films.some((film) => film.panels.includes(given))) given.toggle(name);
  }
  function toggleOf(film, unit, name) {
    const given = film.panels.find((p) => p.unit === unit && p.lines.some((l) => l.name === name));
    if (given) toggleAll(given, name);
  }

  // ---- time
  const clock = element("output", { id: "clock" });
  const scrub = element("input", { type: "range", min: 0, max: 10000, step: 1, value: 0, ariaLabel: "time" });
  const play = element("button", { type: "button", id: "play", textContent: "play" });
  const speed = element("select", { ariaLabel: "speed" },
    ...SPEEDS.map((s) => element("option", { value: s, textContent: `${s} x` })));
  speed.value = state.speed;
  function follow() {
    clock.textContent = `${(state.t / second).toFixed(3)} ${clocked} of ${moment(duration)}`;
    scrub.value = Math.round((1e4 * state.t) / duration);
    for (const each of scenes) each.follow();
    for (const each of panels) each.follow();
  }
  function redraw() { for (const each of [...scenes, ...panels]) each.draw(); follow(); }
  function seek(t) {
    state.t = Math.min(duration, Math.max(0, t));
    const span = state.to - state.from;
    if (state.t > state.to || state.t < state.from) {
      state.from = Math.min(Math.max(0, state.t - 0.1 * span), duration - span);
      state.to = state.from + span;
      for (const each of panels) each.draw();
    }
    follow();
  }
  function zoom(from, to) {
    const span = Math.min(duration, Math.max(1e-7 * duration, to - from));
    state.from = Math.min(Math.max(0, from), duration - span);
    state.to = state.from + span;
    for (const each of panels) each.draw();
    follow();
  }
  let last = 0;
  function frame(now) {
    if (!state.playing) return;
    state.frames++;
    const t = state.t + ((now - last) / 1e3) * state.speed;
    last = now;
    if (t >= duration) { seek(duration); toggle(); return; }
    seek(t);
    requestAnimationFrame(frame);
  }
  function toggle() {
    state.playing = !state.playing;
    play.textContent = state.playing ? "pause" : "play";
    if (!state.playing) return;
    if (state.t >= duration) state.t = 0;
    last = performance.now();
    requestAnimationFrame(frame);
  }
  const quicken = (by) => {
    const k = Math.min(SPEEDS.length - 1, Math.max(0, SPEEDS.indexOf(state.speed) + by));
    state.speed = SPEEDS[k];
    speed.value = state.speed;
  };
  const shade = () => {
    const root = document.documentElement, dark = matchMedia("(prefers-color-scheme: dark)").matches;
    root.dataset.theme = (root.dataset.theme || (dark ? "dark" : "light")) === "dark" ? "light" : "dark";
    redraw();
  };
  play.onclick = toggle;
  scrub.oninput = () => seek((scrub.value / 1e4) * duration);
  speed.onchange = () => { state.speed = Number(speed.value); };
  document.addEventListener("keydown", (event) => {
    if (event.target.tagName === "SELECT" || event.ctrlKey || event.metaKey || event.altKey) return;
    const step = ((state.to - state.from) / 100) * (event.shiftKey ? 10 : 1);
    const keys = { " ": toggle, ArrowRight: () => seek(state.t + step), ArrowLeft: () => seek(state.t - step),
      Home: () => seek(0), End: () => seek(duration), "+": () => quicken(1), "-": () => quicken(-1),
      i: () => zoom(state.t - (state.to - state.from) / 4, state.t + (state.to - state.from) / 4),
      o: () => zoom(state.from - (state.to - state.from) / 2, state.to + (state.to - state.from) / 2),
      0: () => zoom(0, duration), d: shade };
    if (!keys[event.key] || (event.target.tagName === "BUTTON" && event.key === " ")) return;
    event.preventDefault();
    keys[event.key]();
  });

  // ---- the page
  const controls = element("div", { className: "controls" }, play, clock, scrub, speed,
    element("button", { type: "button", textContent: "dark or light", onclick: shade }));
  page.append(controls);
  const grid = element("div", { className: "films" });
  grid.style.setProperty("--films", films.length);
  page.append(grid);
  for (const film of films) {
    const column = element("article", { className: film.drawing ? "circuit" : "" }), place = element("div", { className: "scene" });
    const moments = film.moments.map((m) => element("button", { type: "button", className: "moment",
      textContent: `${m.name} at ${moment(m.time)}${m.neuron ? `: ${m.neuron} ${m.why}` : ""}`, onclick: () => visit(film, m) }));
    column.append(element("h1", { textContent: film.title }), element("p", { textContent: film.headline }),
      ...(moments.length ? [element("p", {}, ...moments)] : []), place);
    grid.append(column);
    if (film.world) scene(film, place);
    if (film.eye) eye(film, place);
    if (film.drawing) {
      const schematic = schematicOf(film, { element, ink, value, amount, state, choose, toggle: toggleOf });
      place.append(schematic.node);
      scenes.push({ draw: () => {}, follow: schematic.follow });
    }
    for (const given of film.panels) panel(film, given, column, false);
    const facts = Object.entries(film.facts).flatMap(([k, v], n) => [n ? ", " : "", `${k} `, element("b", { textContent: v })]);
    column.append(element("p", { className: "facts" }, ...facts));
    if (film.command) column.append(element("p", {}, element("code", { textContent: film.command })));
  }
  page.append(inside);
  const help = element("p");
  help.innerHTML = "<kbd>space</kbd> play, <kbd>&larr;</kbd> <kbd>&rarr;</kbd> step (with <kbd>shift</kbd> ten)," +
    " <kbd>+</kbd> <kbd>-</kbd> speed, <kbd>i</kbd> <kbd>o</kbd> zoom, <kbd>0</kbd> all, <kbd>d</kbd> dark or light;" +
    " wheel zooms, drag moves, click goes to a time and into a neuron";
  page.append(help);
  page.removeAttribute("aria-busy");
  addEventListener("resize", redraw);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  redraw();
  window.noctule = { state, films, seek, toggle, zoom, value, ready: performance.now() };
})();
