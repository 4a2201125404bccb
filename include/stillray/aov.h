// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Frames of other renderers: assigns the layers of an EXR file to light and guides, converts their
/// conventions to those of Frame, and writes denoised light back into the file.
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

#include "stillray/camera.h"
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
  kToPrevious,    ///< position one frame ago minus position now, as in stillray
  kFromPrevious,  ///< position now minus position one frame ago
  kToNext,        ///< position one frame later minus position now; assumes steady motion
  kFromNext,      ///< position now minus position one frame later; assumes steady motion
};

/// The convention of a motion layer.
struct MotionConvention {
  MotionUnit unit = MotionUnit::kPixels;
  MotionDirection direction = MotionDirection::kToPrevious;
  bool y_up = false;      ///< positive y points to the top of the picture
  bool jittered = false;  ///< includes the difference of the frames' jitter
  float scale = 1;        ///< multiplies stored values first, e.g. 1 / shutter length
};

/// Sample positions of this and the previous frame, pixels from the pixel centre.
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
  float background = 1e9f;  ///< stored values >= this are infinity (kLinear and kRay)
};

struct NormalConvention {
  bool camera_space = false;  ///< rotated to world space if the file has worldToCamera
  bool encoded = false;       ///< stored as n / 2 + 1/2
  /// The channels that hold x, y and z: 1, 2, 3 for the first, second, third, negative for the
  /// opposite direction.
  std::array<int, 3> axes = {1, 2, 3};
};

/// Converts motion to the convention of Guides: pixels, y down, towards the previous frame, without
/// jitter.
/// \param x, y  planes of one size, as stored
Image2 ConvertMotion(const Image1& x, const Image1& y, const MotionConvention& convention,
                     const JitterPair& jitter);
/// Motion towards the next frame, otherwise as ConvertMotion: the point seen at p is at p +
/// result(p) one frame later.
/// \param convention  direction kToNext or kFromNext
/// \param jitter      `previous` is that of the next frame
Image2 ConvertNextMotion(const Image1& x, const Image1& y, const MotionConvention& convention,
                         const JitterPair& jitter);
/// Linear depth; +infinity for background. Invalid values (negative, zero, NaN) are kept.
Image1 ConvertDepth(const Image1& depth, const DepthConvention& convention);
/// Hit distances, 0 where there is none: negative, zero, NaN. +infinity for the sky.
/// \param convention  linear, inverse or normalised
Image1 ConvertHitDistance(const Image1& hits, const DepthConvention& convention);
/// Unit normals; zero stays zero, NaN stays NaN.
/// \param world_to_camera  rows of the upper 3 x 3 of OpenEXR's worldToCamera (row vectors:
///        camera = world * matrix), or nullptr
Image3 ConvertNormal(const Image3& normal, const NormalConvention& convention,
                     const std::array<float, 9>* world_to_camera);

/// The camera of the standard attributes. Empty if one is missing, is not of 16 finite numbers, or
/// worldToCamera has no inverse.
std::optional<CameraMatrices> CameraOf(const ExrImage& image);

/// "pixels, to_previous, y_up": in the words of --aov.
std::string ConventionText(const MotionConvention& convention);
std::string ConventionText(const DepthConvention& convention);
std::string ConventionText(const NormalConvention& convention);

/// The roles of layers: arbitrary output variables.
enum class Aov : uint8_t {
  kColour,  ///< all light
  kResult,  ///< destination of the denoised light; kColour's layer by default
  kAlpha,
  kDepth,
  kNormal,
  kPreviousNormal,  ///< Guides::previous_normal; in the axes of kNormal, always in world space
  kMotion,
  kNextMotion,  ///< towards the next frame, in addition to kMotion
  kAlbedo,
  kSpecularAlbedo,
  kTransmissionAlbedo,
  kFallbackAlbedo,  ///< of all reflection; used with kColour alone
  kFallbackNormal,  ///< of the surface that kFallbackAlbedo belongs to; any axes
  // Of the first rough surface behind mirrors and glass; as Cycles' Denoising Data.
  kSeenDepth,       ///< length of the path to it
  kSeenNormal,      ///< any axes
  kSeenAlbedo,      ///< times the throughput of the path
  kHitDistance,     ///< length of the reflected ray from the first surface to what it met
  kSpecularMotion,  ///< of what mirrors show
  // VirtualGuides.
  kReflectionDepth,
  kReflectionNormal,
  kReflectionAlbedo,
  kReflectionMotion,
  kReflectionId,
  kRefractionDepth,
  kRefractionNormal,
  kRefractionAlbedo,
  kRefractionMotion,
  kRefractionId,
  kId,
  kCryptomatte,  ///< id as the bits of a float
  kRoughness,
  kSamples,
  kConfidence,  ///< Frame::confidence
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
inline constexpr int kAovCount = 43;
/// The name on the command line: "colour", "direct_diffuse", ...
const char* AovName(Aov aov);

/// A layer of a file and its role. `channels`: full names, in the order of the components.
struct AovSource {
  Aov aov = Aov::kColour;
  std::string layer;  ///< without the last dot; empty for the main picture
  std::vector<std::string> channels;
};

/// --renderer and --aov as given.
struct AovOptions {
  std::string renderer = "auto";
  std::vector<std::string> mappings;  ///< "normal=MyNormals,encoded", see docs/renderers.md
  /// The prefix of the passes' names ("ViewLayer" in ViewLayer.DiffCol); empty: the view layer with
  /// most passes.
  std::string view_layer = {};
};

/// The roles of all layers of a file; valid for all files with the same channels.
struct AovLayout {
  std::string renderer;
  std::vector<AovSource> sources;
  MotionConvention motion;
  MotionConvention next_motion;
  MotionConvention specular_motion;
  DepthConvention depth;
  DepthConvention hit_distance;  ///< linear, inverse or normalised; `focal` of the frame
  NormalConvention normal;
  /// There is no motion layer; motion of still surfaces follows from depth and the cameras of both
  /// frames.
  bool motion_from_cameras = false;
  /// Reflections in convex surfaces follow the motion of the image that their shape gives.
  bool curved_images = false;
  /// Normals at edges are means over several surfaces: guides are antialiased, or noisy.
  bool soft_guides = false;
  bool light_is_divided = false;  ///< light layers are without albedo (Blender)
  bool from_colour = false;       ///< one signal: colour minus emission and background
  /// With from_colour and no fallback albedo: the weight of specular albedo in the sum of albedos.
  float specular_weight = 1;
  /// The colour was filtered or graded after the passes were written: light comes from the passes
  /// alone, and the result replaces the colour.
  bool ignores_colour = false;
  /// The kind of the light that the colour holds beyond the passes; kEmission is not filtered.
  Aov rest = Aov::kEmission;
  /// The number of samples of every pixel of a frame, where no layer holds it.
  int samples = 1;
  bool single_layer = false;  ///< the file holds the main picture and no other layer
  std::string view_layer;     ///< as AovOptions::view_layer; the one in use
  /// Other view layers with light, which are copied unchanged; empty if a view layer was chosen.
  std::vector<std::string> other_view_layers;
  /// By SignalKind: the channel of Signal::second_moment; empty: none. Copied unchanged.
  std::array<std::string, kSignalKindCount> second_moments;
  std::vector<std::string> carried;  ///< layers without a role, copied unchanged
  std::vector<std::string> notes;    ///< missing layers and the consequences, one line each

