// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Blends the new samples of vectors of pixels into their history, in separate planes or in place.
#if defined(STILLRAY_DENOISE_SIMD_JOIN_HISTORY_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLRAY_DENOISE_SIMD_JOIN_HISTORY_INL_H_
#undef STILLRAY_DENOISE_SIMD_JOIN_HISTORY_INL_H_
#else
#define STILLRAY_DENOISE_SIMD_JOIN_HISTORY_INL_H_
#endif

#include "denoise/simd/fetch_taps-inl.h"
#include "denoise/simd/join_history.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {

HWY_INLINE VF NewFrameWeight(VF length, VF n, VF least, bool constant_weight) {
  const DF d;
  const VF share = hn::Div(n, hn::Max(hn::Add(length, n), hn::Set(d, 1e-6f)));
  const VF alpha = hn::Min(constant_weight ? least : hn::Max(least, share), hn::Set(d, 1.0f));
  const VF with_history = hn::IfThenElse(hn::Gt(length, hn::Zero(d)), alpha, hn::Set(d, 1.0f));
  return hn::IfThenElseZero(hn::Gt(n, hn::Zero(d)), with_history);
}

/// The smallest weight of a vector of pixels: ConfidentAlpha where the history has a confidence.
template <typename OldOf>
HWY_INLINE VF LeastWeight(const OldOf& old_of, float alpha) {
  if constexpr (OldOf::kHasConfidence) {
    return ConfidentAlpha(hn::Set(DF(), alpha), old_of.confidence);
  } else {
    return hn::Set(DF(), alpha);
  }
}

/// The planes of a history in the order of their slots; nullptr if absent.
struct SlotRows {
  float* row[kHistorySlots];
};

inline SlotRows RowsOf(SignalHistory* history, int y) {
  SlotRows rows;
  const auto row_of = [&](Image1& plane) { return plane.empty() ? nullptr : plane.Row(y); };
  for (int c = 0; c < 3; ++c) {
    rows.row[kColourSlot + c] = row_of(history->colour[c]);
    rows.row[kBehindSlot + c] = row_of(history->behind[c]);
  }
  rows.row[kMeanSlot] = row_of(history->mean);
  rows.row[kVarianceSlot] = row_of(history->variance);
  rows.row[kLengthSlot] = row_of(history->length);
  rows.row[kWeights2Slot] = row_of(history->weights2);
  rows.row[kCompressedSlot] = row_of(history->compressed);
  return rows;
}

