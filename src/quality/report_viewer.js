// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The picture viewer: two views of one frame on a canvas, split by a divider, zoomed and panned
/// together. Lengths are CSS pixels of the stage unless they are said to be picture pixels.

const kMaxScale = 64;
// From here on, picture pixels are shown as squares.
const kPixelatedFrom = 2;
const kZoomStep = Math.SQRT2;
const kPanStep = 48;
const kFallbackFps = 24;

class Viewer {
  /// \param onFrame  called with the index of each frame that is about to be shown
  constructor(data, pictures, onFrame) {
    this.data = data;
    this.pictures = pictures;
    this.onFrame = onFrame;
    this.images = new Map();
    this.choices = findChoices(data.frames);
    this.frame = 0;
    this.split = 0.5;
    this.scale = 1;
    this.x = 0;  // of the picture's left edge
    this.y = 0;  // of its top edge
    this.fitted = true;
    this.opened = false;
    this.sides = [{image: null, message: ""}, {image: null, message: ""}];
    this.request = 0;
    this.timer = 0;
    this.playing = false;
    this.pointers = new Map();
    this.pointerAt = null;  // place on the stage, where the pointer is over it
    this.stage = byId("stage");
    this.canvas = byId("canvas");
    this.context = this.canvas.getContext("2d", {alpha: false});
    this.divider = byId("divider");
    this.selects = [byId("left-view"), byId("right-view")];
    this.tags = [byId("left-tag"), byId("right-tag")];
    this.ramp = new Map();
    data.heat.ramp.forEach((colour, i) => this.ramp.has(colour) || this.ramp.set(colour, i));
    this.probe = document.createElement("canvas").getContext("2d", {willReadFrequently: true});
    this.probe.canvas.width = 1;
    this.probe.canvas.height = 1;

    this.stage.style.aspectRatio = `${data.width} / ${data.height}`;
    this.setUpChoices();
    this.setUpZoom();
    this.setUpDivider();
    this.setUpPointers();
    this.setUpFrames();
    this.stage.addEventListener("keydown", (event) => this.onStageKey(event));
    new ResizeObserver(() => this.onResize()).observe(this.stage);
    this.onResize();
    this.setFrame(data.frames.length - 1);
  }

  // Views

  setUpChoices() {
    for (const select of this.selects) {
      fillSelect(select, this.choices);
      select.addEventListener("change", () => this.show());
    }
    const has = (id) => this.choices.some((choice) => choice.id === id);
    const pick = (wanted) => wanted.find(has);
    const left = pick(["noisy", "temporal", "denoised", "reference"]);
    const rest = ["denoised", "reference", "temporal", "noisy"].filter((id) => id !== left);
    this.selects[0].value = left;
    this.selects[1].value = pick(rest) || left;
    byId("swap").addEventListener("click", () => this.swap());
  }

  swap() {
    const [left, right] = this.selects;
    [left.value, right.value] = [right.value, left.value];
    this.show();
  }

  choice(side) {
    return this.choices.find((choice) => choice.id === this.selects[side].value);
  }

  /// Index into the pictures of what a side shows of a frame; null if there is none.
  pictureIndex(frame, side) {
    const {view, key} = this.choice(side);
    const views = this.data.frames[frame].views;
    return views[view] ? views[view][key] : null;
  }

  async load(index) {
    if (index === null) {
      return null;
    }
    if (!this.images.has(index)) {
      const image = new Image();
      image.src = "data:image/png;base64," + this.pictures[index];
      this.images.set(index, image);
    }
    const image = this.images.get(index);
    await image.decode();
    return image;
  }

  /// Shows the chosen views of the current frame as soon as both are decoded. Until then, what was
  /// there before stays. Of several calls the last one wins.
  async show() {
    const request = ++this.request;
    const frame = this.frame;
    const loaded = await Promise.all([0, 1].map(async (side) => {
      try {
        return {image: await this.load(this.pictureIndex(frame, side)), failed: false};
      } catch {
        return {image: null, failed: true};
      }
    }));
    if (request !== this.request) {
      return;
    }
    loaded.forEach(({image, failed}, side) => {
      const {label} = this.choice(side);
      const number = this.data.frames[frame].number;
      this.sides[side].image = image;
      this.sides[side].message = image  ? ""
                                 : failed ? `${label} of frame ${number} cannot be decoded`
                                          : `no ${label} of frame ${number}`;
      this.tags[side].textContent = label;
    });
    this.showScales();
    this.updateDivider();
    this.draw();
    this.showPixel();
    this.stage.dataset.shown = [
      this.data.frames[frame].number, this.selects[0].value, this.selects[1].value].join(" ");
  }

  // Drawing

