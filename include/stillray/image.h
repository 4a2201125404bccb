// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Planar images: one plane per channel, rows from the top, pixel (0,0) at the top left.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <utility>

namespace stillray {

namespace detail {

/// Alignment of plane rows in bytes: a cache line, and the widest vector.
inline constexpr size_t kPlaneAlignment = 64;

/// Zeroed memory of a plane. Large allocations usually start at the same offset in a memory page,
/// so that the same pixel of many planes would compete for the few ways of one cache set:
/// successive planes start at different offsets here. Planes of 2 MiB and more use huge pages where
/// available (Linux): a filter reads more planes than the TLB holds small pages, and the first
/// touch of a small page takes far longer than filling it.
class PlaneMemory {
 public:
  PlaneMemory() = default;
  /// \throws std::bad_alloc
  explicit PlaneMemory(size_t bytes);
  PlaneMemory(PlaneMemory&& other) noexcept { *this = std::move(other); }
  PlaneMemory& operator=(PlaneMemory&& other) noexcept {
    std::swap(block_, other.block_);
    std::swap(data_, other.data_);
    std::swap(mapped_, other.mapped_);
    return *this;
  }
  ~PlaneMemory();

  void* data() const { return data_; }

 private:
  void* block_ = nullptr;
  void* data_ = nullptr;
  size_t mapped_ = 0;  ///< bytes, of large planes
};

}  // namespace detail

/// An owning plane of trivially copyable values. Rows start on cache lines. The pixels are
/// surrounded by a border of `border` pixels on every side (and one vector more to the right) that
/// may be read and written, so that filters need no edge tests. Pixels and border are initially
/// zero.
template <typename T>
class Plane {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  /// Alignment of every row's first pixel in bytes.
  static constexpr size_t kAlignment = detail::kPlaneAlignment;

  Plane() = default;
  /// \param width, height, border  pixels, >= 0 \throws std::bad_alloc
  explicit Plane(int width, int height, int border = 0)
      : width_(width), height_(height), border_(border) {
    constexpr int kPerLine = static_cast<int>(kAlignment / sizeof(T));
    const int left = RoundUp(border, kPerLine);
    // One vector beyond the border: the last vector of a row may start at its last pixel.
    stride_ = RoundUp(left + width + border + kPerLine, kPerLine);
    const size_t count = static_cast<size_t>(stride_) * static_cast<size_t>(height + 2 * border);
    bytes_ = count * sizeof(T);
    storage_ = detail::PlaneMemory(bytes_);
    data_ = static_cast<T*>(storage_.data());
    origin_ = data_ + static_cast<ptrdiff_t>(border) * stride_ + left;
  }
  Plane(const Plane& other) : Plane(other.width_, other.height_, other.border_) {
    if (bytes_ != 0) {
      std::memcpy(static_cast<void*>(data_), other.data_, bytes_);
    }
  }
  Plane(Plane&& other) noexcept { *this = std::move(other); }
  Plane& operator=(const Plane& other) {
    if (this != &other) {
      *this = Plane(other);
    }
    return *this;
  }
  Plane& operator=(Plane&& other) noexcept {
    std::swap(width_, other.width_);
    std::swap(height_, other.height_);
    std::swap(border_, other.border_);
    std::swap(stride_, other.stride_);
    std::swap(bytes_, other.bytes_);
    std::swap(data_, other.data_);
    std::swap(origin_, other.origin_);
    std::swap(storage_, other.storage_);
    return *this;
  }

  int width() const { return width_; }
  int height() const { return height_; }
  int border() const { return border_; }
  ptrdiff_t stride() const { return stride_; }  ///< distance of rows, in elements
  size_t bytes() const { return bytes_; }       ///< of memory, border included
  bool empty() const { return width_ == 0 || height_ == 0; }

  /// Pointer to pixel (0, y), y from -border() to height() + border() - 1.
  T* Row(int y) { return origin_ + y * stride_; }
  const T* Row(int y) const { return origin_ + y * stride_; }
  T& operator()(int x, int y) { return origin_[y * stride_ + x]; }
  const T& operator()(int x, int y) const { return origin_[y * stride_ + x]; }

  /// Sets all pixels, but not the border, to `value`.
  void Fill(T value) {
    for (int y = 0; y < height_; ++y) {
      std::fill_n(Row(y), width_, value);
    }
  }

 private:
  static int RoundUp(int value, int multiple) {
    return (value + multiple - 1) / multiple * multiple;
  }

  int width_ = 0;
  int height_ = 0;
  int border_ = 0;
  ptrdiff_t stride_ = 0;
  size_t bytes_ = 0;
  T* data_ = nullptr;  ///< first element, including the border
  T* origin_ = nullptr;
  detail::PlaneMemory storage_;
};

/// N planes of the same size: N = 3 for colour (r, g, b) and normals (x, y, z), 2 for motion.
/// \tparam Basis  tag type of images whose channels have another meaning
template <typename T, int N, typename Basis = void>
struct Planes {
  std::array<Plane<T>, N> channel;

  Planes() = default;
  explicit Planes(int width, int height, int border = 0) {
    for (Plane<T>& plane : channel) {
      plane = Plane<T>(width, height, border);
    }
  }
  int width() const { return channel[0].width(); }
  int height() const { return channel[0].height(); }
  bool empty() const { return channel[0].empty(); }
  size_t bytes() const { return N * channel[0].bytes(); }
  Plane<T>& operator[](int i) { return channel[static_cast<size_t>(i)]; }
  const Plane<T>& operator[](int i) const { return channel[static_cast<size_t>(i)]; }
};

/// Images of 1, 2 and 3 channels of 32-bit floats.
using Image1 = Plane<float>;
using Image2 = Planes<float, 2>;
using Image3 = Planes<float, 3>;

}  // namespace stillray
