// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Values over frames as inline SVG: axes, a legend that shows the values under the pointer, and a
/// line at the frame that the viewer shows.

const kSvg = "http://www.w3.org/2000/svg";
const kPlotHeight = 230;
const kMargin = {left: 58, right: 14, top: 10, bottom: 40};
// With more frames, markers would hide the lines.
const kMaxMarkers = 60;

/// Three or so significant digits without needless zeros.
function formatShort(value) {
  if (value === 0) {
    return "0";
  }
  const size = Math.abs(value);
  return size < 1e-4 || size >= 1e6 ? value.toExponential(1) : String(Number(value.toPrecision(3)));
}

function svgElement(name, attributes, ...children) {
  const element = document.createElementNS(kSvg, name);
  for (const [key, value] of Object.entries(attributes)) {
    element.setAttribute(key, value);
  }
  element.append(...children);
  return element;
}

/// Round values from low to high, about `count` of them.
function linearTicks(low, high, count) {
  const rough = (high - low) / count;
  const power = Math.pow(10, Math.floor(Math.log10(rough)));
  const step = power * ([1, 2, 5, 10].find((factor) => factor * power >= rough * 0.999));
  const ticks = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + step * 1e-9; ++i) {
    ticks.push(Number((i * step).toPrecision(12)));
  }
  return ticks;
}

function logTicks(low, high) {
  const ticks = [];
  const decades = Math.log10(high / low);
  const factors = decades > 2.5 ? [1] : decades > 1.2 ? [1, 3] : [1, 2, 3, 5];
  const every = Math.max(1, Math.ceil(decades / 6));
  for (let power = Math.floor(Math.log10(low)); Math.pow(10, power) <= high; power += every) {
    for (const factor of factors) {
      const tick = Number((factor * Math.pow(10, power)).toPrecision(3));
      if (tick >= low * 0.999 && tick <= high * 1.001) {
        ticks.push(tick);
      }
    }
  }
  return ticks;
}

function markerPath(shape, x, y) {
  const paths = {
    circle: `M${x - 4} ${y}a4 4 0 1 0 8 0a4 4 0 1 0 -8 0z`,
    square: `M${x - 3.5} ${y - 3.5}h7v7h-7z`,
    diamond: `M${x} ${y - 5}l5 5l-5 5l-5 -5z`,
  };
  return paths[shape];
}

class Plot {
  /// \param options  title, note (what is better), frames (numbers, ascending), series ([{name,
  ///                 shape, values}], values: numbers, null or "inf"), logarithmic, fromZero, format
  ///                 (value -> text), onPick (called with the number of a clicked frame)
  constructor(options) {
    this.options = options;
    this.hover = null;    // index into frames
    this.current = null;  // number of the viewer's frame
    this.element = document.createElement("figure");
    this.element.className = "plot";
    const caption = document.createElement("figcaption");
    const heading = document.createElement("h3");
    heading.textContent = options.title + " ";
    const note = document.createElement("span");
    note.className = "quiet";
    note.style.fontWeight = "400";
    note.textContent = options.note;
    heading.append(note);
    this.legend = document.createElement("div");
    this.legend.className = "legend";
    this.svg = svgElement("svg", {role: "img", tabindex: "0", "aria-label": this.summary()});
    caption.append(heading, this.legend);
    this.element.append(caption, this.svg);
    this.finite = options.series.flatMap((s) => s.values.filter((v) => this.drawable(v)));
    this.setRange();
    this.listen();
    new ResizeObserver(() => this.draw()).observe(this.element);
  }

  drawable(value) {
    return typeof value === "number" && (!this.options.logarithmic || value > 0);
  }

  summary() {
    const {title, series, frames} = this.options;
    const last = frames.length - 1;
    const ends = series.map(
        (s) => `${s.name} ${this.format(s.values[0])} to ${this.format(s.values[last])}`);
    return `${title} from frame ${frames[0]} to frame ${frames[last]}: ${ends.join(", ")}`;
  }