/// Blends the new samples with the history of the pixels x, x + 1, ... of row y.
/// \param old_of  returns the previous values of a plane; its Length() those of the history length
/// \param store   receives a slot and a vector of its values
/// \tparam kLimited  whether Joining::limits is given
template <bool kLimited, typename OldOf, typename Store>
HWY_INLINE void JoinOld(const Joining& j, const LightRow& light, bool nothing_new, int x, int y,
                        const OldOf& old_of, const Store& store) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  const AccumulateParameters& p = j.p;
  const SignalHistory& before = j.before;
  const VF n = hn::LoadU(d, light.samples + x);
  const VF old_length = old_of.Length();
  VF length = old_length;
  const VF weights2 = old_of(before.weights2);
  VF ratio = one;
  if constexpr (kLimited) {
    ratio = hn::LoadU(d, j.limits.ratio->Row(y) + x);
    const VF bias = hn::LoadU(d, j.limits.bias->Row(y) + x);
    const VF distrust = hn::MulAdd(hn::Set(d, j.limits.gain), bias, weights2);
    const VF limited = hn::Div(one, hn::Max(distrust, hn::Set(d, 1e-6f)));
    length = hn::IfThenElse(hn::Gt(bias, hn::Zero(d)), hn::Min(length, limited), length);
  }
  const auto corrected = [&](VF old) HWY_ATTR __attribute__((always_inline)) {
    if constexpr (kLimited) {
      return hn::Mul(old, ratio);
    } else {
      return old;
    }
  };
  if (p.max_history > 0) {
    length = hn::Min(
        length, hn::Max(hn::Sub(hn::Set(d, static_cast<float>(p.max_history)), n), hn::Zero(d)));
  }
  const bool constant = p.history_weight_constant != 0;
  const VF alpha = NewFrameWeight(length, n, LeastWeight(old_of, p.alpha_min), constant);
  const VF alpha_moments =
      NewFrameWeight(length, n, LeastWeight(old_of, p.alpha_moments), constant);
  VF colour[3];
  for (int c = 0; c < 3; ++c) {
    colour[c] = nothing_new ? hn::Zero(d) : hn::LoadU(d, light.colour[c] + x);
    const VF old = corrected(old_of(before.colour[c]));
    store(kColourSlot + c, hn::MulAdd(alpha, hn::Sub(colour[c], old), old));
    if (!before.behind.empty()) {
      const VF behind = corrected(old_of(before.behind[c]));
      store(kBehindSlot + c, hn::MulAdd(alpha, hn::Sub(colour[c], behind), behind));
    }
  }
  const VF mean = corrected(old_of(before.mean));
  const VF variance = corrected(corrected(old_of(before.variance)));
  const VF l = colour[0];
  if (j.compressed_scale > 0) {
    VF old = old_of(before.compressed);
    if constexpr (kLimited) {  // ScaledCompressed
      const VF scaled = hn::Mul(old, ratio);
      old = hn::Div(scaled, hn::Max(hn::Add(scaled, hn::Sub(one, old)), hn::Set(d, 1e-30f)));
    }
    const VF light_l = hn::Max(l, hn::Zero(d));
    const VF c = hn::Div(light_l, hn::Add(light_l, hn::Set(d, j.compressed_scale)));
    store(kCompressedSlot, hn::MulAdd(alpha, hn::Sub(c, old), old));
  }
  const VF difference = hn::Sub(l, mean);
  const VF keep = hn::Sub(one, alpha_moments);
  VF mixed = hn::Mul(keep, hn::MulAdd(hn::Mul(alpha_moments, difference), difference, variance));
  if (!j.light.within.empty()) {
    mixed = hn::MulAdd(alpha_moments, hn::LoadU(d, j.light.within.Row(y) + x), mixed);
  }
  const VF keep_light = hn::Sub(one, alpha);
  const MF arrived = hn::Gt(n, hn::Zero(d));
  const VF added = hn::Div(hn::Mul(alpha, alpha), hn::IfThenElse(arrived, n, one));
  const VF new_weights2 = hn::MulAdd(hn::Mul(keep_light, keep_light), weights2, added);
  store(kVarianceSlot, mixed);
  store(kMeanSlot, hn::MulAdd(alpha_moments, difference, mean));
  store(kWeights2Slot, hn::IfThenElse(arrived, new_weights2, weights2));
  store(kLengthSlot, hn::IfThenElse(arrived, hn::Add(length, n), old_length));
}

/// Whether the history is fetched with a confidence.
inline bool HasConfidence(const Joining& j) {
  return j.taps != nullptr && j.taps->confidence != nullptr;
}

/// The history at the pixel itself, without reprojection.
struct OwnHistory : HistoryConfidence<false> {
  const SignalHistory& before;
  int x, y;

  HWY_INLINE VF operator()(const Image1& plane) const { return hn::LoadU(DF(), plane.Row(y) + x); }
  HWY_INLINE VF Length() const { return (*this)(before.length); }
};

/// \tparam kWithConfidence  whether ReprojectionTaps::confidence is given
template <bool kLimited, bool kWithConfidence, typename Store>
HWY_INLINE void JoinVector(const Joining& j, const LightRow& light, bool nothing_new, int x, int y,
                           const Store& store) {
  if (j.taps == nullptr) {
    JoinOld<kLimited>(j, light, nothing_new, x, y, OwnHistory{{}, j.before, x, y}, store);
    return;
  }
  WithHistory<kWithConfidence>(
      j.before, *j.taps, x, y, [&](const auto& old_of) HWY_ATTR __attribute__((always_inline)) {
        JoinOld<kLimited>(j, light, nothing_new, x, y, old_of, store);
      });
}

}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#endif  // include guard
