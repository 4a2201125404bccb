// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The denoiser: one engine with a table of parameters and named presets (EAW, SVGF and extensions
/// of SVGF). It handles frames, not scenes or files.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stillray/frame.h"
#include "stillray/parameter.h"
#include "stillray/status.h"

namespace stillray {

/// The grouping of a frame's signals; each group is filtered separately.
enum class SignalGrouping : int {
  kSplit,            ///< direct diffuse, indirect diffuse, specular
  kDirectIndirect,   ///< as in SVGF: direct and indirect light, diffuse and specular together
  kDiffuseSpecular,  ///< all diffuse light, all specular light
  kSingle,           ///< all light in one signal
  kChannels,         ///< all light, one signal each for red, green and blue
};

/// Storage of the normals of this and the previous frame.
enum class NormalStorage : int {
  kAuto,        ///< kOctahedral on devices with half precision, else kPlain
  kPlain,       ///< three floats
  kOctahedral,  ///< 2 x 16 bits, error at most 0.0037 degrees
};
enum class HistoryWeight : int {
  kConstant,  ///< alpha is alpha_min wherever there is history (SVGF)
  kAge,  ///< alpha is max(alpha_min, n / (n_history + n)): at first the arithmetic mean (PSVGF)
};
enum class HistoryTaps : int {
  kBilinear,  ///< the four pixels around the reprojected position
  kNearest,   ///< the nearest pixel: no blur, but slow motion advances in whole pixels
};
enum class VarianceOf : int {
  kFrame,  ///< variance of a single frame, as in the papers
  kMean,   ///< variance of the accumulated mean: the filter narrows as a static view converges
};
enum class ShortHistory : int {
  kSpatial,  ///< bilateral estimate (SVGF, section 4.2)
  kBlur,     ///< no luminance weight while the history is short (PSVGF, section 4.4.3)
  /// Mean square of the window's second differences along rows and columns, which are insensitive
  /// to gradients (Immerkaer 1996). Below one sample per pixel: kSpatial with 7x7 pixels.
  kSecondDifference,
};
/// The window of the estimates of ShortHistory, in pixels.
enum class ShortHistoryWindow : int { k7x7, k5x5 };
/// Smoothing of the variance that scales the luminance weight, by a 3x3 kernel.
enum class PrefilterVariance : int {
  kOff,
  kOnce,  ///< before the first level: all levels use the smoothed variance (PSVGF, section 4.3)
  kOn,  ///< before every level, for its weights only; the filtered variance is not smoothed (SVGF,
        ///< section 4.4)
};
enum class Wavelet : int {
  kOff,    ///< no spatial filter
  kNaive,  ///< no edge-stopping functions, for comparison
  kEaw,    ///< Gaussians of luminance, normal and depth differences (Dammertz et al. 2010)
  kSvgf,   ///< variance-guided (Schied et al. 2017)
};
enum class Kernel : int { k3x3, k5x5 };
enum class DepthWeight : int {
  kGradient,  ///< |z_p - z_q| relative to the depth gradient at p (SVGF, eq. 3)
  kPlane,     ///< distance of q from the plane through p, relative to its depth
  kPosition,  ///< distance of the points in space, relative to depth; needs Frame::focal_pixels
};
enum class LuminanceWeights : int { kRec709, kRec601 };
enum class LuminanceScale : int {
  kDeviation,  ///< differences are measured in standard deviations
  kVariance,   ///< divided by the variance, as printed in PSVGF: depends on exposure
};
enum class Firefly : int {
  kOff,
  kClamp,     ///< radiance is clamped to the maximum of the eight neighbours
  kCompress,  ///< radiance is filtered on a curve that compresses luminance above 32
};
/// When filtered light becomes history, below one sample per pixel.
enum class FeedbackWhen : int {
  kFrame,   ///< after every frame: pixels without a new sample are blurred repeatedly
  kSample,  ///< after each complete sample per pixel: the image then changes visibly
  kBlend,   ///< as kSample, but blended in until the next complete sample (PSVGF, section 5)
};
enum class Antialias : int {
  kOff,
  kTaa,   ///< temporal, with or without jittered frames
  kAuto,  ///< temporal, from the first frame with nonzero jitter on
};
enum class TaaFilter : int {
  kCatmullRom,
  kSpline,   ///< the cubic B-spline through the pixels
  kSubcell,  ///< a step within each pixel (subcell resolution, Harten 1989), and Catmull-Rom
};
/// The quantity whose history is clamped to the neighbourhood of the current pixel.
enum class TaaClamp : int {
  kPicture,
  kLight,  ///< the image divided by the antialiased albedo
};
enum class Fxaa : int {
  kOff,
  kSparse,  ///< in frames below one sample per pixel, at pixels with fewer than four samples
  kOn,
};
enum class Tonemap : int { kLinear, kReinhard, kFilmic, kAces };

inline constexpr int kMaxLevels = 8;

/// Wavelet step sizes in the order of the levels.
struct StepList {
  int count = 5;
  std::array<int, kMaxLevels> step = {1, 2, 4, 8, 16, 0, 0, 0};
  bool operator==(const StepList&) const = default;
};

/// All parameters of the denoiser. Parameters() has their meaning, unit and range,
/// docs/parameters.md (generated) also the values of the presets; the defaults here are those of
/// the preset "default".
struct Settings {
  bool fill_guides = true;
  NormalStorage normals = NormalStorage::kAuto;
  SignalGrouping signals = SignalGrouping::kSplit;
  bool demodulate = true;
  Firefly firefly = Firefly::kOff;