  const AovSource* Find(Aov aov) const;
};

/// Names for AovOptions::renderer: "auto", "blender", ...
std::span<const std::string_view> RendererNames();

/// Assigns roles to the layers of `image`.
/// \param name  of the file, for messages
/// \return kInvalidArgument naming the wrong part of the options; kNotFound if there is no light or
///     if a requested layer is missing
Result<AovLayout> UnderstandAovs(const ExrImage& image, const AovOptions& options,
                                 const std::string& name);
/// The layout as a table with a heading, and the notes.
std::string AovTable(const AovLayout& layout);

/// New content of the layer that serves as `aov`.
struct NewLayer {
  Aov aov = Aov::kColour;
  Image3 values;  ///< of alpha: the first plane
};

/// The pixels of a decoded file as stored, so that it can be written again without decoding it
/// again. Takes the size of the uncompressed pixels.
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

/// As DecodeExr in io.h, and also returns the pixels as stored.
Result<ExrImage> DecodeExr(const uint8_t* data, size_t size, const std::string& name,
                           StoredPixels* stored);

/// The cost of decoding a file, from its header alone.
struct ExrExtent {
  int64_t width = 0;  ///< of the display window
  int64_t height = 0;
  int64_t pixels = 0;    ///< of the largest window, data or display
  int64_t channels = 0;  ///< of all parts that are decoded
};
/// \return kBadData if the header is damaged
Result<ExrExtent> MeasureExr(const uint8_t* data, size_t size, const std::string& name);

/// The light of one layer that went into a signal of the frame.
struct LightPart {
  Aov aov = Aov::kColour;  ///< kColour: light that the colour has and no layer holds
  SignalKind kind = SignalKind::kDirectDiffuse;
  Image3 radiance;
  /// The stored colour that divides the layer, if it differs from the frame's albedo.
  Image3 stored_albedo;
};

/// Converts an image to a frame whose light adds up to the file's colour. Motion that comes from
/// cameras is zero here, as it needs two frames.
/// \param previous_jitter  of the previous frame, x and y; only for files with jitter
/// \param parts            optional: the layers of each signal
/// \return kBadData naming a channel of the layout that the image lacks
Result<Frame> ImportFrame(const ExrImage& image, const AovLayout& layout,
                          std::array<float, 2> previous_jitter, const std::string& name,
                          std::vector<LightPart>* parts = nullptr);

/// Motion towards the next frame (see ConvertNextMotion), for playing a sequence backward. Empty if
/// no layer has it, or if the layer is zero everywhere, which in Blender means "unknown" as often
/// as "still".
/// \param jitter  `previous` is that of the next frame
Image2 ImportNextMotion(const ExrImage& image, const AovLayout& layout, const JitterPair& jitter);

/// Encodes the EXR file `original` with its light replaced by `colour`: the channels of the
/// layout's result, or new channels of the first part. All other channels, parts, attributes, pixel
/// types, windows and the compression are kept; but parts with the light that are compressed with
/// DWAA or DWAB become ZIP, since their other channels would lose again.
/// \param layers  other layers to replace; those that are not in the layout are ignored
/// \param stored  pixels of `original`; empty: decoded here
/// \return kBadData; kInvalidArgument if sizes differ
Result<std::string> ReplaceLight(const std::string& original, const AovLayout& layout,
                                 const Image3& colour, const std::string& name,
                                 const std::vector<NewLayer>& layers = {},
                                 StoredPixels stored = StoredPixels());

}  // namespace stillray
