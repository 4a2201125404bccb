// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Encoded pictures for tests.
#pragma once

#include <cstdint>
#include <vector>

namespace stillray::test {

/// width x height texels of RGBA that all differ from their neighbours.
std::vector<uint8_t> TestTexels(int width, int height);
std::vector<uint8_t> EncodePng(const std::vector<uint8_t>& rgba, int width, int height);
/// Lossless.
std::vector<uint8_t> EncodeWebp(const std::vector<uint8_t>& rgba, int width, int height);
/// Best quality; alpha is lost.
std::vector<uint8_t> EncodeJpeg(const std::vector<uint8_t>& rgba, int width, int height);

}  // namespace stillray::test
