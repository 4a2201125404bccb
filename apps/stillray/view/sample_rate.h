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
  double fixed_ms = 0;   ///< part of trace_ms that fewer samples do not save: guides of all pixels
  double total() const { return trace_ms + filter_ms; }
};

/// Keeps the frame time near its target: by samples, and only where even the fewest take too long
/// by resolution, never above the one that the user chose. The same costs give the same decisions.
///
/// Samples fall after two frames in a row that are a tenth late, at once after one that is far too
/// late, and rise after four in which twice as many would have fitted. The resolution falls after
/// four late frames that no rate would have saved (two that are far too late), and rises again
/// after kFramesToGrow frames in which the larger picture would have fitted with room to spare, be
/// it with fewer samples. What has to be taken back at once is tried less and less often, so that
/// neither swings.
class RateControl {
 public:
  /// Parts of the chosen width and height, coarse enough that each is worth a new start.
  static constexpr float kParts[] = {1.0f, 0.71f, 0.5f, 0.35f, 0.25f};

  RateControl() = default;
  RateControl(const SampleRate& rate, float chosen_scale)
      : rate_(rate), chosen_(chosen_scale), part_(0) {}

  const SampleRate& rate() const { return rate_; }
  float scale() const { return chosen_ * kParts[part_]; }
  float chosen_scale() const { return chosen_; }
  void set_rate(const SampleRate& rate) { rate_ = rate; }
  /// \param may_fall  whether the resolution may be less than the chosen one
  void ChooseScale(float scale, bool may_fall);

  /// Takes the cost of a frame made with rate() and scale().
  /// \param target_ms  time that a frame may take, > 0
  void Observe(const FrameCost& cost, double target_ms);

 private:
  /// How often something may be tried: less often each time it had to be taken back soon.
  struct Patience {
    int least;           ///< frames
    int frames = least;  ///< good ones in a row that are needed now
    int since = -1;      ///< frames since the last try; -1: it has proved itself
    void Try() { since = 0; }
    void Age();
    void TakenBack();
  };

  bool LowerRate(const FrameCost& cost, double target_ms);
  void Shrink(const FrameCost& cost, double target_ms);
  bool FitsWhenGrown(const FrameCost& cost, double target_ms, SampleRate* rate) const;
  void JudgeLastFall(const FrameCost& cost);
  void Changed();

  SampleRate rate_{1, 16};
  float chosen_ = 1;
  int part_ = 2;  ///< index into kParts; the first pictures are small, and there at once
  bool may_fall_ = true;
  int over_ = 0;     ///< frames in a row that took too long
  FrameCost least_;  ///< the cheapest of these
  int under_ = 0;    ///< frames in a row that could have had twice the samples
  int roomy_ = 0;    ///< frames in a row in which a larger picture would have fitted
  Patience rise_{4};
  Patience grow_{15};
  // A fall that did not make tracing faster is taken back: what takes the time is something else.
  SampleRate before_fall_;
  double paths_before_fall_ = 0;  ///< ms; 0: no fall is being judged
  int since_fall_ = 0;
  int hold_ = 0;  ///< frames in which samples do not fall
};

}  // namespace stillray::view
