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

void PaneTextures::UploadPane(const Rgb8Image& picture, Pane* pane) const {
  if (pane->name == 0) {
    glGenTextures(1, &pane->name);
  }
  glBindTexture(GL_TEXTURE_2D, pane->name);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  if (pane->width == picture.width && pane->height == picture.height) {
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, picture.width, picture.height, GL_RGB, GL_UNSIGNED_BYTE,
                    picture.pixels.data());
  } else {
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, picture.width, picture.height, 0, GL_RGB,
                 GL_UNSIGNED_BYTE, picture.pixels.data());
    pane->width = picture.width;
    pane->height = picture.height;
  }
  const GLint filter = sharp_ ? GL_NEAREST : GL_LINEAR;
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

void PaneTextures::Upload(const ViewFrame& frame, bool sharp_pixels) {
  if (shown_ == &frame && shown_number_ == frame.number && sharp_ == sharp_pixels) {
    return;
  }
  shown_ = &frame;
  shown_number_ = frame.number;
  sharp_ = sharp_pixels;
  count_ = static_cast<int>(frame.pictures.size());
  if (panes_.size() < frame.pictures.size()) {
    panes_.resize(frame.pictures.size());
  }
  for (size_t i = 0; i < frame.pictures.size(); ++i) {
    UploadPane(frame.pictures[i], &panes_[i]);
  }
}

}  // namespace stillray::view
