// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "apps/program.h"
#include "quality/pictures.h"
#include "stillray/io.h"
#include "stillray/quality.h"

namespace stillray::cli_compare_test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

ExrImage MakeExr(const Image3& colour) {
  ExrImage exr;
  exr.width = colour.width();
  exr.height = colour.height();
  exr.Add("", PixelType::kFloat, colour);
  return exr;
}

void WriteLinear(const std::string& path, const Image3& colour) {
  const Status status = WriteExr(path, MakeExr(colour));
  ASSERT_TRUE(status.ok()) << status.message();
}

/// A grey picture of one byte value.
void WriteGrey(const std::string& path, int width, int height, uint8_t value) {
  const Rgb8Image image = {width, height,
                           std::vector<uint8_t>(static_cast<size_t>(width * height * 3), value)};
  const Status status = WritePng(path, image);
  ASSERT_TRUE(status.ok()) << status.message();
}

/// Success without a word on standard error.
void ExpectSuccess(const ProgramRun& run) {
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.errors, IsEmpty());
}

/// One clear line on standard error, exit code 2, and nothing that looks like a result.
void ExpectFailure(const ProgramRun& run, const std::string& what) {
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.errors, AllOf(StartsWith("stillray: error: "), HasSubstr(what)));
  EXPECT_EQ(std::count(run.errors.begin(), run.errors.end(), '\n'), 1) << run.errors;
  EXPECT_THAT(run.output, IsEmpty());
}

class CliCompare : public testing::Test {
 protected:
  const TemporaryFolder folder_;
};

TEST_F(CliCompare, OneLinearPicture) {
  const Image3 reference = ScenePicture(40, 30, 2.0f);
  const Image3 test = Blend(reference, NoisePicture(40, 30, 1), 0.3f);
  WriteLinear(folder_ / "test.exr", test);
  WriteLinear(folder_ / "reference.exr", reference);
  const ProgramRun run = RunProgram({"compare", folder_ / "test.exr", folder_ / "reference.exr",
                                     "--json", folder_ / "result.json"});
  ExpectSuccess(run);
  EXPECT_THAT(run.output, AllOf(HasSubstr("PSNR, dB"), HasSubstr("HDR-FLIP"),
                                HasSubstr("bright specks"), HasSubstr("darkest region")));
  const Result<ImageMetrics> expected = CompareImages(test, reference, false);
  ASSERT_TRUE(expected.ok());
  const json result = json::parse(ReadText(folder_ / "result.json"));
  ASSERT_EQ(result["frames"].size(), 1u);
  const json& frame = result["frames"][0];
  EXPECT_EQ(frame["test"], folder_ / "test.exr");
  EXPECT_EQ(frame["reference"], folder_ / "reference.exr");
  EXPECT_EQ(frame["width"], 40);
  EXPECT_EQ(frame["height"], 30);
  EXPECT_EQ(frame["display"], false);
  EXPECT_EQ(frame["psnr"], expected->psnr);
  EXPECT_EQ(frame["ssim"], expected->ssim);
  EXPECT_EQ(frame["rel_mse"], expected->rel_mse);
  EXPECT_EQ(frame["flip"], expected->flip);
  EXPECT_EQ(frame["hdr_flip"], expected->hdr_flip);
  EXPECT_EQ(frame["brightness"], expected->brightness);
  EXPECT_EQ(frame["brightness_lowest"], expected->brightness_lowest);
  EXPECT_EQ(frame["brightness_highest"], expected->brightness_highest);
  EXPECT_GT(expected->bright_specks, 0);
  EXPECT_EQ(frame["bright_specks"], expected->bright_specks);
  EXPECT_EQ(frame["dark_specks"], expected->dark_specks);
  EXPECT_EQ(frame["worst_share"], expected->worst_share);
  EXPECT_EQ(frame["non_finite"], 0);
  EXPECT_FALSE(frame.contains("frame"));
  EXPECT_FALSE(frame.contains("temporal_error"));
  EXPECT_FALSE(frame.contains("light_change"));
  EXPECT_EQ(result["mean"]["psnr"], expected->psnr);
  EXPECT_THAT(result["notes"], IsEmpty());
}

