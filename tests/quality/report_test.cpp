// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "quality/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "quality/heat_map.h"
#include "quality/report_test_folder.h"
#include "stillray/quality.h"

namespace stillray::report::report_test {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

std::string Build(const TestFolder& folder, const ReportOptions& options = {}) {
  const Result<std::string> page = BuildReport(folder.path(), options);
  EXPECT_TRUE(page.ok()) << page.status().message();
  return page.ok() ? *page : std::string();
}

Status BuildError(const TestFolder& folder, const ReportOptions& options = {}) {
  const Result<std::string> page = BuildReport(folder.path(), options);
  EXPECT_FALSE(page.ok());
  return page.status();
}

std::vector<std::string> Notes(const json& data) {
  return data["notes"].get<std::vector<std::string>>();
}

std::vector<int> FrameNumbers(const json& data) {
  std::vector<int> numbers;
  for (const json& frame : data["frames"]) {
    numbers.push_back(frame["number"].get<int>());
  }
  return numbers;
}

/// The bytes of a picture that a frame of the page refers to.
std::string EmbeddedPicture(const std::string& page, size_t frame, const std::string& view,
                            const std::string& key = "picture") {
  const json index = PageData(page)["frames"][frame]["views"][view][key];
  if (!index.is_number_unsigned()) {
    ADD_FAILURE() << "no " << key << " of " << view << ": " << index.dump();
    return "";
  }
  return DecodeBase64(PagePictures(page)[index.get<size_t>()].get<std::string>());
}

Rgb8Image Decode(const std::string& png) {
  const Result<Rgb8Image> image =
      DecodePng8(reinterpret_cast<const uint8_t*>(png.data()), png.size(), "embedded");
  EXPECT_TRUE(image.ok()) << image.status().message();
  return image.ok() ? *image : Rgb8Image{};
}

TEST(Report, EmbedsTheFilesByteForByte) {
  const TestFolder folder;
  for (int frame = 1; frame <= 3; ++frame) {
    folder.AddPng(fmt::format("noisy.{:04}.png", frame), 10 * frame);
    folder.AddPng(fmt::format("denoised.{:04}.png", frame), 100 + 10 * frame);
    folder.AddPng(fmt::format("temporal.{:04}.png", frame), 50 + 10 * frame);
    folder.AddPng(fmt::format("reference.{:04}.png", frame), 200 + 10 * frame);
  }
  const std::string page = Build(folder);
  EXPECT_THAT(FrameNumbers(PageData(page)), ElementsAre(1, 2, 3));
  for (size_t frame = 0; frame < 3; ++frame) {
    for (const char* view : {"noisy", "temporal", "denoised", "reference"}) {
      EXPECT_EQ(EmbeddedPicture(page, frame, view),
                folder.Read(fmt::format("{}.{:04}.png", view, frame + 1)))
          << view << frame;
    }
  }
}

TEST(Report, SizeAndFolderComeFromTheFiles) {
  const TestFolder folder("walk in the park");
  folder.AddPng("denoised.0005.png", 3, 31, 9);
  const json data = PageData(Build(folder));
  EXPECT_EQ(data["width"], 31);
  EXPECT_EQ(data["height"], 9);
  EXPECT_EQ(data["source"], "the folder walk in the park");
  EXPECT_EQ(data["title"], "walk in the park");
  EXPECT_FALSE(data["has_log"]);
}

TEST(Report, OnePictureIsEnoughAndThePageSaysWhatIsMissing) {
  const TestFolder folder;
  folder.AddPng("denoised.0001.png", 3);
  const json data = PageData(Build(folder));
  EXPECT_THAT(Notes(data),
              AllOf(Contains("The folder holds no noisy, temporal and reference pictures."),
                    Contains(HasSubstr("Quality is not measured")),
                    Contains(HasSubstr("There is no render.json"))));
  EXPECT_TRUE(data["quality"]["sources"].empty());
}

TEST(Report, NamesFramesThatLackAView) {
  const TestFolder folder;
  for (int frame = 1; frame <= 9; ++frame) {
    folder.AddPng(fmt::format("denoised.{}.png", frame), 3);
    if (frame == 2) {
      folder.AddPng("noisy.2.png", 3);
    }
    if (frame != 4) {
      folder.AddPng(fmt::format("reference.{}.png", frame), 3);
    }
  }
  EXPECT_THAT(Notes(PageData(Build(folder))),
              AllOf(Contains("There are no reference pictures of frame 4."),
                    Contains("There are no noisy pictures of frames 1, 3, 4, 5, 6 and 3 more.")));
}

TEST(Report, ThinsFramesEvenly) {
  const TestFolder folder;
  for (int frame = 1; frame <= 21; ++frame) {
    folder.AddPng(fmt::format("denoised.{:04}.png", frame), frame);
    folder.AddPng(fmt::format("reference.{:04}.png", frame), 2 * frame);
  }
  ReportOptions options;
  options.max_frames = 5;
  ReportSummary summary;
  const Result<std::string> page = BuildReport(folder.path(), options, &summary);
  ASSERT_TRUE(page.ok()) << page.status().message();
  const json data = PageData(*page);
  EXPECT_THAT(FrameNumbers(data), ElementsAre(1, 6, 11, 16, 21));
  EXPECT_THAT(Notes(data), Contains(HasSubstr("Pictures of 5 of 21 frames are embedded")));
  EXPECT_EQ(data["quality"]["frames"].size(), 21u) << "quality is measured on every frame";
  EXPECT_EQ(summary.frames_found, 21);
  EXPECT_EQ(summary.frames_shown, 5);
  EXPECT_EQ(summary.page_bytes, page->size());
  EXPECT_EQ(summary.notes, Notes(data));
  options.max_frames = 1;
  EXPECT_THAT(FrameNumbers(PageData(Build(folder, options))), ElementsAre(21));
}

TEST(Report, ThinsFramesToTheSizeOfThePage) {
  const TestFolder folder;
  for (int frame = 1; frame <= 9; ++frame) {
    folder.AddPng(fmt::format("denoised.{:04}.png", frame), frame, 200, 150);
  }
  const double picture = 4.0 / 3 * static_cast<double>(folder.Read("denoised.0001.png").size());
  ReportOptions options;
  options.max_page_bytes = static_cast<int64_t>(3.5 * picture);
  const json data = PageData(Build(folder, options));
  EXPECT_THAT(FrameNumbers(data), ElementsAre(1, 5, 9));
  EXPECT_THAT(Notes(data), Contains(HasSubstr("to keep this page below")));
  options.max_page_bytes = 1;
  EXPECT_THAT(FrameNumbers(PageData(Build(folder, options))), ElementsAre(9))
      << "one frame always stays";
}

TEST(Report, MeasuresDisplayValues) {
  const TestFolder folder;
  folder.AddFlatPng("noisy.0001.png", 255);
  folder.AddFlatPng("denoised.0001.png", 0);
  folder.AddFlatPng("reference.0001.png", 0);
  const json data = PageData(Build(folder));
  const json& sources = data["quality"]["sources"];
  ASSERT_EQ(sources.size(), 1u);
  EXPECT_EQ(sources[0]["source"], "display");
  const json& noisy = sources[0]["views"]["noisy"]["mean"];
  // White against black: PSNR with peak 1 is 0 dB, relMSE is 1 / 0.01, FLIP its largest value.
  EXPECT_NEAR(noisy["psnr"].get<double>(), 0.0, 1e-5);
  EXPECT_NEAR(noisy["rel_mse"].get<double>(), 100.0, 1e-3);
  EXPECT_GT(noisy["flip"].get<double>(), 0.9);
  const json& denoised = sources[0]["views"]["denoised"];
  EXPECT_EQ(denoised["mean"]["psnr"], "inf");
  EXPECT_EQ(denoised["values"]["psnr"], json::array({"inf"}));
  EXPECT_EQ(denoised["mean"]["flip"].get<double>(), 0.0);
  EXPECT_THAT(Notes(data), Contains(HasSubstr("display values of PNG files")));
}

TEST(Report, MeasuresLinearRadianceWhereBothHaveIt) {
  const TestFolder folder;
  folder.AddExr("denoised.0001.exr", 2.0f);
  folder.AddExr("reference.0001.exr", 1.0f);
  folder.AddFlatPng("denoised.0001.png", 7);
  folder.AddFlatPng("reference.0001.png", 7);
  const json data = PageData(Build(folder));
  const json& sources = data["quality"]["sources"];
  ASSERT_EQ(sources.size(), 1u) << sources.dump();
  EXPECT_EQ(sources[0]["source"], "linear");
  const json& mean = sources[0]["views"]["denoised"]["mean"];
  EXPECT_NEAR(mean["rel_mse"].get<double>(), 1.0 / 1.01, 1e-5);
  EXPECT_NEAR(mean["brightness"].get<double>(), 2.0, 1e-6);
  EXPECT_NEAR(mean["brightness_lowest"].get<double>(), 2.0, 1e-6);
  EXPECT_NEAR(mean["brightness_highest"].get<double>(), 2.0, 1e-6);
  EXPECT_EQ(mean["bright_specks"].get<double>(), 0.0);
  EXPECT_EQ(mean["dark_specks"].get<double>(), 0.0);
  // The error is even: 1 % of 384 pixels are 4.
  EXPECT_NEAR(mean["worst_share"].get<double>(), 4.0 / 384, 1e-6);
  EXPECT_TRUE(mean["light_change"].is_null());
  EXPECT_THAT(Notes(data), Contains("Quality is measured on the linear radiance of EXR files."));
}

TEST(Report, OffersBothScalesWhereOneViewHasOnlyPng) {
  const TestFolder folder;
  folder.AddExr("denoised.0001.exr", 2.0f);
  folder.AddExr("reference.0001.exr", 1.0f);
  folder.AddFlatPng("denoised.0001.png", 7);
  folder.AddFlatPng("reference.0001.png", 7);
  folder.AddFlatPng("temporal.0001.png", 70);
  const json sources = PageData(Build(folder))["quality"]["sources"];
  ASSERT_EQ(sources.size(), 2u);
  EXPECT_EQ(sources[0]["source"], "linear");
  EXPECT_FALSE(sources[0]["views"].contains("temporal"));
  EXPECT_EQ(sources[1]["source"], "display");
  EXPECT_TRUE(sources[1]["views"].contains("temporal"));
  EXPECT_EQ(sources[1]["views"]["denoised"]["mean"]["psnr"], "inf");
}

TEST(Report, ErrorMapsShowTheError) {
  const TestFolder folder;
  folder.AddExr("denoised.0001.exr", 2.0f, 8, 8);
  folder.AddExr("reference.0001.exr", 1.0f, 8, 8);
  const std::string page = Build(folder);
  const Rgb8Image map = Decode(EmbeddedPicture(page, 0, "denoised", "rel_se"));
  ASSERT_EQ(map.width, 8);
  ASSERT_EQ(map.height, 8);
  const Rgb8 expected = HeatPalette()[HeatIndex(1.0f / 1.01f, kRelativeSquaredErrorScale)];
  for (size_t i = 0; i < map.pixels.size(); ++i) {
    ASSERT_EQ(map.pixels[i], expected[i % 3]) << i;
  }
  EXPECT_NE(EmbeddedPicture(page, 0, "denoised", "flip"), "");
  EXPECT_TRUE(PageData(page)["frames"][0]["views"]["reference"]["flip"].is_null());
}

TEST(Report, DevelopsExrFilesWithoutPng) {
  const TestFolder folder;
  folder.AddExr("denoised.0001.exr", 0.25f, 5, 3);
  folder.Write("render.json", R"({"exposure": 1.0, "tonemap": "reinhard"})");
  const std::string clipped = Build(folder);
  const Rgb8Image picture = Decode(EmbeddedPicture(clipped, 0, "denoised"));
  // 0.25 at +1 stop is 0.5: 188 in sRGB.
  EXPECT_THAT(picture.pixels, ::testing::Each(188));
  EXPECT_THAT(Notes(PageData(clipped)), Contains(HasSubstr("no tone curve")));

  ReportOptions options;
  std::string curve;
  double stops = 0;
  options.develop = [&](const Image3& radiance, const std::string& tonemap, double exposure) {
    curve = tonemap;
    stops = exposure;
    return Result<Rgb8Image>(
        Rgb8Image{radiance.width(), radiance.height(), std::vector<uint8_t>(45, 77)});
  };
  const std::string page = Build(folder, options);
  EXPECT_EQ(curve, "reinhard");
  EXPECT_EQ(stops, 1.0);
  EXPECT_THAT(Decode(EmbeddedPicture(page, 0, "denoised")).pixels, ::testing::Each(77));
  EXPECT_THAT(Notes(PageData(page)), Contains(HasSubstr("tone curve reinhard")));
}

/// An EXR picture of one value in a frame whose pixels were `motion_x` to the right before.
void AddMovedExr(const TestFolder& folder, const std::string& name, float value, float motion_x) {
  constexpr int kWidth = 24;
  constexpr int kHeight = 16;
  Image3 colour(kWidth, kHeight);
  Image1 motion(kWidth, kHeight);
  motion.Fill(motion_x);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        colour[c](x, y) = value * static_cast<float>(x);
      }
    }
  }
  ExrImage exr;
  exr.width = kWidth;
  exr.height = kHeight;
  exr.Add("", PixelType::kFloat, colour);
  exr.Add("motion.X", PixelType::kFloat, motion);
  exr.Add("motion.Y", PixelType::kFloat, Image1(kWidth, kHeight));
  ASSERT_TRUE(WriteExr(folder.Path(name), exr).ok());
}

