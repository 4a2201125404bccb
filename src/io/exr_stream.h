// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// OpenEXR streams in memory, and OpenEXR's process-wide settings.
#pragma once

#include <OpenEXR/ImfIO.h>

#include <cstddef>
#include <cstdint>
#include <string>

#include "stillray/status.h"

namespace stillray::io {

/// Reads from bytes that the caller owns. Throws on reading past their end.
class ExrMemoryInput final : public Imf::IStream {
 public:
  ExrMemoryInput(const uint8_t* data, size_t size, const std::string& name)
      : IStream(name.c_str()), data_(data), size_(size) {}
  bool read(char bytes[], int count) override;
  uint64_t tellg() override { return position_; }
  void seekg(uint64_t position) override { position_ = position; }

 private:
  const uint8_t* data_;
  size_t size_;
  uint64_t position_ = 0;
};

/// Collects OpenEXR's output in memory, because OpenEXR writes its line table in a destructor,
/// where it swallows the error of a full disk.
class ExrMemoryOutput final : public Imf::OStream {
 public:
  ExrMemoryOutput() : OStream("memory") {}
  void write(const char bytes[], int count) override;
  uint64_t tellp() override { return position_; }
  void seekp(uint64_t position) override { position_ = position; }
  std::string Take() { return std::move(bytes_); }

 private:
  std::string bytes_;
  uint64_t position_ = 0;
};

/// Starts OpenEXR's threads, unless SetExrThreads has, and sets its limits. Further calls are
/// cheap.
void PrepareOpenExr();

/// \return kBadData if the bytes do not begin as an EXR file; the message names the format if it is
///     a known one
Status CheckExrSignature(const uint8_t* data, size_t size, const std::string& name);

}  // namespace stillray::io
