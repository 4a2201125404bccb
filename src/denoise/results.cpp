// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The finished picture on its way to the caller.

#include <cmath>

#include "denoise/denoiser_impl.h"
#include "denoise/device_denoiser.h"
#include "denoise/stage_timer.h"

namespace stillray {
namespace {

void MakeRoom(const Image3& like, Image3* to) {
  if (to->width() != like.width() || to->height() != like.height()) {
    *to = Image3(like.width(), like.height());
  }
}

void CopyResult(const Image3& from, Image3* to) {
  MakeRoom(from, to);
  CopyImage(from, to);
}

/// ToDisplay into memory that is there already.
void Display(const Image3& colour, float exposure, Tonemap curve, float dither, int64_t frame,
             std::vector<uint8_t>* bytes) {
  bytes->resize(static_cast<size_t>(colour.width()) * static_cast<size_t>(colour.height()) * 3);
  cpu::Tonemap(colour, std::exp2f(exposure), static_cast<int>(curve),
               {dither, static_cast<uint32_t>(frame)}, bytes->data());
}

}  // namespace

Image3* Denoiser::Impl::Result() {
  if (!results.colour) {
    return nullptr;
  }
  MakeRoom(state.picture, &out->colour);
  return &out->colour;
}

/// The finished picture as the caller wants it.
void Denoiser::Impl::HandOver() {
  has_result = true;
  if (!results.colour) {
    out->colour = Image3();
  } else if (!is_handed_over) {
    CopyResult(state.picture, &out->colour);
  }
  out->shared.reset();
  if (!results.display && !results.shared) {
    out->display.clear();
  } else {
    const StageTimer timer(&out->timings, "tonemap");
    Display(state.picture, settings.exposure, settings.tonemap, settings.dither, frame->index,
            &out->display);
  }
}

void Denoiser::SetResults(const Results& wanted) {
  if (device_ != nullptr) {
    device_->SetResults(wanted);
  }
  impl_->results = wanted;
}

Status Denoiser::ReadColour(Image3* colour) {
  if (device_ != nullptr) {
    return device_->ReadColour(colour);
  }
  if (!impl_->has_result) {
    return Status::NotFound("there is no finished frame to read");
  }
  CopyResult(impl_->state.picture, colour);
  return Status::Ok();
}

std::vector<uint8_t> ToDisplay(const Image3& colour, float exposure, Tonemap curve, float dither,
                               int64_t frame) {
  std::vector<uint8_t> bytes;
  Display(colour, exposure, curve, dither, frame, &bytes);
  return bytes;
}

}  // namespace stillray