  draw() {
    const context = this.context;
    const {width, height} = this.canvas;
    const split = Math.round(this.split * width);
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = "#17191c";
    context.fillRect(0, 0, width, height);
    this.drawSide(this.sides[0], 0, split);
    this.drawSide(this.sides[1], split, width);
  }

  drawSide(side, from, to) {
    if (to <= from) {
      return;
    }
    const context = this.context;
    const ratio = this.ratio;
    context.save();
    context.beginPath();
    context.rect(from, 0, to - from, this.canvas.height);
    context.clip();
    if (side.image) {
      const scale = this.scale * ratio;
      context.imageSmoothingEnabled = scale < kPixelatedFrom;
      context.imageSmoothingQuality = "high";
      // Whole device pixels, so that a scale of one shows the picture's own values.
      context.drawImage(
          side.image, Math.round(this.x * ratio), Math.round(this.y * ratio),
          Math.round(this.data.width * scale), Math.round(this.data.height * scale));
    } else if (side.message) {
      context.fillStyle = "#c3c8ce";
      context.font = `${15 * ratio}px system-ui, sans-serif`;
      context.textAlign = "center";
      context.fillText(side.message, (from + to) / 2, this.canvas.height / 2,
                       Math.max(to - from - 60 * ratio, 1));
    }
    context.restore();
  }

  onResize() {
    const box = this.stage.getBoundingClientRect();
    const old = {width: this.width, height: this.height};
    this.ratio = window.devicePixelRatio || 1;
    this.width = Math.max(box.width, 1);
    this.height = Math.max(box.height, 1);
    this.canvas.width = Math.round(this.width * this.ratio);
    this.canvas.height = Math.round(this.height * this.ratio);
    if (!this.opened) {
      this.opened = true;
      this.open();
    } else if (this.fitted) {
      this.reset();
    } else {
      // What was in the middle stays there.
      this.moveTo(this.scale, this.x + (this.width - old.width) / 2,
                  this.y + (this.height - old.height) / 2);
    }
    this.updateDivider();
  }

  // Zoom and pan

  fitScale() {
    return Math.min(this.width / this.data.width, this.height / this.data.height);
  }

  /// From the whole picture, or one screen pixel per picture pixel if that is less, to squares.
  clampScale(scale) {
    const fit = this.fitScale();
    return clamp(scale, Math.min(fit, 1 / this.ratio), Math.max(kMaxScale, fit));
  }

  open() {
    this.reset();
    if (this.data.zoom_width > 0) {
      this.zoomCentre(this.width / this.data.zoom_width / this.scale);
    }
  }

  reset() {
    this.moveTo(this.fitScale(), 0, 0);
  }

  /// Sets scale and position within their bounds: a picture smaller than the stage is centred, a
  /// larger one covers it.
  moveTo(scale, x, y) {
    const fit = this.fitScale();
    this.scale = this.clampScale(scale);
    const place = (offset, picture, stage) =>
        picture <= stage ? (stage - picture) / 2 : clamp(offset, stage - picture, 0);
    this.x = place(x, this.data.width * this.scale, this.width);
    this.y = place(y, this.data.height * this.scale, this.height);
    this.fitted = Math.abs(this.scale / fit - 1) < 1e-6;
    this.stage.classList.toggle("zoomed", this.scale > fit * 1.001);
    const percent = 100 * this.scale * this.ratio;
    byId("zoom-level").value = `${percent < 10 ? percent.toFixed(1) : Math.round(percent)} %`;
    this.draw();
    this.showPixel();
  }

  /// Zooms so that the picture's point at the place `from` of the stage comes to lie at `to`.
  /// \return whether the scale has changed
  zoomAbout(from, factor, to = from) {
    const old = this.scale;
    const scale = this.clampScale(old * factor);
    this.moveTo(scale, to[0] - (from[0] - this.x) * scale / old,
                to[1] - (from[1] - this.y) * scale / old);
    return scale !== old;
  }

  zoomCentre(factor) {
    this.zoomAbout([this.width / 2, this.height / 2], factor);
  }

  setUpZoom() {
    byId("zoom-in").addEventListener("click", () => this.zoomCentre(kZoomStep));
    byId("zoom-out").addEventListener("click", () => this.zoomCentre(1 / kZoomStep));
    byId("zoom-one").addEventListener("click", () => this.zoomOne());
    byId("zoom-reset").addEventListener("click", () => this.reset());
    this.stage.addEventListener("wheel", (event) => {
      const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1;
      const pages = event.deltaMode === WheelEvent.DOM_DELTA_PAGE ? this.height : 1;
      // A pinch on a touch pad comes as small wheel steps with the control key.
      const speed = event.ctrlKey ? 0.01 : 0.002;
      const point = this.stagePoint(event);
      const zoomed = this.zoomAbout(point, Math.exp(-event.deltaY * lines * pages * speed));
      // At the end of the range the wheel scrolls the page as usual.
      if (zoomed || event.ctrlKey) {
        event.preventDefault();
      }
      this.pointTo(point);
    }, {passive: false});
  }

