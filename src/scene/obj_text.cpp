// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <string_view>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>

#include "scene/obj_import.h"

namespace stillray {

namespace {

/// The parser's triangulation takes at least quadratic time in the number of corners.
constexpr size_t kMaxEarClipped = 128;
/// Each group becomes a node, with a mesh per material.
constexpr size_t kMaxGroups = 65536;
constexpr std::string_view kSpaces = " \t\r\v\f";

std::string_view Trimmed(std::string_view text) {
  const size_t begin = text.find_first_not_of(kSpaces);
  if (begin == std::string_view::npos) {
    return {};
  }
  return text.substr(begin, text.find_last_not_of(kSpaces) - begin + 1);
}

/// Removes the first word from `rest` and returns it; empty at the end.
std::string_view NextWord(std::string_view* rest) {
  *rest = Trimmed(*rest);
  const size_t end = std::min(rest->find_first_of(kSpaces), rest->size());
  const std::string_view word = rest->substr(0, end);
  rest->remove_prefix(end);
  return word;
}

/// Assigns numbers to names in order of first use.
class NameTable {
 public:
  explicit NameTable(std::vector<std::string>* names) : names_(names) {}
  size_t Number(std::string_view name) {
    const auto [at, is_new] = numbers_.try_emplace(std::string(name), names_->size());
    if (is_new) {
      names_->emplace_back(name);
    }
    return at->second;
  }

 private:
  std::vector<std::string>* names_;
  std::unordered_map<std::string, size_t> numbers_;
};

enum Kind : size_t { kPosition, kTexture, kNormal };
constexpr std::array<const char*, 3> kKindNames = {"vertex", "texture coordinate", "normal"};

class Checker {
 public:
  Checker(ImportLog* log, ObjText* out)
      : log_(log), out_(out), materials_(&out->materials), groups_(&out->groups) {}

  Status Run(std::string_view text);

 private:
  Status CheckLine(std::string_view line);
  Status CheckNumbers(std::string_view keyword, std::string_view rest);
  Status CheckFace(std::string_view rest);
  Status CheckCorner(std::string_view word, std::array<int64_t, 3>* corner);
  Status CheckReferences() const;
  void WriteFace(const std::vector<std::array<int64_t, 3>>& corners);
  void WriteCorner(const std::array<int64_t, 3>& corner);
  void BeginGroup(std::string_view name);
  void SetSmoothing(std::string_view rest);
  void AddLibraries(std::string_view rest);

  template <typename... Arguments>
  Status Fault(fmt::format_string<Arguments...> format, Arguments&&... arguments) const {
    return Status::BadData(fmt::format("line {}: ", line_) +
                           fmt::format(format, std::forward<Arguments>(arguments)...));
  }

