// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Radiance images (.hdr). Source: Ward, "Real Pixels", Graphics Gems II (1991), and the file format
// description of the Radiance manual.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "core/status_prefix.h"
#include "io/decoders.h"
#include "io/image_limits.h"
#include "io/text.h"
#include "stillray/io.h"

namespace stillray {

namespace io {

namespace {

using Rgbe = std::array<uint8_t, 4>;

/// Rows outside these widths are never run-length encoded by component.
constexpr int kMinRunWidth = 8;
constexpr int kMaxRunWidth = 32767;
/// A whole row can be one repeated pixel: about 12 bytes for kMaxSide pixels.
constexpr uint64_t kMaxRatio = static_cast<uint64_t>(kMaxSide);
constexpr size_t kMaxHeaderLine = 4096;
constexpr size_t kMaxShown = 64;  // characters of a line in messages

Status Damaged(const std::string& name, const std::string& what) {
  return Status::BadData(fmt::format("{}: is a damaged HDR file: {}", name, what));
}

struct HdrHeader {
  int64_t width = 0;
  int64_t height = 0;
  bool flip_x = false;
  bool flip_y = false;
  double exposure = 1;  ///< product of all EXPOSURE lines
  size_t data_begin = 0;
};

/// The line that starts at *at, without its line end; *at is set to the next line. Nothing if there
/// is no line end.
std::optional<std::string_view> NextLine(std::string_view bytes, size_t* at) {
  const size_t end = bytes.find('\n', *at);
  if (end == std::string_view::npos || end - *at > kMaxHeaderLine) {
    return std::nullopt;
  }
  std::string_view line = bytes.substr(*at, end - *at);
  *at = end + 1;
  if (line.ends_with('\r')) {
    line.remove_suffix(1);
  }
  return line;
}

std::vector<std::string_view> Words(std::string_view line) {
  std::vector<std::string_view> words;
  for (size_t at = 0; (at = line.find_first_not_of(" \t", at)) != std::string_view::npos;) {
    const size_t end = std::min(line.find_first_of(" \t", at), line.size());
    words.push_back(line.substr(at, end - at));
    at = end;
  }
  return words;
}

std::optional<int64_t> ParseCount(std::string_view text) {
  int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  return whole ? std::optional(value) : std::nullopt;
}

/// "-Y 512 +X 768": rows from the top, pixels from the left.
Status ParseResolution(const std::string& name, std::string_view line, HdrHeader* header) {
  const std::vector<std::string_view> words = Words(line);
  const auto is_axis = [](std::string_view word, char axis) {
    return word.size() == 2 && (word[0] == '+' || word[0] == '-') && word[1] == axis;
  };
  const std::string shown = OneLine(line, kMaxShown);
  if (words.size() == 4 && is_axis(words[0], 'X') && is_axis(words[2], 'Y')) {
    return Status::Unsupported(
        fmt::format("{}: its rows run along y (\"{}\"), which is not supported", name, shown));
  }
  if (words.size() != 4 || !is_axis(words[0], 'Y') || !is_axis(words[2], 'X')) {
    return Damaged(name, fmt::format("\"{}\" stands where the size should", shown));
  }
  const std::optional<int64_t> height = ParseCount(words[1]);
  const std::optional<int64_t> width = ParseCount(words[3]);
  if (!height || !width) {
    return Damaged(name, fmt::format("\"{}\" is not a size", shown));
  }
  header->height = *height;
  header->width = *width;
  header->flip_y = words[0][0] == '+';
  header->flip_x = words[2][0] == '-';
  return CheckImageSize(name, header->width, header->height);
}

Status ParseVariable(const std::string& name, std::string_view line, HdrHeader* header) {
  constexpr std::string_view kFormat = "FORMAT=";
  constexpr std::string_view kExposure = "EXPOSURE=";
  if (line.starts_with(kFormat) && line.substr(kFormat.size()) != "32-bit_rle_rgbe") {
    return Status::Unsupported(
        fmt::format("{}: its format is {}; only 32-bit_rle_rgbe is supported", name,
                    OneLine(line.substr(kFormat.size()), kMaxShown)));
  }
  if (line.starts_with(kExposure)) {
    const std::vector<std::string_view> words = Words(line.substr(kExposure.size()));
    double value = 0;
    if (!words.empty()) {
      std::from_chars(words[0].data(), words[0].data() + words[0].size(), value);
    }
    header->exposure *= value;
    if (!std::isfinite(header->exposure) || header->exposure <= 0) {
      return Damaged(name, fmt::format("its exposure is \"{}\"", OneLine(line, kMaxShown)));
    }
  }
  return Status::Ok();
}

Result<HdrHeader> ParseHeader(std::string_view bytes, const std::string& name) {
  HdrHeader header;
  size_t at = 0;
  while (true) {
    const std::optional<std::string_view> line = NextLine(bytes, &at);
    if (!line) {
      return Damaged(name, "its header has no end");
    }
    if (line->empty()) {
      break;
    }
    STILLRAY_RETURN_IF_ERROR(ParseVariable(name, *line, &header));
  }
  const std::optional<std::string_view> line = NextLine(bytes, &at);
  if (!line) {
    return Damaged(name, "its size is missing");
  }
  STILLRAY_RETURN_IF_ERROR(ParseResolution(name, *line, &header));
  header.data_begin = at;
  return header;
}

/// Reads rows in order; every function returns nullptr or an error text.
class RowReader {
 public:
  explicit RowReader(std::string_view bytes) : bytes_(bytes) {}

