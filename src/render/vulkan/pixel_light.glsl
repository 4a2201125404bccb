// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The only function that adds radiance to a pixel. Needs trace.glsl. A pixel of the batch has one
// path at a time, hence no other thread writes to its signals.
void AddSignal(uint number, int kind, vec3 light) {
  if (!IsUsableLight(light)) {
    atomicAdd(counters.dropped, 1u);
    return;
  }
  if (light == vec3(0.0f)) {
    return;  // no contribution of this kind
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
