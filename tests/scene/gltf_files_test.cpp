// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>

#include "scene/data_uri.h"
#include "scene/gltf_builder.h"
#include "scene/test_pictures.h"

namespace stillray::gltf_files_test {
namespace {

using nlohmann::json;
using test::GltfBuilder;
using test::TemporaryFolder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

/// A scene whose buffer and texture are files named `buffer` and `picture`.
GltfBuilder WithFiles(const std::string& buffer, const std::string& picture) {
  GltfBuilder builder;
  builder.json["buffers"] = {{{"byteLength", 36}, {"uri", buffer}}};
  builder.AddTriangle();
  builder.Add("images", {{"uri", picture}});
  builder.Add("textures", {{"name", "wood"}, {"source", 0}});
  builder.UseMaterial({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
  return builder;
}

std::vector<uint8_t> TriangleBytes() {
  const std::vector<float> positions = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const uint8_t* bytes = reinterpret_cast<const uint8_t*>(positions.data());
  return {bytes, bytes + 36};
}

void ExpectError(const Result<Scene>& scene, StatusCode code,
                 const std::vector<std::string>& parts) {
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.status().code(), code) << scene.status().message();
  for (const std::string& part : parts) {
    EXPECT_THAT(scene.status().message(), HasSubstr(part));
  }
  EXPECT_THAT(scene.status().message(), Not(HasSubstr("\n")));
}

TEST(GltfFiles, BuffersAndPicturesBesideTheScene) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() + "/maps");
  folder.Write("geometry.bin", TriangleBytes());
  folder.Write("maps/a b.png", test::EncodePng(test::TestTexels(2, 2), 2, 2));
  const std::string path =
      folder.Write("scene.gltf", WithFiles("geometry.bin", "maps/a%20b.png").Text());
  const Result<Scene> scene = LoadScene(path);
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  EXPECT_EQ(scene->TriangleCount(), 1u);
  EXPECT_EQ(scene->textures.at(0).texels, test::TestTexels(2, 2));
  EXPECT_EQ(scene->textures.at(0).name, "wood");
  EXPECT_EQ(scene->name, "scene") << "named after the file, for want of a better name";
}

TEST(GltfFiles, AMissingTextureIsOneClearLine) {
  const TemporaryFolder folder;
  folder.Write("geometry.bin", TriangleBytes());
  const std::string path = folder.Write("scene.gltf", WithFiles("geometry.bin", "oak.png").Text());
  ExpectError(LoadGltf(path), StatusCode::kNotFound,
              {path, "texture 'wood' (images[0])", "oak.png: no such file"});
}

TEST(GltfFiles, ADamagedTextureIsNamed) {
  const TemporaryFolder folder;
  folder.Write("geometry.bin", TriangleBytes());
  std::vector<uint8_t> png = test::EncodePng(test::TestTexels(40, 40), 40, 40);
  png[png.size() / 2] ^= 0x55;
  folder.Write("oak.png", png);
  const std::string path = folder.Write("scene.gltf", WithFiles("geometry.bin", "oak.png").Text());
  ExpectError(LoadGltf(path), StatusCode::kBadData,
              {path, "texture 'wood' (images[0]) in oak.png", "damaged PNG"});
}

TEST(GltfFiles, ATextureThatIsNoPictureIsNamed) {
  const TemporaryFolder folder;
  folder.Write("geometry.bin", TriangleBytes());
  folder.Write("oak.png", std::string("<html>404</html>"));
  const std::string path = folder.Write("scene.gltf", WithFiles("geometry.bin", "oak.png").Text());
  ExpectError(LoadGltf(path), StatusCode::kBadData, {"oak.png", "not a PNG, JPEG or WebP picture"});
}

TEST(GltfFiles, AMissingBufferIsNamed) {
  const TemporaryFolder folder;
  const std::string path = folder.Write("scene.gltf", WithFiles("lost.bin", "oak.png").Text());
  ExpectError(LoadGltf(path), StatusCode::kNotFound, {"buffers[0].uri", "lost.bin: no such file"});
}

TEST(GltfFiles, AShortBufferIsNamedWithBothSizes) {
  const TemporaryFolder folder;
  folder.Write("geometry.bin", std::vector<uint8_t>(20, 0));
  const std::string path = folder.Write("scene.gltf", WithFiles("geometry.bin", "x.png").Text());
  ExpectError(LoadGltf(path), StatusCode::kBadData,
              {"buffers[0].byteLength: says 36 bytes, there are 20"});
}

TEST(GltfFiles, PathsMayNotLeaveTheFolder) {
  const TemporaryFolder folder;
  for (const char* uri : {"../secret.bin", "a/../../secret.bin", "/etc/passwd", "%2e%2e/secret.bin",
                          "http://example.com/a.bin", "file:///etc/passwd"}) {
    const std::string path = folder.Write("scene.gltf", WithFiles(uri, "x.png").Text());
    ExpectError(LoadGltf(path), StatusCode::kBadData, {"buffers[0].uri"});
  }
}

TEST(GltfFiles, FromMemoryNothingElseIsReadWithoutAFolder) {
  const GltfBuilder builder = WithFiles("geometry.bin", "x.png");
  ExpectError(builder.Load(), StatusCode::kBadData,
              {"buffers[0].uri", "'geometry.bin' cannot be read"});
}

TEST(GltfFiles, AMissingSceneIsNamed) {
  ExpectError(LoadScene("/no/such/scene.glb"), StatusCode::kNotFound, {"/no/such/scene.glb"});
}

TEST(GltfFiles, OtherFormatsAreNamed) {
  const TemporaryFolder folder;
  const std::string path = folder.Write("a.FBX", "Kaydara FBX Binary");
  const Status status = LoadScene(path).status();
  EXPECT_EQ(status.code(), StatusCode::kUnsupported);
  EXPECT_EQ(status.message(),
            path +
                ": Autodesk FBX files (.fbx) are not read, expected a scene in glTF 2.0 "
                "(.gltf, .glb), Wavefront OBJ (.obj) or builtin:NAME");
  EXPECT_THAT(LoadScene(folder.Write("a.usdz", "PK")).status().message(),
              HasSubstr("OpenUSD files (.usdz) are not read"));
  EXPECT_THAT(LoadScene(folder.Write("a.blend", "BLENDER")).status().message(),
              HasSubstr("Blender files (.blend) are not read"));
  EXPECT_THAT(LoadScene(folder.Write("a.xyz", "1 2 3")).status().message(),
              HasSubstr("files in .xyz are not read"));
  EXPECT_THAT(LoadScene(folder.Write("b", "# a scene")).status().message(),
              HasSubstr("b: files of this kind are not read, expected a scene in glTF 2.0"));
  // Files that are glTF by content or by name get messages of the glTF importer.
  EXPECT_THAT(LoadScene(folder.Write("c.txt", "{}")).status().message(), HasSubstr("asset"));
  EXPECT_THAT(LoadScene(folder.Write("d.gltf", "v 0 0 0")).status().message(), HasSubstr("JSON"));
  EXPECT_THAT(LoadScene("").status().message(), HasSubstr("the scene's name is empty"));
}

TEST(GltfFiles, AFolderIsNoScene) {
  const TemporaryFolder folder;
  ExpectError(LoadGltf(folder.path()), StatusCode::kBadData,
              {folder.path(), "not an ordinary file"});
}

TEST(GltfFiles, NamesOfFilesAreMadePrintable) {
  ExpectError(LoadGltf("/no/such\nscene.glb"), StatusCode::kNotFound, {"/no/such\\nscene.glb"});
}

TEST(GltfFiles, LoadingCanBeStoppedAnywhere) {
  GltfBuilder builder;
  for (int i = 0; i < 20; ++i) {
    builder.AddTriangle();
  }
  const std::vector<uint8_t> bytes = builder.Glb();
  int stopped = 0;
  for (int stop_at = 1;; ++stop_at) {
    std::atomic<int> calls{0};
    const Result<Scene> scene = LoadGltfFromMemory(
        bytes.data(), bytes.size(), "", [&] { return calls.fetch_add(1) + 1 < stop_at; });
    if (scene.ok()) {
      EXPECT_LT(calls, stop_at);
      break;
    }
    ASSERT_EQ(scene.status().code(), StatusCode::kCancelled) << scene.status().message();
    ++stopped;
  }
  // At every step of the import and at every primitive.
  EXPECT_GE(stopped, 20);
}

TEST(GltfFiles, TheChecksumFollowsEveryFile) {
  const TemporaryFolder folder;
  const auto load = [&](const std::vector<uint8_t>& buffer, const std::vector<uint8_t>& picture) {
    folder.Write("geometry.bin", buffer);
    folder.Write("wood.png", picture);
    const std::string text = WithFiles("geometry.bin", "wood.png").Text();
    const Result<Scene> scene =
        LoadGltf(folder.Write("scene.gltf", std::vector<uint8_t>(text.begin(), text.end())));
    EXPECT_TRUE(scene.ok()) << scene.status().message();
    return scene.ok() ? scene->checksum : 0;
  };
  const std::vector<uint8_t> picture = test::EncodePng(test::TestTexels(2, 2), 2, 2);
  const uint64_t first = load(TriangleBytes(), picture);
  EXPECT_NE(first, 0u);
  EXPECT_EQ(load(TriangleBytes(), picture), first);
  std::vector<uint8_t> longer = picture;
  longer.push_back(0);  // behind the end of the picture
  EXPECT_NE(load(TriangleBytes(), longer), first);
  std::vector<uint8_t> other = TriangleBytes();
  other[12] ^= 1;
  EXPECT_NE(load(other, picture), first);
  EXPECT_EQ(MakeBuiltinScene("cornell")->checksum, 0u);
}

TEST(DataUri, DecodesWithAndWithoutPadding) {
  EXPECT_THAT(DecodeDataUri("data:;base64,AAEC").value(), ElementsAre(0, 1, 2));
  EXPECT_THAT(DecodeDataUri("data:a/b;base64,AAE=").value(), ElementsAre(0, 1));
  EXPECT_THAT(DecodeDataUri("data:a/b;base64,AA").value(), ElementsAre(0));
  EXPECT_TRUE(DecodeDataUri("data:;base64,").value().empty());
}

TEST(DataUri, RefusesWhatIsNotBase64) {
  EXPECT_FALSE(DecodeDataUri("data:;base64,A").ok());
  EXPECT_FALSE(DecodeDataUri("data:;base64,A*AA").ok());
  EXPECT_FALSE(DecodeDataUri("data:text/plain,hello").ok());
  EXPECT_FALSE(DecodeDataUri("data:;base64").ok());
}

}  // namespace
}  // namespace stillray::gltf_files_test
