// The explorer's page: draws what Python has worked out, and tells Python what was done.

const SVG = "http://www.w3.org/2000/svg";
const MOST_BYTES = 40e6; // of a file that is opened
const THEMES = ["auto", "light", "dark", "projector"];
const HELP = [
  ["Tab", "from handle to handle, field to field"],
  ["← →", "handle: frequency by 2 %, with Shift by 20 %"],
  ["↑ ↓", "handle: gain or depth by 0.5 dB, with Shift by 3 dB"],
  ["+ −", "handle: wider or narrower; with a mouse, the wheel"],
  ["Delete", "handle: remove the filter"],
  ["Ctrl Z, Ctrl Y", "undo, redo"],
  ["Ctrl S", "save the scenario file"],
];

function make(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (typeof value === "boolean") made.toggleAttribute(name, value);
    else if (value !== undefined) made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
}

function shown(value, digits = 4) {
  if (value === null || value === undefined) return "–";
  return String(Number(value.toPrecision(digits)));
}

// A number at an axis, short.
function tick(value) {
  const size = Math.abs(value);
  if (size && (size >= 1e5 || size < 1e-3)) return value.toExponential().replace("e+", "e");
  return shown(value);
}

// ---- Arrays that come beside a message --------------------------------------------------------

function unpacked(value, buffers) {
  if (Array.isArray(value)) return value.map((each) => unpacked(each, buffers));
  if (value === null || typeof value !== "object") return value;
  if ("$array" in value) {
    const view = buffers[value.$array];
    const bytes = view.buffer.slice(view.byteOffset, view.byteOffset + view.byteLength);
    return new Float32Array(bytes);
  }
  return Object.fromEntries(
    Object.entries(value).map(([name, each]) => [name, unpacked(each, buffers)]),
  );
}

// ---- Messages: one on its way, of those that wait the newest of each gesture ------------------

class Wire {
  constructor(model) {
    this.model = model;
    this.waiting = [];
    this.count = 0;
    this.latencies = [];
    this.sent = null;
  }

  send(message) {
    const last = this.waiting.at(-1);
    const same = last && message.gesture && last.gesture === message.gesture;
    if (same) this.waiting.pop();
    this.waiting.push({ since: performance.now(), ...message });
    this.flush();
  }

  flush() {
    if (this.sent !== null || !this.waiting.length) return;
    const batch = this.waiting.splice(0);
    this.since = batch.at(-1).since;
    for (const { since, ...message } of batch) {
      this.count += 1;
      this.sent = this.count;
      this.model.send({ id: this.count, ...message });
    }
  }

  // The quick part of an answer is there: the next message may go.
  answered(id) {
    if (id !== this.sent) return;
    this.sent = null;
    this.flush();
  }

  forget() {
    this.sent = null;
    this.waiting = [];
  }

  get busy() {
    return this.sent !== null || this.waiting.length > 0;
  }
}

// ---- Plots --------------------------------------------------------------------------------------

const SPOT = 1.5; // pixels, less than a dot is wide
const EDGE = { left: 52, right: 12, top: 8, bottom: 36 };

function steps(low, high, wanted) {
  const rough = (high - low) / wanted;
  const power = 10 ** Math.floor(Math.log10(rough));
  return multiples(low, high, [1, 2, 5, 10].map((n) => n * power).find((size) => size >= rough));
}

function degrees(low, high) {
  const sizes = [45, 90, 180, 360];
  return multiples(low, high, sizes.find((size) => (high - low) / size <= 6) ?? 720);
}

function multiples(low, high, step) {
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1) {
    found.push(Number((k * step).toPrecision(12)));
  }
  return found;
}

function decades(low, high) {
  const found = [];
  for (let k = Math.floor(Math.log10(low)); 10 ** k <= high * 1.001; k += 1) {
    for (let n = 1; n < 10; n += 1) {
      const value = n * 10 ** k;
      if (value >= low * 0.999 && value <= high * 1.001) found.push([value, n === 1]);
    }
  }
  return found;
}

// Plots that are painted behind the frame that shows the numbers, each once.
const waiting = new Set();

function afterwards(plot) {
  if (!waiting.size) {
    requestAnimationFrame(() =>
      setTimeout(() => {
        const plots = [...waiting];
        waiting.clear();
        for (const each of plots) each.paint();
      }),
    );
  }
  waiting.add(plot);
}

class Plot {
  constructor(title, options = {}) {
    this.title = title;
    this.options = options;
    this.svg = document.createElementNS(SVG, "svg");
    this.svg.setAttribute("role", "img");
    this.caption = make("figcaption", {}, title);
    const look = options.look ?? "";
    this.figure = make("figure", { class: look }, this.caption, this.svg);
    this.handles = new Map();
    this.drawn = document.createElementNS(SVG, "g");
    this.held = document.createElementNS(SVG, "g");
    this.svg.append(this.drawn, this.held);
    this.clip = `clip-${Math.random().toString(36).slice(2)}`;
    this.seen = false;
    // Sizes are told, not asked for: asking makes the browser lay the page out at once.
    [this.width, this.height] = [0, 0];
    new ResizeObserver(([entry]) => {
      ({ width: this.width, height: this.height } = entry.contentRect);
      this.paint();
    }).observe(this.svg);
    new IntersectionObserver(([entry]) => this.see(entry.isIntersecting), { rootMargin: "200px" }).observe(this.svg);
  }

  draw(spec) {
    this.spec = spec;
    const keys = (spec.keys ?? []).map(([name, look]) =>
      make("span", { class: look ? `key ${look}` : "" }, name),
    );
    this.caption.replaceChildren(spec.title ?? this.title, ...keys);
    this.svg.setAttribute("aria-label", `${this.title}: ${spec.told ?? ""}`);
    if (this.options.grabbed) this.paint();
    else afterwards(this);
  }

  see(seen) {
    this.seen = seen;
    if (seen && this.stale) this.paint();
  }

  // What is out of sight is painted once it comes into it, or for a picture.
  paint(always = false) {
    this.stale = !(this.seen || always);
    const { width, height } = this;
    if (this.stale || !this.spec || width < 10) return;
    this.svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.scale(width, height);
    this.drawn.innerHTML = [this.axes(width, height), this.inside(width, height)].join("");
    this.place();
  }

  scale(width, height) {
    let { x: [x0, x1], y: [y0, y1] } = this.spec;
    const wide = width - EDGE.left - EDGE.right;
    const high = height - EDGE.top - EDGE.bottom;
    if (this.options.equal) {
      const half = (0.5 * (y1 - y0) * wide) / high;
      const middle = 0.5 * (x0 + x1);
      [x0, x1] = [middle - half, middle + half];
    }
    this.range = { x: [x0, x1], y: [y0, y1] };
    const log = this.options.log;
    const [a, b] = log ? [Math.log(x0), Math.log(x1)] : [x0, x1];
    this.toX = (x) => EDGE.left + (((log ? Math.log(x) : x) - a) / (b - a)) * wide;
    this.toY = (y) => EDGE.top + ((y1 - y) / (y1 - y0)) * high;
    this.fromX = (px) => {
      const at = a + ((px - EDGE.left) / wide) * (b - a);
      return log ? Math.exp(at) : at;
    };
    this.fromY = (py) => y1 - ((py - EDGE.top) / high) * (y1 - y0);
  }

