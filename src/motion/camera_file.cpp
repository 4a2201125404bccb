// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "motion/camera_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <nlohmann/json.hpp>

#include "core/checksum.h"
#include "stillray/io.h"

namespace stillray::motion {
namespace {

using Json = nlohmann::json;

constexpr size_t kMaxFileBytes = size_t{1} << 28;
constexpr int64_t kMaxSide = 1 << 16;
constexpr int64_t kVersion = 1;
/// Types of cameras. Only the first two have a projection matrix.
constexpr const char* kPerspective = "perspective";
constexpr const char* kOrthographic = "orthographic";
constexpr const char* kPanoramic = "panoramic";
constexpr const char* kTypes = "\"perspective\", \"orthographic\" or \"panoramic\"";
/// Largest entry of a matrix, and smallest determinant relative to the length of its columns.
constexpr double kMaxEntry = 1e15;
constexpr double kLeastDeterminant = 1e-12;
/// The last rows of matrices, in single precision.
constexpr double kRounding = 1e-6;

/// The value as text, shortened.
std::string Shown(const Json& value) {
  constexpr size_t kMost = 40;
  std::string text = value.dump(-1, ' ', true, Json::error_handler_t::replace);
  if (text.size() > kMost) {
    text.replace(kMost - 3, std::string::npos, "...");
  }
  return text;
}

/// Reads the members of one object; `where` is its location in the file, for messages.
class Reader {
 public:
  Reader(const Json& object, std::string name, std::string where)
      : object_(object), name_(std::move(name)), where_(std::move(where)) {}

  Status Wrong(const char* key, const std::string& expected) const {
    const auto at = object_.find(key);
    return Status::BadData(
        at == object_.end()
            ? fmt::format("{}: {}{} is missing, expected {}", name_, where_, key, expected)
            : fmt::format("{}: {}{} is {}, expected {}", name_, where_, key, Shown(*at), expected));
  }

  bool Has(const char* key) const { return object_.contains(key); }
  const Json& At(const char* key) const { return object_.at(key); }

  Status Whole(const char* key, int64_t low, int64_t high, int64_t* value) const {
    const auto at = object_.find(key);
    if (at == object_.end() || !at->is_number_integer() ||
        (at->is_number_unsigned() &&
         at->get<uint64_t>() > static_cast<uint64_t>(std::numeric_limits<int64_t>::max())) ||
        at->get<int64_t>() < low || at->get<int64_t>() > high) {
      return Wrong(key, low == high ? fmt::format("{}", low)
                                    : fmt::format("a whole number from {} to {}", low, high));
    }
    *value = at->get<int64_t>();
    return Status::Ok();
  }

  Status Number(const char* key, double* value) const {
    const auto at = object_.find(key);
    if (at == object_.end() || !at->is_number() || !std::isfinite(at->get<double>())) {
      return Wrong(key, "a finite number");
    }
    *value = at->get<double>();
    return Status::Ok();
  }

  /// Exactly `count` finite numbers.
  Status Numbers(const char* key, size_t count, double* values) const {
    const auto at = object_.find(key);
    const std::string expected = fmt::format("{} finite numbers", count);
    if (at == object_.end() || !at->is_array() || at->size() != count) {
      return Wrong(key, expected);
    }
    for (size_t i = 0; i < count; ++i) {
      const Json& entry = (*at)[i];
      if (!entry.is_number() || !(std::fabs(entry.get<double>()) < kMaxEntry)) {
        return Status::BadData(fmt::format("{}: {}{}[{}] is {}, expected {}", name_, where_, key, i,
                                           Shown(entry), expected));
      }
      values[i] = entry.get<double>();
    }
    return Status::Ok();
  }

  /// A matrix whose rows follow one another. \return kBadData also if it has no inverse
  Status Matrix(const char* key, glm::dmat4* matrix) const {
    std::array<double, 16> rows{};
    STILLRAY_RETURN_IF_ERROR(Numbers(key, rows.size(), rows.data()));
    double scale = 1;
    for (int column = 0; column < 4; ++column) {
      for (int row = 0; row < 4; ++row) {
        (*matrix)[column][row] = rows[static_cast<size_t>(4 * row + column)];
      }
      scale *= glm::length((*matrix)[column]);
    }
    if (!(std::fabs(glm::determinant(*matrix)) > kLeastDeterminant * scale)) {
      return Wrong(key, "a matrix with an inverse");
    }
    return Status::Ok();
  }

  /// \param rule  description of the row, for messages
  Status CheckLastRow(const char* key, const glm::dmat4& matrix, const glm::dvec4& row,
                      const char* rule) const {
    for (int column = 0; column < 4; ++column) {
      if (!(std::fabs(matrix[column][3] - row[column]) < kRounding)) {
        return Status::BadData(fmt::format(
            "{}: {}{} has the last row {:.4g} {:.4g} {:.4g} {:.4g}, expected {:g} {:g} {:g} {:g} "
            "({}; rows follow one another)",
            name_, where_, key, matrix[0][3], matrix[1][3], matrix[2][3], matrix[3][3], row[0],
            row[1], row[2], row[3], rule));
      }
    }
    return Status::Ok();
  }

