// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A denoiser for tests of which the settings are known to be good.
#pragma once

#include <utility>

#include <gtest/gtest.h>

#include "stillray/denoise.hpp"

namespace stillray::test {

inline Denoiser MakeDenoiser(const Settings& s, Backend backend = Backend::kCpu) {
  Result<Denoiser> made = Denoiser::Create(s, backend);
  EXPECT_TRUE(made.ok()) << made.status().message();
  return std::move(made.value());
}

}  // namespace stillray::test
