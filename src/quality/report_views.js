// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What a side of the viewer can show: pictures and error maps, and the scales of the latter.

const kViews = ["noisy", "temporal", "denoised", "reference"];
const kMaps = [
  {key: "flip", label: "FLIP error"},
  {key: "rel_se", label: "Relative squared error"},
];

function byId(id) {
  return document.getElementById(id);
}

function clamp(value, low, high) {
  return Math.min(Math.max(value, low), high);
}

/// What a side can show: {id, view, key, label, group}; `key` is "picture" or a map's.
function findChoices(frames) {
  const choices = [];
  const has = (view, key) =>
      frames.some((frame) => frame.views[view] && frame.views[view][key] !== null);
  for (const view of kViews) {
    if (has(view, "picture")) {
      choices.push({id: view, view, key: "picture", label: view, group: "Pictures"});
    }
  }
  for (const map of kMaps) {
    for (const view of kViews) {
      if (has(view, map.key)) {
        choices.push({
          id: `${view}-${map.key}`,
          view,
          key: map.key,
          label: `${view}: ${map.label}`,
          group: map.label,
        });
      }
    }
  }
  return choices;
}

function fillSelect(select, choices) {
  let group = null;
  for (const choice of choices) {
    if (group === null || group.label !== choice.group) {
      group = document.createElement("optgroup");
      group.label = choice.group;
      select.append(group);
    }
    group.append(new Option(choice.label, choice.id));
  }
}

/// The error at one end-to-end position 0..1 of a scale.
function scaleValue(scale, position) {
  return scale.logarithmic ? scale.low * Math.pow(scale.high / scale.low, position)
                           : scale.low + (scale.high - scale.low) * position;
}

/// The colours of an error map with the values that they stand for.
function makeScale(map, heat) {
  const scale = heat[map.key];
  const box = document.createElement("div");
  box.className = "scale";
  const bar = document.createElement("canvas");
  const colours = heat.ramp.slice(0, -1);
  bar.width = colours.length;
  bar.height = 1;
  const context = bar.getContext("2d");
  colours.forEach((colour, x) => {
    context.fillStyle = colour;
    context.fillRect(x, 0, 1, 1);
  });
  const ticks = document.createElement("div");
  ticks.className = "ticks";
  const count = scale.logarithmic ? Math.round(Math.log10(scale.high / scale.low)) : 4;
  for (let i = 0; i <= count; ++i) {
    const tick = document.createElement("span");
    tick.style.left = `${100 * i / count}%`;
    tick.textContent = formatShort(scaleValue(scale, i / count));
    ticks.append(tick);
  }
  const label = document.createElement("div");
  label.textContent = map.label + (scale.logarithmic ? " (logarithmic)" : "");
  box.append(label, bar, ticks);
  return box;
}