// Bytes 51 and 102: a difference of 1/5 in the file.
TEST_F(CliCompare, DisplayPictures) {
  WriteGrey(folder_ / "test.png", 20, 10, 102);
  WriteGrey(folder_ / "reference.png", 20, 10, 51);
  const ProgramRun run =
      RunProgram({"compare", folder_ / "test.png", folder_ / "reference.png", "--json", "-"});
  ExpectSuccess(run);
  const json result = json::parse(run.output);
  EXPECT_EQ(result["frames"][0]["display"], true);
  EXPECT_NEAR(result["frames"][0]["psnr"], -10 * std::log10(0.04), 1e-3);
  EXPECT_FALSE(result["frames"][0].contains("hdr_flip"));
  EXPECT_FALSE(result["mean"].contains("hdr_flip"));
}

TEST_F(CliCompare, EqualPicturesHaveNoFinitePsnr) {
  WriteGrey(folder_ / "a.png", 20, 10, 102);
  const ProgramRun table = RunProgram({"compare", folder_ / "a.png", folder_ / "a.png"});
  ExpectSuccess(table);
  EXPECT_THAT(table.output, HasSubstr(" inf "));
  const ProgramRun run =
      RunProgram({"compare", folder_ / "a.png", folder_ / "a.png", "--json", "-"});
  ExpectSuccess(run);
  EXPECT_TRUE(json::parse(run.output)["mean"]["psnr"].is_null());
}

TEST_F(CliCompare, CountsPixelsThatAreNotFinite) {
  Image3 test = ScenePicture(20, 10);
  WriteLinear(folder_ / "reference.exr", test);
  test[0](3, 3) = std::numeric_limits<float>::quiet_NaN();
  test[1](4, 3) = std::numeric_limits<float>::infinity();
  WriteLinear(folder_ / "test.exr", test);
  const ProgramRun run = RunProgram({"compare", folder_ / "test.exr", folder_ / "reference.exr",
                                     "--json", "-", "--heatmap", folder_ / "maps"});
  ExpectSuccess(run);
  EXPECT_EQ(json::parse(run.output)["frames"][0]["non_finite"], 2);
  // The map marks them in a colour of their own: green.
  const Result<Rgb8Image> map = ReadPng8(folder_ / "maps/flip.png");
  ASSERT_TRUE(map.ok()) << map.status().message();
  const size_t at = 3 * (3 * 20 + 3);
  EXPECT_GT(map->pixels[at + 1], 200);
  EXPECT_LT(map->pixels[at], 50);
}

TEST_F(CliCompare, HeatMapsShowWhereTheErrorIs) {
  const Image3 reference = ConstantPicture(64, 32, {0.5f, 0.5f, 0.5f});
  Image3 test = reference;
  for (int y = 0; y < 32; ++y) {
    for (int x = 48; x < 64; ++x) {
      test[0](x, y) = 5.0f;
    }
  }
  WriteLinear(folder_ / "test.exr", test);
  WriteLinear(folder_ / "reference.exr", reference);
  ExpectSuccess(RunProgram({"compare", folder_ / "test.exr", folder_ / "reference.exr", "--heatmap",
                            folder_ / "new/maps"}));
  for (const char* name : {"new/maps/flip.png", "new/maps/rel_mse.png"}) {
    const Result<Rgb8Image> map = ReadPng8(folder_ / name);
    ASSERT_TRUE(map.ok()) << map.status().message();
    ASSERT_EQ(map->width, 64);
    ASSERT_EQ(map->height, 32);
    const auto brightness = [&map](size_t x, size_t y) {
      const uint8_t* p = &map->pixels[3 * (y * 64 + x)];
      return p[0] + p[1] + p[2];
    };
    EXPECT_EQ(brightness(2, 16), 0) << name;
    EXPECT_GT(brightness(56, 16), 200) << name;
  }
}

