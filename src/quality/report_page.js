// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Puts the page together. Everything that comes from files becomes text nodes, never markup.

const kShapes = {
  noisy: "circle",
  temporal: "square",
  denoised: "diamond",
  render: "circle",
  denoise: "diamond",
};

// Lines through fewer points would show a course that was not measured.
const kLeastPlotted = 4;

// Least number of rows after which the parameters' table goes on in a second column.
const kParameterRows = 18;

const kSourceLabels = {
  linear: "linear radiance (EXR)",
  display: "display values (PNG)",
};

/// `better`: +1 higher is better, -1 lower is better, 0 closer to one, null neither. `details`: in
/// the second table.
const kMetrics = [
  {key: "psnr", label: "PSNR", unit: "dB", better: 1, format: (v) => `${v.toFixed(2)} dB`},
  {key: "ssim", label: "SSIM", unit: "", better: 1, format: (v) => v.toFixed(4)},
  {key: "flip", label: "FLIP", unit: "", better: -1, format: (v) => v.toFixed(4), fromZero: true},
  {key: "rel_mse", label: "relMSE", unit: "", better: -1, format: formatShort, logarithmic: true},
  {
    key: "hdr_flip",
    label: "HDR-FLIP",
    unit: "",
    better: -1,
    format: (v) => v.toFixed(4),
    fromZero: true,
    source: "linear",
  },
  {
    key: "temporal_error",
    label: "Temporal error",
    column: "Temporal",
    unit: "",
    better: -1,
    format: (v) => v.toFixed(5),
    fromZero: true,
  },
  {key: "brightness", label: "Brightness", unit: "", better: 0, format: (v) => v.toFixed(4),
   tableOnly: true},
  {
    key: "bright_specks",
    label: "Bright specks per 10,000 pixels",
    column: "Bright specks",
    unit: "",
    better: -1,
    format: (v) => v.toFixed(2),
    fromZero: true,
    details: true,
  },
  {
    key: "dark_specks",
    label: "Dark specks per 10,000 pixels",
    column: "Dark specks",
    unit: "",
    better: -1,
    format: (v) => v.toFixed(2),
    fromZero: true,
    details: true,
  },
  {
    key: "worst_share",
    label: "Worst 1 % of the pixels",
    column: "Worst 1 %",
    unit: "",
    better: null,
    note: "share of the squared error",
    format: (v) => v.toFixed(4),
    fromZero: true,
    details: true,
  },
  {
    key: "brightness_lowest",
    label: "Darkest region",
    unit: "",
    better: 0,
    format: (v) => v.toFixed(4),
    details: true,
    tableOnly: true,
  },
  {
    key: "brightness_highest",
    label: "Brightest region",
    unit: "",
    better: 0,
    format: (v) => v.toFixed(4),
    details: true,
    tableOnly: true,
  },
  {
    key: "light_change",
    label: "Light change",
    unit: "",
    better: 0,
    format: (v) => v.toFixed(4),
    details: true,
  },
];

const kBetterText = {
  "1": "higher is better",
  "-1": "lower is better",
  "0": "ideal: 1",
};

function noteOf(metric) {
  return metric.note || kBetterText[metric.better];
}

/// An element with attributes and children; strings become text.
function make(name, attributes, ...children) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    element.setAttribute(key, value);
  }
  element.append(...children);
  return element;
}

function formatMs(value) {
  return value >= 100 ? value.toFixed(0) : value >= 10 ? value.toFixed(1) : value.toFixed(2);
}

/// In MB, as --timings prints them.
function formatBytes(value) {
  return `${(value / 1e6).toFixed(value < 1e5 ? 3 : 1)} MB`;
}

function formatMetric(metric, value) {
  return value === null ? "\u2013" : value === "inf" ? "\u221e" : metric.format(value);
}

function showSummary(data) {
  byId("title").textContent = data.title;
  const setting = (name) => (data.settings.find(([key]) => key === name) || [])[1];
  const count = data.frames_found;
  const parts = [`${data.width} \u00d7 ${data.height} pixels`,
                 `${count} frame${count > 1 ? "s" : ""}`];
  const known = [
    ["fps", (v) => `${Number(v)} frames per second`],
    ["spp", (v) => `${v} sample${v === "1" ? "" : "s"} per pixel`],
    ["bounces", (v) => `${v} bounces`],
    ["sampler", (v) => `sampler ${v}`],
    ["seed", (v) => `seed ${v}`],
  ];
  for (const [name, describe] of known) {
    if (setting(name) !== undefined) {
      parts.push(describe(setting(name)));
    }
  }
  byId("summary").textContent = parts.join(" \u00b7 ");
  byId("footer").textContent =
      `Made by stillray report from ${data.source}.` +
      (data.version ? ` Pictures by stillray ${data.version}.` : "");
}