  axes(width, height) {
    const { x, y } = this.range;
    const [left, right] = [EDGE.left, width - EDGE.right];
    const [top, bottom] = [EDGE.top, height - EDGE.bottom];
    const parts = [];
    const ticks = this.options.log
      ? decades(...x)
      : (this.options.turn ? degrees(...x) : steps(...x, Math.max(3, Math.floor(width / 90)))).map(
          (value) => [value, true],
        );
    const many = ticks.filter(([, named]) => named).length < 2;
    for (const [value, named] of ticks) {
      const at = this.toX(value).toFixed(1);
      parts.push(`<path class="grid" d="M${at} ${top}V${bottom}"/>`);
      if (named || many) {
        parts.push(`<text x="${at}" y="${bottom + 14}" text-anchor="middle">${tick(value)}</text>`);
      }
    }
    for (const value of this.options.degrees ? degrees(...y) : steps(...y, Math.max(3, height / 42))) {
      const at = this.toY(value).toFixed(1);
      parts.push(`<path class="grid" d="M${left} ${at}H${right}"/>`);
      parts.push(`<text x="${left - 5}" y="${at}" dy=".32em" text-anchor="end">${tick(value)}</text>`);
    }
    const middle = (left + right) / 2;
    parts.push(`<text x="${middle}" y="${height - 5}" text-anchor="middle">${this.spec.xlabel}</text>`);
    parts.push(
      `<text transform="translate(11 ${(top + bottom) / 2}) rotate(-90)" ` +
        `text-anchor="middle">${this.spec.ylabel}</text>`,
    );
    parts.push(`<path class="frame" d="M${left} ${top}H${right}V${bottom}H${left}Z"/>`);
    return parts.join("");
  }

  inside(width, height) {
    const { spec } = this;
    const wide = width - EDGE.left - EDGE.right;
    const high = height - EDGE.top - EDGE.bottom;
    const parts = [
      `<clipPath id="${this.clip}"><rect x="${EDGE.left}" y="${EDGE.top}" ` +
        `width="${wide}" height="${high}"/></clipPath><g clip-path="url(#${this.clip})">`,
    ];
    for (const { from, to } of spec.spans ?? []) {
      const [a, b] = [this.toX(from), this.toX(to)];
      parts.push(`<rect class="bound" x="${a}" y="${EDGE.top}" width="${b - a}" height="${high}"/>`);
    }
    for (const { x, low, high: top, look } of spec.bands ?? []) {
      const above = this.thinned(x, top, Math.max);
      const below = this.thinned(x, low, Math.min).reverse();
      parts.push(`<path class="band ${look}" d="M${[...above, ...below].join("L")}Z"/>`);
    }
    for (const { x, y, radius, look } of spec.rounds ?? []) {
      parts.push(`<path class="band ${look}" d="${this.circles(x, y, radius)}"/>`);
    }
    for (const { level, at, look } of spec.levels ?? []) {
      const line = at === undefined
        ? `M${EDGE.left} ${this.toY(level).toFixed(1)}h${wide}`
        : `M${this.toX(at).toFixed(1)} ${EDGE.top}v${high}`;
      parts.push(`<path class="line ${look}" d="${line}"/>`);
    }
    for (const { x, y, look, dots, wraps, many } of spec.lines ?? []) {
      const d = dots ? this.dots(x, y) : many ? this.dense(x, y) : this.path(x, y, wraps);
      parts.push(`<path class="${dots ? "dots" : "line"} ${look}" d="${d}"/>`);
    }
    for (const { x, y, text } of spec.marks ?? []) {
      const [px, py] = [this.toX(x), this.toY(y)];
      parts.push(`<circle class="mark" cx="${px}" cy="${py}" r="4"/>`);
      if (text) parts.push(`<text x="${px + 7}" y="${py - 6}">${text}</text>`);
    }
    return parts.join("") + "</g>";
  }

  point(x, y) {
    const px = Math.max(-4000, Math.min(8000, this.toX(x)));
    const py = Math.max(-4000, Math.min(8000, this.toY(y)));
    return `${Math.round(10 * px) / 10} ${Math.round(10 * py) / 10}`;
  }

  path(x, y, wraps) {
    if (!x.length) return "M0 0";
    let d = "";
    for (let i = 0; i < x.length; i += 1) {
      const back = i === 0 || (wraps && Math.abs(x[i] - x[i - 1]) > 180);
      d += (back ? "M" : "L") + this.point(x[i], y[i]);
    }
    return d;
  }

  // Of points within a pixel across the extreme one, as points.
  thinned(x, y, extreme) {
    const found = [];
    let [column, value, place] = [NaN, 0, 0];
    for (let i = 0; i < x.length; i += 1) {
      const at = Math.round(this.toX(x[i]));
      if (at === column) value = extreme(value, y[i]);
      else {
        if (i) found.push(this.point(place, value));
        [column, value, place] = [at, y[i], x[i]];
      }
    }
    if (x.length) found.push(this.point(place, value));
    return found;
  }

  // A line through very many points: of those within a pixel the highest and the lowest.
  dense(x, y) {
    const [high, low] = [this.thinned(x, y, Math.max), this.thinned(x, y, Math.min)];
    return high.length ? `M${high.map((each, i) => (low[i] === each ? each : `${each}L${low[i]}`)).join("L")}` : "M0 0";
  }

  // Dots that can be seen, one for each spot that a dot covers.
  dots(x, y) {
    const { x: [x0, x1], y: [y0, y1] } = this.range;
    const there = new Set();
    let d = "";
    for (let i = 0; i < x.length; i += 1) {
      if (x[i] < x0 || x[i] > x1 || y[i] < y0 || y[i] > y1) continue;
      const spot = this.spot(x[i], y[i]);
      if (there.has(spot)) continue;
      there.add(spot);
      d += `M${this.point(x[i], y[i])}h0`;
    }
    return d || "M0 0";
  }

  spot(x, y) {
    return Math.round(this.toX(x) / SPOT) * 8192 + Math.round(this.toY(y) / SPOT);
  }

  // Circles in sight, of those around one spot the largest.
  circles(x, y, radius) {
    const size = Math.abs(this.toX(1) - this.toX(0));
    const largest = new Map();
    for (let i = 0; i < x.length; i += 1) {
      const r = radius[i] * size;
      const [px, py] = [this.toX(x[i]), this.toY(y[i])];
      if (r < 0.5 || px < 0 || px > this.width || py < 0 || py > this.height) continue;
      const spot = this.spot(x[i], y[i]);
      if (r <= (largest.get(spot)?.r ?? 0)) continue;
      const d = `M${(px - r).toFixed(1)} ${py.toFixed(1)}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0`;
      largest.set(spot, { r, d });
    }
    return [...largest.values()].map(({ d }) => d).join("") || "M0 0";
  }

  // Handles stay the same elements, so that focus and pointer stay on them.
  place() {
    const wanted = this.spec.handles ?? [];
    for (const [name, own] of this.handles) {
      if (!wanted.some((each) => each.name === name)) {
        own.remove();
        this.handles.delete(name);
      }
    }
    const under = this.crowded(wanted);
    for (const each of wanted) {
      let own = this.handles.get(each.name);
      if (!own) {
        own = this.newHandle(each.name);
        this.handles.set(each.name, own);
        this.held.append(own);
      }
      const [low, high] = this.range.y;
      const y = this.toY(Math.max(low, Math.min(high, each.db)));
      own.setAttribute("transform", `translate(${this.toX(each.hz).toFixed(1)} ${y.toFixed(1)})`);
      own.setAttribute("aria-label", each.label);
      own.setAttribute("aria-valuenow", shown(each.hz, 6));
      own.setAttribute("aria-valuetext", `${shown(each.hz)} Hz, ${shown(each.db, 3)} dB`);
      const label = own.querySelector("text");
      label.textContent = each.label;
      label.setAttribute("y", under.has(each.name) ? 19 : -9);
    }
  }

