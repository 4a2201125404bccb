// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Reads accessors (glTF 2.0, 3.6.2): ranges, strides and types are checked when an accessor is
/// opened, so that reading its elements cannot fail.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scene/gltf_document.h"

namespace stillray {

/// An opened accessor. References the document's buffers.
class Accessor {
 public:
  size_t count() const { return count_; }
  int components() const { return components_; }  ///< 1..4; 16 for MAT4, column-major
  bool is_float() const { return component_type_ == 5126; }
  size_t component_bytes() const { return component_bytes_; }
  bool normalized() const { return normalized_; }
  bool is_unsigned() const {
    return component_type_ == 5121 || component_type_ == 5123 || component_type_ == 5125;
  }

  /// The components of element i, i < count(). Normalised integers are mapped to -1..1 or 0..1
  /// (glTF 2.0, 3.6.2.2); other integers are converted.
  void Read(size_t i, float* out) const;
  /// Element i of a scalar accessor of unsigned integers.
  uint32_t ReadIndex(size_t i) const;

 private:
  friend bool OpenAccessor(const GltfDocument&, ImportLog*, int, const std::string&, Accessor*);
  const uint8_t* Element(size_t i) const;

  size_t count_ = 0;
  int components_ = 0;
  uint64_t component_type_ = 0;
  size_t component_bytes_ = 0;
  bool normalized_ = false;
  const uint8_t* data_ = nullptr;  ///< nullptr: all zero
  size_t stride_ = 0;
  std::vector<uint32_t> sparse_indices_;  ///< strictly increasing
  const uint8_t* sparse_values_ = nullptr;
};

/// Opens accessors[index].
/// \param user  name of the referencing element, for error messages
/// \return false after a failure, which is logged
bool OpenAccessor(const GltfDocument& document, ImportLog* log, int index, const std::string& user,
                  Accessor* accessor);

}  // namespace stillray
