// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "doctor/warp.h"

#include <algorithm>

#include "core/parallel.h"
#include "core/pixels.h"

namespace stillray::doctor {
namespace {

/// Differences of albedo count twice: neighbouring surfaces often have similar colours.
constexpr float kAlbedoWeight = 2.0f;

float FiniteOr0(float value) {
  return std::isfinite(value) ? value : 0.0f;
}

bool Varies(const Image3& image) {
  return std::any_of(image.channel.begin(), image.channel.end(), [](const Image1& plane) {
    return AnyPixel(plane, [&](float v) { return v != plane(0, 0); });
  });
}

/// Mean over 7x7 pixels: smaller windows are too noisy at one sample per pixel.
Image1 Blurred(const Image1& image) {
  constexpr int kRadius = 3;
  Image1 rows(image.width(), image.height());
  Image1 out(image.width(), image.height());
  const auto mean = [](const auto& at, int i, int size) {
    float sum = 0;
    const int first = std::max(i - kRadius, 0);
    const int last = std::min(i + kRadius, size - 1);
    for (int k = first; k <= last; ++k) {
      sum += at(k);
    }
    return sum / static_cast<float>(last - first + 1);
  };
  ParallelRows(image.height(), kRowsPerTask, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < image.width(); ++x) {
        rows(x, y) = mean([&](int k) { return image(k, y); }, x, image.width());
      }
    }
  });
  ParallelRows(image.height(), kRowsPerTask, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < image.width(); ++x) {
        out(x, y) = mean([&](int k) { return rows(x, k); }, y, image.height());
      }
    }
  });
  return out;
}

double MeanOf(const Image1& image) {
  double sum = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      sum += image(x, y);
    }
  }
  return sum / (static_cast<double>(image.width()) * image.height());
}

}  // namespace

Features::Features(const Exhibit& exhibit)
    : width_(exhibit.frame.width), height_(exhibit.frame.height) {
  const Guides& g = exhibit.frame.guides;
  std::vector<Image1> own;  // made here
  std::vector<std::pair<const Image1*, float>> planes;
  if (!g.albedo.empty() && Varies(g.albedo)) {
    for (int c = 0; c < 3; ++c) {
      planes.emplace_back(&g.albedo[c], kAlbedoWeight);
    }
  }
  if (!g.normal.empty() && Varies(g.normal)) {
    for (int c = 0; c < 3; ++c) {
      planes.emplace_back(&g.normal[c], 1.0f);
    }
  }
  if (planes.empty()) {
    of_guides_ = false;
    own.push_back(Blurred(exhibit.light));
    const auto mean = static_cast<float>(std::max(MeanOf(exhibit.light), 1e-20));
    planes.emplace_back(&own[0], 1.0f / mean);
  }
  count_ = planes.size();
  values_.resize(count_ * static_cast<size_t>(width_) * static_cast<size_t>(height_));
  ParallelRows(height_, kRowsPerTask, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      float* to = values_.data() + count_ * static_cast<size_t>(y) * static_cast<size_t>(width_);
      for (int x = 0; x < width_; ++x) {
        for (const auto& [plane, weight] : planes) {
          *to++ = FiniteOr0((*plane)(x, y)) * weight;
        }
      }
    }
  });
}

float Features::Distance(int x, int y, const Features& other, int other_x, int other_y) const {
  if (count_ != other.count_) {
    return 1;
  }
  const auto at = [&](const Features& f, int px, int py) {
    return f.values_.data() + count_ * (static_cast<size_t>(py) * static_cast<size_t>(f.width_) +
                                        static_cast<size_t>(px));
  };
  const float* a = at(*this, x, y);
  const float* b = at(other, other_x, other_y);
  float sum = 0;
  for (size_t i = 0; i < count_; ++i) {
    sum += std::fabs(a[i] - b[i]);
  }
  return std::min(sum, 1.0f);
}

float Features::DistanceAt(int x, int y, const Features& other, vec2 place) const {
  if (!(place.x > -0.5f && place.y > -0.5f && place.x < static_cast<float>(other.width_) - 0.5f &&
        place.y < static_cast<float>(other.height_) - 0.5f)) {
    return 1;
  }
  const int left = static_cast<int>(std::floor(place.x));
  const int top = static_cast<int>(std::floor(place.y));
  float least = 1;
  for (int dy = 0; dy <= 1; ++dy) {
    for (int dx = 0; dx <= 1; ++dx) {
      const int px = left + dx;
      const int py = top + dy;
      if (px >= 0 && py >= 0 && px < other.width_ && py < other.height_) {
        least = std::min(least, Distance(x, y, other, px, py));
      }
    }
  }
  return least;
}

}  // namespace stillray::doctor