  // Handles whose labels go below, as they would run into the one before.
  crowded(handles) {
    const under = new Set();
    let last = null;
    for (const each of [...handles].sort((a, b) => a.hz - b.hz)) {
      const near = last && this.toX(each.hz) - this.toX(last.hz) < 8 * last.label.length + 12;
      if (near && !under.has(last.name)) under.add(each.name);
      last = each;
    }
    return under;
  }

  newHandle(name) {
    const own = document.createElementNS(SVG, "g");
    own.setAttribute("class", "handle");
    own.setAttribute("role", "slider");
    own.setAttribute("tabindex", "0");
    own.dataset.handle = name;
    own.innerHTML =
      '<circle class="hit" r="16"/><circle class="dot" r="6.5"/><text x="9" y="-9"></text>';
    this.options.grabbed?.(own, name, this);
    return own;
  }
}

// ---- The page -----------------------------------------------------------------------------------

class Explorer {
  constructor(model, el) {
    this.model = model;
    this.el = el;
    this.wire = new Wire(model);
    this.gestures = 0;
    this.view = "loop";
    this.status = {};
    this.fields = new Map();
    el.classList.add("jounce-explorer");
    el.jounce = this;
    this.build();
    this.theme(stored("jounce-theme") ?? "auto");
    this.listen();
  }

  listen() {
    const come = (content, buffers) => this.come(unpacked(content, buffers));
    const lost = () => this.lost();
    const open = () => this.start();
    this.model.on("msg:custom", come);
    this.model.on("lost", lost);
    this.model.on("open", open);
    const keys = (event) => this.key(event);
    const around = this.model.get("notebook") ? this.el : document;
    around.addEventListener("keydown", keys);
    const dark = matchMedia("(prefers-color-scheme: dark)");
    const changed = () => this.theme(this.themed);
    dark.addEventListener("change", changed);
    this.leave = () => {
      around.removeEventListener("keydown", keys);
      this.model.off("msg:custom", come);
      this.model.off("lost", lost);
      this.model.off("open", open);
      dark.removeEventListener("change", changed);
    };
  }

  start() {
    this.wire.forget();
    this.bad.hidden = true;
    // What is looked at is told by the session first, by a page that comes back later.
    const view = this.stood ? { view: this.view } : {};
    this.wire.send({ kind: "start", link: this.model.get("link") ?? "", ...view });
  }

  lost() {
    this.wire.forget();
    this.tell(
      "The connection is lost: nothing is computed. The page comes back by itself once " +
        "`jounce explore` runs again under this address; its address holds what was changed.",
      "bad",
    );
  }

  // ---- what comes

  come(part) {
    const shows = {
      numbers: () => this.numbers(part),
      status: () => this.stand(part),
      curves: () => this.curves(part),
      closed: () => this.closed(part),
      step: () => this.step(part),
      response: () => this.response(part),
      worst: () => this.worst(part),
      move: () => this.move(part),
      proof: () => this.proof(part),
      asked: () => this.list(this.askedElements, part.elements),
      proposal: () => this.proposal(part),
      problem: () => this.tell(part.text, "bad"),
      saved: () => this.saved(part),
      ready: () => this.ready(part),
      done: () => this.done(part),
    };
    if (part.part === "numbers" || part.part === "move") this.timed(part);
    shows[part.part]?.();
  }

  // From the event to the frame in which its numbers are.
  timed(part) {
    if (part.id !== this.wire.sent) return;
    const since = this.wire.since;
    requestAnimationFrame(() => this.wire.latencies.push(performance.now() - since));
  }

  ready(part) {
    this.wire.answered(part.id);
  }

  done(part) {
    this.wire.answered(part.id);
    this.el.dataset.idle = String(!this.wire.busy);
    if (!this.wire.busy) this.say();
    this.link();
  }

  // Once things are at rest: a browser takes its time over an address.
  link() {
    const link = this.status.link === "{}" ? "" : this.status.link;
    if (this.model.get("link") === undefined || this.model.get("link") === link) return;
    this.model.set("link", link);
    this.model.save_changes();
  }

  change(message) {
    this.el.dataset.idle = "false";
    this.bad.hidden = true;
    this.wire.send(message);
  }

  tell(text, look) {
    this.bad.className = `told ${look}`;
    this.bad.firstChild.textContent = text;
    this.bad.hidden = false;
  }

  saved(part) {
    this.tell(`Saved ${part.file}.`, "good");
  }

  // For screen readers, once things are at rest.
  say() {
    const verdict = this.verdict.textContent;
    const row = this.rows?.get("phase_margin_deg");
    this.said.textContent = row ? `${verdict}; phase margin ${row.shown} degrees` : verdict;
  }

  // ---- what is there

  build() {
    const button = (name, act, attributes = {}) =>
      make("button", { type: "button", onclick: act, ...attributes }, name);
    this.heading = make("h1", {}, "jounce explorer");
    this.undo = button("Undo", () => this.change({ kind: "undo" }), { title: "Ctrl Z" });
    this.redo = button("Redo", () => this.change({ kind: "redo" }), { title: "Ctrl Y" });
    this.save = button("Save", () => this.keep(), { title: "Ctrl S" });
    this.name = make("input", { type: "text", "aria-label": "file to save to", size: 22 });
    this.tabs = ["loop", "move"].map((view) =>
      button(view === "loop" ? "Loop" : "Move", () => this.look(view), { role: "tab", "data-view": view }),
    );
    this.themes = make(
      "select",
      { "aria-label": "colours", onchange: (event) => this.theme(event.target.value) },
      ...THEMES.map((name) => make("option", { value: name }, name)),
    );
    this.help = make(
      "dialog",
      { "aria-label": "keys" },
      make("h2", {}, "Keys"),
      make("dl", {}, ...HELP.flatMap(([key, what]) => [make("dt", {}, key), make("dd", {}, what)])),
      button("Close", () => this.help.close()),
    );
    this.bad = make("div", { class: "told", role: "alert", hidden: true }, make("span"));
    this.bad.append(button("×", () => (this.bad.hidden = true), { "aria-label": "dismiss" }));
    this.said = make("div", { class: "unseen", "aria-live": "polite" });
    const header = make(
      "header",
      {},
      this.heading,
      make("span", { class: "group", role: "tablist" }, ...this.tabs),
      make("span", { class: "group" }, this.undo, this.redo),
      make("span", { class: "group" }, this.name, this.save),
      make(
        "span",
        { class: "group" },
        button("SVG", () => this.picture("svg"), { title: "the plots as a picture" }),
        button("PNG", () => this.picture("png"), { title: "the plots as a picture" }),
      ),
      this.themes,
      button("?", () => this.help.showModal(), { "aria-label": "keys" }),
    );
    this.loopPane = make("div", { class: "work", role: "tabpanel", "aria-label": "loop" });
    this.movePane = make("div", { class: "work", role: "tabpanel", "aria-label": "move" });
    this.el.replaceChildren(header, this.bad, this.loopPane, this.movePane, this.said, this.help);
    this.buildLoop(button);
    this.buildMove();
    this.askedElements = make("div");
    this.askedPanel = make(
      "section",
      { class: "panel", "aria-label": "what is asked" },
      make("h2", {}, "Feedforward, disturbances, requirements"),
      this.askedElements,
    );
    this.dropping();
    this.look("loop", false);
  }