TEST(Report, MeasuresTheTemporalErrorAsCompareDoes) {
  const TestFolder folder;
  for (int frame = 1; frame <= 3; ++frame) {
    const float value = 0.1f * static_cast<float>(frame);
    AddMovedExr(folder, fmt::format("denoised.{:04}.exr", frame), value, 1);
    folder.AddExr(fmt::format("reference.{:04}.exr", frame), 0.5f);
  }
  const json data = PageData(Build(folder));
  const json& view = data["quality"]["sources"][0]["views"]["denoised"];
  ASSERT_EQ(view["values"]["temporal_error"].size(), 3u);
  EXPECT_TRUE(view["values"]["temporal_error"][0].is_null()) << "there is no frame before";
  const auto read = [&](const std::string& name) { return ReadImage(folder.Path(name)).value(); };
  Image2 motion(24, 16);
  motion[0].Fill(1);
  const Result<double> expected = TemporalError(
      read("denoised.0002.exr"), read("denoised.0001.exr"), read("reference.0002.exr"),
      read("reference.0001.exr"), motion, Image1(), Image1(), false);
  ASSERT_TRUE(expected.ok());
  EXPECT_GT(*expected, 0.01);
  EXPECT_EQ(view["values"]["temporal_error"][1].get<double>(), *expected);
  EXPECT_NEAR(view["mean"]["temporal_error"].get<double>(),
              (*expected + view["values"]["temporal_error"][2].get<double>()) / 2, 1e-12);
  EXPECT_THAT(Notes(data), Not(Contains(HasSubstr("as if nothing moved"))));
}

