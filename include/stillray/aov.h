// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Frames of other renderers: which layers of an EXR file hold which light and which guide, under
/// which convention, and the way from there to a Frame and back into the file.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stillray/frame.h"
#include "stillray/io.h"
#include "stillray/status.h"

namespace stillray {

enum class MotionUnit : uint8_t {
  kPixels,
  kFraction,  ///< 1 is the width (x) or height (y) of the picture
  kNdc,       ///< 2 is the width or height: coordinates run from -1 to 1
};
enum class MotionDirection : uint8_t {
  kToPrevious,    ///< place one frame ago minus place now, as in stillray
  kFromPrevious,  ///< place now minus place one frame ago
  kToNext,        ///< place one frame later minus place now; taken for steady motion
  kFromNext,      ///< place now minus place one frame later; taken for steady motion
};

/// What the two numbers of a motion layer mean.
struct MotionConvention {
  MotionUnit unit = MotionUnit::kPixels;
  MotionDirection direction = MotionDirection::kToPrevious;
  bool y_up = false;      ///< positive y points to the top of the picture
  bool jittered = false;  ///< the shift of the sample points between the frames is in it
  float scale = 1;        ///< stored values are multiplied by this first, e.g. 1 / shutter length
};

/// Sample points of this frame and the one before it, pixels from the pixel centre.
struct JitterPair {
  float x = 0;
  float y = 0;
  float previous_x = 0;
  float previous_y = 0;
};

enum class DepthKind : uint8_t {
  kLinear,      ///< distance along the viewing axis
  kRay,         ///< length of the ray; needs `focal`
  kInverse,     ///< 1 / linear; 0 is infinity
  kNormalised,  ///< 0 at `near`, 1 at `far`, linear between
  kProjected,   ///< 0 at `near`, 1 at `far`, as a rasteriser stores it
  kReversed,    ///< 1 at `near`, 0 at `far`, as a rasteriser stores it
};

struct DepthConvention {
  DepthKind kind = DepthKind::kLinear;
  float near = 0;
  float far = std::numeric_limits<float>::infinity();
  float focal = 0;          ///< of kRay: focal length in pixels, principal point in the middle
  float background = 1e9f;  ///< stored values from here on are infinity (kLinear and kRay)
};

struct NormalConvention {
  bool camera_space = false;  ///< turned into world space where the file has worldToCamera
  bool encoded = false;       ///< stored as n / 2 + 1/2
  /// Where our x, y and z stand: 1, 2, 3 for the first, second, third channel, negative for its
  /// opposite.
  std::array<int, 3> axes = {1, 2, 3};
};

/// Motion as Guides wants it: pixels, y down, towards the previous frame, without jitter.
/// \param x, y  planes of one size, as stored
Image2 ConvertMotion(const Image1& x, const Image1& y, const MotionConvention& convention,
                     const JitterPair& jitter);
/// Motion towards the next frame, otherwise as ConvertMotion: the point seen at p stands at
/// p + result(p) one frame later.
/// \param convention  direction kToNext or kFromNext
/// \param jitter  `previous` stands for the next frame
Image2 ConvertNextMotion(const Image1& x, const Image1& y, const MotionConvention& convention,
                         const JitterPair& jitter);
/// Linear depth; +infinity for background. What no camera can see (negative, zero, NaN) stays.
Image1 ConvertDepth(const Image1& depth, const DepthConvention& convention);
/// Unit normals; zero stays zero, NaN stays NaN.
/// \param world_to_camera  rows of the upper 3 x 3 of OpenEXR's worldToCamera (row vectors:
///        camera = world * matrix), or nullptr
Image3 ConvertNormal(const Image3& normal, const NormalConvention& convention,
                     const std::array<float, 9>* world_to_camera);

/// The standard attributes worldToCamera and worldToNDC of an EXR file: rows of 4 x 4 matrices for
/// row vectors, as OpenEXR defines them.
struct CameraMatrices {
  std::array<double, 16> world_to_camera;
  std::array<double, 16> world_to_ndc;
};
/// Empty if one is missing, is not of 16 finite numbers, or worldToCamera has no inverse.
std::optional<CameraMatrices> CameraOf(const ExrImage& image);

/// Where the points seen now stand in the picture of the other camera: at p + result(p), in pixels,
/// right and down. For what does not move by itself. Zero where depth is infinite; points behind
/// the other camera lead out of the picture. Device coordinates run from 0 to 1 from the upper left
/// corner (the standard) or from -1 to 1 with y up, and the camera looks along +z (the standard) or
/// -z; where the viewing axis stands in the picture tells which.
/// \param depth  linear; the size of both pictures
Image2 MotionFromCameras(const Image1& depth, const CameraMatrices& now,
                         const CameraMatrices& other);

/// "pixels, to_previous, y_up": the words that --aov takes.
std::string ConventionText(const MotionConvention& convention);
std::string ConventionText(const DepthConvention& convention);
std::string ConventionText(const NormalConvention& convention);

/// What a layer can serve as.
enum class Aov : uint8_t {
  kColour,  ///< all light
  kResult,  ///< where the denoised light is written; kColour's layer unless there is one
  kAlpha,
  kDepth,
  kNormal,
  kMotion,
  kNextMotion,  ///< towards the next frame, beside kMotion
  kAlbedo,
  kSpecularAlbedo,
  kTransmissionAlbedo,
  kFallbackAlbedo,  ///< of all reflection together; used with kColour alone
  kFallbackNormal,  ///< of the surface that kFallbackAlbedo describes; any axes
  kId,
  kCryptomatte,  ///< id as the bits of a float
  kRoughness,
  kSamples,
  kDirectDiffuse,
  kIndirectDiffuse,
  kDirectSpecular,
  kIndirectSpecular,
  kDirectTransmission,
  kIndirectTransmission,
  kDirectVolume,
  kIndirectVolume,
  kEmission,
  kBackground,
};
inline constexpr int kAovCount = 26;
/// The name on the command line: "colour", "direct_diffuse", ...
const char* AovName(Aov aov);

/// A layer of a file in its role. `channels`: full names, in the order of the components.
struct AovSource {
  Aov aov = Aov::kColour;
  std::string layer;  ///< without its last dot; empty for the main picture
  std::vector<std::string> channels;
};

/// --renderer and --aov as given.
struct AovOptions {
  std::string renderer = "auto";
  std::vector<std::string> mappings;  ///< "normal=MyNormals,encoded", see docs/renderers.md
  /// What stands before the names of the passes ("ViewLayer" in ViewLayer.DiffCol); empty: the view
  /// layer with most passes.
  std::string view_layer = {};
};

/// How the layers of a file were understood; valid for all files with the same channels.
struct AovLayout {
  std::string renderer;
  std::vector<AovSource> sources;
  MotionConvention motion;
  MotionConvention next_motion;
  DepthConvention depth;
  NormalConvention normal;
  /// No layer tells motion; depth and the cameras of both frames do, for what stands still.
  bool motion_from_cameras = false;
  /// Normals are means over several surfaces at edges: guides are antialiased, or noisy.
  bool soft_guides = false;
  bool light_is_divided = false;  ///< light layers are without albedo (Blender)
  bool from_colour = false;       ///< one signal: colour less emission and background
  /// With from_colour and no fallback albedo: what specular albedo counts in the sum of albedos.
  float specular_weight = 1;
  /// The colour was filtered or graded after the passes were written: light is that of the passes
  /// alone, and the colour is where the result goes.
  bool ignores_colour = false;
  /// What light is that the colour holds beyond the passes; kEmission is not filtered.
  Aov rest = Aov::kEmission;
  bool single_layer = false;  ///< the file holds the main picture and no other layer
  std::string view_layer;     ///< as AovOptions::view_layer; the one that serves
  /// View layers with light of their own, which is kept as it is; empty where one was chosen.
  std::vector<std::string> other_view_layers;
  std::vector<std::string> carried;  ///< layers that serve as nothing, and are kept as they are
  std::vector<std::string> notes;    ///< what is missing and what follows from it, one line each

