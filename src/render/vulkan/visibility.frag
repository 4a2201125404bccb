// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450

// The nearest triangle of a pixel: instance and primitive.
layout(location = 0) flat in uvec2 triangle;
layout(location = 0) out uvec2 seen;

void main() {
  seen = triangle;
}
