"use strict";
// A circuit's schematic: each net shows its voltage at the cursor, each device its current.
function schematicOf(film, tools) {
  const { element, ink, value, amount, state, choose, toggle } = tools;
  const drawing = film.drawing, SPAN = 4; // decades of current below the largest that are told by colour; ours
  const space = element("div", { innerHTML: "<svg></svg>" }).firstChild.namespaceURI;
  const svg = (name, given = {}, ...children) => {
    const node = document.createElementNS(space, name);
    for (const [key, each] of Object.entries(given)) node.setAttribute(key, each);
    node.append(...children);
    return node;
  };
  const { width, height } = drawing;
  const root = svg("svg", { viewBox: `0 0 ${width} ${height}`, class: "schematic", role: "group",
    "aria-label": `schematic of ${film.title}` });
  const LARGE = 1.4; // pixels a point at which it is easily read; ours
  root.style.maxWidth = `${width * LARGE}px`;
  const lines = (unit) => new Map(film.panels.filter((p) => p.unit === unit).flatMap((p) => p.lines.map((l) => [l.name, l])));
  const volts = lines("V"), amps = lines("A"), nets = new Map(), devices = new Map();
  const known = new Map(film.neurons.map((n) => [n.name, n]));
  const reach = (all, size) => { let most = 0; for (const l of all.values()) for (const v of l.value) most = Math.max(most, size(v)); return most; };
  const highest = reach(volts, (v) => v) || 1, largest = reach(amps, Math.abs) || 1;

  const pressed = (node, label, act) => {
    node.setAttribute("role", "button");
    node.setAttribute("tabindex", "0");
    node.setAttribute("aria-label", label);
    node.onclick = act;
    node.onkeydown = (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      event.stopPropagation();
      act();
    };
  };
  const group = (of, name, kind) => {
    if (!of.has(name)) {
      const node = svg("g", { class: kind });
      of.set(name, { node, texts: [], box: [Infinity, Infinity, -Infinity, -Infinity] });
      root.append(node);
    }
    return of.get(name);
  };
  const of = (piece) => (piece.device ? group(devices, piece.device, "device") : group(nets, piece.net, "net"));
  const joined = (points) => points.map((p) => p.join(",")).join(" ");
  for (const stroke of drawing.strokes) {
    const own = of(stroke), points = joined(stroke.points), look = stroke.filled ? "filled" : "open";
    const [[x, y]] = stroke.points;
    if (stroke.radius > 0) own.node.append(svg("circle", { cx: x, cy: y, r: stroke.radius, class: look }));
    else own.node.append(svg(stroke.filled ? "polygon" : "polyline", { points, class: look }));
    if (!stroke.device) own.node.append(svg("polyline", { points, class: "near" }));
    for (const [x, y] of stroke.points) {
      const b = own.box;
      [b[0], b[1], b[2], b[3]] = [Math.min(b[0], x), Math.min(b[1], y), Math.max(b[2], x), Math.max(b[3], y)];
    }
  }
  for (const text of drawing.texts) {
    const own = of(text), node = svg("text", { x: text.at[0], y: text.at[1] });
    node.textContent = text.text;
    own.node.append(node);
    let before = null;
    if (text.value) own.texts.push((told) => {
      if (told !== before) node.textContent = text.text ? `${text.text} ${told}` : told;
      before = told;
    });
  }
  for (const [name, each] of devices) {
    const [l, t, r, b] = each.box;
    each.node.append(svg("rect", { x: l - 2, y: t, width: r - l + 4, height: b - t, class: "near" }));
    if (known.has(name)) pressed(each.node, name, () => choose(film, known.get(name)));
  }
  for (const [name, each] of nets) if (volts.has(name)) pressed(each.node, `net ${name}`, () => toggle(film, "V", name));

  const paint = (each, colour) => { // a browser does much even for the colour that is there
    if (each.colour !== colour) each.node.style.color = each.colour = colour;
  };
  const mix = (share, cold, hot) => `color-mix(in oklab, ${hot} ${(100 * Math.min(1, Math.max(0, share))).toFixed(0)}%, ${cold})`;
  const follow = () => {
    const [soft, plain, hot, far] = ["--soft", "--ink", "--c1", "--c0"].map(ink);
    for (const [name, each] of nets) {
      const line = volts.get(name);
      if (!line) { paint(each, plain); continue; }
      const v = value(line, state.t);
      paint(each, mix(v / highest, far, hot));
      each.node.classList.toggle("shown", line.shown);
      for (const tell of each.texts) tell(amount(v, "V"));
    }
    for (const [name, each] of devices) {
      const line = amps.get(name), i = line ? value(line, state.t) : NaN;
      paint(each, mix(1 + Math.log10(Math.abs(i) / largest + 1e-30) / SPAN, soft, plain));
      each.node.classList.toggle("chosen", state.chosen === name);
      for (const tell of each.texts) tell(amount(i, "A"));
    }
  };
  const told = "nets from blue (0 V) to orange (" + amount(highest, "V") + "), devices stronger with more current; " +
    "click a device to look into it, a net to draw it";
  const larger = element("button", { type: "button", className: "small", textContent: "larger", ariaPressed: "false" });
  const caption = element("figcaption", {}, larger, told);
  const node = element("figure", { className: "schematics" }, element("div", {}, root), caption);
  larger.onclick = () => {
    const large = larger.ariaPressed === "false";
    larger.ariaPressed = String(large);
    root.style.maxWidth = root.style.width = large ? `${width * LARGE}px` : "";
    if (!large) root.style.maxWidth = `${width * LARGE}px`;
  };
  return { node, follow };
}