  ImportLog* log_;
  ObjText* out_;
  NameTable materials_;
  NameTable groups_;
  std::unordered_map<std::string, size_t> smoothing_;
  size_t line_ = 0;
  size_t faces_ = 0;
  std::array<int64_t, 3> counts_ = {0, 0, 0};
  // Indices may reference later elements: the maximum is checked at the end.
  std::array<int64_t, 3> largest_ = {0, 0, 0};
  std::array<size_t, 3> line_of_largest_ = {0, 0, 0};
};

Status Checker::Run(std::string_view text) {
  out_->text.reserve(text.size() + 64);
  std::string joined;
  for (size_t at = 0; at < text.size();) {
    ++line_;
    const size_t end = std::min(text.find('\n', at), text.size());
    std::string_view line = text.substr(at, end - at);
    at = end + 1;
    const auto is_binary = [](char c) {
      const auto byte = static_cast<unsigned char>(c);
      return byte < 0x20 && c != '\t' && c != '\r' && c != '\v' && c != '\f';
    };
    if (const auto bad = std::find_if(line.begin(), line.end(), is_binary); bad != line.end()) {
      return Fault("byte {:#04x} is not text, so this is no OBJ file",
                   static_cast<unsigned char>(*bad));
    }
    const std::string_view trimmed = Trimmed(line);
    if (!trimmed.empty() && trimmed.back() == '\\' && at < text.size()) {
      joined.append(trimmed.substr(0, trimmed.size() - 1));
      joined.push_back(' ');
      continue;
    }
    if (!joined.empty()) {
      joined.append(trimmed);
      line = joined;
    }
    if (Status status = CheckLine(line); !status.ok()) {
      return status;
    }
    joined.clear();
  }
  if (faces_ == 0) {
    return Status::BadData(
        fmt::format("no faces in {} lines, so there is nothing to render", line_));
  }
  return CheckReferences();
}

Status Checker::CheckLine(std::string_view line) {
  std::string_view rest = line;
  const std::string_view keyword = NextWord(&rest);
  if (keyword.empty() || keyword.front() == '#') {
    return Status::Ok();
  }
  rest = Trimmed(rest);
  const std::string_view numbers = rest.substr(0, rest.find('#'));
  if (keyword == "v" || keyword == "vt" || keyword == "vn") {
    return CheckNumbers(keyword, numbers);
  }
  if (keyword == "f" || keyword == "fo") {
    return CheckFace(numbers);
  }
  if (keyword == "g" || keyword == "o") {
    BeginGroup(rest);
  } else if (keyword == "s") {
    SetSmoothing(numbers);
  } else if (keyword == "usemtl") {
    fmt::format_to(std::back_inserter(out_->text), "usemtl {}\n", materials_.Number(rest));
  } else if (keyword == "mtllib") {
    AddLibraries(rest);
  } else if (keyword == "l" || keyword == "p") {
    log_->Warn("points and lines are not supported and were left out");
  } else if (keyword == "curv" || keyword == "curv2" || keyword == "surf") {
    log_->Warn("curves and curved surfaces are not supported and were left out");
  }
  return Status::Ok();
}

Status Checker::CheckNumbers(std::string_view keyword, std::string_view rest) {
  const Kind kind = keyword == "v" ? kPosition : keyword == "vt" ? kTexture : kNormal;
  const size_t needed = kind == kTexture ? 1 : 3;
  // A position may have a weight, or a colour.
  const size_t most = kind == kPosition ? 7 : 3;
  size_t count = 0;
  out_->text.append(keyword);
  for (std::string_view word = NextWord(&rest); !word.empty() && count < most;
       word = NextWord(&rest)) {
    const std::string_view digits = word.front() == '+' ? word.substr(1) : word;
    double value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    const bool tiny = error == std::errc::result_out_of_range && digits.find("e-") != digits.npos;
    if (!tiny && (error == std::errc::result_out_of_range ||
                  (error == std::errc() && !std::isfinite(value)))) {
      return Fault("{} {}: '{}' is not finite", keyword, count + 1, Printable(word));
    }
    if (error == std::errc::invalid_argument || end != digits.data() + digits.size()) {
      return Fault("{} {}: '{}' is no number", keyword, count + 1, Printable(word));
    }
    if (!tiny && std::abs(value) > static_cast<double>(std::numeric_limits<float>::max())) {
      return Fault("{} {}: '{}' is beyond a 32-bit float", keyword, count + 1, Printable(word));
    }
    // Reformatted, since the parser accepts fewer notations.
    fmt::format_to(std::back_inserter(out_->text), " {}", tiny ? 0.0f : static_cast<float>(value));
    ++count;
  }
  out_->text.push_back('\n');
  if (count < needed) {
    return Fault("{} needs {} numbers, found {}", keyword, needed, count);
  }
  ++counts_[kind];
  return Status::Ok();
}

Status Checker::CheckCorner(std::string_view word, std::array<int64_t, 3>* corner) {
  const std::string_view whole = word;
  *corner = {0, 0, 0};
  for (size_t kind = 0; kind < 3; ++kind) {
    const size_t slash = std::min(word.find('/'), word.size());
    const std::string_view part = word.substr(0, slash);
    word.remove_prefix(std::min(slash + 1, word.size()));
    if (part.empty() && kind != kPosition) {
      continue;
    }
    int64_t index = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), index);
    if (error == std::errc::invalid_argument || end != part.data() + part.size()) {
      return Fault("'{}' is no corner of a face", Printable(whole));
    }
    const int64_t counted = index < 0 ? counts_[kind] + index + 1 : index;
    if (error == std::errc::result_out_of_range || index == 0 || counted < 1 ||
        counted > std::numeric_limits<int32_t>::max()) {
      return Fault("{} {} is out of range, there are {}", kKindNames[kind], Printable(part),
                   counts_[kind]);
    }
    if (counted > largest_[kind]) {
      largest_[kind] = counted;
      line_of_largest_[kind] = line_;
    }
    (*corner)[kind] = counted;
  }
  return word.empty() ? Status::Ok() : Fault("'{}' is no corner of a face", Printable(whole));
}

