// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The picture files of `stillray render` and their layers. docs/files.md describes them for users.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "render/render_options.h"
#include "stillray/denoise.hpp"
#include "stillray/frame.h"
#include "stillray/io.h"

namespace stillray {

/// Guides that --aov may add to denoised EXR files.
inline constexpr const char* kGuideNames[] = {
    "motion", "depth",     "normal",   "albedo",    "specular_albedo", "transmission_albedo",
    "id",     "roughness", "emission", "background"};

/// Whether this output of the denoiser is a finished picture with its own files.
bool IsPictureOutput(const std::string& name);

/// "FOLDER/VIEW.####.EXTENSION", the pattern of the files of one view.
std::string ViewPattern(const std::string& folder, const std::string& view,
                        const std::string& extension);

/// The result with the layers of --aov, and with motion and depth if there is a reference.
ExrImage DenoisedExr(const RenderOptions& options, const Frame& frame, const DenoisedFrame& out);

/// The frame as rendered: the sum of all light, every signal, every guide.
ExrImage NoisyExr(const RenderOptions& options, const Frame& frame);

/// Planes of a frame that its files and effects need (kLightPlanes, kGuidePlanes); 0: none.
uint32_t PlanesInFiles(const RenderOptions& options);

/// Writes all files of a finished frame; reads only the planes of PlanesInFiles.
/// \param reference  converged picture, or nullptr
/// \param display    set to the denoised display picture
/// \param written    receives the paths of the files
Status WriteFrameFiles(const RenderOptions& options, const Frame& frame, const DenoisedFrame& out,
                       const Image3* reference, Rgb8Image* display,
                       std::vector<std::string>* written);

}  // namespace stillray
