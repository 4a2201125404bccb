// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stillray/aov.h"

namespace stillray::aov_layout_test {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A picture of 2 x 1 pixels with these channels, all of the value 1.
ExrImage WithChannels(const std::vector<std::string>& names) {
  ExrImage image;
  image.width = 2;
  image.height = 1;
  Image1 ones(2, 1);
  ones.Fill(1);
  for (const std::string& name : names) {
    image.Add(name, PixelType::kFloat, ones);
  }
  return image;
}

void AddLayer(const std::string& layer, const char* letters, std::vector<std::string>* names) {
  for (const char* letter = letters; *letter != '\0'; ++letter) {
    names->push_back(layer + "." + std::string(1, *letter));
  }
}

std::vector<std::string> BlenderChannels(const std::string& prefix, bool renamed) {
  std::vector<std::string> names;
  const std::vector<std::string> old_names = {"DiffDir",  "DiffInd",  "DiffCol",  "GlossDir",
                                              "GlossInd", "GlossCol", "TransDir", "TransInd",
                                              "TransCol", "Emit",     "Env"};
  const std::vector<std::string> new_names = {
      "Diffuse Direct",     "Diffuse Indirect", "Diffuse Color",       "Glossy Direct",
      "Glossy Indirect",    "Glossy Color",     "Transmission Direct", "Transmission Indirect",
      "Transmission Color", "Emission",         "Environment"};
  for (const std::string& layer : renamed ? new_names : old_names) {
    AddLayer(prefix + layer, "RGB", &names);
  }
  AddLayer(prefix + "Combined", "RGBA", &names);
  AddLayer(prefix + "Normal", "XYZ", &names);
  AddLayer(prefix + "Vector", "XYZW", &names);
  names.push_back(prefix + "Depth.Z");
  names.push_back(prefix + (renamed ? "Object Index.X" : "IndexOB.X"));
  AddLayer(prefix + "Mist", "Z", &names);
  return names;
}

Result<AovLayout> Understand(const std::vector<std::string>& names, const AovOptions& options) {
  return UnderstandAovs(WithChannels(names), options, "file");
}

std::string LayerOf(const AovLayout& layout, Aov aov) {
  const AovSource* source = layout.Find(aov);
  return source == nullptr ? "nothing" : source->layer;
}

TEST(AovLayout, BlenderByItsNamesOldAndNew) {
  for (const bool renamed : {false, true}) {
    const Result<AovLayout> layout = Understand(BlenderChannels("View.Layer 1.", renamed), {});
    ASSERT_TRUE(layout.ok()) << layout.status().message();
    EXPECT_EQ(layout->renderer, "blender");
    EXPECT_TRUE(layout->light_is_divided);
    EXPECT_FALSE(layout->from_colour);
    EXPECT_EQ(LayerOf(*layout, Aov::kIndirectTransmission),
              renamed ? "View.Layer 1.Transmission Indirect" : "View.Layer 1.TransInd");
    EXPECT_EQ(LayerOf(*layout, Aov::kResult), "View.Layer 1.Combined");
    EXPECT_THAT(layout->Find(Aov::kMotion)->channels,
                ElementsAre("View.Layer 1.Vector.X", "View.Layer 1.Vector.Y"));
    EXPECT_EQ(ConventionText(layout->motion), "pixels, to_previous, y_up");
    EXPECT_THAT(layout->carried, ElementsAre("View.Layer 1.Mist"));
    EXPECT_THAT(layout->notes, ElementsAre());
  }
}

TEST(AovLayout, FileOutputNodeHasNoViewLayer) {
  std::vector<std::string> names = {"Depth.V", "IndexOB.V"};
  AddLayer("Image", "RGBA", &names);
  AddLayer("Vector", "XYZ", &names);
  AddLayer("Normal", "XYZ", &names);
  AddLayer("Denoising Albedo", "RGB", &names);
  const Result<AovLayout> layout = Understand(names, {"blender", {}});
  ASSERT_TRUE(layout.ok()) << layout.status().message();
  EXPECT_TRUE(layout->from_colour);
  EXPECT_EQ(LayerOf(*layout, Aov::kColour), "Image");
  EXPECT_THAT(layout->Find(Aov::kDepth)->channels, ElementsAre("Depth.V"));
  EXPECT_EQ(LayerOf(*layout, Aov::kFallbackAlbedo), "Denoising Albedo");
  EXPECT_THAT(layout->notes, ElementsAre(HasSubstr("light passes are missing")));
}

TEST(AovLayout, TheAlbedoOfAllReflectionIsOnlyForColourAlone) {
  std::vector<std::string> names = BlenderChannels("V.", false);
  AddLayer("V.Denoising Albedo", "RGB", &names);
  const Result<AovLayout> layout = Understand(names, {});
  ASSERT_TRUE(layout.ok());
  EXPECT_EQ(layout->Find(Aov::kFallbackAlbedo), nullptr);
  EXPECT_THAT(layout->carried, Contains("V.Denoising Albedo"));
}

TEST(AovLayout, TheViewLayerWithMostPassesCounts) {
  std::vector<std::string> names = BlenderChannels("Main.", false);
  AddLayer("Composite.Combined", "RGBA", &names);
  const Result<AovLayout> layout = Understand(names, {});
  ASSERT_TRUE(layout.ok());
  EXPECT_EQ(LayerOf(*layout, Aov::kColour), "Main.Combined");
  EXPECT_THAT(layout->carried, Contains("Composite.Combined"));
}

TEST(AovLayout, AnotherViewLayerCanBeChosen) {
  std::vector<std::string> names = BlenderChannels("Main.", false);
  const std::vector<std::string> more = BlenderChannels("Only Ball.", false);
  names.insert(names.end(), more.begin(), more.end());
  AddLayer("Composite.Combined", "RGBA", &names);
  Result<AovLayout> layout = Understand(names, {});
  ASSERT_TRUE(layout.ok());
  EXPECT_EQ(layout->view_layer, "Main");
  EXPECT_THAT(layout->other_view_layers, ElementsAre("Only Ball"));
  EXPECT_THAT(layout->notes, Contains(HasSubstr("only Main is denoised; Only Ball stays")));

  layout = Understand(names, {"auto", {}, "Only Ball"});
  ASSERT_TRUE(layout.ok());
  EXPECT_EQ(LayerOf(*layout, Aov::kResult), "Only Ball.Combined");
  EXPECT_EQ(LayerOf(*layout, Aov::kDirectDiffuse), "Only Ball.DiffDir");
  EXPECT_EQ(layout->view_layer, "Only Ball");
  EXPECT_THAT(layout->notes, ElementsAre());

  const Status status = Understand(names, {"auto", {}, "only ball"}).status();
  EXPECT_EQ(status.code(), StatusCode::kNotFound);
  EXPECT_THAT(status.message(), HasSubstr("--view-layer is 'only ball', expected one of"));
  EXPECT_THAT(status.message(), HasSubstr("Only Ball"));
}

TEST(AovLayout, APictureWithoutPassesIsNamed) {
  const Result<AovLayout> layout = Understand({"R", "G", "B", "A"}, {});
  ASSERT_TRUE(layout.ok());
  EXPECT_TRUE(layout->single_layer);
  EXPECT_THAT(layout->notes, ElementsAre(HasSubstr("OpenEXR MultiLayer")));
}

TEST(AovLayout, ArnoldAndStillrayAreTold) {
  std::vector<std::string> names = {"R", "G", "B", "A", "Z"};
  AddLayer("diffuse_direct", "RGB", &names);
  AddLayer("diffuse_indirect", "RGB", &names);
  AddLayer("diffuse_albedo", "RGB", &names);
  AddLayer("N", "XYZ", &names);
  Result<AovLayout> layout = Understand(names, {});
  ASSERT_TRUE(layout.ok());
  EXPECT_EQ(layout->renderer, "arnold");
  EXPECT_FALSE(layout->light_is_divided);
  EXPECT_THAT(layout->Find(Aov::kDepth)->channels, ElementsAre("Z"));
  EXPECT_THAT(layout->notes, Contains(HasSubstr("no motion")));

  names = {"R", "G", "B", "depth.Z", "motion.X", "motion.Y"};
  AddLayer("direct_diffuse", "RGB", &names);
  AddLayer("normal", "XYZ", &names);
  layout = Understand(names, {});
  ASSERT_TRUE(layout.ok());
  EXPECT_EQ(layout->renderer, "stillray");
}

TEST(AovLayout, MappingsOverrideNames) {
  std::vector<std::string> names = {"R", "G", "B", "dist"};
  AddLayer("my.nrm", "RGB", &names);
  AddLayer("mv", "RGBA", &names);
  const Result<AovLayout> layout =
      Understand(names, {"blender",
                         {"normal=nrm,encoded,camera,axes=x-zy",
                          "motion=mv,ndc,from_previous,y_down,scale=0.5,channels=BA",
                          "depth=dist,reversed,near=0.1,far=100"}});
  ASSERT_TRUE(layout.ok()) << layout.status().message();
  EXPECT_EQ(LayerOf(*layout, Aov::kNormal), "my.nrm");
  EXPECT_EQ(ConventionText(layout->normal), "camera, encoded, axes=x-zy");
  EXPECT_THAT(layout->Find(Aov::kMotion)->channels, ElementsAre("mv.B", "mv.A"));
  EXPECT_EQ(ConventionText(layout->motion), "ndc, from_previous, y_down, scale=0.5");
  EXPECT_THAT(layout->Find(Aov::kDepth)->channels, ElementsAre("dist"));
  EXPECT_EQ(ConventionText(layout->depth), "reversed, near=0.1, far=100");
  EXPECT_THAT(AovTable(*layout), HasSubstr("my.nrm"));
}

TEST(AovLayout, TheWayToTheNextFrameGoesWithItsMotion) {
  Result<AovLayout> layout = Understand(BlenderChannels("", false), {"blender", {}});
  ASSERT_TRUE(layout.ok());
  EXPECT_THAT(layout->Find(Aov::kNextMotion)->channels, ElementsAre("Vector.Z", "Vector.W"));
  EXPECT_EQ(ConventionText(layout->next_motion), "pixels, from_next, y_up");
  layout = Understand(BlenderChannels("", false), {"blender", {"motion=Vector,y_down"}});
  ASSERT_TRUE(layout.ok());
  EXPECT_EQ(layout->Find(Aov::kNextMotion), nullptr);
  layout =
      Understand(BlenderChannels("", false), {"blender", {"next_motion=Vector,from_previous"}});
  EXPECT_EQ(layout.status().message(),
            "--aov next_motion: its direction is from_previous, expected to_next or from_next");
}

TEST(AovLayout, NoneTakesALayerAway) {
  const Result<AovLayout> layout =
      Understand(BlenderChannels("", false), {"blender", {"motion=none"}});
  ASSERT_TRUE(layout.ok());
  EXPECT_EQ(layout->Find(Aov::kMotion), nullptr);
  EXPECT_THAT(layout->carried, Contains("Vector"));
}

// Of 40 pixels, `count` have a normal of half the length; one has none.
TEST(AovLayout, ShortNormalsTellAntialiasedGuides) {
  const auto soft = [](int count, bool encoded) {
    ExrImage image;
    image.width = 40;
    image.height = 1;
    Image3 normal(40, 1);
    for (int x = 1; x < 40; ++x) {
      normal[2](x, 0) = x <= count ? 0.5f : 1.0f;
    }
    for (int c = 0; c < 3 && encoded; ++c) {
      for (int x = 0; x < 40; ++x) {
        normal[c](x, 0) = 0.5f + 0.5f * normal[c](x, 0);
      }
    }
    Image1 light(40, 1);
    for (const char* name : {"R", "G", "B"}) {
      image.Add(name, PixelType::kFloat, light);
    }
    image.Add("N.", PixelType::kFloat, normal, true);
    const Result<AovLayout> layout =
        UnderstandAovs(image, {"arnold", {encoded ? "normal=N,encoded" : "normal=N"}}, "f");
    EXPECT_TRUE(layout.ok()) << layout.status().message();
    return layout.ok() && layout->soft_guides;
  };
  for (const bool encoded : {false, true}) {
    EXPECT_FALSE(soft(0, encoded));
    EXPECT_TRUE(soft(2, encoded));
  }
}

TEST(AovLayout, WrongOptionsAreNamed) {
  const std::vector<std::string> names = BlenderChannels("", false);
  const auto message = [&](const std::string& mapping) {
    const Result<AovLayout> layout = Understand(names, {"auto", {mapping}});
    return layout.ok() ? "ok" : layout.status().message();
  };
  EXPECT_THAT(message("normals=Normal"), HasSubstr("--aov is 'normals=Normal', expected NAME="));
  EXPECT_THAT(message("normal"), HasSubstr("expected NAME=LAYER"));
  EXPECT_THAT(message("normal=Nrm"), HasSubstr("no layers are called 'Nrm'"));
  EXPECT_THAT(message("normal=Normal,sideways"), HasSubstr("'sideways' is not understood"));
  EXPECT_THAT(message("normal=Normal,axes=xxy"), HasSubstr("axes=xxy"));
  EXPECT_THAT(message("normal=Normal,channels=XY"), HasSubstr("expected 3 letters"));
  EXPECT_THAT(message("normal=Depth"), HasSubstr("has no channels RGB or XYZ"));
  EXPECT_THAT(message("depth=Depth,ray"), HasSubstr("ray needs focal=PIXELS"));
  EXPECT_THAT(message("depth=Depth,projected,near=2,far=1"), HasSubstr("0 < near < far"));
  EXPECT_THAT(message("depth=Depth,normalised,near=1"), HasSubstr("near < far"));
  EXPECT_THAT(message("motion=Vector,scale=-1"), HasSubstr("'scale=-1' is not understood"));
  EXPECT_THAT(message("albedo=DiffCol,encoded"), HasSubstr("'encoded' is not understood"));
  EXPECT_THAT(Understand(names, {"cinema", {}}).status().message(),
              HasSubstr("--renderer is 'cinema', expected one of auto, blender"));
  EXPECT_EQ(Understand({"Depth.Z"}, {}).status().code(), StatusCode::kNotFound);
}

TEST(AovLayout, LightWithoutItsColourIsNotUsed) {
  std::vector<std::string> names;
  AddLayer("DiffDir", "RGB", &names);
  AddLayer("DiffInd", "RGB", &names);
  EXPECT_THAT(Understand(names, {"blender", {}}).status().message(),
              HasSubstr("layer DiffDir is without its colour"));
  AddLayer("Combined", "RGB", &names);
  const Result<AovLayout> layout = Understand(names, {"blender", {}});
  ASSERT_TRUE(layout.ok());
  EXPECT_TRUE(layout->from_colour);
  EXPECT_THAT(layout->notes, Contains(HasSubstr("DiffDir is not used")));
}

TEST(AovLayout, IdsThatNobodyGaveOutAreNotUsed) {
  std::vector<std::string> names = {"R", "G", "B", "CryptoObject00.r"};
  ExrImage image = WithChannels(names);
  image.Add("IndexOB.X", PixelType::kFloat, Image1(2, 1));
  const Result<AovLayout> layout = UnderstandAovs(image, {"blender", {}}, "file");
  ASSERT_TRUE(layout.ok());
  EXPECT_EQ(layout->Find(Aov::kId), nullptr);
  EXPECT_NE(layout->Find(Aov::kCryptomatte), nullptr);
  image.channels[3].type = PixelType::kHalf;
  EXPECT_EQ(UnderstandAovs(image, {"blender", {}}, "file")->Find(Aov::kCryptomatte), nullptr);
}

TEST(AovLayout, CountsOfCyclesNeedTheNumberTheyAreFractionsOf) {
  std::vector<std::string> names = BlenderChannels("View.Layer 1.", false);
  names.push_back("View.Layer 1.Debug Sample Count.X");
  ExrImage image = WithChannels(names);
  for (const char* number : {"", "many", "0", "-4", "16x"}) {
    image.attributes["cycles.View.Layer 1.samples"] = number;
    const Result<AovLayout> layout = UnderstandAovs(image, {}, "file");
    ASSERT_TRUE(layout.ok()) << layout.status().message();
    EXPECT_EQ(layout->Find(Aov::kSamples), nullptr) << number;
    EXPECT_THAT(layout->notes,
                ElementsAre("View.Layer 1.Debug Sample Count is not used: it holds fractions of "
                            "the number of samples, and the file has no attribute "
                            "cycles.View.Layer 1.samples with that number"));
    EXPECT_THAT(layout->carried, Contains("View.Layer 1.Debug Sample Count"));
  }
  image.attributes["cycles.View.Layer 1.samples"] = "16";
  const Result<AovLayout> layout = UnderstandAovs(image, {}, "file");
  ASSERT_TRUE(layout.ok());
  EXPECT_EQ(LayerOf(*layout, Aov::kSamples), "View.Layer 1.Debug Sample Count");
  EXPECT_THAT(layout->notes, ElementsAre());
  EXPECT_EQ(UnderstandAovs(image, {"auto", {"samples=none"}}, "file")->Find(Aov::kSamples),
            nullptr);
}

}  // namespace
}  // namespace stillray::aov_layout_test
