// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Embree's reference-counted objects as owning pointers.
#pragma once

#include <memory>
#include <type_traits>

#include <embree3/rtcore.h>

namespace stillray::render {

template <auto kRelease>
struct EmbreeRelease {
  template <typename Handle>
  void operator()(Handle handle) const {
    kRelease(handle);
  }
};
template <typename Handle, auto kRelease>
using EmbreeHandle = std::unique_ptr<std::remove_pointer_t<Handle>, EmbreeRelease<kRelease>>;

using EmbreeDevice = EmbreeHandle<RTCDevice, rtcReleaseDevice>;
using EmbreeScene = EmbreeHandle<RTCScene, rtcReleaseScene>;
using EmbreeGeometry = EmbreeHandle<RTCGeometry, rtcReleaseGeometry>;
using EmbreeBvh = EmbreeHandle<RTCBVH, rtcReleaseBVH>;

}  // namespace stillray::render
