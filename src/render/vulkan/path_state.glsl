// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Loads and stores paths between the steps. Needs trace.glsl. Members that a step does not use are
// not transferred: the throughput of the first surface's lobes is written once, and media exist
// only in solid glass.

bool HasMedium(PathState path) {
  return path.extinction != vec3(0.0f) || path.scatter_albedo != vec3(0.0f) || path.collisions != 0;
}

PathState LoadPath(uint number) {
  GpuPath from = paths[number];
  PathState path = StartPath(from.seed);
  path.throughput = from.throughput;
  path.density = from.density;
  path.light_total = from.light_total;
  path.roughest = from.roughest;
  path.origin = from.origin;
  path.normal = from.normal;
  path.step = int(from.counts & 0xffffu);
  path.bounces = int(from.counts >> 16);
  path.free_events = int(from.state & 0xffu);
  path.first = int(from.state >> 8 & 0xffu);
  path.light = int(from.state >> 16 & 0xffu);
  if (path.first == 0) {
    path.diffuse = path_parts[number].diffuse;
    path.specular = path_parts[number].specular;
  }
  if (from.state >> 24 != 0u) {
    path.extinction = path_parts[number].extinction;
    path.collisions = path_parts[number].collisions;
    path.scatter_albedo = path_parts[number].scatter_albedo;
    path.scatter_anisotropy = path_parts[number].scatter_anisotropy;
  }
  return path;
}

// \param with_weights  the path has just scattered at the first surface
void StorePath(uint number, PathState path, bool with_weights) {
  bool with_medium = HasMedium(path);
  uint counts = uint(path.step) | uint(path.bounces) << 16;
  uint state = uint(path.free_events) | uint(path.first) << 8 | uint(path.light) << 16 |
               (with_medium ? 1u << 24 : 0u);
  paths[number] = GpuPath(path.throughput, path.density, path.origin, path.light_total, path.normal,
                          path.roughest, counts, state, path.seed, 0u);
  if (with_weights) {
    path_parts[number].diffuse = path.diffuse;
    path_parts[number].specular = path.specular;
  }
  if (with_medium) {
    path_parts[number].extinction = path.extinction;
    path_parts[number].collisions = path.collisions;
    path_parts[number].scatter_albedo = path.scatter_albedo;
    path_parts[number].scatter_anisotropy = path.scatter_anisotropy;
  }
}
