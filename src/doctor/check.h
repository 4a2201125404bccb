// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The interface of the doctor's checks: each check compares every frame with the previous one,
/// accumulates a few statistics, and concludes at the end. Thresholds are declared with their
/// check, beside the values measured on clean and faulty sequences.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "stillray/aov.h"
#include "stillray/doctor.h"
#include "stillray/frame.h"
#include "stillray/io.h"

namespace stillray::doctor {

/// One frame, prepared for the checks.
struct Exhibit {
  int64_t number = 0;
  std::string name;
  const ExrImage* image = nullptr;  ///< of the newest frame only
  const AovLayout* layout = nullptr;
  Frame frame;
  /// Luminance of all noisy radiance divided by its albedo; 0 where missing.
  Image1 light;
};

/// Collects the findings.
class Verdict {
 public:
  explicit Verdict(DoctorReport* report) : report_(report) {}

  void Add(Finding finding) { report_->findings.push_back(std::move(finding)); }
  void Add(Measure measure) { report_->measures.push_back(std::move(measure)); }
  /// Whether there is a finding whose name starts with the prefix.
  bool Has(std::string_view prefix) const {
    return std::any_of(report_->findings.begin(), report_->findings.end(),
                       [&](const Finding& f) { return f.name.starts_with(prefix); });
  }

  /// Whether a measure of that name exceeds its limit, even if that is not reported as a finding.
  bool Exceeds(std::string_view name) const {
    return std::any_of(report_->measures.begin(), report_->measures.end(),
                       [&](const Measure& m) { return m.name == name && m.broken; });
  }

 private:
  DoctorReport* report_;
};

class Check {
 public:
  virtual ~Check() = default;
  /// \param before  the frame with the preceding number, if it exists, has the same size, and is
  ///     neither a copy nor adjacent to a copy; else nullptr
  virtual void Look(const Exhibit& now, const Exhibit* before) = 0;
  virtual void Conclude(Verdict* verdict) = 0;
};

std::unique_ptr<Check> MakeMissingLayersCheck();
std::unique_ptr<Check> MakeDamageCheck();
std::unique_ptr<Check> MakeLossyCheck();
std::unique_ptr<Check> MakeMotionCheck();
std::unique_ptr<Check> MakeStillMotionCheck();
std::unique_ptr<Check> MakeNormalCheck();
std::unique_ptr<Check> MakeCameraSpaceCheck();
std::unique_ptr<Check> MakeDepthValuesCheck();
std::unique_ptr<Check> MakeDepthPlanesCheck();
std::unique_ptr<Check> MakeAlbedoCheck();
std::unique_ptr<Check> MakeSumCheck();
std::unique_ptr<Check> MakeRangeCheck();
std::unique_ptr<Check> MakeExposureCheck();
std::unique_ptr<Check> MakeSeedCheck();
std::unique_ptr<Check> MakeFirstHitCheck();
std::unique_ptr<Check> MakeGuideNoiseCheck();
std::unique_ptr<Check> MakeIdCheck();
std::unique_ptr<Check> MakeVirtualGuidesCheck();
std::unique_ptr<Check> MakeSeenGuidesCheck();

/// The layer's name for messages: "ViewLayer.Vector", "the main picture".
std::string LayerText(const AovLayout& layout, Aov aov);
/// "motion=ViewLayer.Vector,pixels,to_previous,y_down": a value of --aov, without blanks.
std::string MappingText(const AovLayout& layout, Aov aov, const std::string& words);
/// "stillray denoise ... --aov 'MAPPING'"
std::string MappingCure(const std::string& mapping);

/// Mean of Exhibit::light.
double MeanLight(const Exhibit& exhibit);
/// A layer's plane as stored, as float; empty if the layout lacks the layer or component.
Image1 StoredPlane(const Exhibit& exhibit, Aov aov, size_t component);
/// As above, for three components.
Image3 StoredColour(const Exhibit& exhibit, Aov aov);

}  // namespace stillray::doctor
