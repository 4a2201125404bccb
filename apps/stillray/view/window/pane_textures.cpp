// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/window/pane_textures.h"

#include <GL/gl.h>

namespace stillray::view {

PaneTextures::~PaneTextures() {
  for (const Pane& pane : panes_) {
    glDeleteTextures(1, &pane.name);
  }
}

Status PaneTextures::PrepareSharing() {
  Result<std::unique_ptr<SharedImports>> made = SharedImports::Create();
  STILLRAY_RETURN_IF_ERROR(made.status());
  imports_ = std::move(made.value());
  return Status::Ok();
}

void PaneTextures::BindPane(int width, int height, uint32_t format, Pane* pane) const {
  if (pane->name == 0) {
    glGenTextures(1, &pane->name);
  }
  glBindTexture(GL_TEXTURE_2D, pane->name);
  if (pane->width != width || pane->height != height || pane->format != format) {
    glTexImage2D(GL_TEXTURE_2D, 0, format == GL_RGB ? GL_RGB8 : GL_RGBA8, width, height, 0, format,
                 GL_UNSIGNED_BYTE, nullptr);
    pane->width = width;
    pane->height = height;
    pane->format = format;
  }
  const GLint filter = sharp_ ? GL_NEAREST : GL_LINEAR;
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
}

Status PaneTextures::UploadPane(const ViewFrame& frame, size_t index) {
  const Rgb8Image& picture = frame.pictures[index];
  Pane* pane = &panes_[index];
  if (frame.shared[index] == nullptr) {
    BindPane(picture.width, picture.height, GL_RGB, pane);
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, picture.width, picture.height, GL_RGB, GL_UNSIGNED_BYTE,
                    picture.pixels.data());
    return Status::Ok();
  }
  if (imports_ == nullptr) {
    return Status::Unsupported("pictures are not shared with this window");
  }
  STILLRAY_RETURN_IF_ERROR(imports_->Import(frame.shared[index]));
  BindPane(picture.width, picture.height, GL_RGBA, pane);
  return imports_->CopyToTexture(frame.shared[index]);
}

Status PaneTextures::Upload(const ViewFrame& frame, bool sharp_pixels) {
  if (shown_ == &frame && shown_number_ == frame.number && sharp_ == sharp_pixels) {
    return Status::Ok();
  }
  shown_ = &frame;
  shown_number_ = frame.number;
  sharp_ = sharp_pixels;
  count_ = static_cast<int>(frame.pictures.size());
  if (panes_.size() < frame.pictures.size()) {
    panes_.resize(frame.pictures.size());
  }
  Status first;
  for (size_t i = 0; i < frame.pictures.size(); ++i) {
    const Status uploaded = UploadPane(frame, i);
    first = first.ok() ? uploaded : first;
  }
  return first;
}

}  // namespace stillray::view
