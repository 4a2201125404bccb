// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "common/post_options.h"

#include <limits>
#include <string_view>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "common/option_checks.h"
#include "core/nearest_names.h"
#include "post/motion_blur.h"
#include "render/camera.h"
#include "render/lens.h"

namespace stillray {
namespace {

constexpr std::string_view kEffects[] = {"dof", "motion_blur"};

Status AddEffect(const std::string& name, PostEffects* effects) {
  if (name == kEffects[0]) {
    effects->depth_of_field = true;
  } else if (name == kEffects[1]) {
    effects->motion_blur = true;
  } else {
    return Status::InvalidArgument(
        fmt::format("--post has '{}', expected a list of dof, motion_blur{}", name,
                    DidYouMean(name, kEffects)));
  }
  return Status::Ok();
}

/// Depth of the surface at the image centre; infinity if there is none.
float CentreDepth(const Image1& depth) {
  const float centre = depth(depth.width() / 2, depth.height() / 2);
  return centre > 0.0f ? centre : std::numeric_limits<float>::infinity();
}

Status BlurByDepth(post::ThinLens lens, const Guides& guides, Image3* colour) {
  if (guides.depth.empty()) {
    return Status::InvalidArgument("--post dof needs depth, which the frame does not have");
  }
  if (lens.focus == 0.0f) {
    lens.focus = CentreDepth(guides.depth);
  }
  return post::DepthOfField(lens, guides.depth, colour);
}

Status BlurByMotion(float shutter, const Guides& guides, Image3* colour) {
  if (guides.motion.empty() || guides.depth.empty()) {
    return Status::InvalidArgument(
        fmt::format("--post motion_blur needs {}, which the frame does not have",
                    guides.motion.empty() ? "motion" : "depth"));
  }
  post::Shutter open;
  open.open = shutter;
  return post::MotionBlur(open, guides.motion, guides.depth, colour);
}

}  // namespace

void AddPostOptions(CLI::App* command, PostArguments* arguments) {
  command
      ->add_option(
          "--post", arguments->effects,
          "Effects on the denoised picture: a list of dof (depth of field, with --aperture "
          "and --focus) and motion_blur")
      ->allow_extra_args(false)
      ->take_all();
  command
      ->add_option(
          "--shutter", arguments->shutter,
          "With --post motion_blur: how much of the time between two frames the shutter is "
          "open, 0 to 1; default: 0.5")
      ->check(InRange(0, 1));
}

Result<PostEffects> ParsePostArguments(const PostArguments& arguments) {
  PostEffects effects;
  for (const std::string& list : arguments.effects) {
    for (const std::string& name : CLI::detail::split(list, ',')) {
      STILLRAY_RETURN_IF_ERROR(AddEffect(name, &effects));
    }
  }
  if (arguments.shutter && !effects.motion_blur) {
    return Status::InvalidArgument("--shutter is for motion blur, expected --post motion_blur");
  }
  effects.shutter = static_cast<float>(arguments.shutter.value_or(0.5));
  return effects;
}

std::string PostText(const PostEffects& effects) {
  std::string text = effects.depth_of_field ? "dof" : "";
  if (effects.motion_blur) {
    text += fmt::format("{}motion_blur shutter {}", text.empty() ? "" : ",", effects.shutter);
  }
  return text;
}

post::ThinLens ThinLensOf(const Lens& lens, float yfov, int width, int height) {
  Camera camera;
  camera.yfov = yfov;
  const render::CameraView view = render::MakeCameraView(camera, mat4(1.0f), width, height);
  post::ThinLens thin;
  thin.radius = render::LensRadius(lens, view);
  thin.focus = lens.focus;
  thin.pixels_per_tangent = post::PixelsPerTangent(height, static_cast<double>(yfov));
  return thin;
}

Status ApplyPostEffects(const PostEffects& effects, const post::ThinLens& lens,
                        const Guides& guides, Image3* colour) {
  if (effects.depth_of_field) {
    STILLRAY_RETURN_IF_ERROR(BlurByDepth(lens, guides, colour));
  }
  return effects.motion_blur ? BlurByMotion(effects.shutter, guides, colour) : Status::Ok();
}

}  // namespace stillray
