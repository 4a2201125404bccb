// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/batch_store.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <tbb/parallel_for.h>

namespace stillray::render {
namespace {

/// Pixels per row chunk that a thread reorders.
constexpr int kChunkWidth = 256;

/// Calls body(tile) for pieces of the batch's tile, on all threads.
template <typename Body>
void ForChunks(const Tile& tile, const Body& body) {
  const int rows = (tile.height + static_cast<int>(kBlockSize) - 1) / static_cast<int>(kBlockSize);
  tbb::parallel_for(0, rows, [&](int row) {
    Tile chunk;
    chunk.y0 = tile.y0 + row * static_cast<int>(kBlockSize);
    chunk.height = std::min<int>(kBlockSize, tile.y0 + tile.height - chunk.y0);
    for (int x = 0; x < tile.width; x += kChunkWidth) {
      chunk.x0 = tile.x0 + x;
      chunk.width = std::min(kChunkWidth, tile.width - x);
      body(chunk);
    }
  });
}

/// Calls body(index in the batch) for the pixels of a chunk, row by row.
template <typename Body>
void ForPixels(const GpuBatch& batch, const Tile& chunk, const Body& body) {
  for (int y = 0; y < chunk.height; ++y) {
    for (int x = 0; x < chunk.width; ++x) {
      body(NumberInBatch(static_cast<uint32_t>(batch.width),
                         static_cast<uint32_t>(chunk.x0 + x - batch.x),
                         static_cast<uint32_t>(chunk.y0 + y - batch.y)));
    }
  }
}

}  // namespace

PixelGuides GuidesOf(const GpuGuides& guides) {
  PixelGuides out;
  out.depth = guides.depth;
  out.normal = guides.normal;
  out.albedo = guides.albedo;
  out.specular_albedo = guides.specular_albedo;
  out.motion = vec2(guides.motion_x, guides.motion_y);
  out.id = guides.id;
  out.roughness = guides.roughness;
  out.emission = guides.emission;
  out.background = guides.background;
  out.previous_normal = guides.previous_normal;
  out.transmission_albedo = guides.transmission_albedo;
  return out;
}

VirtualImage ImageOf(const GpuImage& image) {
  VirtualImage out;
  out.depth = image.depth;
  out.normal = image.normal;
  out.albedo = image.albedo;
  out.motion = vec2(image.motion_x, image.motion_y);
  out.id = image.id;
  return out;
}

SampleLight LightOf(const GpuSignal* first, uint32_t signals) {
  SampleLight out;
  out.fill(vec3(0.0f));
  for (uint32_t k = 0; k < signals; ++k) {
    out[k] = first[k].light;
  }
  return out;
}

Tile TileOf(const GpuBatch& batch, int width, int height) {
  const int rows = static_cast<int>(batch.count) / batch.width;
  return {batch.x, batch.y, std::min(batch.width, width - batch.x),
          std::min(rows, height - batch.y)};
}

namespace {

void StoreLightOf(const GpuBatch& batch, const Tile& chunk, const BatchResults& results,
                  Frame* frame) {
  std::vector<SampleLight> lights;
  std::vector<SampleSquares> squares;
  lights.reserve(static_cast<size_t>(chunk.count()));
  squares.reserve(static_cast<size_t>(chunk.count()));
  ForPixels(batch, chunk, [&](uint32_t number) {
    const GpuSignal* first = results.sums + size_t{number} * results.signals;
    lights.push_back(LightOf(first, results.signals));
    SampleSquares& square = squares.emplace_back();
    for (uint32_t k = 0; k < results.signals; ++k) {
      square[k] = first[k].square;
    }
  });
  StoreLight(chunk, results.spp, lights.data(), squares.data(), frame);
}

/// Converts the values of a chunk's pixels, row by row.
template <typename T, typename Value, typename Convert>
std::vector<T> Converted(const GpuBatch& batch, const Tile& chunk, const Value* values,
                         const Convert& convert) {
  std::vector<T> of_chunk;
  of_chunk.reserve(static_cast<size_t>(chunk.count()));
  ForPixels(batch, chunk, [&](uint32_t number) { of_chunk.push_back(convert(values[number])); });
  return of_chunk;
}

}  // namespace

void StoreBatch(const GpuBatch& batch, const BatchResults& results, Frame* frame) {
  ForChunks(TileOf(batch, frame->width, frame->height), [&](const Tile& chunk) {
    if (results.guides != nullptr) {
      const auto guides = Converted<PixelGuides>(batch, chunk, results.guides, GuidesOf);
      StoreGuides(chunk, guides.data(), frame);
    }
    for (const auto& [from, to] : {std::pair{results.reflections, &frame->reflection},
                                   std::pair{results.refractions, &frame->refraction}}) {
      if (from != nullptr) {
        const auto images = Converted<VirtualImage>(batch, chunk, from, ImageOf);
        StoreVirtualImages(chunk, images.data(), to);
      }
    }
    if (results.sums != nullptr) {
      StoreLightOf(batch, chunk, results, frame);
    }
  });
}

void StoreReference(const GpuBatch& batch, const GpuSignal* sums, int spp, Image3* radiance) {
  const auto samples = static_cast<double>(spp);
  ForChunks(TileOf(batch, radiance->width(), radiance->height()), [&](const Tile& chunk) {
    int i = 0;
    ForPixels(batch, chunk, [&](uint32_t number) {
      const glm::dvec3 sum(sums[kSurfaceSignals * number].light);
      const glm::dvec3 lost(sums[kSurfaceSignals * number + 1].light);
      StorePixel(radiance, chunk.x0 + i % chunk.width, chunk.y0 + i / chunk.width,
                 vec3((sum - lost) / samples));
      ++i;
    });
  });
}

}  // namespace stillray::render