function showNotes(data) {
  byId("notes").append(...data.notes.map((note) => make("li", {}, note)));
  byId("notes-section").hidden = data.notes.length === 0;
}

// Quality

/// Whether `value` is the best of `all` means of a metric.
function isBest(metric, value, all) {
  const rank = (v) => {
    const number = v === "inf" ? Infinity : v;
    return metric.better === 0 ? -Math.abs(number - 1) : metric.better * number;
  };
  const known = all.filter((v) => v !== null);
  return metric.better !== null && value !== null && known.length > 1 &&
         known.every((v) => rank(v) <= rank(value));
}

/// \param details  the second table
function meansTable(source, frames, details) {
  const metrics = kMetrics.filter(
      (metric) => (metric.details || false) === details &&
                  (!metric.source || metric.source === source.source));
  const views = Object.entries(source.views);
  const anyNonFinite = !details && views.some(([, quality]) => quality.mean.non_finite > 0);
  const head = make("tr", {}, make("th", {scope: "col"}, "Mean over frames"));
  for (const metric of metrics) {
    head.append(make("th", {scope: "col"}, metric.column || metric.label,
                     make("span", {class: "quiet"}, noteOf(metric))));
  }
  if (!details) {
    head.append(make("th", {scope: "col"}, "Frames", make("span", {class: "quiet"}, "compared")));
  }
  if (anyNonFinite) {
    head.append(make("th", {scope: "col"}, "Left out",
                     make("span", {class: "quiet"}, "pixels not finite")));
  }
  const body = make("tbody", {});
  for (const [view, quality] of views) {
    const row = make("tr", {}, make("th", {scope: "row"}, view));
    for (const metric of metrics) {
      const all = views.map(([, other]) => other.mean[metric.key]);
      const value = quality.mean[metric.key];
      row.append(make("td", isBest(metric, value, all) ? {class: "best"} : {},
                      formatMetric(metric, value)));
    }
    if (!details) {
      row.append(make("td", {}, String(quality.mean.frames)));
    }
    if (anyNonFinite) {
      row.append(make("td", {}, String(quality.mean.non_finite)));
    }
    body.append(row);
  }
  return make("table", {}, make("thead", {}, head), body, ...frameRows(frames, views, metrics));
}

/// The values of every frame, where they are too few for plots; one frame is its own mean.
function frameRows(frames, views, metrics) {
  if (frames.length < 2 || frames.length >= kLeastPlotted) {
    return [];
  }
  return frames.map((number, i) => {
    const rows = views.map(([view, quality]) => make(
        "tr", {}, make("th", {scope: "row"}, `${view}, frame ${number}`),
        ...metrics.map((metric) => make("td", {}, formatMetric(metric,
                                                               quality.values[metric.key][i])))));
    return make("tbody", {class: "frames"}, ...rows);
  });
}

/// \return the plots of one source
function showQuality(data, source, onPick) {
  byId("means").replaceChildren(meansTable(source, data.quality.frames, false));
  byId("details").replaceChildren(meansTable(source, data.quality.frames, true));
  const plots = [];
  const plotted = data.quality.frames.length >= kLeastPlotted ? kMetrics : [];
  for (const metric of plotted) {
    const known = Object.values(source.views).some(
        ({values}) => values[metric.key].some((value) => value !== null));
    if (metric.tableOnly || !known || (metric.source && metric.source !== source.source)) {
      continue;
    }
    const series = Object.entries(source.views).map(([view, quality]) => ({
      name: view,
      shape: kShapes[view],
      values: quality.values[metric.key],
    }));
    plots.push(new Plot({
      title: metric.label,
      note: noteOf(metric) + (metric.logarithmic ? ", logarithmic" : ""),
      frames: data.quality.frames,
      series,
      logarithmic: metric.logarithmic || false,
      fromZero: metric.fromZero || false,
      format: metric.format,
      onPick,
    }));
  }
  byId("quality-plots").replaceChildren(...plots.map((plot) => plot.element));
  return plots;
}

// Times

