// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Folders of small pictures for the tests of the report, and pages taken apart again.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/colour.h"
#include "stillray/image.h"
#include "stillray/io.h"

namespace stillray::report {

/// A new folder that goes away with the object.
class TestFolder {
 public:
  explicit TestFolder(const std::string& name = "shot") {
    std::string pattern =
        (std::filesystem::temp_directory_path() / "stillray-report-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) {
      ADD_FAILURE() << "no temporary folder";
    }
    root_ = pattern;
    folder_ = root_ / name;
    std::filesystem::create_directory(folder_);
  }
  TestFolder(const TestFolder&) = delete;
  TestFolder& operator=(const TestFolder&) = delete;
  ~TestFolder() { std::filesystem::remove_all(root_); }

  std::string path() const { return folder_.string(); }
  std::string Path(const std::string& name) const { return (folder_ / name).string(); }

  void Write(const std::string& name, const std::string& bytes) const {
    std::ofstream(Path(name), std::ios::binary) << bytes;
  }
  std::string Read(const std::string& name) const {
    std::ifstream file(Path(name), std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
  }

  /// A PNG picture that differs from pixel to pixel, around `level`.
  void AddPng(const std::string& name, int level, int width = 24, int height = 16) const {
    Rgb8Image image{width, height, {}};
    for (int i = 0; i < 3 * width * height; ++i) {
      image.pixels.push_back(static_cast<uint8_t>((level + i * 7 % 13) % 256));
    }
    const Status written = WritePng(Path(name), image);
    ASSERT_TRUE(written.ok()) << written.message();
  }
  void AddFlatPng(const std::string& name, int level, int width = 24, int height = 16) const {
    const Rgb8Image image{
        width, height,
        std::vector<uint8_t>(static_cast<size_t>(3 * width * height), static_cast<uint8_t>(level))};
    const Status written = WritePng(Path(name), image);
    ASSERT_TRUE(written.ok()) << written.message();
  }
  /// An EXR picture of one value.
  void AddExr(const std::string& name, float value, int width = 24, int height = 16) const {
    Image3 image(width, height);
    for (int c = 0; c < 3; ++c) {
      image[c].Fill(value);
    }
    ExrImage exr;
    exr.width = width;
    exr.height = height;
    exr.Add("", PixelType::kFloat, image);
    const Status written = WriteExr(Path(name), exr);
    ASSERT_TRUE(written.ok()) << written.message();
  }

 private:
  std::filesystem::path root_;
  std::filesystem::path folder_;
};

/// The text of the script element with this id.
inline std::string ScriptText(const std::string& page, const std::string& id) {
  const std::string open = "<script type=\"application/json\" id=\"" + id + "\">";
  const size_t start = page.find(open);
  if (start == std::string::npos) {
    ADD_FAILURE() << "the page has no " << id;
    return "null";
  }
  const size_t from = start + open.size();
  return page.substr(from, page.find("</script>", from) - from);
}

inline nlohmann::json PageData(const std::string& page) {
  return nlohmann::json::parse(ScriptText(page, "report-data"));
}

inline nlohmann::json PagePictures(const std::string& page) {
  return nlohmann::json::parse(ScriptText(page, "report-pictures"));
}

/// Decodes RFC 4648 base64, by its definition and not by the encoder's code.
inline std::string DecodeBase64(std::string_view text) {
  const std::string_view alphabet =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bits;
  for (const char c : text) {
    const size_t value = alphabet.find(c);
    if (value == std::string_view::npos) {
      EXPECT_EQ(c, '=');
      continue;
    }
    for (int bit = 5; bit >= 0; --bit) {
      bits.push_back((value >> bit & 1) != 0 ? '1' : '0');
    }
  }
  std::string bytes;
  for (size_t i = 0; i + 8 <= bits.size(); i += 8) {
    bytes.push_back(static_cast<char>(std::stoi(bits.substr(i, 8), nullptr, 2)));
  }
  return bytes;
}

}  // namespace stillray::report
