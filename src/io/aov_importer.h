// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The conversion of a file's layers to a Frame.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/seen_guides.h"
#include "stillray/aov.h"

namespace stillray::io {

/// Options and further results of an import.
struct ImportExtras {
  std::vector<LightPart>* parts = nullptr;  ///< ImportFrame
  /// The motion of virtual images is left zero: the caller, which has the camera's motion, sets it
  /// (SetImageMotion).
  bool moves_images = false;
  FrameImages* images = nullptr;
  const CameraMatrices* camera = nullptr;  ///< of the frame, if known
  /// 1 minus the confidence of moving pixels, for motion that is computed later; empty if
  /// confidence does not depend on motion.
  Image1* loss_in_motion = nullptr;
};

/// As ImportFrame (aov.h), with more options.
Result<Frame> ImportFrameWith(const ExrImage& image, const AovLayout& layout,
                              std::array<float, 2> previous_jitter, const std::string& name,
                              const ImportExtras& extras);

/// Converts one file to a frame. The functions for radiance are in aov_import_light.cpp.
class Importer {
 public:
  Importer(const ExrImage& image, const AovLayout& layout, const std::string& name,
           const ImportExtras& extras = {})
      : image_(image),
        layout_(layout),
        name_(name),
        parts_(extras.parts),
        moves_images_later_(extras.moves_images),
        images_(extras.images),
        camera_(extras.camera) {
    frame_.width = image.width;
    frame_.height = image.height;
  }

  Result<Frame> Import(std::array<float, 2> previous_jitter);
  /// After Import: MixedLoss, the loss of confidence of moving pixels; empty if there is none.
  Image1 TakeLossInMotion() { return std::move(loss_in_motion_); }
  Image2 NextMotion(const JitterPair& jitter) const;
  NoSeenGuides CheckSeen(bool has_camera);
  NoSeenGuides CheckHits(bool has_camera);
  bool ShowsCurvedImages();

 private:
  Status CheckChannels() const;
  std::optional<Image1> Plane1(Aov aov) const;
  Image1 Values(const std::string& channel) const;
  Image3 Colour(Aov aov) const;
  bool IsLossyLayer(Aov aov) const;
  Image3 Light(Aov aov) const;
  void ImportJitter();
  void ImportFocalLength();
  void ImportGuides(std::array<float, 2> previous_jitter);
  void ImportNormal();
  void ImportId();
  void ImportAlbedo();
  void ImportImages(const JitterPair& jitter);
  void ImportHits(CameraFits* fits, FrameImages* images);
  void ImportSpecularMotion(const JitterPair& jitter);
  std::optional<Lens> LensOfRays(CameraFits* fits) const;
  VirtualGuides VirtualGuidesOf(Aov depth, Aov normal, Aov albedo, Aov motion, Aov id,
                                const JitterPair& jitter) const;
  Plane<uint32_t> Ids(const Channel& channel) const;
  void ImportPasses();
  void ImportVolume();
  void FilterBackground(const Plane<uint8_t>& without_depth);
  void ImportColourAlone();
  void KeepStoredAlbedos();
  bool MayMixGuides() const;
  void CompleteGuides(const Plane<uint8_t>& without_depth);
  void LimitHistories();
  void AddRest();
  void CompleteTransmissionAlbedo();
  Signal& SignalOf(SignalKind kind);
  void KeepPart(Aov aov, SignalKind kind, const Image3& radiance);

  const ExrImage& image_;
  const AovLayout& layout_;
  const std::string& name_;
  std::vector<LightPart>* parts_;  ///< or nullptr
  bool moves_images_later_;        ///< ImportExtras::moves_images
  FrameImages* images_;            ///< or nullptr
  const CameraMatrices* camera_;   ///< or nullptr
  Image3 volume_;                  ///< light of volumes
  Image1 loss_in_motion_;
  Frame frame_;
};

}  // namespace stillray::io
