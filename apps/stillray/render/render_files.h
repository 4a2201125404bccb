// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The image files of `stillray render` and their layers. docs/files.md describes them for users.
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

/// Whether this output of the denoiser is a finished image with its own files.
bool IsPictureOutput(const std::string& name);

/// File name pattern of one view: "FOLDER/VIEW.####.EXTENSION".
std::string ViewPattern(const std::string& folder, const std::string& view,
                        const std::string& extension);

/// The denoised image with the layers of --aov, and with motion and depth if there is a reference.
ExrImage DenoisedExr(const RenderOptions& options, const Frame& frame, const DenoisedFrame& out);

/// The noisy frame: total radiance, all signals and all guides.
ExrImage NoisyExr(const RenderOptions& options, const Frame& frame);

/// Planes of a frame required by its files and effects (kLightPlanes, kGuidePlanes); 0: none.
uint32_t PlanesInFiles(const RenderOptions& options);

/// Writes all files of a finished frame; reads only the planes in PlanesInFiles.
/// \param reference  converged image, or nullptr
/// \param display    [out] the denoised display image
/// \param written    [out] paths of the files
Status WriteFrameFiles(const RenderOptions& options, const Frame& frame, const DenoisedFrame& out,
                       const Image3* reference, Rgb8Image* display,
                       std::vector<std::string>* written);

}  // namespace stillray
