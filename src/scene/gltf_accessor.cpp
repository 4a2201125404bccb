// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "scene/gltf_accessor.h"

#include <algorithm>
#include <array>
#include <cstring>

#include <fmt/format.h>

namespace stillray {

namespace {

constexpr uint64_t kByte = 5120;
constexpr uint64_t kUnsignedByte = 5121;
constexpr uint64_t kShort = 5122;
constexpr uint64_t kUnsignedShort = 5123;
constexpr uint64_t kUnsignedInt = 5125;
constexpr uint64_t kFloat = 5126;

/// Maximum number of elements: larger than any array of a scene that fits into memory.
constexpr uint64_t kMaxElements = 100'000'000;
/// Maximum number of elements of an accessor without data (all zero) in excess of the file's size
/// in bytes: real files use accessors without data only for small morph targets and placeholders.
constexpr uint64_t kMaxFreeElements = 1'000'000;

const std::array<uint8_t, 64> kZeros{};

size_t ComponentBytes(uint64_t type) {
  switch (type) {
    case kByte:
    case kUnsignedByte:
      return 1;
    case kShort:
    case kUnsignedShort:
      return 2;
    case kUnsignedInt:
    case kFloat:
      return 4;
    default:
      return 0;
  }
}

int ComponentCount(const std::string& type) {
  if (type == "SCALAR") {
    return 1;
  }
  if (type.size() == 4 && type.compare(0, 3, "VEC") == 0 && type[3] >= '2' && type[3] <= '4') {
    return type[3] - '0';
  }
  if (type == "MAT4") {
    return 16;  // columns are not padded for any component type
  }
  return 0;
}

template <typename T>
T Load(const uint8_t* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

float LoadComponent(const uint8_t* bytes, uint64_t type, bool normalized) {
  switch (type) {
    case kByte: {
      const float value = Load<int8_t>(bytes);
      return normalized ? std::max(value / 127.0f, -1.0f) : value;
    }
    case kUnsignedByte: {
      const float value = Load<uint8_t>(bytes);
      return normalized ? value / 255.0f : value;
    }
    case kShort: {
      const float value = Load<int16_t>(bytes);
      return normalized ? std::max(value / 32767.0f, -1.0f) : value;
    }
    case kUnsignedShort: {
      const float value = Load<uint16_t>(bytes);
      return normalized ? value / 65535.0f : value;
    }
    case kUnsignedInt:
      return static_cast<float>(Load<uint32_t>(bytes));
    default:
      return Load<float>(bytes);
  }
}

uint32_t LoadUnsigned(const uint8_t* bytes, uint64_t type) {
  switch (type) {
    case kUnsignedByte:
      return Load<uint8_t>(bytes);
    case kUnsignedShort:
      return Load<uint16_t>(bytes);
    default:
      return Load<uint32_t>(bytes);
  }
}

/// Locates the bytes of `count` elements from `offset` on; logs a failure and returns false if they
/// exceed the view.
bool OpenElements(const GltfDocument& document, const JsonView& owner, uint64_t count,
                  size_t element_bytes, bool may_stride, const uint8_t** data, size_t* stride) {
  ImportLog* log = owner.log();
  const JsonView root = document.Root(log);
  const int view = owner.Index("bufferView", root.Size("bufferViews"), "bufferViews");
  if (view < 0) {
    return log->ok();
  }
  ByteSpan bytes;
  size_t view_stride = 0;
  const uint64_t offset = owner.Count("byteOffset", 0);
  if (!log->ok() || !OpenBufferView(document, log, static_cast<size_t>(view), owner.path(), &bytes,
                                    &view_stride)) {
    return false;
  }
  const size_t step = may_stride && view_stride != 0 ? view_stride : element_bytes;
  if (step < element_bytes) {
    owner.Fail(nullptr,
               fmt::format("elements of {} bytes overlap in bufferViews[{}], whose stride is {}",
                           element_bytes, view, step));
    return false;
  }
  // None of these can overflow: count <= kMaxElements, step <= 252, offset < 2^53.
  const uint64_t end = offset + (count - 1) * step + element_bytes;
  if (end > bytes.size()) {
    owner.Fail(nullptr, fmt::format("{} elements end at byte {} of bufferViews[{}], which has {}",
                                    count, end, view, bytes.size()));
    return false;
  }
  *data = bytes.data() + offset;
  *stride = step;
  return true;
}

}  // namespace

const uint8_t* Accessor::Element(size_t i) const {
  if (!sparse_indices_.empty()) {
    const auto it = std::lower_bound(sparse_indices_.begin(), sparse_indices_.end(), i);
    if (it != sparse_indices_.end() && *it == i) {
      const size_t rank = static_cast<size_t>(it - sparse_indices_.begin());
      return sparse_values_ + rank * component_bytes_ * static_cast<size_t>(components_);
    }
  }
  return data_ == nullptr ? kZeros.data() : data_ + i * stride_;
}

void Accessor::Read(size_t i, float* out) const {
  const uint8_t* bytes = Element(i);
  for (int c = 0; c < components_; ++c) {
    out[c] = LoadComponent(bytes, component_type_, normalized_);
    bytes += component_bytes_;
  }
}

uint32_t Accessor::ReadIndex(size_t i) const {
  return LoadUnsigned(Element(i), component_type_);
}

namespace {

/// The indices of the sparse part, checked to be increasing and below `count`.
bool ReadSparseIndices(const GltfDocument& document, const JsonView& sparse, uint64_t sparse_count,
                       uint64_t count, std::vector<uint32_t>* out) {
  const JsonView indices = sparse.Object("indices");
  const uint64_t type = indices.Count("componentType", 0);
  if (type != kUnsignedByte && type != kUnsignedShort && type != kUnsignedInt) {
    indices.Fail("componentType", fmt::format("{} is no type of indices", type));
    return false;
  }
  const uint8_t* data = nullptr;
  size_t stride = 0;
  if (!OpenElements(document, indices, sparse_count, ComponentBytes(type), false, &data, &stride)) {
    return false;
  }
  if (data == nullptr) {
    indices.Fail("bufferView", "missing");
    return false;
  }
  out->resize(sparse_count);
  for (size_t i = 0; i < sparse_count; ++i) {
    const uint32_t index = LoadUnsigned(data + i * stride, type);
    if (index >= count || (i != 0 && index <= (*out)[i - 1])) {
      indices.Fail(nullptr, fmt::format("index {} at position {} is not increasing or not below {}",
                                        index, i, count));
      return false;
    }
    (*out)[i] = index;
  }
  return true;
}

}  // namespace

bool OpenAccessor(const GltfDocument& document, ImportLog* log, int index, const std::string& user,
                  Accessor* accessor) {
  const JsonView view = document.Root(log).Item("accessors", static_cast<size_t>(index));
  const std::string type = view.String("type");
  const uint64_t count = view.Count("count", 0);
  *accessor = Accessor();
  accessor->component_type_ = view.Count("componentType", 0);
  accessor->normalized_ = view.Bool("normalized", false);
  if (!log->ok()) {
    return false;
  }
  accessor->components_ = ComponentCount(type);
  accessor->component_bytes_ = ComponentBytes(accessor->component_type_);
  if (accessor->components_ == 0) {
    view.Fail("type", fmt::format("'{}' is not SCALAR, VEC2, VEC3, VEC4 or MAT4, as {} needs",
                                  Printable(type), user));
    return false;
  }
  if (accessor->component_bytes_ == 0) {
    view.Fail("componentType",
              fmt::format("{} is none of glTF's component types", accessor->component_type_));
    return false;
  }
  if (count < 1 || count > kMaxElements) {
    view.Fail("count", fmt::format("{} is outside 1..{}", count, kMaxElements));
    return false;
  }
  accessor->count_ = count;
  const size_t element_bytes =
      accessor->component_bytes_ * static_cast<size_t>(accessor->components_);
  if (!OpenElements(document, view, count, element_bytes, true, &accessor->data_,
                    &accessor->stride_)) {
    return false;
  }
  if (accessor->data_ == nullptr && count > kMaxFreeElements + document.total_bytes) {
    view.Fail("count", fmt::format("{} elements without data in a file of {} bytes", count,
                                   document.total_bytes));
    return false;
  }
  const JsonView sparse = view.Object("sparse");
  if (!sparse.exists()) {
    return log->ok();
  }
  const uint64_t sparse_count = sparse.Count("count", 0);
  if (!log->ok()) {
    return false;
  }
  if (sparse_count < 1 || sparse_count > count) {
    sparse.Fail("count", fmt::format("{} is outside 1..{}", sparse_count, count));
    return false;
  }
  const JsonView values = sparse.Object("values");
  size_t stride = 0;
  if (!ReadSparseIndices(document, sparse, sparse_count, count, &accessor->sparse_indices_) ||
      !OpenElements(document, values, sparse_count, element_bytes, false, &accessor->sparse_values_,
                    &stride)) {
    return false;
  }
  if (accessor->sparse_values_ == nullptr) {
    values.Fail("bufferView", "missing");
    return false;
  }
  return true;
}

}  // namespace stillray
