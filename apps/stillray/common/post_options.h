// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// --post of every command that writes denoised pictures: effects on them (docs/post.md).
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

/// The options as given.
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

/// The lens for pictures of this size; Lens::focus is kept, 0 for that of the picture's centre.
/// \param yfov  vertical angle of view, radians
post::ThinLens ThinLensOf(const Lens& lens, float yfov, int width, int height);

/// Depth of field first, then motion blur.
/// \param lens  with a focus of 0: the depth in the picture's centre
/// \return kInvalidArgument naming the guide that is missing
Status ApplyPostEffects(const PostEffects& effects, const post::ThinLens& lens,
                        const Guides& guides, Image3* colour);

}  // namespace stillray