// Four frames, of which the reference has three; frames 2 and 3 follow each other, 5 stands alone.
TEST_F(CliCompare, SequencesShareSomeFrames) {
  const Image3 one = ConstantPicture(8, 4, {1, 1, 1});
  const Image3 three = ConstantPicture(8, 4, {3, 3, 3});
  for (const int frame : {1, 2, 3, 5}) {
    WriteLinear(FrameFileName(folder_ / "test.####.exr", frame), frame == 3 ? three : one);
  }
  for (const int frame : {2, 3, 5, 6}) {
    WriteLinear(FrameFileName(folder_ / "reference.%02d.exr", frame), one);
  }
  const ProgramRun run =
      RunProgram({"compare", folder_ / "test.####.exr", folder_ / "reference.%02d.exr", "--json",
                  folder_ / "result.json", "--heatmap", folder_ / "maps"});
  ExpectSuccess(run);
  EXPECT_THAT(run.output, AllOf(HasSubstr("mean"), HasSubstr("motion.X"), HasSubstr("depth.Z")));
  const json result = json::parse(ReadText(folder_ / "result.json"));
  ASSERT_EQ(result["frames"].size(), 3u);
  EXPECT_EQ(result["frames"][0]["frame"], 2);
  EXPECT_EQ(result["frames"][1]["frame"], 3);
  EXPECT_EQ(result["frames"][2]["frame"], 5);
  EXPECT_FALSE(result["frames"][0].contains("temporal_error"));
  EXPECT_NEAR(result["frames"][1]["temporal_error"], 0.25, 1e-9);
  EXPECT_FALSE(result["frames"][2].contains("temporal_error"));
  EXPECT_NEAR(result["mean"]["temporal_error"], 0.25, 1e-9);
  EXPECT_NEAR(result["mean"]["rel_mse"], 4 / 1.01 / 3, 1e-9);
  EXPECT_EQ(result["notes"].size(), 2u);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "maps/flip.0003.png"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "maps/rel_mse.0005.png"));
}

// A picture that moves two pixels right per frame: with the layers that say so there is no temporal
// error where history is visible. An object at half the depth covered the sixth column before.
TEST_F(CliCompare, TemporalErrorFollowsTheLayersOfTheTest) {
  const Image3 before = NoisePicture(12, 5, 1);
  Image3 after = NoisePicture(12, 5, 2);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < 5; ++y) {
      for (int x = 2; x < 12; ++x) {
        after[c](x, y) = before[c](x - 2, y);
      }
      after[c](8, y) = 0;  // was hidden before: must not count
    }
  }
  Image1 motion_x(12, 5), motion_y(12, 5), depth(12, 5), previous_depth(12, 5);
  motion_x.Fill(-2);
  depth.Fill(10);
  previous_depth.Fill(10);
  for (int y = 0; y < 5; ++y) {
    previous_depth(6, y) = 5;
  }
  const auto write = [&](int frame, const Image3& colour, const Image1& depth_layer) {
    ExrImage exr = MakeExr(colour);
    exr.Add("motion.X", PixelType::kFloat, motion_x);
    exr.Add("motion.Y", PixelType::kFloat, motion_y);
    exr.Add("depth.Z", PixelType::kFloat, depth_layer);
    const Status status = WriteExr(FrameFileName(folder_ / "test.#.exr", frame), exr);
    ASSERT_TRUE(status.ok()) << status.message();
    WriteLinear(FrameFileName(folder_ / "reference.#.exr", frame), ConstantPicture(12, 5, {}));
  };
  write(1, before, previous_depth);
  write(2, after, depth);
  const ProgramRun run =
      RunProgram({"compare", folder_ / "test.#.exr", folder_ / "reference.#.exr", "--json", "-"});
  ExpectSuccess(run);
  const json result = json::parse(run.output);
  EXPECT_EQ(result["frames"][1]["temporal_error"], 0);
  EXPECT_THAT(result["notes"], IsEmpty());
}