  zoomOne() {
    this.zoomCentre(1 / this.ratio / this.scale);
  }

  stagePoint(event) {
    const box = this.stage.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  setUpPointers() {
    const stage = this.stage;
    stage.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || event.target === this.divider) {
        return;
      }
      stage.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, this.stagePoint(event));
      stage.classList.add("panning");
    });
    stage.addEventListener("pointermove", (event) => {
      const point = this.stagePoint(event);
      if (this.pointers.has(event.pointerId)) {
        this.onDrag(event.pointerId, point);
      }
      this.pointTo(point);
    });
    const end = (event) => {
      this.pointers.delete(event.pointerId);
      stage.classList.toggle("panning", this.pointers.size > 0);
    };
    stage.addEventListener("pointerup", end);
    stage.addEventListener("pointercancel", end);
    stage.addEventListener("pointerleave", () => this.pointTo(null));
  }

  /// One pointer pans; two pan with their middle and zoom with their distance.
  onDrag(id, point) {
    const before = [...this.pointers.values()].slice(0, 2);
    this.pointers.set(id, point);
    const after = [...this.pointers.values()].slice(0, 2);
    const middle = (points) =>
        [0, 1].map((k) => points.reduce((sum, p) => sum + p[k], 0) / points.length);
    const spread = (points) =>
        points.length < 2 ? 1 : Math.hypot(points[0][0] - points[1][0], points[0][1] - points[1][1]);
    const factor = spread(before) > 0 ? spread(after) / spread(before) : 1;
    this.zoomAbout(middle(before), factor, middle(after));
  }

  onStageKey(event) {
    if (event.target !== this.stage || event.ctrlKey || event.altKey || event.metaKey) {
      return;
    }
    const pan = (dx, dy) => this.moveTo(this.scale, this.x + dx * kPanStep, this.y + dy * kPanStep);
    const actions = {
      "+": () => this.zoomCentre(kZoomStep),
      "=": () => this.zoomCentre(kZoomStep),
      "-": () => this.zoomCentre(1 / kZoomStep),
      "0": () => this.reset(),
      "1": () => this.zoomOne(),
      "s": () => this.swap(),
      ",": () => this.setFrame(this.frame - 1),
      ".": () => this.setFrame(this.frame + 1),
      " ": () => this.togglePlay(),
      "ArrowLeft": () => pan(1, 0),
      "ArrowRight": () => pan(-1, 0),
      "ArrowUp": () => pan(0, 1),
      "ArrowDown": () => pan(0, -1),
    };
    const action = actions[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (action) {
      event.preventDefault();
      action();
    }
  }

  // Divider

  setSplit(split) {
    this.split = clamp(split, 0, 1);
    this.updateDivider();
    this.draw();
  }

  updateDivider() {
    const percent = Math.round(100 * this.split);
    this.divider.style.left = `${100 * this.split}%`;
    this.divider.setAttribute("aria-valuenow", percent);
    this.divider.setAttribute(
        "aria-valuetext",
        `${percent} % ${this.choice(0).label}, ${100 - percent} % ${this.choice(1).label}`);
    this.tags[0].style.visibility = this.split > 0.02 ? "visible" : "hidden";
    this.tags[1].style.visibility = this.split < 0.98 ? "visible" : "hidden";
  }

  setUpDivider() {
    const divider = this.divider;
    let grip = null;  // where within the divider it was taken
    divider.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) {
        return;
      }
      event.preventDefault();
      divider.focus({preventScroll: true});
      divider.setPointerCapture(event.pointerId);
      grip = this.stagePoint(event)[0] - this.split * this.width;
    });
    divider.addEventListener("pointermove", (event) => {
      if (grip !== null) {
        this.setSplit((this.stagePoint(event)[0] - grip) / this.width);
      }
    });
    const end = () => { grip = null; };
    divider.addEventListener("pointerup", end);
    divider.addEventListener("pointercancel", end);
    divider.addEventListener("lostpointercapture", end);
    divider.addEventListener("keydown", (event) => {
      const step = event.shiftKey ? 0.1 : 0.01;
      const targets = {
        ArrowLeft: this.split - step,
        ArrowDown: this.split - step,
        ArrowRight: this.split + step,
        ArrowUp: this.split + step,
        PageDown: this.split - 0.1,
        PageUp: this.split + 0.1,
        Home: 0,
        End: 1,
      };
      if (event.key in targets) {
        event.preventDefault();
        this.setSplit(targets[event.key]);
      }
    });
  }

  // Frames

  setUpFrames() {
    const slider = byId("frame");
    const count = this.data.frames.length;
    slider.max = count - 1;
    slider.addEventListener("input", () => {
      this.pause();
      this.setFrame(Number(slider.value));
    });
    byId("play").addEventListener("click", () => this.togglePlay());
    for (const part of [slider, byId("play"), byId("speed").parentElement]) {
      part.hidden = count < 2;
    }
  }

  /// \return a promise that is kept once the frame is shown
  setFrame(index) {
    this.frame = clamp(index, 0, this.data.frames.length - 1);
    const {number, seconds} = this.data.frames[this.frame];
    const slider = byId("frame");
    slider.value = this.frame;
    slider.setAttribute("aria-valuetext", `frame ${number}`);
    byId("frame-label").value =
        `frame ${number}` + (seconds === null ? "" : `, ${seconds.toFixed(2)} s`);
    this.onFrame(this.frame);
    return this.show();
  }

  /// Shows the frame of that number, or the nearest one that is in the page.
  goToNumber(number) {
    const distance = (frame) => Math.abs(frame.number - number);
    let best = 0;
    this.data.frames.forEach((frame, i) => {
      best = distance(frame) < distance(this.data.frames[best]) ? i : best;
    });
    this.pause();
    this.setFrame(best);
  }

  togglePlay() {
    if (this.playing) {
      this.pause();
    } else if (this.data.frames.length > 1) {
      this.playing = true;
      this.showPlaying();
      this.advance();
    }
  }

  pause() {
    this.playing = false;
    clearTimeout(this.timer);
    this.showPlaying();
  }

  showPlaying() {
    const button = byId("play");
    button.classList.toggle("playing", this.playing);
    button.setAttribute("aria-label", this.playing ? "Pause" : "Play");
  }

  /// Shows the next frame, then waits for as long as that frame lasts.
  async advance() {
    const next = (this.frame + 1) % this.data.frames.length;
    await this.setFrame(next);
    if (this.playing) {
      clearTimeout(this.timer);
      this.timer = setTimeout(() => this.advance(), this.duration(next));
    }
  }

  /// Milliseconds until the next frame of the page; frames left out between the two count.
  duration(index) {
    const frames = this.data.frames;
    const fps = this.data.fps || kFallbackFps;
    const gap = index + 1 < frames.length ? frames[index + 1].number - frames[index].number
                                          : frames[index].number - frames[index - 1].number;
    return clamp(1000 * gap / fps / Number(byId("speed").value), 1000 / 120, 3000);
  }

  // Values

  showScales() {
    const keys = new Set([0, 1].map((side) => this.choice(side).key));
    const box = byId("scales");
    box.replaceChildren();
    for (const map of kMaps.filter(({key}) => keys.has(key))) {
      box.append(makeScale(map, this.data.heat));
    }
  }

  /// "rgb(1, 2, 3)" or the error that a map's colour stands for.
  describe(side, x, y) {
    const {image} = this.sides[side];
    if (!image) {
      return null;
    }
    const probe = this.probe;
    probe.clearRect(0, 0, 1, 1);
    probe.drawImage(image, x, y, 1, 1, 0, 0, 1, 1);
    const [r, g, b] = probe.getImageData(0, 0, 1, 1).data;
    const hex = "#" + [r, g, b].map((value) => value.toString(16).padStart(2, "0")).join("");
    const {key} = this.choice(side);
    if (key === "picture" || !this.ramp.has(hex)) {
      return {hex, text: `${r} ${g} ${b}`};
    }
    const index = this.ramp.get(hex);
    const last = this.data.heat.ramp.length - 1;
    if (index === last) {
      return {hex, text: "not a finite number"};
    }
    const sign = index === 0 ? "\u2264 " : index === last - 1 ? "\u2265 " : "";
    const value = scaleValue(this.data.heat[key], index / (last - 1));
    return {hex, text: sign + formatShort(value)};
  }

  pointTo(point) {
    this.pointerAt = point;
    this.showPixel();
  }

  /// Says what the two views hold in the picture pixel under the pointer: now, and whenever the
  /// picture under it becomes another.
  showPixel() {
    const [x, y] = this.pointerAt || [-1, -1];
    const column = Math.floor((x - this.x) / this.scale);
    const row = Math.floor((y - this.y) / this.scale);
    const readout = byId("readout");
    const inside = x >= 0 && y >= 0 && column >= 0 && row >= 0 && column < this.data.width &&
                   row < this.data.height;
    readout.textContent = inside ? `x ${column}, y ${row}:` : "\u00a0";
    for (const side of inside ? [0, 1] : []) {
      const found = this.describe(side, column, row);
      if (found) {
        const swatch = document.createElement("span");
        swatch.className = "swatch";
        swatch.style.background = found.hex;
        readout.append(side === 0 ? " " : " \u00b7 ", this.choice(side).label, " ", swatch,
                       found.text);
      }
    }
  }
}