  bool temporal = true;
  HistoryWeight history_weight = HistoryWeight::kAge;
  float alpha_min = 0.1f;
  float alpha_moments = 0.1f;
  int max_history = 0;
  float history_depth = 0.05f;
  float history_normal = 25.0f;
  bool history_id = true;
  HistoryTaps history_taps = HistoryTaps::kBilinear;
  bool history_search = true;
  bool limit_history = true;
  bool correct_history = true;
  float limit_gain = 12.0f;
  float limit_dead = 4.0f;

  VarianceOf variance_of = VarianceOf::kMean;
  ShortHistory short_history = ShortHistory::kSecondDifference;
  ShortHistoryWindow short_history_window = ShortHistoryWindow::k5x5;
  int short_history_length = 4;
  float short_history_boost = 0.5f;
  PrefilterVariance prefilter_variance = PrefilterVariance::kOn;
  float prefilter_limit = 2.0f;

  Wavelet wavelet = Wavelet::kSvgf;
  Kernel kernel = Kernel::k5x5;
  StepList steps;
  int feedback = 0;
  FeedbackWhen feedback_when = FeedbackWhen::kBlend;
  float sigma_n = 64.0f;
  float curvature = 0.5f;
  DepthWeight depth_weight = DepthWeight::kPlane;
  float sigma_z = 1.0f;
  float plane_tolerance = 0.01f;
  float position_sigma = 0.1f;
  float depth_epsilon = 0.001f;
  float max_slope = 0.0f;
  float sigma_l = 3.0f;
  float luminance_epsilon = 0.0001f;
  float luminance_floor = 0.0f;
  LuminanceWeights luminance = LuminanceWeights::kRec709;
  LuminanceScale luminance_scale = LuminanceScale::kDeviation;
  bool pilot = true;
  float noise_ratio = 1.5f;
  bool wavelet_id = false;
  float eaw_sigma_l = 4.0f;
  float eaw_sigma_n = 0.3f;
  float eaw_sigma_z = 0.05f;
  float clip_outliers = 4.0f;
  bool restore_energy = true;
  float virtual_roughness = 0.1f;
  float virtual_motion_roughness = 0.5f;
  float mirror_roughness = 0.05f;
  bool keep_samples = true;
  bool restore_detail = false;