// On the curve the reference goes from 1/3 to 1/2 and stays; the picture makes half of the step.
TEST(Report, MeasuresTheChangeOfLightAsCompareDoes) {
  const TestFolder folder;
  folder.AddExr("denoised.0001.exr", 0.5f);
  folder.AddExr("reference.0001.exr", 0.5f);
  for (int frame = 2; frame <= 3; ++frame) {
    folder.AddExr(fmt::format("denoised.{:04}.exr", frame), 5.0f / 7);
    folder.AddExr(fmt::format("reference.{:04}.exr", frame), 1.0f);
  }
  const json view = PageData(Build(folder))["quality"]["sources"][0]["views"]["denoised"];
  EXPECT_TRUE(view["values"]["light_change"][0].is_null()) << "there is no frame before";
  EXPECT_NEAR(view["values"]["light_change"][1].get<double>(), 0.5, 1e-5);
  EXPECT_TRUE(view["values"]["light_change"][2].is_null()) << "the light is steady";
  EXPECT_NEAR(view["mean"]["light_change"].get<double>(), 0.5, 1e-5);
}

TEST(Report, TemporalErrorWithoutMotionIsSaid) {
  const TestFolder folder;
  for (int frame : {1, 2, 4}) {
    folder.AddFlatPng(fmt::format("denoised.{:04}.png", frame), 10 * frame);
    folder.AddFlatPng(fmt::format("reference.{:04}.png", frame), 100);
  }
  const json data = PageData(Build(folder));
  const json values =
      data["quality"]["sources"][0]["views"]["denoised"]["values"]["temporal_error"];
  EXPECT_TRUE(values[0].is_null());
  // 10 of 255 display steps from frame 1 to 2.
  EXPECT_NEAR(values[1].get<double>(), 10 / 255.0, 1e-4);
  EXPECT_TRUE(values[2].is_null()) << "frame 3 is not there";
  EXPECT_THAT(Notes(data), Contains(HasSubstr("as if nothing moved")));
}

