// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Import of other renderers' frames: assigns the layers of an EXR file to signals and guides,
/// converts their conventions to those of Frame, and writes denoised radiance back into the file.
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

/// The unit of stored motion.
enum class MotionUnit : uint8_t {
  kPixels,
  kFraction,  ///< 1 is the width (x) or height (y) of the image
  kNdc,       ///< 2 is the width or height: coordinates run from -1 to 1
};
/// The sign of stored motion, and the frame to which it refers.
enum class MotionDirection : uint8_t {
  kToPrevious,    ///< position one frame ago minus position now, as in Guides::motion
  kFromPrevious,  ///< position now minus position one frame ago
  kToNext,        ///< position one frame later minus position now; assumes steady motion
  kFromNext,      ///< position now minus position one frame later; assumes steady motion
};

/// The convention of a motion layer.
struct MotionConvention {
  MotionUnit unit = MotionUnit::kPixels;
  MotionDirection direction = MotionDirection::kToPrevious;
  bool y_up = false;      ///< positive y points to the top of the image
  bool jittered = false;  ///< includes the difference of both frames' jitter
  float scale = 1;        ///< factor of the stored values, e.g. 1 / shutter length
};

/// Sample positions of this and the previous frame, pixels from the pixel centre.
struct JitterPair {
  float x = 0;
  float y = 0;
  float previous_x = 0;
  float previous_y = 0;
};

/// The meaning of stored depth.
enum class DepthKind : uint8_t {
  kLinear,      ///< distance along the viewing axis, as in Guides::depth
  kRay,         ///< distance along the pixel's ray; needs `focal`
  kInverse,     ///< 1 / linear; 0 is infinity
  kNormalised,  ///< 0 at `near`, 1 at `far`, linear between
  kProjected,   ///< 0 at `near`, 1 at `far`, as a rasteriser stores it
  kReversed,    ///< 1 at `near`, 0 at `far`, as a rasteriser stores it
};

/// The convention of a depth layer.
struct DepthConvention {
  DepthKind kind = DepthKind::kLinear;
  float near = 0;  ///< clipping planes in scene units, of kNormalised, kProjected and kReversed
  float far = std::numeric_limits<float>::infinity();
  float focal = 0;  ///< of kRay: focal length in pixels; the principal point is the image centre
  float background = 1e9f;  ///< stored values >= this are infinity (kLinear and kRay)
};

/// The convention of a normal layer.
struct NormalConvention {
  bool camera_space = false;  ///< rotated to world space if the file has worldToCamera
  bool encoded = false;       ///< stored as n / 2 + 1/2
  /// The channels of x, y and z: 1, 2 or 3 for the first, second or third channel, negative for the
  /// opposite direction.
  std::array<int, 3> axes = {1, 2, 3};
};

/// Converts motion to the convention of Guides::motion: pixels, y down, towards the previous frame,
/// without jitter.
/// \param x, y  planes of one size, as stored
Image2 ConvertMotion(const Image1& x, const Image1& y, const MotionConvention& convention,
                     const JitterPair& jitter);
/// Converts motion as ConvertMotion does, but towards the next frame: the point visible at p is at
/// p + result(p) one frame later.
/// \param convention  direction kToNext or kFromNext
/// \param jitter      previous_x and previous_y hold the jitter of the next frame
Image2 ConvertNextMotion(const Image1& x, const Image1& y, const MotionConvention& convention,
                         const JitterPair& jitter);
/// Converts to linear view-space depth in scene units; +infinity for background. Invalid values
/// (negative, zero, NaN) are kept.
Image1 ConvertDepth(const Image1& depth, const DepthConvention& convention);
/// Converts to hit distances in scene units: +infinity for the sky; 0 for a missing hit, stored as
/// a negative value, NaN, or (unless inverse) zero.
/// \param convention  kLinear, kInverse or kNormalised
Image1 ConvertHitDistance(const Image1& hits, const DepthConvention& convention);
/// Converts to unit normals, in world space if `world_to_camera` is given; zero stays zero, NaN
/// stays NaN.
/// \param world_to_camera  rows of the upper 3 x 3 of OpenEXR's worldToCamera (row vectors:
///        camera = world * matrix), or nullptr
Image3 ConvertNormal(const Image3& normal, const NormalConvention& convention,
                     const std::array<float, 9>* world_to_camera);