  Antialias antialias = Antialias::kAuto;
  float taa_alpha = 0.12f;
  float taa_moving_alpha = 0.36f;
  TaaFilter taa_filter = TaaFilter::kSubcell;
  bool taa_extrapolate_motion = true;
  TaaClamp taa_clamp = TaaClamp::kLight;
  bool taa_follow_light = true;
  bool taa_tonemapped = false;
  Fxaa fxaa = Fxaa::kSparse;
  float exposure = 0.0f;
  Tonemap tonemap = Tonemap::kAces;
  float dither = 0.0f;

  bool operator==(const Settings&) const = default;
};

/// The table of parameters, in the order of docs/parameters.md.
std::span<const Parameter> Parameters();

/// Names of the presets: "default", "best", "svgf", "psvgf", "eaw", "temporal".
std::span<const std::string_view> PresetNames();

/// The settings of a preset. \return kInvalidArgument with the list of names for another name
Result<Settings> PresetSettings(std::string_view name);

/// Sets one parameter from text: numbers in decimal, flags on/off/true/false/1/0 (also for choices
/// named on or off), choices by name, steps as "1,2,4".
/// \return kInvalidArgument naming the parameter, the value and the allowed ones; `settings` is
///     then unchanged
Status SetParameter(Settings* settings, std::string_view name, std::string_view value);

/// As SetParameter, from "name=value". \return also kInvalidArgument if there is no '='
Status AssignParameter(Settings* settings, std::string_view assignment);

/// The value as text that SetParameter reads back to the same bits.
/// \return kInvalidArgument for an unknown name
Result<std::string> GetParameter(const Settings& settings, std::string_view name);

/// Checks all parameters.
/// \return kInvalidArgument naming the first parameter that is out of range or contradicts another
Status ValidateSettings(const Settings& settings);

/// The implementation of the stages.
enum class Backend : uint8_t {
  kCpu,        ///< SIMD and threads, with the best instruction set of the machine
  kReference,  ///< scalar, one pixel at a time; the other implementations are tested against it
};

struct StageTime {
  std::string_view name;    ///< of static storage
  double milliseconds = 0;  ///< sum over signals; each wavelet level ("atrous1", ...) is a stage
};

/// An intermediate image, width x height, 1 to 3 channels.
struct NamedImage {
  std::string name;
  std::vector<Image1> channels;
};

class SharedPicture;

/// The forms in which Denoise returns a denoised image. From a device `colour` and `display` are
/// copied to the host: 16 and 4 bytes per pixel.
struct Results {
  bool colour = true;
  bool display = false;
  /// The display image in device memory, without a copy to the host, if the device can share
  /// memory; else as `display`.
  bool shared = false;
};

struct DenoisedFrame {
  /// Scene-linear RGB, width x height: remodulated, with emission and background, antialiased.
  /// Empty if not requested.
  Image3 colour;
  /// ToDisplay of the colour with the settings (exposure, tonemap, dither) and the frame's index:
  /// width * height * 3 bytes. Values of different devices differ by at most 1 of 255. Empty if not
  /// requested.
  std::vector<uint8_t> display;
  /// The display image in device memory (stillray/shared_picture.h); nullptr if not requested, or
  /// if `display` holds it.
  std::shared_ptr<const SharedPicture> shared;
  std::vector<StageTime> timings;  ///< in the order of the pipeline
  std::vector<NamedImage> images;  ///< the images requested with SetOutputs()
  /// Numbers of pixels whose radiance was NaN or infinite (non_finite), or below -1/1024 of the
  /// mean radiance (negative), and was treated as missing, counted per signal; and of pixels with
  /// invalid guides, which are not filtered, or NaN as confidence (bad_guides).
  int64_t non_finite = 0;
  int64_t negative = 0;
  int64_t bad_guides = 0;
  /// One line about a suspicious frame, for example if all normals are zero; usually empty. Frames
  /// on a device are not checked.
  std::string warning;
};

/// Accumulated radiance of later frames, reprojected to this frame's pixels; this frame's own
/// radiance is not included. Made by Denoiser::Accumulate, used by Denoiser::Denoise. Always in
/// host memory, as many may be held, and for use by another device.
class FutureLight {
 public:
  FutureLight();
  FutureLight(FutureLight&&) noexcept;
  FutureLight& operator=(FutureLight&&) noexcept;
  ~FutureLight();