// Blender without Combined, which is replaced by the sum of the passes.
TEST(Report, FilesOfLightPassesShowTheirSum) {
  const TestFolder folder;
  ExrImage exr;
  exr.width = 24;
  exr.height = 16;
  const auto add = [&](const std::string& layer, float value) {
    Image3 image(24, 16);
    for (int c = 0; c < 3; ++c) {
      image[c].Fill(value);
    }
    exr.Add("ViewLayer." + layer + ".", PixelType::kFloat, image);
  };
  add("DiffDir", 0.25f);
  add("DiffInd", 0.25f);
  add("DiffCol", 0.5f);
  add("Emit", 0.25f);
  ASSERT_TRUE(WriteExr(folder.Path("a.0001.exr"), exr).ok());
  folder.AddExr("b.0001.exr", 0.5f);
  ReportSequences sequences;
  sequences.noisy = folder.Path("a.####.exr");
  sequences.clean = folder.Path("b.####.exr");
  sequences.reference = sequences.clean;
  const Result<std::string> page = BuildReport(sequences, ReportOptions());
  ASSERT_TRUE(page.ok()) << page.status().message();
  // 0.5 times the sum of direct and indirect light, and the emission.
  EXPECT_EQ(PageData(*page)["quality"]["sources"][0]["views"]["noisy"]["mean"]["psnr"], "inf");
}

