// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Adds light to the picture; all light passes through here. Needs trace.glsl. A pixel of the batch
// has one path at a time, so no other thread writes to its light.
const int kDirectDiffuse = 0;
const int kIndirectDiffuse = 1;
const int kDirectSpecular = 2;
const int kIndirectSpecular = 3;

void AddSignal(uint number, int kind, vec3 light) {
  if (!IsUsableLight(light)) {
    atomicAdd(counters.dropped, 1u);
    return;
  }
  sample_lights[number].signals[kind].light += light;
}

void AddFound(uint number, bool direct, vec3 diffuse, vec3 specular) {
  FoundLight light = ClampLight(FoundLight(diffuse, specular), frame.clamp_radiance);
  AddSignal(number, direct ? kDirectDiffuse : kIndirectDiffuse, light.diffuse);
  AddSignal(number, direct ? kDirectSpecular : kIndirectSpecular, light.specular);
}