  buildLoop(button) {
    this.verdict = make("p", { class: "verdict" });
    this.table = make("tbody");
    this.before = make("th", { scope: "col" }, "was");
    const head = ["", "now", "may be", "at worst", "at [Hz]"].map((name) =>
      make("th", { scope: "col" }, name),
    );
    this.notes = make("ul", { class: "notes" });
    const margins = make(
      "section",
      { class: "panel", "aria-label": "margins" },
      make("h2", {}, "Margins"),
      this.verdict,
      make(
        "table",
        {},
        make("thead", {}, make("tr", {}, ...head, this.before)),
        this.table,
      ),
      this.notes,
    );
    this.kinds = make(
      "select",
      { "aria-label": "kind of filter" },
      ...["notch", "lead-lag", "low-pass"].map((kind) => make("option", {}, kind)),
    );
    this.elements = make("div");
    const elements = make(
      "section",
      { class: "panel", "aria-label": "elements" },
      make("h2", {}, "Plant and controller"),
      this.elements,
      make(
        "div",
        { class: "row" },
        this.kinds,
        button("Add filter", () => this.change({ kind: "add", filter: this.kinds.value })),
      ),
    );
    this.loopPane.append(
      make("div", { class: "side" }, margins, elements, this.tuning(button), this.uncertain(), this.measured()),
      this.loopPlots(),
    );
  }

  loopPlots() {
    const grabbed = (own, name, plot) => this.grab(own, name, plot);
    this.gain = new Plot("Open loop: gain", { log: true, grabbed, look: "wide tall" });
    this.phase = new Plot("Open loop: phase", { log: true, degrees: true, look: "wide" });
    this.nyquist = new Plot("Nyquist", { equal: true, look: "square" });
    this.nichols = new Plot("Nichols", { turn: true, look: "square" });
    this.peaks = new Plot("S and T", { log: true });
    this.stepPlot = new Plot("Step of the command");
    this.errorPlot = new Plot("Move: error");
    this.torquePlot = new Plot("Move: torque");
    const plots = [this.gain, this.phase, this.nyquist, this.nichols, this.peaks, this.stepPlot, this.errorPlot, this.torquePlot];
    this.loopDrawn = plots;
    return make("div", { class: "plots" }, ...plots.map((plot) => plot.figure));
  }

  tuning(button) {
    const bound = (label) =>
      make("input", { type: "text", inputmode: "decimal", value: "1.6", "aria-label": label });
    this.most = [bound("largest |S|"), bound("largest |T|")];
    this.proposed = make("div", { "aria-live": "polite" });
    return make(
      "section",
      { class: "panel", "aria-label": "tuning" },
      make("h2", {}, "Tune the gains"),
      make(
        "div",
        { class: "row" },
        "|S| ≤",
        this.most[0],
        "|T| ≤",
        this.most[1],
        button("Propose", () =>
          this.change({
            kind: "tune",
            max_sensitivity: numberOf(this.most[0].value),
            max_complementary: numberOf(this.most[1].value),
          }),
        ),
      ),
      this.proposed,
    );
  }

  uncertain() {
    const slide = (name, label, most, unit, scale) => {
      const range = make("input", { type: "range", min: 0, max: most, step: most / 100, "aria-label": label });
      const told = make("output");
      const gesture = () => `uncertain-${name}-${this.gestures}`;
      range.addEventListener("input", () => {
        told.textContent = `${shown(Number(range.value))} ${unit}`;
        this.change({ kind: "uncertain", [name]: Number(range.value) * scale, gesture: gesture() });
      });
      range.addEventListener("change", () => (this.gestures += 1));
      this.errors[name] = { range, told, unit, scale };
      return make("label", { class: "field" }, label, range, told);
    };
    this.errors = {};
    return make(
      "section",
      { class: "panel", "aria-label": "errors of the model" },
      make("h2", {}, "How far the model may be off"),
      slide("inertia_error", "inertia, either way", 50, "%", 0.01),
      slide("delay_error_s", "delay, later", 5, "ms", 1e-3),
    );
  }

  measured() {
    const choice = (label, names) =>
      make("select", { "aria-label": label }, ...names.map((name) => make("option", {}, name)));
    this.dataKind = choice("what was measured", ["plant", "loop", "sensitivity", "process-sensitivity", "complementary"]);
    this.dataOutput = choice("what its output is", ["position", "velocity", "acceleration"]);
    this.dataTime = make("input", { type: "text", placeholder: "none", "aria-label": "sample time in seconds" });
    const file = make("input", {
      type: "file",
      id: `file-${Math.random().toString(36).slice(2)}`,
      "aria-label": "measured response",
      onchange: (event) => {
        this.open(event.target.files[0]);
        event.target.value = ""; // so that the same file may be opened again
      },
    });
    this.dataName = make("p", { class: "quiet" });
    this.source = choice("margins are of", ["model", "data"]);
    this.source.addEventListener("change", () => this.change({ kind: "source", source: this.source.value }));
    return make(
      "section",
      { class: "panel", "aria-label": "measured response" },
      make("h2", {}, "Measured response"),
      make("div", { class: "row" }, this.dataKind, this.dataOutput, "dt [s]", this.dataTime),
      make("div", { class: "row" }, make("label", { class: "file" }, "Open, or drop a file", file), "margins of", this.source),
      this.dataName,
    );
  }

  buildMove() {
    this.which = make("select", { "aria-label": "which move" });
    this.which.addEventListener("change", () =>
      this.change({ kind: "move", move: Number(this.which.value) }),
    );
    this.figures = make("tbody");
    this.proven = make("p", { class: "quiet" });
    this.left = make("tbody");
    this.moveElements = make("div");
    const head = (...names) =>
      make("thead", {}, make("tr", {}, ...names.map((name) => make("th", { scope: "col" }, name))));
    this.required = make("tbody");
    this.requiredTable = make("table", { hidden: true }, head("required", "must be", "is"), this.required);
    this.movePlots = make("div", { class: "plots" });
    this.spectrum = new Plot("Spectrum of the move", { log: true, look: "wide" });
    this.moveError = new Plot("Error in the loop");
    this.moveTorque = new Plot("Torque in the loop");
    this.derivatives = [];
    this.movePane.append(
      make(
        "div",
        { class: "side" },
        make(
          "section",
          { class: "panel", "aria-label": "figures" },
          make("h2", {}, "Move"),
          this.which,
          make("table", {}, head("figure", "value"), this.figures),
          this.requiredTable,
          this.proven,
          make("table", {}, head("mode", "at", "left ringing"), this.left),
        ),
        make("section", { class: "panel", "aria-label": "limits" }, make("h2", {}, "Limits and shaper"), this.moveElements),
      ),
      this.movePlots,
    );
  }

  look(view, tell = true) {
    this.view = view;
    this.loopPane.hidden = view !== "loop";
    this.movePane.hidden = view !== "move";
    this.loopPane.style.display = view === "loop" ? "" : "none";
    this.movePane.style.display = view === "move" ? "" : "none";
    (view === "loop" ? this.loopPane : this.movePane).firstChild.append(this.askedPanel);
    for (const tab of this.tabs) tab.setAttribute("aria-selected", String(tab.dataset.view === view));
    if (tell) this.change({ kind: "view", view });
  }