TEST(Report, SequencesOfAnyName) {
  const TestFolder folder("work");
  std::filesystem::create_directory(folder.Path("ref"));
  for (int frame = 1; frame <= 5; ++frame) {
    folder.AddExr(fmt::format("beauty_{:03}.exr", frame), 0.25f);
    if (frame > 1) {
      folder.AddPng(fmt::format("clean.v2.{}.png", frame), 10 * frame);
    }
    if (frame < 4) {
      folder.AddPng(fmt::format("ref/{:04}.png", frame), 10 * frame);
    }
  }
  ReportSequences sequences;
  sequences.noisy = folder.Path("beauty_###.exr");
  sequences.clean = folder.Path("clean.v2.*.png");
  sequences.reference = folder.Path("ref");
  const Result<std::string> page = BuildReport(sequences, ReportOptions());
  ASSERT_TRUE(page.ok()) << page.status().message();
  const json data = PageData(*page);
  EXPECT_THAT(FrameNumbers(data), ElementsAre(2, 3, 4, 5));
  EXPECT_EQ(data["title"], "work/clean.v2.*.png");
  EXPECT_EQ(data["fps"], 24.0);
  EXPECT_EQ(EmbeddedPicture(*page, 0, "denoised"), folder.Read("clean.v2.2.png"));
  EXPECT_EQ(EmbeddedPicture(*page, 1, "reference"), folder.Read("ref/0003.png"));
  EXPECT_THAT(data["quality"]["frames"], ElementsAre(2, 3));
  EXPECT_THAT(Notes(data), AllOf(Contains(HasSubstr("no reference pictures of frames 4 and 5")),
                                 Contains(HasSubstr("noisy pictures have no PNG files")),
                                 Not(Contains(HasSubstr("render.json"))),
                                 Not(Contains(HasSubstr("temporal pictures")))));
  sequences.noisy = folder.Path("beuaty_###.exr");
  const Result<std::string> wrong = BuildReport(sequences, ReportOptions());
  ASSERT_FALSE(wrong.ok());
  EXPECT_THAT(wrong.status().message(),
              AllOf(HasSubstr("--noisy: "), HasSubstr("found beauty_001.exr ... beauty_005.exr")));
}

