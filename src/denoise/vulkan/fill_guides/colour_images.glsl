// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The colours of fill_guides: albedo, specular albedo, transmission albedo, emission, background.
// COLOURS_BINDING is the binding of the first image to write, in set 1.
layout(set = 1, binding = COLOURS_BINDING, LIGHT_FORMAT) writeonly uniform image2D albedo_out;
layout(set = 1, binding = COLOURS_BINDING + 1, LIGHT_FORMAT) writeonly uniform image2D specular_out;
layout(set = 1, binding = COLOURS_BINDING + 2, LIGHT_FORMAT) writeonly uniform image2D through_out;
layout(set = 1, binding = COLOURS_BINDING + 3, rgba32f) writeonly uniform image2D emission_out;
layout(set = 1, binding = COLOURS_BINDING + 4, rgba32f) writeonly uniform image2D background_out;

void StoreColour(int k, ivec2 p, vec3 value) {
  vec4 v = vec4(value, 1.0f);
  switch (k) {
    case 0:
      imageStore(albedo_out, p, Stored(v));
      break;
    case 1:
      imageStore(specular_out, p, Stored(v));
      break;
    case 2:
      imageStore(through_out, p, Stored(v));
      break;
    case 3:
      imageStore(emission_out, p, v);
      break;
    default:
      imageStore(background_out, p, v);
  }
}