// The light goes from 0.1 to 0.2 to 0.4 on the curve, then stays; the test makes the first step,
// half of the second, and a step when nothing changes.
TEST_F(CliCompare, LightChangeOfSequences) {
  const auto write = [this](const std::string& name, int frame, float compressed) {
    const float value = compressed / (1 - compressed);
    WriteLinear(FrameFileName(folder_ / name, frame),
                ConstantPicture(24, 16, {value, value, value}));
  };
  const std::vector<float> test = {0.1f, 0.2f, 0.3f, 0.4f};
  const std::vector<float> reference = {0.1f, 0.2f, 0.4f, 0.4f};
  for (size_t i = 0; i < 4; ++i) {
    write("test.#.exr", static_cast<int>(i) + 1, test[i]);
    write("reference.#.exr", static_cast<int>(i) + 1, reference[i]);
  }
  const ProgramRun run = RunProgram({"compare", folder_ / "test.#.exr", folder_ / "reference.#.exr",
                                     "--json", folder_ / "result.json"});
  ExpectSuccess(run);
  const json result = json::parse(ReadText(folder_ / "result.json"));
  EXPECT_FALSE(result["frames"][0].contains("light_change"));
  EXPECT_NEAR(result["frames"][1]["light_change"], 1, 1e-5);
  EXPECT_NEAR(result["frames"][2]["light_change"], 0.5, 1e-5);
  EXPECT_TRUE(result["frames"][3]["light_change"].is_null());
  // The larger step has more weight.
  EXPECT_NEAR(result["mean"]["light_change"], (0.01 + 0.02) / (0.01 + 0.04), 1e-5);
  EXPECT_EQ(result["mean"]["brightness_lowest"], result["mean"]["brightness"]);
  // The second table, of the same frames.
  const std::string details = run.output.substr(run.output.find("\n\n"));
  EXPECT_THAT(details, HasSubstr("      1         0.000       0.000    0.00000        1.00000 "
                                 "         1.00000            -\n"));
  EXPECT_THAT(details, HasSubstr(" 0.50000\n"));
  EXPECT_THAT(details, HasSubstr("\n   mean "));
}

TEST_F(CliCompare, TablesFitTheTerminal) {
  WriteLinear(folder_ / "a.exr", NoisePicture(20, 10, 1, 100.0f));
  WriteLinear(folder_ / "b.exr", NoisePicture(20, 10, 2, 0.1f));
  const ProgramRun run = RunProgram({"compare", folder_ / "a.exr", folder_ / "b.exr"});
  ExpectSuccess(run);
  std::istringstream lines(run.output);
  for (std::string line; std::getline(lines, line);) {
    EXPECT_LE(line.size(), 100u) << line;
  }
}

/// A grey picture of 4x2 pixels, by the brightness of its halves.
Image3 MakeHalves(float left, float right) {
  Image3 colour(4, 2);
  for (Image1& plane : colour.channel) {
    for (int y = 0; y < 2; ++y) {
      for (int x = 0; x < 4; ++x) {
        plane(x, y) = x < 2 ? left : right;
      }
    }
  }
  return colour;
}

/// White; the left half is object 5, the right one 9.
ExrImage MakeObjects(const char* layer) {
  ExrImage exr = MakeExr(MakeHalves(1, 1));
  Channel objects = {layer, PixelType::kFloat, MakeHalves(5, 9)[0], {}};
  if (layer == std::string("id.X")) {  // as stillray writes it
    objects.type = PixelType::kUint32;
    objects.integers = Plane<uint32_t>(4, 2);
    for (int y = 0; y < 2; ++y) {
      for (int x = 0; x < 4; ++x) {
        objects.integers(x, y) = static_cast<uint32_t>(objects.values(x, y));
      }
    }
    objects.values = Image1();
  }
  exr.channels.push_back(std::move(objects));
  return exr;
}