/// The camera in OpenEXR's standard attributes worldToCamera and worldToNDC. Empty if an attribute
/// is missing or does not hold 16 finite numbers, or if worldToCamera has no inverse.
std::optional<CameraMatrices> CameraOf(const ExrImage& image);

/// "pixels, to_previous, y_up": the convention in the syntax of --aov.
std::string ConventionText(const MotionConvention& convention);
std::string ConventionText(const DepthConvention& convention);
std::string ConventionText(const NormalConvention& convention);

/// The roles of layers (AOV: arbitrary output variable).
enum class Aov : uint8_t {
  kColour,  ///< radiance of all light
  kResult,  ///< destination of the denoised radiance; kColour's layer by default
  kAlpha,
  kDepth,
  kNormal,
  kPreviousNormal,  ///< Guides::previous_normal; in the axes of kNormal, always in world space
  kMotion,
  kNextMotion,  ///< towards the next frame, in addition to kMotion
  kAlbedo,
  kSpecularAlbedo,
  kTransmissionAlbedo,
  kFallbackAlbedo,  ///< diffuse plus specular; used if the file has kColour and no light layers
  kFallbackNormal,  ///< of the surface of kFallbackAlbedo; any axes
  // Guides of the first rough surface after mirrors and glass, as in Cycles' Denoising Data.
  kSeenDepth,       ///< length of the path to that surface
  kSeenNormal,      ///< any axes
  kSeenAlbedo,      ///< times path throughput
  kHitDistance,     ///< length of the reflected ray from the first surface to its hit point
  kSpecularMotion,  ///< of the virtual image in mirrors
  // The members of VirtualGuides.
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

/// A layer of a file and its role. `channels`: full names, in the order of the components (r, g, b;
/// x, y, z).
struct AovSource {
  Aov aov = Aov::kColour;
  std::string layer;  ///< without the last dot; empty for the main image
  std::vector<std::string> channels;
};

/// The options --renderer and --aov, as text.
struct AovOptions {
  std::string renderer = "auto";
  std::vector<std::string> mappings;  ///< "normal=MyNormals,encoded", see docs/renderers.md
  /// The prefix of the passes' names ("ViewLayer" in ViewLayer.DiffCol); empty: the view layer with
  /// the most passes.
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
  DepthConvention hit_distance;  ///< kLinear, kInverse or kNormalised
  NormalConvention normal;
  /// There is no motion layer; the motion of static surfaces is computed from depth and the cameras
  /// of both frames.
  bool motion_from_cameras = false;
  /// Reflections in convex surfaces are reprojected by the motion of the virtual image, whose depth
  /// is estimated from the curvature of the surface.
  bool curved_images = false;
  /// Guides are antialiased or noisy: normals at edges are averages over several surfaces.
  bool soft_guides = false;
  bool light_is_divided = false;  ///< light layers are already divided by albedo (Blender)
  bool from_colour = false;       ///< one signal: colour minus emission and background
  /// With from_colour and no fallback albedo: the weight of specular albedo in the sum of albedos.
  float specular_weight = 1;
  /// The colour was filtered or graded after the passes were written: light comes from the passes
  /// alone, and the result replaces the colour.
  bool ignores_colour = false;
  /// The role of the remainder: colour minus the sum of the passes. kEmission is not filtered.
  Aov rest = Aov::kEmission;
  /// Samples per pixel of a frame if no layer has the role kSamples.
  int samples = 1;
  bool single_layer = false;  ///< the file has the main image and no other layer
  std::string view_layer;     ///< the view layer in use; see AovOptions::view_layer
  /// Other view layers with light, which are copied unchanged; empty if a view layer was chosen.
  std::vector<std::string> other_view_layers;
  /// The channel of Signal::second_moment of each SignalKind; empty: none. Copied unchanged.
  std::array<std::string, kSignalKindCount> second_moments;
  std::vector<std::string> carried;  ///< layers without a role, copied unchanged
  std::vector<std::string> notes;    ///< missing layers and the consequences, one line each