  const std::string& name() const { return name_; }

 private:
  const Json& object_;
  std::string name_;
  std::string where_;
};

/// From clip space with y up and -1 to 1, as OpenGL has it, to 0 to 1 from the upper left corner.
glm::dmat4 ToStandard() {
  glm::dmat4 m(1.0);
  m[0][0] = 0.5;
  m[3][0] = 0.5;
  m[1][1] = -0.5;
  m[3][1] = 0.5;
  return m;
}

/// OpenEXR's attributes hold matrices for row vectors.
std::array<double, 16> ForRowVectors(const glm::dmat4& matrix) {
  std::array<double, 16> entries{};
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      entries[static_cast<size_t>(4 * i + j)] = matrix[i][j];
    }
  }
  return entries;
}

/// World-to-camera matrices by time, in frames relative to the camera's frame.
using Poses = std::map<double, glm::dmat4>;

/// \param middle  [out] of the shutter, in frames relative to the camera's frame; 0 without a
///     shutter
Status ReadShutter(const Reader& reader, double* middle) {
  double shutter[2] = {};
  if (reader.Has("shutter")) {
    STILLRAY_RETURN_IF_ERROR(reader.Numbers("shutter", 2, shutter));
    if (!(shutter[0] <= shutter[1])) {
      return reader.Wrong("shutter", "that it opens before it closes");
    }
  }
  *middle = (shutter[0] + shutter[1]) / 2;
  return Status::Ok();
}

Status ReadPose(const Reader& reader, glm::dmat4* pose) {
  STILLRAY_RETURN_IF_ERROR(reader.Matrix("world_to_camera", pose));
  return reader.CheckLastRow("world_to_camera", *pose, {0, 0, 0, 1},
                             "the fourth column is the translation");
}

/// Adds the poses while the shutter is open. \param where location of the camera in the file
Status ReadMotion(const Reader& reader, const std::string& where, Poses* poses) {
  if (!reader.Has("motion")) {
    return Status::Ok();
  }
  const Json& motion = reader.At("motion");
  if (!motion.is_array()) {
    return reader.Wrong("motion", "a list of poses");
  }
  for (size_t i = 0; i < motion.size(); ++i) {
    const std::string place = fmt::format("{}motion[{}]", where, i);
    if (!motion[i].is_object()) {
      return Status::BadData(
          fmt::format("{}: {} is {}, expected an object", reader.name(), place, Shown(motion[i])));
    }
    const Reader pose(motion[i], reader.name(), place + ".");
    double time = 0;
    STILLRAY_RETURN_IF_ERROR(pose.Number("time", &time));
    STILLRAY_RETURN_IF_ERROR(ReadPose(pose, &(*poses)[time]));
  }
  return Status::Ok();
}

/// Interpolates between two poses with constant velocity and angular velocity.
/// \param part  of the way, 0..1
glm::dmat4 Between(const glm::dmat4& from, const glm::dmat4& to, double part) {
  const auto eye = [](const glm::dmat4& pose) { return glm::dvec3(glm::inverse(pose)[3]); };
  const glm::dquat turn =
      glm::slerp(glm::quat_cast(glm::dmat3(from)), glm::quat_cast(glm::dmat3(to)), part);
  const glm::dmat3 rotation = glm::mat3_cast(turn);
  glm::dmat4 pose(rotation);
  pose[3] = glm::dvec4(-(rotation * glm::mix(eye(from), eye(to), part)), 1);
  return pose;
}

/// Whether a matrix consists of rotation and translation, without scale.
bool IsRigid(const glm::dmat4& pose) {
  constexpr double kSlack = 1e-3;
  const glm::dmat3 rotation(pose);
  const glm::dmat3 product = glm::transpose(rotation) * rotation;
  double worst = 0;
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) {
      worst = std::max(worst, std::fabs(product[c][r] - (c == r ? 1 : 0)));
    }
  }
  return worst < kSlack && glm::determinant(rotation) > 0;
}

/// The pose at a time; the frame's own pose if no poses surround the time, or if they are scaled,
/// which cannot be interpolated.
glm::dmat4 PoseAt(const Poses& poses, double time) {
  const auto after = poses.lower_bound(time);
  if (after == poses.end() || (after == poses.begin() && after->first != time)) {
    return poses.at(0);
  }
  if (after->first == time) {
    return after->second;
  }
  const auto before = std::prev(after);
  if (!IsRigid(before->second) || !IsRigid(after->second)) {
    return poses.at(0);
  }
  return Between(before->second, after->second,
                 (time - before->first) / (after->first - before->first));
}

Status CheckClipping(const Reader& reader, bool perspective) {
  double near = 0;
  double far = 0;
  if (reader.Has("near")) {
    STILLRAY_RETURN_IF_ERROR(reader.Number("near", &near));
    if (perspective && !(near > 0)) {
      return reader.Wrong("near", "a number above 0");
    }
  }
  if (reader.Has("far")) {
    STILLRAY_RETURN_IF_ERROR(reader.Number("far", &far));
    if (reader.Has("near") && !(far > near)) {
      return reader.Wrong("far", fmt::format("a number above {:g} (near)", near));
    }
  }
  return Status::Ok();
}