/// \param largest  the share whose bar is full; 0: the step is no stage and has no share
function timeRow(step, largest, attributes) {
  const row = make("tr", attributes, make("th", {scope: "row"}, step.name));
  for (const value of [step.median, step.min, step.max]) {
    row.append(make("td", {}, formatMs(value)));
  }
  if (largest > 0) {
    const bar = make("span", {class: "bar", "aria-hidden": "true"});
    bar.style.setProperty("--share", step.share / largest);
    const number = make("span", {class: "number"}, `${(100 * step.share).toFixed(1)} %`);
    row.append(make("td", {class: "share"}, number, bar));
  } else {
    row.append(make("td", {class: "share"}));
  }
  return row;
}

function timesTable(times) {
  const head = make("tr", {}, ...["Median", "Min", "Max"].map(
      (text) => make("th", {scope: "col"}, text, make("span", {class: "quiet"}, "ms"))));
  head.prepend(make("th", {scope: "col"}, "Step"));
  head.append(make("th", {scope: "col", class: "share"}, "Share",
                   make("span", {class: "quiet"}, "of all stages")));
  const largest = Math.max(...times.stages.map((stage) => stage.share));
  const body = make("tbody", {});
  const whole = (step) => step && body.append(timeRow(step, 0, {class: "total"}));
  whole(times.render);
  whole(times.denoise);
  body.append(...times.stages.map((stage) => timeRow(stage, largest, {class: "part"})));
  whole(times.write);
  const count = times.frames.length;
  return make("table", {}, make("caption", {}, `Over ${count} frame${count > 1 ? "s" : ""}`),
              make("thead", {}, head), body);
}

function showTimes(data, onPick) {
  const times = data.times;
  if (times.stages.length === 0 && !times.render && !times.denoise && !times.write) {
    return [];
  }
  byId("times").append(timesTable(times));
  byId("times-section").hidden = false;
  const plots = [];
  for (const name of ["denoise", "render"]) {
    if (times[name] && times.frames.length >= kLeastPlotted) {
      plots.push(new Plot({
        title: `Time to ${name}`,
        note: "ms, lower is better",
        frames: times.frames,
        series: [{name, shape: kShapes[name], values: times[`${name}_ms`]}],
        logarithmic: false,
        fromZero: true,
        format: (value) => `${formatMs(value)} ms`,
        onPick,
      }));
    }
  }
  byId("time-plots").append(...plots.map((plot) => plot.element));
  return plots;
}

// Settings

function pairsTable(title, pairs) {
  return make("table", {}, make("caption", {}, title),
              make("tbody", {}, ...pairs.map(([name, value]) => make(
                  "tr", {}, make("th", {scope: "row"}, name), make("td", {}, value)))));
}

function showSettings(data) {
  const memory = data.memory.map(
      ([name, bytes]) => [`memory, ${name.replace(/_bytes$/, "")}`, formatBytes(bytes)]);
  const parameters = [];
  const rows = Math.max(kParameterRows, Math.ceil(data.parameters.length / 2));
  for (let i = 0; i < data.parameters.length; i += rows) {
    const title = i === 0 ? "Denoiser parameters" : "Denoiser parameters, continued";
    parameters.push([[title, data.parameters.slice(i, i + rows)]]);
  }
  // One column each.
  for (const column of [[["Rendering", data.settings], ["Memory", memory]], ...parameters]) {
    const tables = column.filter(([, pairs]) => pairs.length > 0);
    if (tables.length > 0) {
      byId("settings").append(
          make("div", {}, ...tables.map(([title, pairs]) => pairsTable(title, pairs))));
      byId("settings-section").hidden = false;
    }
  }
}

function main() {
  const data = JSON.parse(byId("report-data").textContent);
  const pictures = JSON.parse(byId("report-pictures").textContent);
  byId("report-pictures").remove();
  showSummary(data);
  showNotes(data);
  showSettings(data);
  const plots = {quality: [], times: []};
  const mark = (index) => {
    for (const plot of [...plots.quality, ...plots.times]) {
      plot.setCurrent(data.frames[index].number);
    }
  };
  const viewer = new Viewer(data, pictures, mark);
  const onPick = (number) => viewer.goToNumber(number);
  plots.times = showTimes(data, onPick);
  const sources = data.quality.sources;
  const showSource = () => {
    plots.quality = showQuality(data, sources[byId("source").selectedIndex], onPick);
    mark(viewer.frame);
  };
  for (const {source} of sources) {
    byId("source").add(new Option(kSourceLabels[source], source));
  }
  byId("source").addEventListener("change", showSource);
  byId("source-field").hidden = sources.length < 2;
  if (sources.length > 0) {
    byId("quality-section").hidden = false;
    showSource();
  }
  mark(viewer.frame);
}

main();