TEST_F(CliCompare, ObjectsShowWhereTheErrorIs) {
  for (const char* layer : {"id.X", "ViewLayer.IndexOB.X"}) {
    ASSERT_TRUE(WriteExr(folder_ / "reference.exr", MakeObjects(layer)).ok());
    WriteLinear(folder_ / "test.exr", MakeHalves(1, 3));
    const ProgramRun run = RunProgram({"compare", folder_ / "test.exr", folder_ / "reference.exr",
                                       "--objects", "auto", "--json", "-"});
    ExpectSuccess(run);
    const json objects = json::parse(run.output)["objects"];
    ASSERT_EQ(objects.size(), 2u) << layer;
    EXPECT_EQ(objects[0]["object"], 9);
    EXPECT_EQ(objects[0]["error"], 1);
    EXPECT_EQ(objects[0]["pixels"], 0.5);
    EXPECT_NEAR(objects[0]["psnr"], -20 * std::log10(0.25), 1e-6);
    EXPECT_NEAR(objects[0]["brightness"], 3, 1e-6);
    EXPECT_EQ(objects[1]["object"], 5);
    EXPECT_EQ(objects[1]["error"], 0);
    EXPECT_TRUE(objects[1]["psnr"].is_null());
  }
  const ProgramRun table = RunProgram({"compare", folder_ / "test.exr", folder_ / "reference.exr",
                                       "--objects", "ViewLayer.IndexOB.X"});
  ExpectSuccess(table);
  EXPECT_THAT(table.output, HasSubstr("         9     50.00   100.00    12.041"));
  ExpectFailure(RunProgram({"compare", folder_ / "test.exr", folder_ / "reference.exr", "--objects",
                            "shape.X"}),
                "--objects shape.X: neither");
  // From other files, of a sequence too.
  WriteLinear(folder_ / "test.0003.exr", MakeHalves(1, 3));
  WriteLinear(folder_ / "reference.0003.exr", MakeHalves(1, 1));
  ASSERT_TRUE(WriteExr(folder_ / "noisy.0003.exr", MakeObjects("id.X")).ok());
  const std::vector<std::string> sequence = {"compare", folder_ / "test.####.exr",
                                             folder_ / "reference.####.exr", "--objects", "auto"};
  const auto with = [&](const std::string& files) {
    std::vector<std::string> arguments = sequence;
    arguments.insert(arguments.end(), {"--objects-of", files});
    return RunProgram(arguments);
  };
  EXPECT_THAT(with(folder_ / "noisy.####.exr").output, HasSubstr("         9     50.00   100.00"));
  ExpectFailure(with(folder_ / "test.####.exr"), "test.0003.exr does not have a layer id.X");
  ExpectFailure(with(folder_ / "none.####.exr"), "none.0003.exr");
  ExpectFailure(RunProgram(sequence), "--objects-of names files that have");
}

TEST_F(CliCompare, FramesChoosesSome) {
  for (int frame = 1; frame <= 5; ++frame) {
    WriteGrey(FrameFileName(folder_ / "a.####.png", frame), 4, 4, 10);
  }
  const auto count = [this](const std::string& frames) {
    const ProgramRun run = RunProgram({"compare", folder_ / "a.####.png", folder_ / "a.####.png",
                                       "--frames", frames, "--json", "-"});
    ExpectSuccess(run);
    return json::parse(run.output)["frames"].size();
  };
  EXPECT_EQ(count("2-4"), 3u);
  EXPECT_EQ(count("5"), 1u);
  EXPECT_EQ(count("4-900"), 2u);
}

TEST_F(CliCompare, BadFrames) {
  WriteGrey(folder_ / "a.0001.png", 4, 4, 10);
  const auto run = [this](const std::string& frames) {
    return RunProgram(
        {"compare", folder_ / "a.####.png", folder_ / "a.####.png", "--frames=" + frames});
  };
  for (const char* text : {"x", "1-", "1-x", "1,2", "-", "1-2-3", "99999999999999999999"}) {
    ExpectFailure(run(text), "expected a frame or a range");
  }
  ExpectFailure(run("3-1"), "lies after the last one");
  ExpectFailure(run("2-9"), "no frame is in both sequences between 2 and 9");
  ExpectFailure(
      RunProgram({"compare", folder_ / "a.0001.png", folder_ / "a.0001.png", "--frames", "1"}),
      "--frames is for sequences");
}

TEST_F(CliCompare, FilesThatCannotBeRead) {
  WriteGrey(folder_ / "a.png", 4, 4, 10);
  std::ofstream(folder_ / "text.png") << "no picture";
  const std::string good = folder_ / "a.png";
  ExpectFailure(RunProgram({"compare", folder_ / "none.png", good}), "none.png: ");
  ExpectFailure(RunProgram({"compare", good, folder_ / "none.exr"}), "none.exr: ");
  ExpectFailure(RunProgram({"compare", folder_ / "text.png", good}), "text.png: ");
  ExpectFailure(RunProgram({"compare", folder_.path(), good}), "compare like with like");
  const std::string png = ReadText(good);
  std::ofstream(folder_ / "cut.png", std::ios::binary) << png.substr(0, png.size() / 2);
  ExpectFailure(RunProgram({"compare", good, folder_ / "cut.png"}), "cut.png: ");
}