  const char* Read(std::vector<Rgbe>* row) {
    const size_t width = row->size();
    const bool may_be_runs = width >= kMinRunWidth && width <= kMaxRunWidth;
    if (may_be_runs && Left() >= 4 && Peek(0) == 2 && Peek(1) == 2 && Peek(2) < 128) {
      const size_t found = static_cast<size_t>(Peek(2)) << 8 | Peek(3);
      if (found != width) {
        return "a row has another width than the picture";
      }
      at_ += 4;
      return ReadComponents(row);
    }
    return ReadPixels(row);
  }

 private:
  size_t Left() const { return bytes_.size() - at_; }
  uint8_t Peek(size_t offset) const { return static_cast<uint8_t>(bytes_[at_ + offset]); }
  static constexpr const char* kEndsEarly = "it ends too early";

  /// Each of the four components separately, as runs (above 128) and literals.
  const char* ReadComponents(std::vector<Rgbe>* row) {
    for (size_t component = 0; component < 4; ++component) {
      for (size_t x = 0; x < row->size();) {
        if (Left() < 2) {
          return kEndsEarly;
        }
        const uint8_t code = Peek(0);
        const bool run = code > 128;
        const size_t count = run ? code - 128u : code;
        ++at_;
        if (count == 0 || count > row->size() - x) {
          return "a run is longer than its row";
        }
        const size_t stored = run ? 1 : count;
        if (Left() < stored) {
          return kEndsEarly;
        }
        for (size_t i = 0; i < count; ++i) {
          (*row)[x + i][component] = Peek(run ? 0 : i);
        }
        at_ += stored;
        x += count;
      }
    }
    return nullptr;
  }

  /// Whole pixels; (1, 1, 1, n) repeats the last one n times; consecutive repeats are digits to the
  /// base 256, the lowest first.
  const char* ReadPixels(std::vector<Rgbe>* row) {
    int shift = 0;
    for (size_t x = 0; x < row->size();) {
      if (Left() < 4) {
        return kEndsEarly;
      }
      const Rgbe pixel = {Peek(0), Peek(1), Peek(2), Peek(3)};
      at_ += 4;
      if (pixel[0] != 1 || pixel[1] != 1 || pixel[2] != 1) {
        (*row)[x++] = pixel;
        shift = 0;
        continue;
      }
      if (x == 0 || shift > 16) {
        return "a run has nothing to repeat";
      }
      const size_t count = static_cast<size_t>(pixel[3]) << shift;
      if (count > row->size() - x) {
        return "a run is longer than its row";
      }
      std::fill_n(row->begin() + static_cast<ptrdiff_t>(x), count, (*row)[x - 1]);
      x += count;
      shift += 8;
    }
    return nullptr;
  }