TEST(Report, ShowsTimesAndSettings) {
  const TestFolder folder;
  folder.AddPng("denoised.0001.png", 3);
  folder.Write("render.json", R"({"scene": "lamp.glb", "preset": "svgf", "spp": 2,
    "parameters": {"steps": [1, 2], "sigma_l": 4.0},
    "frames": [{"frame": 1, "seconds": 0.5, "denoise_ms": 8.0, "stages_ms": {"a": 1.0, "b": 3.0}}],
    "memory": {"denoiser_bytes": 12}})");
  const json data = PageData(Build(folder));
  EXPECT_EQ(data["title"], "lamp.glb, svgf");
  EXPECT_EQ(data["settings"],
            json::parse(R"([["scene", "lamp.glb"], ["preset", "svgf"], ["spp", "2"]])"));
  EXPECT_EQ(data["parameters"], json::parse(R"([["steps", "1, 2"], ["sigma_l", "4.0"]])"));
  EXPECT_EQ(data["memory"], json::parse(R"([["denoiser_bytes", 12]])"));
  EXPECT_EQ(data["times"]["stages"][1]["name"], "b");
  EXPECT_EQ(data["times"]["stages"][1]["share"], 0.75);
  EXPECT_EQ(data["times"]["denoise"]["median"], 8.0);
  EXPECT_TRUE(data["times"]["render"].is_null());
  EXPECT_EQ(data["frames"][0]["seconds"], 0.5);
}

