// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Adds light to the picture; all light passes through here. Needs trace.glsl. A pixel of the batch
// has one path at a time, so no other thread writes to its light.
void AddSignal(uint number, int kind, vec3 light) {
  if (!IsUsableLight(light)) {
    atomicAdd(counters.dropped, 1u);
    return;
  }
  if (light == vec3(0.0f)) {
    return;  // no lobe of this kind
  }
  sample_lights[FirstSignal(number) + uint(kind)].light += light;
}

// \param properties  kLight...
void AddFound(uint number, int properties, vec3 diffuse, vec3 specular) {
  FoundLight light =
      SortLight(ClampLight(FoundLight(diffuse, specular), frame.clamp_radiance), properties);
  AddSignal(number, DiffuseKind(properties), light.diffuse);
  AddSignal(number, SpecularKind(properties), light.specular);
}