  format(value) {
    return value === null           ? "none"
           : value === "inf"        ? "\u221e"
           : value === "-inf"       ? "\u2212\u221e"
                                    : this.options.format(value);
  }

  setRange() {
    const {logarithmic, fromZero} = this.options;
    let low = this.finite.length > 0 ? this.finite[0] : 0;
    let high = low;
    // Not Math.min(...all): long sequences have more values than a call may have arguments.
    for (const value of this.finite) {
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
    if (this.finite.length === 0) {
      [low, high] = logarithmic ? [0.1, 1] : [0, 1];
    }
    if (logarithmic) {
      const pad = Math.max(Math.pow(high / low, 0.06), 1.25);
      this.range = [low / pad, high * pad];
      return;
    }
    if (fromZero) {
      low = Math.min(low, 0);
    }
    const pad = high > low ? 0.06 * (high - low) : Math.max(Math.abs(high) * 0.05, 1e-6);
    this.range = [fromZero && low === 0 ? 0 : low - pad, high + pad];
  }

  place(value) {
    const [low, high] = this.range;
    const position = this.options.logarithmic ? Math.log(value / low) / Math.log(high / low)
                                              : (value - low) / (high - low);
    return kPlotHeight - kMargin.bottom -
           position * (kPlotHeight - kMargin.top - kMargin.bottom);
  }

  placeFrame(number) {
    const {frames} = this.options;
    const first = frames[0];
    const span = frames[frames.length - 1] - first;
    const width = this.width - kMargin.left - kMargin.right;
    return kMargin.left + width * (span > 0 ? (number - first) / span : 0.5);
  }

  draw() {
    this.width = Math.max(this.element.clientWidth, 160);
    this.svg.setAttribute("viewBox", `0 0 ${this.width} ${kPlotHeight}`);
    this.marks = svgElement("g", {});
    this.svg.replaceChildren(...this.axes(), ...this.options.series.flatMap((s) => this.line(s)),
                             this.marks);
    this.update();
  }

  axes() {
    const {frames, logarithmic} = this.options;
    const bottom = kPlotHeight - kMargin.bottom;
    const right = this.width - kMargin.right;
    const parts = [];
    const [low, high] = this.range;
    for (const tick of logarithmic ? logTicks(low, high) : linearTicks(low, high, 5)) {
      const y = this.place(tick);
      parts.push(svgElement("line", {class: "grid", x1: kMargin.left, x2: right, y1: y, y2: y}));
      parts.push(svgElement("text", {x: kMargin.left - 7, y: y + 4, "text-anchor": "end"},
                            formatShort(tick)));
    }
    const first = frames[0];
    const last = frames[frames.length - 1];
    const ticks = last > first ? linearTicks(first, last, clamp(this.width / 90, 2, 10)) : [first];
    for (const tick of ticks.filter(Number.isInteger)) {
      const x = this.placeFrame(tick);
      parts.push(svgElement("line", {class: "axis", x1: x, x2: x, y1: bottom, y2: bottom + 4}));
      parts.push(svgElement("text", {x, y: bottom + 17, "text-anchor": "middle"}, String(tick)));
    }
    parts.push(svgElement("line",
                          {class: "axis", x1: kMargin.left, x2: right, y1: bottom, y2: bottom}));
    parts.push(svgElement(
        "text", {x: (kMargin.left + right) / 2, y: kPlotHeight - 6, "text-anchor": "middle"},
        "frame"));
    return parts;
  }

  line(series) {
    const {frames} = this.options;
    const parts = [];
    let path = "";
    let open = false;
    series.values.forEach((value, i) => {
      if (!this.drawable(value)) {
        open = false;
        return;
      }
      const x = this.placeFrame(frames[i]).toFixed(1);
      const y = this.place(value).toFixed(1);
      path += `${open ? "L" : "M"}${x} ${y}`;
      open = true;
    });
    parts.push(svgElement("path", {class: `series ${series.name}`, d: path}));
    if (frames.length <= kMaxMarkers) {
      const points = series.values.flatMap(
          (value, i) => this.drawable(value)
              ? [markerPath(series.shape, this.placeFrame(frames[i]), this.place(value))]
              : []);
      parts.push(svgElement("path", {class: `marker ${series.name}`, d: points.join("")}));
    }
    return parts;
  }

  /// Moves the lines at the pointer's frame and at the viewer's, and shows their values.
  update() {
    const {frames, series} = this.options;
    this.marks.replaceChildren();
    const mark = (number, name) => {
      const x = this.placeFrame(number);
      this.marks.append(svgElement("line", {class: name, x1: x, x2: x, y1: kMargin.top,
                                            y2: kPlotHeight - kMargin.bottom}));
    };
    if (this.current !== null && this.current >= frames[0] &&
        this.current <= frames[frames.length - 1]) {
      mark(this.current, "current");
    }
    const currentIndex = frames.indexOf(this.current);
    const index = this.hover !== null ? this.hover : currentIndex;
    if (this.hover !== null) {
      mark(frames[this.hover], "cursor");
    }
    this.legend.replaceChildren(...series.map((s) => this.legendEntry(s, index)));
    if (index >= 0) {
      const at = document.createElement("span");
      at.className = "at";
      at.textContent = `frame ${frames[index]}`;
      this.legend.append(at);
      for (const s of series.filter((entry) => this.drawable(entry.values[index]))) {
        this.marks.append(svgElement("path", {
          class: `marker ${s.name}`,
          d: markerPath(s.shape, this.placeFrame(frames[index]), this.place(s.values[index])),
        }));
      }
    }
  }

  legendEntry(series, index) {
    const entry = document.createElement("span");
    entry.className = series.name;
    const value = index >= 0 ? " " + this.format(series.values[index]) : "";
    entry.append(svgElement("svg", {viewBox: "0 0 26 12", "aria-hidden": "true"},
                            svgElement("path", {class: `series ${series.name}`, d: "M0 6h26"}),
                            svgElement("path", {class: `marker ${series.name}`,
                                                d: markerPath(series.shape, 13, 6)})),
                 ` ${series.label || series.name}${value}`);
    return entry;
  }

  setHover(index) {
    if (index !== this.hover) {
      this.hover = index;
      this.update();
    }
  }

  setCurrent(number) {
    this.current = number;
    if (this.marks) {
      this.update();
    }
  }

  nearest(event) {
    const {frames} = this.options;
    const x = event.clientX - this.svg.getBoundingClientRect().left;
    let best = 0;
    frames.forEach((number, i) => {
      const closer = Math.abs(this.placeFrame(number) - x) <
                     Math.abs(this.placeFrame(frames[best]) - x);
      best = closer ? i : best;
    });
    return best;
  }

  listen() {
    const {frames, onPick} = this.options;
    this.svg.addEventListener("pointermove", (event) => this.setHover(this.nearest(event)));
    this.svg.addEventListener("pointerleave", () => this.setHover(null));
    this.svg.addEventListener("blur", () => this.setHover(null));
    this.svg.addEventListener("click", (event) => onPick(frames[this.nearest(event)]));
    this.svg.addEventListener("keydown", (event) => {
      const last = frames.length - 1;
      const from = this.hover !== null ? this.hover : Math.max(frames.indexOf(this.current), 0);
      const targets = {ArrowLeft: from - 1, ArrowRight: from + 1, Home: 0, End: last};
      if (event.key in targets) {
        event.preventDefault();
        this.setHover(clamp(targets[event.key], 0, last));
      } else if (event.key === "Enter" && this.hover !== null) {
        onPick(frames[this.hover]);
      }
    });
  }
}
