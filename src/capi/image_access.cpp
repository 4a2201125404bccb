// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "capi/image_access.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>

#include <fmt/format.h>

#include "core/half.h"
#include "core/parallel.h"

namespace stillray::capi {
namespace {

/// Beyond any address space, yet small enough that offsets within an image do not overflow.
constexpr ptrdiff_t kMaxStride = ptrdiff_t{1} << 44;

ptrdiff_t BytesOf(int format) {
  return format == STILLRAY_FORMAT_HALF ? 2 : 4;
}

/// Whether two elements of the image share bytes: in ascending order, each stride must exceed the
/// extent of the smaller strides.
bool Overlaps(const stillray_image& image) {
  struct Axis {
    ptrdiff_t stride;
    ptrdiff_t count;
  };
  std::array<Axis, 3> axes = {Axis{std::abs(image.channel_stride), image.channels},
                              Axis{std::abs(image.pixel_stride), image.width},
                              Axis{std::abs(image.row_stride), image.height}};
  std::sort(axes.begin(), axes.end(), [](const Axis& a, const Axis& b) {
    return a.stride != b.stride ? a.stride < b.stride : a.count < b.count;
  });
  ptrdiff_t extent = BytesOf(image.format);
  for (const Axis& axis : axes) {
    if (axis.count == 1) {
      continue;
    }
    if (axis.stride < extent) {
      return true;
    }
    extent += axis.stride * (axis.count - 1);
  }
  return false;
}

Status CheckRange(std::string_view name, ptrdiff_t stride) {
  if (stride <= kMaxStride && stride >= -kMaxStride) {
    return Status::Ok();
  }
  return Status::InvalidArgument(fmt::format(
      "image '{}' has a stride of {} bytes, expected at most {}", name, stride, kMaxStride));
}

Status CheckStrides(std::string_view name, stillray_image* image) {
  STILLRAY_RETURN_IF_ERROR(CheckRange(name, image->pixel_stride));
  STILLRAY_RETURN_IF_ERROR(CheckRange(name, image->channel_stride));
  const ptrdiff_t bytes = BytesOf(image->format);
  image->pixel_stride = image->pixel_stride != 0 ? image->pixel_stride : image->channels * bytes;
  image->row_stride =
      image->row_stride != 0 ? image->row_stride : image->width * image->pixel_stride;
  image->channel_stride = image->channel_stride != 0 ? image->channel_stride : bytes;
  STILLRAY_RETURN_IF_ERROR(CheckRange(name, image->row_stride));
  if (Overlaps(*image)) {
    return Status::InvalidArgument(fmt::format(
        "image '{}' overlaps itself: {}x{} pixels of {} channels of {} bytes with pixel "
        "stride {}, row stride {}, channel stride {}",
        name, image->width, image->height, image->channels, bytes, image->pixel_stride,
        image->row_stride, image->channel_stride));
  }
  return Status::Ok();
}

/// Calls visit(address, plane element) for every pixel, rows in parallel.
template <typename PlaneType, typename Visit>
void ForEach(const stillray_image& image, int channel, PlaneType& plane, const Visit& visit) {
  ParallelRows(image.height, kBand, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      char* at =
          static_cast<char*>(image.data) + y * image.row_stride + channel * image.channel_stride;
      auto* row = plane.Row(y);
      for (int x = 0; x < image.width; ++x) {
        visit(at + x * image.pixel_stride, row[x]);
      }
    }
  });
}

}  // namespace

Status CheckImage(std::string_view name, int channels, bool id, stillray_image* image) {
  if (image->data == nullptr) {
    return Status::InvalidArgument(fmt::format("image '{}' has no data (NULL)", name));
  }
  if (image->format < STILLRAY_FORMAT_FLOAT || image->format > STILLRAY_FORMAT_UINT32) {
    return Status::InvalidArgument(
        fmt::format("image '{}' has the unknown format {}", name, image->format));
  }
  if ((image->format == STILLRAY_FORMAT_UINT32) != id) {
    return Status::InvalidArgument(fmt::format("image '{}' has the wrong format, expected {}", name,
                                               id ? "UINT32" : "FLOAT or HALF"));
  }
  if (image->width < 1 || image->height < 1 || image->width > kMaxSide ||
      image->height > kMaxSide) {
    return Status::InvalidArgument(fmt::format("image '{}' is {}x{}, expected 1x1 to {}x{}", name,
                                               image->width, image->height, kMaxSide, kMaxSide));
  }
  if (image->channels < channels || image->channels > 4) {
    return Status::InvalidArgument(fmt::format("image '{}' has {} channels, expected {} to 4", name,
                                               image->channels, channels));
  }
  return CheckStrides(name, image);
}

void ReadChannel(const stillray_image& image, int channel, Image1* plane) {
  // Elements need not be aligned, so they are copied byte by byte.
  if (image.format == STILLRAY_FORMAT_HALF) {
    ForEach(image, channel, *plane, [](const char* from, float& to) {
      uint16_t half = 0;
      std::memcpy(&half, from, sizeof(half));
      to = FloatFromHalf(half);
    });
    return;
  }
  ForEach(image, channel, *plane,
          [](const char* from, float& to) { std::memcpy(&to, from, sizeof(to)); });
}

void ReadIds(const stillray_image& image, Plane<uint32_t>* plane) {
  ForEach(image, 0, *plane,
          [](const char* from, uint32_t& to) { std::memcpy(&to, from, sizeof(to)); });
}

void WriteChannel(const Image1& plane, int channel, const stillray_image& image) {
  if (image.format == STILLRAY_FORMAT_HALF) {
    ForEach(image, channel, plane, [](char* to, const float& from) {
      const uint16_t half = HalfFromFloat(from);
      std::memcpy(to, &half, sizeof(half));
    });
    return;
  }
  ForEach(image, channel, plane,
          [](char* to, const float& from) { std::memcpy(to, &from, sizeof(from)); });
}

void ClearChannel(int channel, const stillray_image& image) {
  WriteChannel(Image1(image.width, image.height), channel, image);
}

}  // namespace stillray::capi