  std::string_view bytes_;
  size_t at_ = 0;
};

/// The largest value: 255 / 256 * 2^127.
constexpr float kLargest = 0x1.fep+126f;

/// Mantissas rounded to the nearest; black has the exponent 0.
Rgbe ToRgbe(float r, float g, float b) {
  const auto bounded = [](float v) { return v > 0 ? std::min(v, kLargest) : 0.0f; };
  const float channels[3] = {bounded(r), bounded(g), bounded(b)};
  const float largest = std::max({channels[0], channels[1], channels[2]});
  int exponent = 0;
  std::frexp(largest, &exponent);
  // Rounding up the largest mantissa takes the next exponent.
  exponent += std::lround(std::ldexp(largest, 8 - exponent)) > 255 ? 1 : 0;
  constexpr int kBias = 128;
  if (largest <= 0 || exponent + kBias < 1) {
    return {0, 0, 0, 0};
  }
  Rgbe pixel = {0, 0, 0, static_cast<uint8_t>(exponent + kBias)};
  for (size_t c = 0; c < 3; ++c) {
    pixel[c] = static_cast<uint8_t>(std::lround(std::ldexp(channels[c], 8 - exponent)));
  }
  return pixel;
}

/// One component of a row as runs (of 4 or more, since shorter ones save nothing) and literals.
void AppendRuns(const std::vector<Rgbe>& row, size_t component, std::string* out) {
  constexpr size_t kShortest = 4;
  constexpr size_t kLongestRun = 127;
  constexpr size_t kMostLiterals = 128;
  const auto run_at = [&](size_t x) {
    size_t end = x + 1;
    while (end < row.size() && end - x < kLongestRun && row[end][component] == row[x][component]) {
      ++end;
    }
    return end - x;
  };
  for (size_t x = 0; x < row.size();) {
    const size_t run = run_at(x);
    if (run >= kShortest) {
      out->push_back(static_cast<char>(128 + run));
      out->push_back(static_cast<char>(row[x][component]));
      x += run;
      continue;
    }
    size_t end = x + 1;
    while (end < row.size() && end - x < kMostLiterals && run_at(end) < kShortest) {
      ++end;
    }
    out->push_back(static_cast<char>(end - x));
    for (; x < end; ++x) {
      out->push_back(static_cast<char>(row[x][component]));
    }
  }
}

void AppendRow(const std::vector<Rgbe>& row, std::string* out) {
  const size_t width = row.size();
  if (width < kMinRunWidth || width > kMaxRunWidth) {
    for (const Rgbe& pixel : row) {
      out->append(pixel.begin(), pixel.end());
    }
    return;
  }
  const char mark[] = {2, 2, static_cast<char>(width >> 8), static_cast<char>(width & 0xff)};
  out->append(mark, sizeof(mark));
  for (size_t component = 0; component < 4; ++component) {
    AppendRuns(row, component, out);
  }
}

}  // namespace

Result<Image3> DecodeHdr(const uint8_t* data, size_t size, const std::string& name) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  Result<HdrHeader> header = ParseHeader(bytes, name);
  if (!header.ok()) {
    return header.status();
  }
  const uint64_t decoded = static_cast<uint64_t>(header->width) *
                           static_cast<uint64_t>(header->height) * 3 * sizeof(float);
  STILLRAY_RETURN_IF_ERROR(CheckDecodedSize(name, decoded, size - header->data_begin, kMaxRatio));
  const int width = static_cast<int>(header->width);
  const int height = static_cast<int>(header->height);
  // Value = mantissa / 256 * 2^(exponent - 128). Without Radiance's half step, so that black stays
  // black, as in other readers.
  std::array<float, 256> scale{};
  for (int e = 1; e < 256; ++e) {
    scale[static_cast<size_t>(e)] =
        static_cast<float>(std::ldexp(1.0, e - (128 + 8)) / header->exposure);
  }
  Image3 image(width, height);
  RowReader reader(bytes.substr(header->data_begin));
  std::vector<Rgbe> row(static_cast<size_t>(width));
  for (int i = 0; i < height; ++i) {
    if (const char* problem = reader.Read(&row); problem != nullptr) {
      return Damaged(name, fmt::format("row {} of {}: {}", i + 1, height, problem));
    }
    const int y = header->flip_y ? height - 1 - i : i;
    for (int c = 0; c < 3; ++c) {
      float* out = image[c].Row(y);
      for (int x = 0; x < width; ++x) {
        const Rgbe& pixel = row[static_cast<size_t>(header->flip_x ? width - 1 - x : x)];
        out[x] = static_cast<float>(pixel[static_cast<size_t>(c)]) * scale[pixel[3]];
      }
    }
  }
  return image;
}

}  // namespace io

Result<std::string> EncodeHdr(const Image3& radiance) {
  const int width = radiance.width();
  const int height = radiance.height();
  if (width < 1 || height < 1 || width > io::kMaxSide || height > io::kMaxSide) {
    return Status::InvalidArgument(
        fmt::format("an HDR picture of {} x {} pixels cannot be written; 1 to {} a side can", width,
                    height, io::kMaxSide));
  }
  std::string file =
      fmt::format("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {} +X {}\n", height, width);
  std::vector<io::Rgbe> row(static_cast<size_t>(width));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      row[static_cast<size_t>(x)] =
          io::ToRgbe(radiance[0](x, y), radiance[1](x, y), radiance[2](x, y));
    }
    io::AppendRow(row, &file);
  }
  return file;
}

Status WriteHdr(const std::string& path, const Image3& radiance) {
  const Result<std::string> bytes = EncodeHdr(radiance);
  if (!bytes.ok()) {
    return PrefixStatus(path, bytes.status());
  }
  return WriteFileAtomically(path, bytes->data(), bytes->size());
}

}  // namespace stillray
