// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Finished pictures that stay on the device that filtered them, for other APIs to show.
#pragma once

#include <array>
#include <cstdint>

#include "stillray/status.h"

namespace stillray {

/// A picture as displayed, in memory that OpenGL on the same device imports as a buffer
/// (GL_EXT_memory_object_fd): from its beginning width * height pixels of red, green, blue and
/// alpha (255) in 8 bits each, rows from the top without gaps. The device had written all of it
/// before the frame was handed over: nothing is to be waited for. The denoiser takes the memory for
/// a later frame once nobody holds the picture any more: to be held until the copy from it is done.
/// May be used by any thread, and outlives its denoiser.
class SharedPicture {
 public:
  using Uuid = std::array<uint8_t, 16>;

  virtual ~SharedPicture() = default;
  SharedPicture(const SharedPicture&) = delete;
  SharedPicture& operator=(const SharedPicture&) = delete;

  virtual int width() const = 0;
  virtual int height() const = 0;
  /// Size of the memory in bytes, to import it with; more than the picture takes.
  virtual uint64_t memory_bytes() const = 0;
  /// What OpenGL calls GL_DEVICE_UUID_EXT and GL_DRIVER_UUID_EXT: others cannot import it.
  virtual Uuid device_uuid() const = 0;
  virtual Uuid driver_uuid() const = 0;
  /// A new file descriptor of the memory, the caller's to close or to give to who imports it.
  /// \return what fails on the device
  virtual Result<int> Export() const = 0;

 protected:
  SharedPicture() = default;
};

}  // namespace stillray