  theme(name) {
    this.themed = THEMES.includes(name) ? name : "auto";
    const dark = matchMedia("(prefers-color-scheme: dark)").matches;
    this.el.dataset.theme = this.themed === "auto" ? (dark ? "dark" : "light") : this.themed;
    this.themes.value = this.themed;
    store("jounce-theme", this.themed);
  }

  // ---- the loop

  stand(status) {
    this.status = status;
    if (!this.stood) this.look(status.view, false);
    this.stood = true;
    this.heading.replaceChildren(
      status.title,
      make("small", {}, `${status.file}${status.changed ? ", changed" : ""}`),
    );
    this.name.value ||= status.file;
    this.save.classList.toggle("main", status.changed);
    // Not `disabled`, which would take the focus away.
    this.undo.setAttribute("aria-disabled", String(!status.undo));
    this.redo.setAttribute("aria-disabled", String(!status.redo));
    this.source.value = status.source;
    this.source.disabled = !status.data;
    this.dataName.textContent = status.data || "none is open";
    for (const [name, { range, told, unit, scale }] of Object.entries(this.errors)) {
      if (document.activeElement !== range) range.value = status[name] / scale;
      told.textContent = `${shown(Number(range.value))} ${unit}`;
    }
    const options = status.moves.map((name, index) => make("option", { value: index }, name));
    if (this.which.options.length !== options.length) this.which.replaceChildren(...options);
    this.which.value = status.move;
  }

  numbers(part) {
    const names = { true: "stable", false: "UNSTABLE", null: "stability cannot be told" };
    const fails = part.margins.filter((row) => row.fails).map((row) => row.label);
    const look = part.stable === false || fails.length ? "bad" : part.stable === null ? "warn" : "good";
    this.verdict.className = `verdict ${look}`;
    const of = part.source === "data" ? ` by ${part.data}` : "";
    this.verdict.textContent = names[part.stable] + of + (fails.length ? `; fails: ${fails.join(", ")}` : "");
    this.before.textContent = part.revision === "as opened" ? "opened" : "baseline";
    this.before.title = part.revision;
    this.rows = new Map(part.margins.map((row) => [row.name, row]));
    this.table.replaceChildren(...part.margins.map((row) => marginRow(row)));
    this.notes.replaceChildren(...part.notes.map((note) => make("li", {}, note)));
  }

  worst(part) {
    for (const line of this.table.rows) {
      const value = part.margins[line.dataset.margin];
      if (value !== undefined) line.querySelector(".worst").textContent = shown(value);
    }
    if (part.stable === false) {
      this.verdict.className = "verdict bad";
      this.verdict.textContent += "; unstable at the worst of the model's errors";
    }
  }

  curves(part) {
    const { model, data } = part;
    const x = part.range_hz;
    const keys = [["model", "model"], ...(data ? [["data", "data"]] : [])];
    const span = yRange([model.gain_db, data?.gain_db], 20, -120, 120);
    this.handled = new Map(part.handles.map((each) => [each.name, each]));
    this.gain.draw({
      x, y: span, xlabel: "frequency [Hz]", ylabel: "gain [dB]", keys,
      told: `gain crossovers at ${part.crossovers_hz.map((hz) => shown(hz)).join(", ")} Hz`,
      bands: data?.low_db ? [{ x: data.frequency, low: data.low_db, high: data.high_db, look: "data" }] : [],
      levels: [{ level: 0, look: "soft" }],
      lines: [
        { x: model.frequency, y: model.gain_db, look: "model" },
        ...(data ? [{ x: data.frequency, y: data.gain_db, look: "data", many: true }] : []),
      ],
      marks: part.crossovers_hz.map((hz) => ({ x: hz, y: 0 })),
      handles: part.handles,
    });
    this.phase.draw({
      x, y: yRange([model.phase_deg], 90, -720, 180), xlabel: "frequency [Hz]", ylabel: "phase [deg]", keys,
      told: `phase margin ${shown(part.phase_margin_deg)} degrees`,
      levels: [{ level: -180, look: "limit" }, ...part.crossovers_hz.map((at) => ({ at, look: "soft" }))],
      lines: [
        { x: model.frequency, y: model.phase_deg, look: "model" },
        ...(data ? [{ x: data.frequency, y: data.phase_deg, look: "data", dots: true }] : []),
      ],
    });
    this.planes(part, keys);
    this.list(this.elements, part.elements);
  }

  planes(part, keys) {
    const { model, data } = part;
    const looks = { S: "s", T: "t", disk: "soft" };
    const round = part.circles.map((each) => ({ ...each, look: each.kind === "limit" ? "limit" : looks[each.of] }));
    const names = round.map((each) => [each.label, each.look]);
    this.nyquist.draw({
      x: [-2.5, 1.5], y: [-2, 2], xlabel: "Re L", ylabel: "Im L", keys: [...keys, ...names],
      told: names.map(([name]) => name).join(", "),
      rounds: data?.radius ? [{ x: data.re, y: data.im, radius: data.radius, look: "data" }] : [],
      lines: [
        ...round.map((each) => ({ x: each.re, y: each.im, look: each.look })),
        { x: model.re, y: model.im, look: "model" },
        ...(data ? [{ x: data.re, y: data.im, look: "data", dots: true }] : []),
      ],
      marks: [{ x: -1, y: 0 }],
    });
    this.nichols.draw({
      x: [-360, 0], y: [-40, 40], xlabel: "phase [deg]", ylabel: "gain [dB]", keys,
      told: "gain over phase",
      levels: [{ level: 0, look: "soft" }, { at: -180, look: "soft" }],
      lines: [
        ...round.map((each) => ({ x: each.phase_deg, y: each.gain_db, look: each.look, wraps: true })),
        { x: model.phase_deg, y: model.gain_db, look: "model" },
        ...(data ? [{ x: data.phase_deg, y: data.gain_db, look: "data", dots: true }] : []),
      ],
      marks: [{ x: -180, y: 0 }],
    });
  }

  closed(part) {
    const { data } = part;
    const bands = data
      ? ["s", "t"].map((of) => ({ x: data.frequency, low: data[`${of}_low`], high: data[`${of}_high`], look: of }))
      : [];
    const limits = Object.entries(part.limits_db).filter(([, level]) => level !== null);
    const dotted = ["s", "t"].map((of) => data && { x: data.frequency, y: data[`${of}_db`], look: of, dots: true });
    this.peaks.draw({
      x: part.range_hz, y: [-60, 20], xlabel: "frequency [Hz]", ylabel: "magnitude [dB]",
      keys: [["S", "s"], ["T", "t"], ...limits.map(([of, level]) => [`|${of}| ≤ ${shown(10 ** (level / 20), 3)}`, "limit"])],
      told: "sensitivity and complementary sensitivity",
      bands,
      levels: limits.map(([, level]) => ({ level, look: "limit" })),
      lines: [
        { x: part.frequency, y: part.s_db, look: "s" },
        { x: part.frequency, y: part.t_db, look: "t" },
        ...dotted.filter(Boolean),
      ],
    });
  }

  step(part) {
    const none = { time: [0, 1], position: [] };
    const { time, position } = part.time ? part : none;
    this.stepPlot.draw({
      x: ends(time), y: yRange([position], 0.5, -1, 3), xlabel: "time [s]", ylabel: "position",
      keys: part.figures?.slice(0, 1).map(told) ?? [["the loop is unstable", ""]],
      told: part.figures?.map((each) => told(each)[0]).join(", ") ?? "none, the loop is unstable",
      levels: [{ level: 1, look: "soft" }],
      lines: [{ x: time, y: position, look: "model" }],
    });
  }