  bool empty() const;
  size_t bytes() const;  ///< memory in use

 private:
  friend class Denoiser;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Motion towards the next frame, in pixels as Guides::motion: the point visible at p is at p +
/// result(p) one frame later. Inverts the next frame's motion, which points back: finds the pixel q
/// of the next frame with q + next_motion(q) = p; of several, the nearest surface by `next_depth`,
/// as it hides the others at p. If there is no such q (the point leaves the image or becomes
/// hidden), p + result(p) lies outside the image. Both images must have the same size.
Image2 ReverseMotion(const Image2& next_motion, const Image1& next_depth);

/// Precision of radiance between stages on a device. The CPU always uses 32 bits.
enum class DevicePrecision : uint8_t {
  kHalf,   ///< 16 bits
  kFloat,  ///< 32 bits: closer to the result of the CPU, with twice the memory
};

/// The device that runs a denoiser's stages: the CPU, or a Vulkan device. Copies refer to the same
/// device; it stays open while a denoiser uses it.
class Device {
 public:
  /// The CPU.
  Device();
  /// \param choice  "auto": a GPU if a usable GPU exists, else the CPU, with the reason in
  ///     remark(); "cpu"; "vulkan": the first usable device, GPUs before software; "vulkan:N"
  /// \return kInvalidArgument for another choice; kNotFound: no such device; kUnsupported: no
  ///     Vulkan, or the device lacks a feature, which is named
  static Result<Device> Open(const std::string& choice);

  bool is_cpu() const;
  /// "cpu", or "vulkan:0: NAME (discrete GPU), DRIVER, ...".
  const std::string& description() const;
  /// Why "auto" chose the CPU; empty otherwise.
  const std::string& remark() const;

 private:
  friend class Denoiser;
  friend Device MakeDevice(std::shared_ptr<class DeviceBackend> backend, std::string description);
  friend std::shared_ptr<class DeviceBackend> BackendOf(const Device& device);
  struct Impl;
  static Result<Device> OpenBest();
  std::shared_ptr<Impl> impl_;
};

/// A Vulkan device of this machine.
struct DeviceDescription {
  std::string choice;  ///< for Device::Open
  std::string name;
  std::string kind;  ///< "discrete GPU", "integrated GPU", "virtual GPU", "software", "other"
  std::string driver;
  uint64_t memory_bytes = 0;
  bool is_gpu = false;
  Status usable;  ///< ok, or the missing feature
};

/// The Vulkan devices of this machine, usable or not.
/// \param remark  set to the reason if Vulkan is not available
std::vector<DeviceDescription> ListDevices(std::string* remark);

/// Memory that a denoiser uses on its device.
struct DeviceMemory {
  uint32_t allocations = 0;
  uint32_t resources = 0;  ///< images and buffers in the allocations
  uint64_t bytes = 0;
  uint64_t largest = 0;  ///< bytes of the largest image or buffer
};

/// Denoises a sequence frame by frame. An object holds the history of one sequence; objects are
/// independent; an object must not be used by two threads at once. Equal frames and settings give
/// equal bits, for any number of threads.
class Denoiser {
 public:
  /// \return kInvalidArgument if the settings are not valid
  static Result<Denoiser> Create(const Settings& settings, Backend backend = Backend::kCpu);
  /// As above, on `device`. Results are bit-exact only on the same device with the same driver, and
  /// equal those of the CPU within the bounds stated in docs/gpu.md. Settings with a stage that
  /// devices lack (`restore_detail`) run on the CPU, with a remark, if the device was chosen by
  /// "auto".
  /// \return kInvalidArgument also for such settings on a device that was chosen by name
  static Result<Denoiser> Create(const Settings& settings, const Device& device,
                                 DevicePrecision precision = DevicePrecision::kHalf);
  Denoiser(Denoiser&&) noexcept;
  Denoiser& operator=(Denoiser&&) noexcept;
  ~Denoiser();

