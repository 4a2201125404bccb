// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The demodulated radiance of a signal in the unit of the input, with firefly compression inverted.
// \param c  luminance, red, blue times the exposure
vec3 FilteredLight(vec3 c, int s) {
  c /= exposure[s];
  if (demodulate.firefly == 2) {
    c *= ExpandScale(c.x);
  }
  if (by_channel != 0) {
    vec3 rgb = vec3(0.0f);
    rgb[ChannelOf(s)] = c.x;
    return rgb;
  }
  float green =
      demodulate.luminance_rec601 != 0 ? Green601(c.x, c.y, c.z) : Green709(c.x, c.y, c.z);
  return vec3(c.y, green, c.z);
}