TEST_F(CliCompare, PicturesThatDoNotFitEachOther) {
  WriteGrey(folder_ / "a.png", 4, 5, 10);
  WriteGrey(folder_ / "b.png", 5, 4, 10);
  WriteLinear(folder_ / "c.exr", ConstantPicture(4, 5, {1, 1, 1}));
  ExpectFailure(RunProgram({"compare", folder_ / "a.png", folder_ / "b.png"}), "4x5 pixels, but");
  ExpectFailure(RunProgram({"compare", folder_ / "a.png", folder_ / "c.exr"}),
                "cannot be compared");
  ExpectFailure(RunProgram({"compare", folder_ / "a.####.png", folder_ / "a.png"}),
                "compare like with like");
  ExpectFailure(RunProgram({"compare", folder_ / "x.####.png", folder_ / "y.####.png"}),
                "no file matches this pattern");
}

TEST_F(CliCompare, SequencesThatChange) {
  WriteGrey(folder_ / "size.1.png", 4, 4, 10);
  WriteGrey(folder_ / "size.2.png", 4, 5, 10);
  const ProgramRun size =
      RunProgram({"compare", folder_ / "size.#.png", folder_ / "size.#.png", "--json", "-"});
  ExpectFailure(size, "size.2.png: 4x5 pixels, but");
  // The format does not follow from the file's extension.
  WriteGrey(folder_ / "kind.1.png", 4, 4, 10);
  WriteLinear(folder_ / "kind.2.png", ConstantPicture(4, 4, {1, 1, 1}));
  const ProgramRun kind =
      RunProgram({"compare", folder_ / "kind.#.png", folder_ / "kind.#.png", "--json", "-"});
  ExpectFailure(kind, "they are no sequence");
}

TEST_F(CliCompare, NothingFinite) {
  WriteLinear(folder_ / "nan.exr", ConstantPicture(4, 4, {NAN, NAN, NAN}));
  ExpectFailure(RunProgram({"compare", folder_ / "nan.exr", folder_ / "nan.exr"}),
                "nan.exr: no pixel is finite");
}

TEST_F(CliCompare, ResultsThatCannotBeWritten) {
  WriteGrey(folder_ / "a.png", 4, 4, 10);
  const std::string a = folder_ / "a.png";
  ExpectFailure(RunProgram({"compare", a, a, "--json", folder_ / "none/result.json"}),
                "--json " + (folder_ / "none/result.json") + ": could not be written: the folder");
  ExpectFailure(RunProgram({"compare", a, a, "--heatmap", a}), "cannot make the folder");
  const ProgramRun full = RunProgram({"compare", a, a}, "/dev/full");
  EXPECT_EQ(full.exit_code, 2);
  EXPECT_THAT(full.errors, HasSubstr("standard output: could not be written: No space left"));
  const ProgramRun json_full = RunProgram({"compare", a, a, "--json", "/dev/full"});
  EXPECT_EQ(json_full.exit_code, 2);
  EXPECT_THAT(json_full.errors, HasSubstr("No space left"));
}

// A picture whose name holds marks is a picture.
TEST_F(CliCompare, NamesWithMarks) {
  WriteGrey(folder_ / "take#1.png", 4, 4, 10);
  ExpectSuccess(RunProgram({"compare", folder_ / "take#1.png", folder_ / "take#1.png"}));
}

TEST_F(CliCompare, CommandLine) {
  const ProgramRun help = RunProgram({"compare", "--help"});
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_THAT(help.output, AllOf(HasSubstr("Examples:"), HasSubstr("--heatmap")));
  EXPECT_EQ(RunProgram({"compare", "a.png"}).exit_code, 2);
  EXPECT_EQ(RunProgram({"compare", "a.png", "b.png", "--unknown"}).exit_code, 2);
}

}  // namespace
}  // namespace stillray::cli_compare_test
