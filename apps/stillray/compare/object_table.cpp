// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "compare/object_table.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <fmt/format.h>

#include "common/json_output.h"

namespace stillray {
namespace {

constexpr size_t kMostRows = 20;

/// The metrics of one object.
struct Row {
  int64_t object = 0;
  double pixels = 0;  ///< fraction of the image
  double error = 0;   ///< fraction of the squared error
  double psnr = 0;
  double rel_mse = 0;
  double flip = 0;
  double brightness = 0;
};

Row RowOf(const ObjectErrors& e, double all_pixels, double all_error) {
  const auto n = static_cast<double>(e.pixels);
  Row row;
  row.object = e.object;
  row.pixels = n / all_pixels;
  row.error = all_error > 0 ? e.squared_error / all_error : 0;
  row.psnr = e.squared_error > 0 ? -10 * std::log10(e.squared_error / (3 * n))
                                 : std::numeric_limits<double>::infinity();
  row.rel_mse = e.rel_mse / n;
  row.flip = e.flip / n;
  row.brightness = e.reference_luminance > 0 ? e.luminance / e.reference_luminance
                   : e.luminance > 0         ? std::numeric_limits<double>::infinity()
                                             : 1;
  return row;
}

std::vector<Row> RowsOf(const std::map<int64_t, ObjectErrors>& objects) {
  double pixels = 0;
  double error = 0;
  for (const auto& [object, e] : objects) {
    pixels += static_cast<double>(e.pixels);
    error += e.squared_error;
  }
  std::vector<Row> rows;
  for (const auto& [object, e] : objects) {
    rows.push_back(RowOf(e, pixels, error));
  }
  std::ranges::stable_sort(rows, std::greater(), &Row::error);
  return rows;
}

}  // namespace

void ObjectTable::Add(std::span<const ObjectErrors> frame) {
  for (const ObjectErrors& e : frame) {
    ObjectErrors& sum = objects_[e.object];
    sum.object = e.object;
    sum += e;
  }
}

std::string ObjectTable::Text() const {
  const std::vector<Row> rows = RowsOf(objects_);
  std::string text =
      fmt::format("\n{:>10} {:>9} {:>8} {:>9} {:>10} {:>8} {:>11}\n", "object", "pixels, %",
                  "error, %", "PSNR, dB", "relMSE", "FLIP", "brightness");
  for (size_t i = 0; i < std::min(rows.size(), kMostRows); ++i) {
    const Row& r = rows[i];
    text +=
        fmt::format("{:>10} {:>9.2f} {:>8.2f} {:>9.3f} {:>10.4g} {:>8.5f} {:>11.5f}\n", r.object,
                    100 * r.pixels, 100 * r.error, r.psnr, r.rel_mse, r.flip, r.brightness);
  }
  if (rows.size() > kMostRows) {
    text += fmt::format("note: {} more objects have less of the error; --json has all\n",
                        rows.size() - kMostRows);
  }
  return text;
}

nlohmann::ordered_json ObjectTable::Json() const {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const Row& r : RowsOf(objects_)) {
    json.push_back({{"object", r.object},
                    {"pixels", r.pixels},
                    {"error", r.error},
                    {"psnr", JsonNumber(r.psnr)},
                    {"rel_mse", r.rel_mse},
                    {"flip", r.flip},
                    {"brightness", JsonNumber(r.brightness)}});
  }
  return json;
}

}  // namespace stillray