  response(part) {
    const there = Boolean(part.time);
    const time = there ? part.time : [0, 1];
    for (const plot of [this.errorPlot, this.moveError]) {
      plot.draw({
        x: ends(time), y: yRange([there ? part.error : []]), xlabel: "time [s]", ylabel: `error [${part.unit ?? ""}]`,
        keys: there ? [told(part.figures[1]), told(part.figures[0])] : [[part.problem ?? "no move", ""]],
        told: there ? told(part.figures[1])[0] : part.problem,
        levels: [{ level: 0, look: "soft" }],
        lines: there ? [{ x: time, y: part.error, look: "model" }] : [],
      });
    }
    const limit = part.torque_limit;
    for (const plot of [this.torquePlot, this.moveTorque]) {
      const levels = limit ? [{ level: limit, look: "limit" }, { level: -limit, look: "limit" }] : [];
      plot.draw({
        x: ends(time), y: yRange([there ? part.torque : [], limit ? [limit, -limit] : []]),
        xlabel: "time [s]", ylabel: `torque [${part.torque_unit ?? ""}]`,
        keys: there ? part.figures.slice(3).map(told) : [],
        told: there ? told(part.figures[3])[0] : "",
        levels,
        lines: there ? [{ x: time, y: part.torque, look: "model" }] : [],
      });
    }
    if (there) this.inLoop = part.figures;
    const required = part.required ?? [];
    this.requiredTable.hidden = !required.length;
    this.required.replaceChildren(
      ...required.map(([name, must, is, met]) =>
        make(
          "tr",
          { class: met ? "within" : "fails", "data-required": name, title: met ? "met" : "missed" },
          make("th", { scope: "row" }, name),
          make("td", {}, must),
          make("td", { class: "now" }, is),
        ),
      ),
    );
    this.count();
  }

  // ---- handles

  grab(own, name, plot) {
    const drag = { active: false };
    own.addEventListener("pointerdown", (event) => {
      own.setPointerCapture(event.pointerId);
      own.classList.add("held");
      this.gestures += 1;
      const box = plot.svg.getBoundingClientRect();
      const at = this.handled.get(name);
      Object.assign(drag, {
        active: true, box, hz: at.hz,
        x: event.clientX - box.left, y: event.clientY - box.top, factors: { frequency: 1, gain: 1 },
      });
      event.preventDefault();
      own.focus({ preventScroll: true });
    });
    own.addEventListener("pointermove", (event) => {
      if (!drag.active) return;
      const x = event.clientX - drag.box.left;
      const y = event.clientY - drag.box.top;
      const frequency = plot.fromX(x) / plot.fromX(drag.x);
      const gain = 10 ** ((plot.fromY(y) - plot.fromY(drag.y)) / 20);
      this.drag(name, drag.hz, { frequency, gain });
    });
    const end = () => {
      drag.active = false;
      own.classList.remove("held");
    };
    own.addEventListener("pointerup", end);
    own.addEventListener("pointercancel", end);
    own.addEventListener("wheel", (event) => {
      if (!this.handled.get(name)?.wide) return;
      event.preventDefault();
      this.nudge(own, name, { width: event.deltaY < 0 ? 1.05 : 1 / 1.05 });
    }, { passive: false });
    own.addEventListener("keydown", (event) => this.handleKey(event, own, name));
  }

  drag(name, hz, factors) {
    this.change({ kind: "drag", handle: name, hz, gesture: `drag-${this.gestures}`, ...factors });
  }

  handleKey(event, own, name) {
    const far = event.shiftKey;
    const [across, along] = [far ? 1.2 : 1.02, 10 ** ((far ? 3 : 0.5) / 20)];
    const moves = {
      ArrowRight: { frequency: across }, ArrowLeft: { frequency: 1 / across },
      ArrowUp: { gain: along }, ArrowDown: { gain: 1 / along },
      "+": { width: 1.05 }, "-": { width: 1 / 1.05 },
    };
    const index = name.match(/filters\[(\d+)\]/)?.[1];
    if (event.key === "Delete" && index !== undefined) {
      event.preventDefault();
      this.change({ kind: "remove", index: Number(index) });
    } else if (moves[event.key]) {
      event.preventDefault();
      this.nudge(own, name, moves[event.key]);
    }
  }

  // Steps that follow each other within a second are one gesture.
  nudge(own, name, factors) {
    const now = performance.now();
    const last = own.nudged;
    const going = last && now - last.when < 1000;
    const start = going ? last : { hz: this.handled.get(name).hz, frequency: 1, gain: 1, width: 1, count: (this.gestures += 1) };
    own.nudged = { ...start, when: now };
    for (const [each, factor] of Object.entries(factors)) own.nudged[each] *= factor;
    const { frequency, gain, width } = own.nudged;
    this.change({ kind: "drag", handle: name, hz: start.hz, gesture: `nudge-${start.count}`, frequency, gain, width });
  }

  // ---- fields

  list(into, elements) {
    const looks = (field) => [field.key, field.scale === "text", field.choices, field.leave];
    const shape = elements.map((each) => [each.name, each.label, each.fields.map(looks), each.more]);
    const now = JSON.stringify(shape);
    if (into.dataset.shape !== now) {
      into.dataset.shape = now;
      into.replaceChildren(...elements.map((each) => this.element(each, elements)));
    }
    for (const each of elements) for (const field of each.fields) this.fill(into, field);
  }

  element(each, elements) {
    const buttons = [];
    if (each.filter !== undefined) {
      const last = elements.filter((other) => other.filter !== undefined).length - 1;
      const act = (sign, name, message, disabled) =>
        make("button", { type: "button", "aria-label": `${name} ${each.label}`, title: name, disabled, onclick: () => this.change(message) }, sign);
      const reorder = (to) => ({ kind: "reorder", index: each.filter, to });
      buttons.push(
        act("↑", "move up", reorder(each.filter - 1), each.filter === 0),
        act("↓", "move down", reorder(each.filter + 1), each.filter === last),
        act("✕", "remove", { kind: "remove", index: each.filter }, false),
      );
    }
    return make(
      "div",
      { class: "element", role: "group", "aria-label": each.label },
      make("div", {}, make("h3", {}, each.label), ...buttons),
      ...each.fields.map((field) => this.field(field)),
      ...(each.more?.length ? [this.adding(each)] : []),
    );
  }

  // What may be added to a section of the scenario.
  adding({ section, label, more }) {
    const names = make(
      "select",
      { "aria-label": `to add to ${label}` },
      ...more.map((name) => make("option", { value: name }, name.replaceAll("_", " "))),
    );
    const add = () => this.change({ kind: "ask", section, name: names.value });
    return make("div", { class: "row" }, names, make("button", { type: "button", "aria-label": `Add to ${label}`, onclick: add }, "Add"));
  }

