// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "quality/render_log.h"

#include <filesystem>
#include <iterator>
#include <set>
#include <string_view>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "core/lower_case.h"
#include "io/frame_rate.h"
#include "stillray/render.h"

namespace stillray::report {
namespace {

using Json = nlohmann::ordered_json;

/// Far above the needs of any sequence; they bound the work that a hostile file can cause, as
/// look-ups in ordered objects of the JSON library are linear.
constexpr int kMaxDepth = 8;
constexpr size_t kMaxKeysPerObject = 1000;
constexpr size_t kMaxShownText = 60;

/// Thrown through the JSON parser and caught in this file.
struct KeyError {
  std::string message;
};

/// Text of a file, shortened and without line breaks, for a one-line message.
std::string Quote(std::string_view text) {
  std::string shown = "\"";
  for (const char c : text.substr(0, kMaxShownText)) {
    shown.push_back(static_cast<unsigned char>(c) < 0x20 ? ' ' : c);
  }
  return shown + (text.size() > kMaxShownText ? "...\"" : "\"");
}

std::string Describe(const Json& value) {
  if (value.is_string()) {
    return "the text " + Quote(value.get_ref<const std::string&>());
  }
  if (value.is_object() || value.is_array()) {
    return fmt::format("an {}", value.type_name());
  }
  return value.dump();
}

/// Rejects repeated keys and shapes that no render.json has during parsing.
class ShapeCheck {
 public:
  bool operator()(int depth, Json::parse_event_t event, const Json& parsed) {
    if (depth > kMaxDepth) {
      throw KeyError{fmt::format("nested deeper than {} levels", kMaxDepth)};
    }
    if (event == Json::parse_event_t::object_start) {
      keys_.emplace_back();
    } else if (event == Json::parse_event_t::object_end) {
      keys_.pop_back();
    } else if (event == Json::parse_event_t::key) {
      const std::string& key = parsed.get_ref<const std::string&>();
      if (!keys_.back().insert(key).second) {
        throw KeyError{fmt::format("the key {} stands twice in one object", Quote(key))};
      }
      if (keys_.back().size() > kMaxKeysPerObject) {
        throw KeyError{fmt::format("more than {} keys in one object", kMaxKeysPerObject)};
      }
    }
    return true;
  }

