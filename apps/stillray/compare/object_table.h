// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The errors of single objects, over all compared frames.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>

#include <nlohmann/json.hpp>

#include "stillray/quality.h"

namespace stillray {

class ObjectTable {
 public:
  void Add(std::span<const ObjectErrors> frame);
  bool empty() const { return objects_.empty(); }
  /// Table of the 20 objects with the largest share of the squared error, sorted by that share.
  std::string Text() const;
  /// All objects, sorted by their share of the squared error.
  nlohmann::ordered_json Json() const;

 private:
  std::map<int64_t, ObjectErrors> objects_;
};

}  // namespace stillray