  /// Denoises the next frame. A frame of another size than the last one restarts the history.
  /// Signals are required, and from the second frame on motion, if `temporal` or TAA is on (with
  /// Antialias::kAuto: once a frame was jittered). Without depth or normal the edge-stopping
  /// functions do not depend on it; signals without their albedo are not demodulated.
  /// \return kInvalidArgument naming the image that is missing or has a wrong size (history is then
  ///     unchanged); kOutOfMemory
  Status Denoise(const Frame& frame, DenoisedFrame* out);

  /// As above, with radiance of later frames, accumulated by playing the sequence backward: first
  /// frames and disocclusions become as clean as other pixels. The history itself does not include
  /// the future; `feedback` has no effect.
  /// \return also kInvalidArgument if `future` was made from frames of another size or other
  ///     signals
  Status Denoise(const Frame& frame, const FutureLight& future, DenoisedFrame* out);

  /// Accumulates the frame without filtering: for playing a sequence backward, from its last frame
  /// to its first. Motion (see ReverseMotion), previous normals and confidence, if given, must then
  /// refer to the *next* frame in place of the previous one. `future` is set to the accumulated
  /// radiance of all frames after `frame`. Errors as Denoise.
  Status Accumulate(const Frame& frame, FutureLight* future);

  /// Changes the settings from the next frame on. History is kept, except for the changes in
  /// Parameter::resets_history, and if the denoiser moves from a device to the CPU (see Create).
  /// \return kInvalidArgument if the settings are not valid
  Status SetSettings(const Settings& settings);
  const Settings& settings() const;

  /// Why frames are filtered on the CPU although "auto" chose another device: the error of that
  /// device before the first frame was finished. Usually empty.
  const std::string& remark() const;

  /// Forms in which images are returned from the next frame on; does not affect their pixels.
  void SetResults(const Results& wanted);
  /// The scene-linear image of the last frame, for SetResults without `colour`.
  /// \return kNotFound if no frame was finished, or none since the history was restored
  Status ReadColour(Image3* colour);

  /// Intermediate images to return, by name: see OutputNames().
  /// \return kInvalidArgument naming the unknown output
  Status SetOutputs(const std::vector<std::string>& names);
  /// Names valid for SetOutputs with these settings: "temporal", "atrous1", ..., "disocclusion",
  /// and per signal "variance", "history", ...
  static std::vector<std::string> OutputNames(const Settings& settings);

  /// Discards all history: the next frame is a first frame.
  void Reset();

  /// Bytes of history and working memory in use.
  size_t memory_bytes() const;
  /// The part of memory_bytes() on a device; zero on the CPU.
  DeviceMemory device_memory() const;

  /// The whole history as bytes, to continue a sequence later with the same bits: on the CPU, or on
  /// the same device with the same driver.
  /// \return an error only if reading the device's memory fails
  Result<std::vector<uint8_t>> SaveHistory() const;
  /// Restores a history saved by SaveHistory; settings and outputs are kept.
  /// \return kBadData if `bytes` are damaged, or were saved with another grouping of signals, with
  ///     another DevicePrecision, or on the CPU for a denoiser on a device or vice versa; history
  ///     is then unchanged. Errors of the device; then there is no history
  Status RestoreHistory(std::span<const uint8_t> bytes);

 private:
  struct Impl;
  explicit Denoiser(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Applies exposure (2^EV), the tone curve and sRGB encoding to linear radiance. Returns
/// interleaved 8-bit RGB, rows from the top (width * height * 3 bytes). Curves: docs/denoiser.md.
/// \param dither  amplitude of triangular noise added before rounding, in units of 1/255, which
///     prevents banding in gradients
/// \param frame   seed of the noise
std::vector<uint8_t> ToDisplay(const Image3& colour, float exposure, Tonemap curve,
                               float dither = 0, int64_t frame = 0);

}  // namespace stillray