  field(field) {
    if (field.choices) {
      const select = make("select", { "aria-label": field.label, "data-key": field.key }, ...field.choices.map((word) => make("option", {}, word)));
      select.addEventListener("change", () => this.change({ kind: "set", key: field.key, word: select.value }));
      return make("label", { class: "field" }, field.label, select);
    }
    const text = make("input", { type: "text", "aria-label": field.label, "data-key": field.key, autocomplete: "off" });
    text.addEventListener("change", () => {
      const bare = field.unit === "" && text.value.trim() !== "" && !Number.isNaN(Number(text.value));
      const value = bare ? { number: Number(text.value) } : { text: text.value };
      this.change({ kind: "set", key: field.key, ...value });
    });
    const between = field.scale === "text" ? make("span") : this.slider(field, text);
    return make("div", { class: "field" }, make("span", {}, field.label, ...this.leaving(field)), between, text);
  }

  slider(field, text) {
    const range = make("input", { type: "range", min: 0, max: 1000, "aria-label": `${field.label}, slider`, "data-slide": field.key });
    const own = { range, text, field };
    range.addEventListener("input", () => {
      const number = fromSlider(own.field, Number(range.value));
      text.value = quantity({ ...own.field, number });
      this.change({ kind: "set", key: field.key, number, gesture: `set-${field.key}-${this.gestures}` });
    });
    range.addEventListener("change", () => (this.gestures += 1));
    range.own = own;
    return range;
  }

  leaving({ leave, label }) {
    if (!leave) return [];
    const act = () => this.change({ kind: "leave", key: leave });
    return [make("button", { type: "button", class: "leave", "aria-label": `leave out ${label}`, title: "leave out", onclick: act }, "✕")];
  }

  fill(into, field) {
    const key = CSS.escape(field.key);
    if (field.choices) {
      into.querySelector(`select[data-key="${key}"]`).value = field.word;
      return;
    }
    if (field.scale === "text") {
      const text = into.querySelector(`input[data-key="${key}"]`);
      if (document.activeElement !== text || !this.wire.busy) text.value = field.text;
      return;
    }
    const range = into.querySelector(`[data-slide="${key}"]`);
    const { own } = range;
    const still = document.activeElement === range;
    own.field = still ? { ...field, low: own.field.low, high: own.field.high, scale: own.field.scale } : field;
    if (!still) {
      range.step = field.scale === "whole" ? 1 : 1;
      range.min = field.scale === "whole" ? field.low : 0;
      range.max = field.scale === "whole" ? field.high : 1000;
      range.value = toSlider(field);
    }
    range.setAttribute("aria-valuetext", quantity(field));
    if (document.activeElement !== own.text || !this.wire.busy) own.text.value = quantity(field);
  }

  // ---- the move

  move(part) {
    const { time, derivatives } = part;
    while (this.derivatives.length < derivatives.length) this.derivatives.push(new Plot(""));
    this.derivatives.length = derivatives.length;
    const plots = [...this.derivatives, this.spectrum, this.moveError, this.moveTorque];
    const figures = plots.map((plot) => plot.figure);
    if (figures.some((figure, index) => this.movePlots.children[index] !== figure) || this.movePlots.children.length !== figures.length) {
      this.movePlots.replaceChildren(...figures);
    }
    derivatives.forEach((each, k) => this.derivative(this.derivatives[k], each, k, part));
    const { frequency, gain_db: gain } = part.spectrum;
    this.spectrum.draw({
      x: ends(frequency), y: yRange([gain], 20, -120, 10), xlabel: "frequency [Hz]", ylabel: "gain [dB]",
      keys: part.residual.map((mode) => [`${mode.name} ${shown(mode.hz)} Hz`, "limit"]),
      told: "the move as a low-pass filter",
      levels: part.residual.map((mode) => ({ at: mode.hz, look: "limit" })),
      lines: [{ x: frequency, y: gain, look: "model" }],
    });
    this.planned = part.figures;
    this.count();
    this.left.replaceChildren(
      ...part.residual.map((mode) =>
        make(
          "tr",
          { "data-mode": mode.name },
          make("th", { scope: "row" }, mode.name),
          make("td", {}, `${shown(mode.hz)} Hz`),
          make("td", {}, mode.problem ?? `${shown(mode.left)} ${part.unit}`),
        ),
      ),
    );
    this.list(this.moveElements, part.elements);
  }

  derivative(plot, each, k, part) {
    const bounds = [each.low, each.high].filter((bound) => bound !== null);
    const unit = k === 0 ? part.unit : k === 1 ? `${part.unit}/s` : `${part.unit}/s^${k}`;
    const held = part.binding.filter((piece) => piece.by.includes(k));
    const time = held.reduce((sum, piece) => sum + piece.to - piece.from, 0);
    const share = Math.round((100 * time) / part.duration_s);
    const binds = held.length ? `at its limit ${share} % of the time` : bounds.length ? "never at its limit" : "";
    plot.title = each.name;
    plot.draw({
      title: each.name, x: ends(part.time), y: yRange([each.values, bounds]),
      xlabel: "time [s]", ylabel: unit,
      keys: [[`peak ${shown(each.peak)} ${unit}`, ""], ...(binds ? [[binds, held.length ? "limit" : ""]] : [])],
      told: `peak ${shown(each.peak)} ${unit}, ${binds}`,
      spans: held,
      levels: bounds.map((level) => ({ level, look: "limit" })),
      lines: [{ x: part.time, y: each.values, look: "model" }],
    });
  }

  proof(part) {
    this.proven.textContent = part.text;
  }

  count() {
    const all = [...(this.planned ?? []), ...(this.inLoop ?? [])];
    this.figures.replaceChildren(
      ...all.map(([name, value, unit]) =>
        make("tr", { "data-figure": name }, make("th", { scope: "row" }, name), make("td", {}, `${shown(value)} ${unit}`)),
      ),
    );
  }

  // ---- proposals, data, pictures

  proposal(part) {
    const line = ([name, before, after]) =>
      make("tr", {}, make("th", { scope: "row" }, name.replaceAll("_", " ")), make("td", {}, short(before)), make("td", {}, short(after)));
    const clear = () => this.proposed.replaceChildren();
    const button = (name, kind, look) =>
      make("button", { type: "button", class: look, onclick: () => { clear(); this.change({ kind }); } }, name);
    this.proposed.replaceChildren(
      make(
        "table",
        {},
        make("thead", {}, make("tr", {}, ...["", "now", "proposed"].map((name) => make("th", { scope: "col" }, name)))),
        make("tbody", {}, ...[...part.gains, ...part.margins].map(line)),
      ),
      make("div", { class: "row" }, button("Take", "take", "main"), button("Leave", "drop", "")),
    );
  }

  dropping() {
    this.el.addEventListener("dragover", (event) => {
      event.preventDefault();
      this.el.classList.add("dropping");
    });
    this.el.addEventListener("dragleave", (event) => {
      if (event.target === this.el || event.relatedTarget === null) this.el.classList.remove("dropping");
    });
    this.el.addEventListener("drop", (event) => {
      event.preventDefault();
      this.el.classList.remove("dropping");
      if (event.dataTransfer.files.length) this.open(event.dataTransfer.files[0]);
    });
  }

  async open(file) {
    if (!file) return;
    if (file.size > MOST_BYTES) {
      const size = `${shown(file.size / 1e6, 3)} MB`;
      this.tell(`${file.name}: ${size}, expected ${MOST_BYTES / 1e6} MB at the most; leave lines out, or average them`, "bad");
      return;
    }
    this.el.dataset.idle = "false";
    const bytes = new Uint8Array(await file.arrayBuffer());
    let text = "";
    for (let at = 0; at < bytes.length; at += 32768) text += String.fromCharCode(...bytes.subarray(at, at + 32768));
    const dt = this.dataTime.value.trim();
    this.change({
      kind: "data", name: file.name, content: btoa(text),
      kind_of: this.dataKind.value, output: this.dataOutput.value,
      ...(dt ? { dt: Number(dt) } : {}),
    });
  }

