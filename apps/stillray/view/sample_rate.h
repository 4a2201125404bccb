// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// How many samples a pixel gets per frame, and how that follows the time a frame may take.
#pragma once

#include <string>
#include <string_view>

#include "stillray/render.h"
#include "stillray/status.h"

namespace stillray::view {

/// spp / cycle samples per pixel and frame; at least one of the two is 1.
struct SampleRate {
  int spp = 1;    ///< paths per pixel and frame, 1..65536
  int cycle = 1;  ///< frames until every pixel has had a sample, 1..256

  double value() const { return static_cast<double>(spp) / cycle; }
  bool operator==(const SampleRate&) const = default;
};

inline constexpr int kMaxLiveSpp = 64;  ///< more would only make the picture answer late

/// "4", "1/8".
std::string ToText(const SampleRate& rate);
/// Reads "4", "1/8" or "0.125". \return kInvalidArgument: the text and what is allowed
Result<SampleRate> ParseSampleRate(std::string_view text);

/// The next power of two above and below; both stay within 1/256 .. kMaxLiveSpp.
SampleRate Doubled(const SampleRate& rate);
SampleRate Halved(const SampleRate& rate);

/// What a frame cost.
struct FrameCost {
  double trace_ms = 0;
  double filter_ms = 0;  ///< everything that depends on the size of the picture alone
  double total() const { return trace_ms + filter_ms; }
};

/// Keeps the frame time near its target: first by samples, then, if it may, by resolution.
/// The same costs give the same decisions.
class RateControl {
 public:
  /// Resolution scales that it chooses from, coarse enough that each step is worth a new start.
  static constexpr float kScales[] = {0.25f, 0.35f, 0.5f, 0.71f, 1.0f};
  /// Below this rate a smaller picture looks better than fewer samples.
  static constexpr double kSmallestGoodRate = 1.0 / 32;

  RateControl() = default;
  RateControl(const SampleRate& rate, float scale) : rate_(rate), scale_(scale) {}

  const SampleRate& rate() const { return rate_; }
  float scale() const { return scale_; }
  void set_rate(const SampleRate& rate) { rate_ = rate; }
  void set_scale(float scale);

  /// Takes the cost of a frame made with rate() and scale().
  /// \param target_ms   time that a frame may take, > 0
  /// \param auto_scale  whether the resolution may change too
  void Observe(const FrameCost& cost, double target_ms, bool auto_scale);

 private:
  void Slower(const FrameCost& cost, double target_ms, bool auto_scale);
  void Faster(bool auto_scale);
  void JudgeLastFall(const FrameCost& cost);

  SampleRate rate_{1, 16};
  float scale_ = 0.5f;
  int over_ = 0;   ///< frames in a row that took too long
  int under_ = 0;  ///< frames in a row that could have had twice the samples
  int roomy_ = 0;  ///< frames in a row in which a larger picture would have fitted
  // A fall that did not make tracing faster is taken back: what takes the time is something else.
  SampleRate before_fall_;
  double trace_before_fall_ = 0;  ///< 0: no fall is being judged
  int since_fall_ = 0;
  int hold_ = 0;  ///< frames in which samples do not fall
};

}  // namespace stillray::view
