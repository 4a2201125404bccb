// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Option --post of all commands that write denoised images: post-processing effects
/// (docs/post.md).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "post/depth_of_field.h"
#include "stillray/frame.h"
#include "stillray/scene.h"
#include "stillray/status.h"

namespace CLI {
class App;
}

namespace stillray {

/// Unparsed option values.
struct PostArguments {
  std::vector<std::string> effects;  ///< lists of names
  std::optional<double> shutter;
};

struct PostEffects {
  bool depth_of_field = false;
  bool motion_blur = false;
  float shutter = 0.5f;  ///< post::Shutter::open

  bool any() const { return depth_of_field || motion_blur; }
};

/// --post and --shutter.
void AddPostOptions(CLI::App* command, PostArguments* arguments);

/// \return kInvalidArgument naming the option, its value and the expected ones
Result<PostEffects> ParsePostArguments(const PostArguments& arguments);

/// "dof,motion_blur shutter 0.5"; empty without effects.
std::string PostText(const PostEffects& effects);

/// The thin lens for images of this size; Lens::focus is kept, where 0 focuses on the image centre.
/// \param yfov  vertical angle of view in radians
post::ThinLens ThinLensOf(const Lens& lens, float yfov, int width, int height);

/// Applies depth of field, then motion blur.
/// \param lens  a focus of 0 is replaced by the depth at the image centre
/// \return kInvalidArgument naming the missing guide
Status ApplyPostEffects(const PostEffects& effects, const post::ThinLens& lens,
                        const Guides& guides, Image3* colour);

}  // namespace stillray