  picture(kind) {
    const plots = (this.view === "loop" ? this.loopDrawn : [...this.derivatives, this.spectrum, this.moveError, this.moveTorque]);
    for (const plot of plots) plot.paint(true);
    const { text, width, height } = together(this.el, plots, this.status);
    const name = `${(this.status.file ?? "explorer").replace(/\.toml$/, "")}-${this.view}`;
    if (kind === "svg") download(`${name}.svg`, text, "image/svg+xml");
    else rastered(text, width, height, (blob) => download(`${name}.png`, blob, "image/png"));
  }

  keep() {
    this.change({ kind: "save", name: this.name.value });
  }

  key(event) {
    if (!(event.ctrlKey || event.metaKey)) return;
    const typing = event.target.matches?.('input[type="text"]');
    const acts = { z: event.shiftKey ? "redo" : "undo", y: "redo", s: "save" };
    const kind = acts[event.key.toLowerCase()];
    if (!kind || (typing && kind !== "save")) return;
    event.preventDefault();
    if (kind === "save") this.keep();
    else this.change({ kind });
  }
}

// ---- Small things -------------------------------------------------------------------------------

function marginRow(row) {
  const value = row.value === null ? "" : String(row.value);
  const unit = row.unit ? ` [${row.unit}]` : "";
  return make(
    "tr",
    { class: `${row.verdict} ${row.fails ? "fails" : ""}`, "data-margin": row.name, title: row.verdict },
    make("th", { scope: "row" }, row.label, make("small", {}, unit)),
    make("td", { class: "now", "data-value": value }, row.shown),
    make("td", {}, row.allowed),
    make("td", { class: "worst" }, row.worst === null ? "" : shown(row.worst)),
    make("td", {}, row.at_hz === null ? "" : shown(row.at_hz, 3)),
    make("td", {}, row.was),
  );
}

// What is no number goes to Python as it is, which says so.
function numberOf(text) {
  return text.trim() === "" || Number.isNaN(Number(text)) ? text : Number(text);
}

function told([name, value, unit]) {
  return [`${name} ${shown(value)} ${unit}`.trim(), ""];
}

function short(value) {
  if (typeof value === "number" || value === null) return shown(value);
  const [number, ...unit] = String(value).split(" ");
  return Number.isNaN(Number(number)) ? String(value) : [shown(Number(number)), ...unit].join(" ");
}

function ends(values) {
  const [first, last] = [values[0], values[values.length - 1]];
  return last > first ? [first, last] : [first, first + 1];
}

// A range that holds all values, in whole steps so that it keeps still while they change.
function yRange(columns, step, least = -Infinity, most = Infinity) {
  let [low, high] = [Infinity, -Infinity];
  for (const column of columns) {
    for (const value of column ?? []) {
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  if (low > high) [low, high] = [0, 1];
  if (low === high) [low, high] = low === 0 ? [-1, 1] : [low - Math.abs(low), high + Math.abs(high)];
  const size = step ?? 10 ** Math.floor(Math.log10(high - low)) / 5;
  const room = step ? 0 : 0.04 * (high - low);
  low = Math.max(least, Math.floor((low - room) / size) * size);
  high = Math.min(most, Math.ceil((high + room) / size) * size);
  return low < high ? [low, high] : [low - size, low + size];
}

function quantity({ number, unit, scale }) {
  const digits = scale === "whole" ? 17 : 5;
  return `${shown(number, digits)} ${unit}`.trim();
}

function toSlider({ number, low, high, scale }) {
  if (scale === "whole") return number;
  const share = scale === "log" ? Math.log(number / low) / Math.log(high / low) : (number - low) / (high - low);
  return 1000 * Math.max(0, Math.min(1, share));
}

function fromSlider({ low, high, scale }, value) {
  if (scale === "whole") return value;
  const share = value / 1000;
  const number = scale === "log" ? low * (high / low) ** share : low + share * (high - low);
  return Number(number.toPrecision(4));
}

// Browsers may keep nothing, as notebooks in frames do.
function stored(name) {
  try {
    return localStorage.getItem(name);
  } catch {
    return null;
  }
}

function store(name, value) {
  try {
    localStorage.setItem(name, value);
  } catch {
    return;
  }
}

function download(name, content, kind) {
  const address = URL.createObjectURL(content instanceof Blob ? content : new Blob([content], { type: kind }));
  make("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 1000);
}

function looks() {
  const rules = [];
  for (const sheet of document.styleSheets) {
    try {
      for (const rule of sheet.cssRules) if (rule.cssText.includes(".jounce-explorer")) rules.push(rule.cssText);
    } catch {
      continue;
    }
  }
  return rules.join("\n");
}

// All plots as one SVG, two in a row, with the looks that they have.
function together(el, plots, status) {
  const [wide, gap, head] = [1000, 16, 24];
  let [x, y, rowHeight] = [0, 40, 0];
  const parts = [];
  for (const plot of plots) {
    const box = plot.svg.getBoundingClientRect();
    const scale = (plot.options.look ?? "").includes("wide") ? wide / box.width : (wide - gap) / 2 / box.width;
    const [width, height] = [box.width * scale, box.height * scale];
    if (x + width > wide + 1) {
      [x, y, rowHeight] = [0, y + rowHeight + gap, 0];
    }
    const title = plot.caption.textContent;
    const inner = plot.svg.innerHTML;
    const name = plot.caption.firstChild?.textContent ?? title;
    parts.push(
      `<g transform="translate(${x} ${y})"><text y="14" style="fill:var(--text)">${escaped(name)}</text>` +
        `<g transform="translate(0 ${head}) scale(${scale})">${inner}</g></g>`,
    );
    x += width + gap;
    rowHeight = Math.max(rowHeight, height + head);
  }
  const height = y + rowHeight + 10;
  const text =
    `<svg xmlns="${SVG}" class="jounce-explorer" data-theme="${el.dataset.theme}" viewBox="-12 0 ${wide + 24} ${height}" ` +
    `width="${wide + 24}" height="${height}"><style>${escaped(looks())}\n.jounce-explorer{font-size:13px}</style>` +
    `<rect x="-12" width="100%" height="100%" style="fill:var(--panel)"/>` +
    `<text y="22" style="fill:var(--text);font-size:17px">${escaped(status.title ?? "")}</text>${parts.join("")}</svg>`;
  // Rules are for svg elements within the explorer; here the picture is the explorer itself.
  return { text: text.replaceAll(".jounce-explorer svg", ".jounce-explorer"), width: wide + 24, height };
}

function escaped(text) {
  return text.replaceAll("&", "&amp;").replaceAll("<", "&lt;");
}

function rastered(text, width, height, take) {
  const image = new Image();
  const address = URL.createObjectURL(new Blob([text], { type: "image/svg+xml" }));
  image.onload = () => {
    const canvas = make("canvas", { width: 2 * width, height: 2 * height });
    canvas.getContext("2d").drawImage(image, 0, 0, 2 * width, 2 * height);
    URL.revokeObjectURL(address);
    canvas.toBlob(take, "image/png");
  };
  image.src = address;
}

export default {
  render({ model, el }) {
    const explorer = new Explorer(model, el);
    if (model.get("link") === undefined || model.get("notebook")) explorer.start();
    return () => explorer.leave();
  },
};