Status Checker::CheckFace(std::string_view rest) {
  std::vector<std::array<int64_t, 3>> corners;
  for (std::string_view word = NextWord(&rest); !word.empty(); word = NextWord(&rest)) {
    std::array<int64_t, 3> corner{};
    if (Status status = CheckCorner(word, &corner); !status.ok()) {
      return status;
    }
    corners.push_back(corner);
  }
  if (corners.size() < 3) {
    return Fault("a face needs 3 corners, found {}", corners.size());
  }
  ++faces_;
  if (corners.size() <= kMaxEarClipped) {
    WriteFace(corners);
    return Status::Ok();
  }
  log_->Warn(fmt::format("faces of more than {} corners are divided as if they were convex",
                         kMaxEarClipped));
  for (size_t i = 1; i + 1 < corners.size(); ++i) {
    WriteFace({corners[0], corners[i], corners[i + 1]});
  }
  return Status::Ok();
}

void Checker::WriteCorner(const std::array<int64_t, 3>& corner) {
  const auto out = std::back_inserter(out_->text);
  fmt::format_to(out, " {}", corner[kPosition]);
  if (corner[kTexture] != 0) {
    fmt::format_to(out, "/{}", corner[kTexture]);
  }
  if (corner[kNormal] != 0) {
    fmt::format_to(out, "{}{}", corner[kTexture] != 0 ? "/" : "//", corner[kNormal]);
  }
}

void Checker::WriteFace(const std::vector<std::array<int64_t, 3>>& corners) {
  out_->text.push_back('f');
  for (const std::array<int64_t, 3>& corner : corners) {
    WriteCorner(corner);
  }
  out_->text.push_back('\n');
}

void Checker::BeginGroup(std::string_view name) {
  const size_t number = groups_.Number(name);
  if (number < kMaxGroups) {
    fmt::format_to(std::back_inserter(out_->text), "g {}\n", number);
  } else {
    log_->Warn(fmt::format("the groups after the first {} are part of the last one", kMaxGroups));
  }
}

/// Smoothing group for the parser, which accepts only numbers; "off" and 0 mean flat.
void Checker::SetSmoothing(std::string_view rest) {
  const std::string_view name = NextWord(&rest);
  const bool off = name.empty() || name == "off" || name.find_first_not_of('0') == name.npos;
  const size_t number =
      off ? 0 : smoothing_.try_emplace(std::string(name), smoothing_.size() + 1).first->second;
  fmt::format_to(std::back_inserter(out_->text), "s {}\n", off ? "off" : std::to_string(number));
}

/// Adds an mtllib line: one name with spaces, or several names.
void Checker::AddLibraries(std::string_view rest) {
  std::vector<std::string> names;
  if (!rest.empty()) {
    names.emplace_back(rest);
  }
  if (rest.find_first_of(kSpaces) != rest.npos) {
    for (std::string_view word = NextWord(&rest); !word.empty(); word = NextWord(&rest)) {
      names.emplace_back(word);
    }
  }
  if (!names.empty() &&
      std::find(out_->libraries.begin(), out_->libraries.end(), names) == out_->libraries.end()) {
    out_->libraries.push_back(std::move(names));
  }
}

Status Checker::CheckReferences() const {
  for (size_t kind = 0; kind < 3; ++kind) {
    if (largest_[kind] > counts_[kind]) {
      return Status::BadData(fmt::format("line {}: {} {} is out of range, there are {}",
                                         line_of_largest_[kind], kKindNames[kind], largest_[kind],
                                         counts_[kind]));
    }
  }
  return Status::Ok();
}

}  // namespace

Status CheckObjText(std::span<const uint8_t> bytes, ImportLog* log, ObjText* out) {
  if (bytes.empty()) {
    return Status::BadData("the file is empty");
  }
  return Checker(log, out).Run(
      std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

}  // namespace stillray