  /// The layer with this role; nullptr if there is none.
  const AovSource* Find(Aov aov) const;
};

/// Names for AovOptions::renderer: "auto", "blender", ...
std::span<const std::string_view> RendererNames();

/// Assigns roles to the layers of `image`.
/// \param name  of the file, for messages
/// \return kInvalidArgument naming the invalid option; kNotFound if the file has no light layer, or
///     if a requested layer is missing
Result<AovLayout> UnderstandAovs(const ExrImage& image, const AovOptions& options,
                                 const std::string& name);
/// The layout as text: a table with a heading, and the notes.
std::string AovTable(const AovLayout& layout);

/// New pixels of the layer with the role `aov`.
struct NewLayer {
  Aov aov = Aov::kColour;
  Image3 values;  ///< alpha: the first plane only
};

/// The pixels of a decoded file as stored, so that ReplaceLight need not decode the file again.
/// Takes the memory of the uncompressed pixels.
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

/// As DecodeExr in io.h; also sets `*stored` to the pixels as stored.
Result<ExrImage> DecodeExr(const uint8_t* data, size_t size, const std::string& name,
                           StoredPixels* stored);

/// The sizes that determine the cost of decoding a file, read from its header alone.
struct ExrExtent {
  int64_t width = 0;  ///< of the display window
  int64_t height = 0;
  int64_t pixels = 0;    ///< of the largest window, data or display
  int64_t channels = 0;  ///< of all parts that are decoded
};
/// \return kBadData if the header is damaged
Result<ExrExtent> MeasureExr(const uint8_t* data, size_t size, const std::string& name);

/// The radiance of one layer, a summand of a signal of the frame.
struct LightPart {
  Aov aov = Aov::kColour;  ///< kColour: the remainder, see AovLayout::rest
  SignalKind kind = SignalKind::kDirectDiffuse;
  Image3 radiance;
  /// The stored albedo that divides the layer, if it differs from the frame's albedo; else empty.
  Image3 stored_albedo;
};

/// Converts an image to a frame whose signals, emission and background sum to the file's colour.
/// With AovLayout::motion_from_cameras motion is zero here, as it needs two frames.
/// \param previous_jitter  of the previous frame, x and y in pixels; only for files with jitter
/// \param parts            [out] optional: the layers of each signal
/// \return kBadData naming a channel of the layout that the image lacks
Result<Frame> ImportFrame(const ExrImage& image, const AovLayout& layout,
                          std::array<float, 2> previous_jitter, const std::string& name,
                          std::vector<LightPart>* parts = nullptr);

/// Motion towards the next frame (see ConvertNextMotion), for playing a sequence backward. Empty if
/// there is no such layer, or if the layer is zero everywhere, which in Blender means "unknown" as
/// often as "static".
/// \param jitter  previous_x and previous_y hold the jitter of the next frame
Image2 ImportNextMotion(const ExrImage& image, const AovLayout& layout, const JitterPair& jitter);

/// Encodes the EXR file `original` with `colour` in the channels of the layout's kResult, or in new
/// channels of the first part. All other channels, parts, attributes, pixel types, windows and the
/// compression are kept; except that the parts with these channels become ZIP if they were DWAA or
/// DWAB, since lossy compression would degrade their other channels a second time.
/// \param layers  other layers to replace; roles that are not in the layout are ignored
/// \param stored  pixels of `original` by DecodeExr; empty: `original` is decoded here
/// \return kBadData; kInvalidArgument if sizes differ
Result<std::string> ReplaceLight(const std::string& original, const AovLayout& layout,
                                 const Image3& colour, const std::string& name,
                                 const std::vector<NewLayer>& layers = {},
                                 StoredPixels stored = StoredPixels());

}  // namespace stillray