  const AovSource* Find(Aov aov) const;
};

/// Names for AovOptions::renderer: "auto", "blender", ...
std::span<const std::string_view> RendererNames();

/// Finds out what the layers of `image` are. `name` stands for the file in messages.
/// \return kInvalidArgument naming the part of the options that is wrong; kNotFound if there is no
///         light or a layer that was asked for is not there
Result<AovLayout> UnderstandAovs(const ExrImage& image, const AovOptions& options,
                                 const std::string& name);
/// The layout as lines of a table with a heading, and the notes.
std::string AovTable(const AovLayout& layout);

/// New content of the layer that serves as `aov`.
struct NewLayer {
  Aov aov = Aov::kColour;
  Image3 values;
};

/// The pixels of a decoded file as they are stored, kept so that it can be written again without
/// being decompressed again. Takes the bytes of the pixels, uncompressed.
class StoredPixels {
 public:
  StoredPixels();
  StoredPixels(StoredPixels&&) noexcept;
  StoredPixels& operator=(StoredPixels&&) noexcept;
  ~StoredPixels();
  bool empty() const { return impl_ == nullptr; }

  struct Impl;  ///< of the module io

 private:
  friend Result<ExrImage> DecodeExr(const uint8_t* data, size_t size, const std::string& name,
                                    StoredPixels* stored);
  friend Result<std::string> ReplaceLight(const std::string& original, const AovLayout& layout,
                                          const Image3& colour, const std::string& name,
                                          const std::vector<NewLayer>& layers, StoredPixels stored);
  std::unique_ptr<Impl> impl_;
};

/// As DecodeExr in io.h, with the pixels as they are stored besides.
Result<ExrImage> DecodeExr(const uint8_t* data, size_t size, const std::string& name,
                           StoredPixels* stored);

/// What decoding a file would take, from its header alone.
struct ExrExtent {
  int64_t width = 0;  ///< of the display window
  int64_t height = 0;
  int64_t pixels = 0;    ///< of the largest window, data or display
  int64_t channels = 0;  ///< of all parts that are decoded
};
/// \return kBadData if the header is damaged
Result<ExrExtent> MeasureExr(const uint8_t* data, size_t size, const std::string& name);

/// The light of one layer, as it went into a signal of the frame.
struct LightPart {
  Aov aov = Aov::kColour;  ///< kColour: what the colour has and no layer names
  SignalKind kind = SignalKind::kDirectDiffuse;
  Image3 radiance;
  /// The stored colour that the layer is without, where the frame's albedo is not the same.
  Image3 stored_albedo;
};

/// Makes a frame of an image. The light of the frame adds up to the file's colour. Where motion
/// comes from cameras it is zero here: two frames are needed to find it. \param previous_jitter  of
/// the frame before, x and y; only for files with jitter \param parts  if given: of what the
/// signals are made \return kBadData naming the channel that the layout has and the image lacks
Result<Frame> ImportFrame(const ExrImage& image, const AovLayout& layout,
                          std::array<float, 2> previous_jitter, const std::string& name,
                          std::vector<LightPart>* parts = nullptr);

/// Motion towards the next frame (see ConvertNextMotion), for playing a sequence backward. Empty
/// where the file does not tell it: no layer has it, or the layer is zero everywhere, which in
/// Blender stands for "not known" as often as for "still".
/// \param jitter  `previous` stands for the next frame
Image2 ImportNextMotion(const ExrImage& image, const AovLayout& layout, const JitterPair& jitter);

/// The bytes of the EXR file `original` with `colour` in place of the light that the layout's
/// result names (added as channels of the first part if it has none). All other channels, parts,
/// attributes, pixel types, windows and the compression stay; parts that hold the light and are
/// compressed with DWAA or DWAB become ZIP, since their other channels would lose again.
/// \param layers  what else is replaced; those that the layout does not have are left out
/// \param stored  of `original`, or empty: then it is decoded here
/// \return kBadData, kInvalidArgument if sizes differ
Result<std::string> ReplaceLight(const std::string& original, const AovLayout& layout,
                                 const Image3& colour, const std::string& name,
                                 const std::vector<NewLayer>& layers = {},
                                 StoredPixels stored = StoredPixels());

}  // namespace stillray
