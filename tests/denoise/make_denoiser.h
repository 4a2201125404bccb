// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A denoiser for tests of which the settings are known to be good.
#pragma once

#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "stillray/denoise.hpp"

namespace stillray::test {

inline Denoiser MakeDenoiser(const Settings& s, Backend backend = Backend::kCpu) {
  Result<Denoiser> made = Denoiser::Create(s, backend);
  EXPECT_TRUE(made.ok()) << made.status().message();
  return std::move(made.value());
}

/// The picture of the last frame.
inline Image3 Denoised(const Settings& settings, const std::vector<Frame>& frames) {
  Denoiser denoiser = MakeDenoiser(settings);
  DenoisedFrame out;
  for (const Frame& frame : frames) {
    const Status status = denoiser.Denoise(frame, &out);
    EXPECT_TRUE(status.ok()) << status.message();
  }
  return std::move(out.colour);
}

}  // namespace stillray::test