TEST(Report, TextFromFilesNeverBecomesMarkup) {
  const std::string hostile =
      "</script><script>alert(1)</script><img src=x onerror=alert(2)>\"'&<!--{{SCRIPT}}";
  const TestFolder folder("<b>&\"'");
  folder.AddPng("denoised.0001.png", 3);
  const json log = {
      {"scene", hostile},         {"preset", hostile},
      {"tonemap", hostile},       {"parameters", {{hostile, hostile}}},
      {"memory", {{hostile, 1}}}, {"frames", {{{"frame", 1}, {"stages_ms", {{hostile, 1.0}}}}}}};
  folder.Write("render.json", log.dump());
  const std::string page = Build(folder);
  EXPECT_THAT(page, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(page, Not(HasSubstr("<img")));
  EXPECT_THAT(page, Not(HasSubstr("<b>")));
  // All that is there arrives as it was.
  const json data = PageData(page);
  EXPECT_EQ(data["title"], hostile + ", " + hostile);
  EXPECT_EQ(data["source"], "the folder <b>&\"'");
  EXPECT_EQ(data["parameters"][0][0], hostile);
  EXPECT_EQ(data["times"]["stages"][0]["name"], hostile);
  EXPECT_THAT(page, HasSubstr("<title>&lt;/script&gt;&lt;script&gt;alert(1)"));
}

TEST(Report, TextThatIsNotUtf8IsReplaced) {
  const TestFolder folder("caf\xe9");
  folder.AddPng("denoised.0001.png", 3);
  const std::string page = Build(folder);
  EXPECT_EQ(PageData(page)["source"], "the folder caf\uFFFD");
  EXPECT_THAT(page, HasSubstr("<title>caf\uFFFD"));
}

TEST(Report, PageStandsAlone) {
  const TestFolder folder;
  folder.AddPng("denoised.0001.png", 3);
  const std::string page = Build(folder);
  EXPECT_THAT(page, HasSubstr("default-src 'none'"));
  for (const char* reference :
       {"src=\"http", "href=\"http", "url(", "@import", "fetch(", "<link rel=\"stylesheet"}) {
    EXPECT_THAT(page, Not(HasSubstr(reference)));
  }
  EXPECT_THAT(page, Not(HasSubstr("{{"))) << "a marker of the template was left";
  EXPECT_TRUE(page.ends_with("</html>\n"));
}

TEST(Report, SameBytesForAnyNumberOfThreads) {
  const TestFolder folder;
  for (int frame = 1; frame <= 4; ++frame) {
    folder.AddPng(fmt::format("noisy.{}.png", frame), 60 * frame);
    folder.AddPng(fmt::format("denoised.{}.png", frame), 50 * frame);
    folder.AddPng(fmt::format("reference.{}.png", frame), 40 * frame);
  }
  std::set<std::string> pages;
  for (const size_t threads : {1, 2, 5}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    pages.insert(Build(folder));
  }
  EXPECT_EQ(pages.size(), 1u);
}

// Errors

TEST(ReportErrors, MissingFolder) {
  const Result<std::string> page = BuildReport("/no/such/folder", {});
  ASSERT_FALSE(page.ok());
  EXPECT_EQ(page.status().code(), StatusCode::kNotFound);
  EXPECT_EQ(page.status().message(), "/no/such/folder: no such folder");
}

TEST(ReportErrors, MessagesAreOneLineWhateverTheFolderIsCalled) {
  const TestFolder folder("a\nb\x1b[31m");
  folder.AddPng("noisy.0001.png", 3);
  folder.Write("denoised.0001.png", "");
  EXPECT_THAT(BuildError(folder).message(), AllOf(Not(HasSubstr("\n")), Not(HasSubstr("\x1b"))));
}

TEST(ReportErrors, FileInsteadOfFolder) {
  const TestFolder folder;
  folder.Write("file", "");
  const Result<std::string> page = BuildReport(folder.Path("file"), {});
  ASSERT_FALSE(page.ok());
  EXPECT_THAT(page.status().message(), HasSubstr("not a folder"));
}

TEST(ReportErrors, NoFrames) {
  const TestFolder folder;
  folder.AddPng("picture.0001.png", 3);
  folder.Write("denoised.png", "");
  folder.Write("denoised.0001.jpg", "");
  folder.Write("denoised.1x.png", "");
  const Status error = BuildError(folder);
  EXPECT_EQ(error.code(), StatusCode::kNotFound);
  EXPECT_THAT(error.message(), HasSubstr("no frames"));
}

TEST(ReportErrors, SizesThatDifferAreNamed) {
  const TestFolder folder;
  folder.AddPng("noisy.0001.png", 3, 24, 16);
  folder.AddPng("noisy.0002.png", 3, 24, 17);
  const Status error = BuildError(folder);
  EXPECT_EQ(error.code(), StatusCode::kBadData);
  EXPECT_THAT(error.message(),
              AllOf(HasSubstr("noisy.0002.png: 24x17"), HasSubstr("noisy.0001.png has 24x16")));
}

TEST(ReportErrors, SizeThatContradictsRenderJson) {
  const TestFolder folder;
  folder.AddPng("noisy.0001.png", 3, 24, 16);
  folder.Write("render.json", R"({"width": 24, "height": 18})");
  EXPECT_THAT(BuildError(folder).message(), HasSubstr("24x16 pixels, but render.json says 24x18"));
}

TEST(ReportErrors, TruncatedPictures) {
  const TestFolder folder;
  folder.AddPng("noisy.0001.png", 3);
  folder.AddPng("reference.0001.png", 3);
  folder.AddPng("denoised.0001.png", 3);
  const std::string whole = folder.Read("denoised.0001.png");
  for (const size_t size :
       {size_t{0}, size_t{1}, size_t{20}, whole.size() / 2, whole.size() - 40}) {
    folder.Write("denoised.0001.png", whole.substr(0, size));
    const Status error = BuildError(folder);
    // Bytes too few to distinguish formats may be unsupported instead.
    EXPECT_THAT(error.code(), AnyOf(StatusCode::kBadData, StatusCode::kUnsupported)) << size;
    EXPECT_THAT(error.message(), AllOf(HasSubstr("denoised.0001.png"), Not(HasSubstr("\n"))))
        << size;
  }
}

TEST(ReportErrors, TwoFilesOfOneFrame) {
  const TestFolder folder;
  folder.AddPng("noisy.1.png", 3);
  folder.AddPng("noisy.0001.png", 3);
  EXPECT_THAT(BuildError(folder).message(),
              AllOf(HasSubstr("noisy.0001.png and "), HasSubstr("noisy.1.png are the same frame")));
}

TEST(ReportErrors, DamagedRenderJson) {
  const TestFolder folder;
  folder.AddPng("noisy.0001.png", 3);
  folder.Write("render.json", "{\n  \"scene\": \"a\",\n  \"spp\" 1\n}\n");
  const Status error = BuildError(folder);
  EXPECT_EQ(error.code(), StatusCode::kBadData);
  EXPECT_THAT(error.message(), AllOf(HasSubstr("render.json: line 3"), Not(HasSubstr("\n"))));
}

TEST(ReportErrors, OptionsOutOfRange) {
  const TestFolder folder;
  folder.AddPng("noisy.0001.png", 3);
  ReportOptions options;
  options.max_frames = 0;
  EXPECT_THAT(BuildError(folder, options).message(), "number of frames: found 0, expected 1..1000");
  options = {};
  options.zoom_width = -1;
  EXPECT_EQ(BuildError(folder, options).code(), StatusCode::kInvalidArgument);
  options = {};
  options.max_page_bytes = 0;
  EXPECT_EQ(BuildError(folder, options).code(), StatusCode::kInvalidArgument);
}

TEST(ReportErrors, PicturesWithoutAnyFinitePixel) {
  const TestFolder folder;
  folder.AddExr("denoised.0001.exr", std::nanf(""));
  folder.AddExr("reference.0001.exr", 1.0f);
  const Status error = BuildError(folder);
  EXPECT_EQ(error.code(), StatusCode::kBadData);
  EXPECT_THAT(error.message(), HasSubstr("denoised.0001.exr"));
}

TEST(ReportErrors, Cancelled) {
  const TestFolder folder;
  folder.AddPng("noisy.0001.png", 3);
  folder.AddPng("noisy.0002.png", 3);
  ReportOptions options;
  std::vector<int> calls;
  options.progress = [&calls](int done, int total) {
    calls.push_back(done);
    EXPECT_EQ(total, 2);
    return done < 1;
  };
  EXPECT_EQ(BuildError(folder, options).code(), StatusCode::kCancelled);
  EXPECT_THAT(calls, ElementsAre(1));
}

TEST(WriteReport, WritesWhatIsBuiltAndReplacesOnlyOnSuccess) {
  const TestFolder folder;
  folder.AddPng("noisy.0001.png", 3);
  const std::string path = folder.Path("report.html");
  Status written = WriteReport(folder.path(), path, {});
  ASSERT_TRUE(written.ok()) << written.message();
  const std::string page = folder.Read("report.html");
  EXPECT_EQ(page, Build(folder));
  folder.Write("render.json", "{");
  written = WriteReport(folder.path(), path, {});
  EXPECT_FALSE(written.ok());
  EXPECT_EQ(folder.Read("report.html"), page);
}

TEST(WriteReport, UnwritableOutput) {
  const TestFolder folder;
  folder.AddPng("noisy.0001.png", 3);
  const Status missing = WriteReport(folder.path(), folder.Path("none/report.html"), {});
  EXPECT_FALSE(missing.ok());
  EXPECT_THAT(missing.message(), HasSubstr("none"));
  std::filesystem::create_directory(folder.Path("taken"));
  const Status taken = WriteReport(folder.path(), folder.Path("taken"), {});
  EXPECT_FALSE(taken.ok());
  EXPECT_THAT(taken.message(), HasSubstr("taken"));
}

}  // namespace
}  // namespace stillray::report::report_test