 private:
  std::vector<std::set<std::string>> keys_;
};

Status WrongValue(const std::string& name, const std::string& key, const Json& value,
                  const std::string& expected) {
  return Status::BadData(
      fmt::format("{}: {}: found {}, expected {}", name, key, Describe(value), expected));
}

enum class Kind { kText, kInteger, kNumber, kFlag };

/// A scalar setting of the top level and its valid values.
struct ScalarKey {
  const char* name;
  Kind kind;
  double min = 0;
  double max = 0;
};

constexpr double kAnyCount = 9007199254740992.0;  // 2^53: integers up to here are exact
constexpr ScalarKey kScalarKeys[] = {
    {"stillray", Kind::kText},
    {"scene", Kind::kText},
    {"command", Kind::kText},
    {"scene_content", Kind::kText},
    {"environment", Kind::kText},
    {"environment_content", Kind::kText},
    {"lens_mask", Kind::kText},
    {"lens_mask_content", Kind::kText},
    {"camera", Kind::kText},
    {"width", Kind::kInteger, 1, 32768},
    {"height", Kind::kInteger, 1, 32768},
    {"fps", Kind::kNumber, kMinFps, kMaxFps},
    {"still", Kind::kFlag},
    {"first_frame", Kind::kInteger, -kAnyCount, kAnyCount},
    {"post", Kind::kText},
    {"post_aperture", Kind::kText},
    {"preset", Kind::kText},
    {"device", Kind::kText},
    {"tracer", Kind::kText},
    {"traces_ahead", Kind::kFlag},
    {"ray_tracing", Kind::kText},
    {"first_hits", Kind::kText},
    {"textures", Kind::kText},
    {"reference", Kind::kInteger, 0, 1e9},
    {"reference_frames", Kind::kText},
    {"aov", Kind::kText},
    {"format", Kind::kText},
    {"float", Kind::kFlag},
    {"save_inputs", Kind::kFlag},
    {"threads", Kind::kInteger, 0, 1e6},
    {"machine", Kind::kText},
    {"date", Kind::kText},
    {"exposure", Kind::kNumber, -1000, 1000},
    {"tonemap", Kind::kText},
};

/// A setting of the path tracer. Other versions may allow other values: only the type counts.
ScalarKey KeyOf(const Parameter& p) {
  switch (p.type) {
    case ParameterType::kFlag:
      return {p.name, Kind::kFlag};
    case ParameterType::kInt:
      return {p.name, Kind::kInteger, -kAnyCount, kAnyCount};
    case ParameterType::kSeed:
      return {p.name, Kind::kInteger, 0, 0x1p64};
    case ParameterType::kFloat:
    case ParameterType::kRate:
      return {p.name, Kind::kNumber, -kAnyCount, kAnyCount};
    default:
      return {p.name, Kind::kText};
  }
}

const std::vector<ScalarKey>& ScalarKeys() {
  static const std::vector<ScalarKey> keys = [] {
    std::vector<ScalarKey> all(std::begin(kScalarKeys), std::end(kScalarKeys));
    for (const Parameter& p : RenderParameters()) {
      all.push_back(KeyOf(p));
    }
    return all;
  }();
  return keys;
}

Status CheckScalar(const std::string& name, const std::string& key, const Json& value, Kind kind,
                   double min, double max) {
  if (kind == Kind::kText) {
    return value.is_string() ? Status::Ok() : WrongValue(name, key, value, "text");
  }
  if (kind == Kind::kFlag) {
    return value.is_boolean() ? Status::Ok() : WrongValue(name, key, value, "true or false");
  }
  const bool right_type = kind == Kind::kInteger ? value.is_number_integer() : value.is_number();
  if (!right_type || value.get<double>() < min || value.get<double>() > max) {
    return WrongValue(
        name, key, value,
        fmt::format("{} in {}..{}", kind == Kind::kInteger ? "a whole number" : "a number", min,
                    max));
  }
  return Status::Ok();
}

std::string ScalarText(const Json& value) {
  return value.is_string() ? value.get<std::string>() : value.dump();
}

Status ReadParameters(const std::string& name, const Json& object, RenderLog* log) {
  if (!object.is_object()) {
    return WrongValue(name, "parameters", object, "an object");
  }
  for (const auto& [key, value] : object.items()) {
    std::string text;
    for (const Json& element : value.is_array() ? value : Json::array({value})) {
      if (element.is_structured() || element.is_null()) {
        return WrongValue(name, "parameters." + key, element, "text, a number, true or false");
      }
      text += (text.empty() ? "" : ", ") + ScalarText(element);
    }
    log->parameters.emplace_back(key, text);
  }
  return Status::Ok();
}

Status ReadMemory(const std::string& name, const Json& object, RenderLog* log) {
  if (!object.is_object()) {
    return WrongValue(name, "memory", object, "an object");
  }
  for (const auto& [key, value] : object.items()) {
    if (key == "device" && value.is_object()) {
      // Memory on a GPU has other numbers than bytes as well.
      for (const auto& [part, number] : value.items()) {
        STILLRAY_RETURN_IF_ERROR(
            CheckScalar(name, "memory.device." + part, number, Kind::kInteger, 0, kAnyCount));
      }
      continue;
    }
    STILLRAY_RETURN_IF_ERROR(
        CheckScalar(name, "memory." + key, value, Kind::kInteger, 0, kAnyCount));
    log->memory.emplace_back(key, value.get<int64_t>());
  }
  return Status::Ok();
}

Status ReadStages(const std::string& name, const std::string& key, const Json& object,
                  RenderLogFrame* frame) {
  if (!object.is_object()) {
    return WrongValue(name, key, object, "an object");
  }
  for (const auto& [stage, value] : object.items()) {
    STILLRAY_RETURN_IF_ERROR(
        CheckScalar(name, key + "." + stage, value, Kind::kNumber, 0, kAnyCount));
    frame->stages_ms.emplace_back(stage, value.get<double>());
  }
  return Status::Ok();
}

Status ReadFrameKey(const std::string& name, const std::string& where, const std::string& key,
                    const Json& value, RenderLogFrame* frame) {
  const std::string path = where + "." + key;
  if (key == "frame") {
    STILLRAY_RETURN_IF_ERROR(CheckScalar(name, path, value, Kind::kInteger, -kAnyCount, kAnyCount));
    frame->number = value.get<int64_t>();
    return Status::Ok();
  }
  if (key == "stages_ms") {
    return ReadStages(name, path, value, frame);
  }
  std::optional<double>* target = key == "seconds"      ? &frame->seconds
                                  : key == "render_ms"  ? &frame->render_ms
                                  : key == "denoise_ms" ? &frame->denoise_ms
                                  : key == "write_ms"   ? &frame->write_ms
                                                        : nullptr;
  if (target == nullptr) {
    return Status::BadData(
        fmt::format("{}: {}: unknown key {}; expected frame, seconds, render_ms, denoise_ms, "
                    "write_ms or stages_ms",
                    name, where, Quote(key)));
  }
  const double min = key == "seconds" ? -kAnyCount : 0;
  STILLRAY_RETURN_IF_ERROR(CheckScalar(name, path, value, Kind::kNumber, min, kAnyCount));
  *target = value.get<double>();
  return Status::Ok();
}

Status ReadFrames(const std::string& name, const Json& array, RenderLog* log) {
  if (!array.is_array()) {
    return WrongValue(name, "frames", array, "an array");
  }
  std::set<int64_t> numbers;
  for (size_t i = 0; i < array.size(); ++i) {
    const Json& entry = array[i];
    const std::string where = fmt::format("frames[{}]", i);
    if (!entry.is_object()) {
      return WrongValue(name, where, entry, "an object");
    }
    if (!entry.contains("frame")) {
      return Status::BadData(fmt::format("{}: {}: no key \"frame\" with its number", name, where));
    }
    RenderLogFrame frame;
    for (const auto& [key, value] : entry.items()) {
      STILLRAY_RETURN_IF_ERROR(ReadFrameKey(name, where, key, value, &frame));
    }
    if (!numbers.insert(frame.number).second) {
      return Status::BadData(
          fmt::format("{}: {}: frame {} stands there twice", name, where, frame.number));
    }
    log->frames.push_back(std::move(frame));
  }
  return Status::Ok();
}

/// The file name without its folders: pages are shared, and the location of a scene is private.
std::string SceneName(const std::string& scene) {
  const std::string ending = LowerExtension(scene);
  return ending == ".glb" || ending == ".gltf" || ending == ".obj"
             ? std::filesystem::path(scene).filename().string()
             : scene;
}

void KeepScalar(const std::string& key, const Json& value, RenderLog* log) {
  log->settings.emplace_back(key,
                             key == "scene" ? SceneName(ScalarText(value)) : ScalarText(value));
  if (key == "stillray") {
    log->version = value.get<std::string>();
  } else if (key == "scene") {
    log->scene = SceneName(value.get<std::string>());
  } else if (key == "preset") {
    log->preset = value.get<std::string>();
  } else if (key == "tonemap") {
    log->tonemap = value.get<std::string>();
  } else if (key == "exposure") {
    log->exposure = value.get<double>();
  } else if (key == "width") {
    log->width = value.get<int>();
  } else if (key == "height") {
    log->height = value.get<int>();
  } else if (key == "fps") {
    log->fps = value.get<double>();
  }
}

Status ReadKey(const std::string& name, const std::string& key, const Json& value, RenderLog* log) {
  if (key == "frames") {
    return ReadFrames(name, value, log);
  }
  if (key == "parameters") {
    return ReadParameters(name, value, log);
  }
  if (key == "memory") {
    return ReadMemory(name, value, log);
  }
  for (const ScalarKey& scalar : ScalarKeys()) {
    if (key == scalar.name) {
      STILLRAY_RETURN_IF_ERROR(CheckScalar(name, key, value, scalar.kind, scalar.min, scalar.max));
      KeepScalar(key, value, log);
      return Status::Ok();
    }
  }
  std::string known;
  for (const ScalarKey& scalar : ScalarKeys()) {
    known += std::string(scalar.name) + ", ";
  }
  return Status::BadData(fmt::format("{}: unknown key {}; expected {}parameters, frames or memory",
                                     name, Quote(key), known));
}

/// "line 3, column 7: ..." out of the JSON library's message.
std::string ParseMessage(const std::string& what) {
  const size_t line = what.find("line ");
  const size_t bracket = what.find("] ");
  const size_t start = line != std::string::npos      ? line
                       : bracket != std::string::npos ? bracket + 2
                                                      : 0;
  return what.substr(start);
}

}  // namespace

Result<RenderLog> ParseRenderLog(const std::string& text, const std::string& name) {
  Json root;
  ShapeCheck check;
  try {
    root = Json::parse(text, [&check](int depth, Json::parse_event_t event, Json& parsed) {
      return check(depth, event, parsed);
    });
  } catch (const Json::exception& error) {
    return Status::BadData(fmt::format("{}: {}", name, ParseMessage(error.what())));
  } catch (const KeyError& error) {
    return Status::BadData(fmt::format("{}: {}", name, error.message));
  }
  if (!root.is_object()) {
    return WrongValue(name, "top level", root, "an object");
  }
  RenderLog log;
  for (const auto& [key, value] : root.items()) {
    STILLRAY_RETURN_IF_ERROR(ReadKey(name, key, value, &log));
  }
  return log;
}

}  // namespace stillray::report