/// \param where  location of the camera in the file, for messages
Result<std::optional<CameraMatrices>> ParseFrame(const Reader& reader, const std::string& where) {
  const Json type = reader.Has("type") ? reader.At("type") : Json();
  if (!type.is_string()) {
    return reader.Wrong("type", kTypes);
  }
  const bool perspective = type == kPerspective;
  const bool has_projection = reader.Has("projection") && !reader.At("projection").is_null();
  const bool is_known = perspective || type == kOrthographic;
  if (!is_known && type != kPanoramic && has_projection) {
    return reader.Wrong("type", fmt::format("{}; only a camera with null as its projection has "
                                            "another type",
                                            kTypes));
  }
  double middle = 0;
  STILLRAY_RETURN_IF_ERROR(ReadShutter(reader, &middle));
  STILLRAY_RETURN_IF_ERROR(CheckClipping(reader, perspective));
  Poses poses;
  STILLRAY_RETURN_IF_ERROR(ReadMotion(reader, where, &poses));
  STILLRAY_RETURN_IF_ERROR(ReadPose(reader, &poses[0]));
  const glm::dmat4 to_camera = PoseAt(poses, middle);
  if (!is_known) {
    return std::optional<CameraMatrices>();
  }
  glm::dmat4 projection(1.0);
  STILLRAY_RETURN_IF_ERROR(reader.Matrix("projection", &projection));
  STILLRAY_RETURN_IF_ERROR(
      perspective
          ? reader.CheckLastRow("projection", projection, {0, 0, -1, 0},
                                "a perspective camera that looks along -z")
          : reader.CheckLastRow("projection", projection, {0, 0, 0, 1}, "an orthographic camera"));
  return std::optional<CameraMatrices>(CameraMatrices{
      ForRowVectors(to_camera), ForRowVectors(ToStandard() * projection * to_camera), true});
}

Status ParseFrames(const Json& frames, CameraFile* file) {
  for (size_t i = 0; i < frames.size(); ++i) {
    const std::string where = fmt::format("frames[{}]", i);
    if (!frames[i].is_object()) {
      return Status::BadData(
          fmt::format("{}: {} is {}, expected an object", file->name, where, Shown(frames[i])));
    }
    const std::string prefix = where + ".";
    const Reader reader(frames[i], file->name, prefix);
    int64_t number = 0;
    constexpr int64_t kMost = int64_t{1} << 53;
    STILLRAY_RETURN_IF_ERROR(reader.Whole("frame", -kMost, kMost, &number));
    Result<std::optional<CameraMatrices>> camera = ParseFrame(reader, prefix);
    STILLRAY_RETURN_IF_ERROR(camera.status());
    if (!file->frames.emplace(number, *camera).second) {
      return reader.Wrong("frame", "a number that no frame before it has");
    }
  }
  return Status::Ok();
}

}  // namespace

Result<std::optional<CameraMatrices>> CameraFile::Camera(int64_t frame) const {
  const auto at = frames.find(frame);
  if (at == frames.end()) {
    return Status::NotFound(
        fmt::format("{} has no camera of frame {}: it has {} frames from {} to {}", name, frame,
                    frames.size(), frames.begin()->first, frames.rbegin()->first));
  }
  return at->second;
}

Result<CameraFile> ParseCameraFile(const std::string& text, const std::string& name) {
  Json json;
  try {
    json = Json::parse(text);
  } catch (const Json::exception& error) {
    return Status::BadData(
        fmt::format("{} is not JSON (numbers must be finite): {}", name, error.what()));
  }
  if (!json.is_object()) {
    return Status::BadData(
        fmt::format("{}: no JSON object, expected the cameras of a sequence "
                    "({{\"version\": 1, \"width\": ..., \"frames\": [...]}})",
                    name));
  }
  const Reader reader(json, name, "");
  int64_t version = 0;
  STILLRAY_RETURN_IF_ERROR(reader.Whole("version", kVersion, kVersion, &version));
  int64_t width = 0;
  int64_t height = 0;
  STILLRAY_RETURN_IF_ERROR(reader.Whole("width", 1, kMaxSide, &width));
  STILLRAY_RETURN_IF_ERROR(reader.Whole("height", 1, kMaxSide, &height));
  if (!reader.Has("frames") || !reader.At("frames").is_array() || reader.At("frames").empty()) {
    return reader.Wrong("frames", "a list of one or more cameras");
  }
  CameraFile file;
  file.name = name;
  file.checksum = AddToChecksum({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
  file.width = static_cast<int>(width);
  file.height = static_cast<int>(height);
  STILLRAY_RETURN_IF_ERROR(ParseFrames(reader.At("frames"), &file));
  return file;
}

Result<CameraFile> ReadCameraFile(const std::string& path) {
  const Result<std::string> text = ReadWholeFile(path, kMaxFileBytes);
  STILLRAY_RETURN_IF_ERROR(text.status());
  return ParseCameraFile(*text, path);
}

}  // namespace stillray::motion
