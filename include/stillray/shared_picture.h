// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Denoised images in the memory of the device that filtered them, for display by other APIs.
#pragma once

#include <array>
#include <cstdint>

#include "stillray/status.h"

namespace stillray {

/// A display-referred image in memory that OpenGL on the same device imports as a buffer
/// (GL_EXT_memory_object_fd): from offset 0 width * height pixels of red, green, blue and alpha
/// (255) in 8 bits each, rows from the top without padding. The device has finished writing before
/// the frame is returned, so no synchronisation is needed. The denoiser reuses the memory for a
/// later frame once there is no other reference to this object: hold a reference until the image
/// has been copied. Thread-safe; outlives its denoiser.
class SharedPicture {
 public:
  using Uuid = std::array<uint8_t, 16>;

  virtual ~SharedPicture() = default;
  SharedPicture(const SharedPicture&) = delete;
  SharedPicture& operator=(const SharedPicture&) = delete;

  virtual int width() const = 0;
  virtual int height() const = 0;
  /// Size of the memory in bytes, for importing it; larger than the image.
  virtual uint64_t memory_bytes() const = 0;
  /// Match GL_DEVICE_UUID_EXT and GL_DRIVER_UUID_EXT; other devices and drivers cannot import the
  /// memory.
  virtual Uuid device_uuid() const = 0;
  virtual Uuid driver_uuid() const = 0;
  /// A new file descriptor of the memory, which the caller closes or passes to an importer.
  /// \return errors of the device
  virtual Result<int> Export() const = 0;

 protected:
  SharedPicture() = default;
};

}  // namespace stillray
