// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Calls of the C API in any order with any arguments. Image memory is always as large as the
/// description says, as that is all that a library cannot check.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include "stillray/stillray.h"

namespace {

constexpr int kMaxSide = 24;

/// Numbers from the fuzzer's bytes; zero when they are used up.
class Bytes {
 public:
  Bytes(const uint8_t* data, size_t size) : data_(data), size_(size) {}
  bool empty() const { return size_ == 0; }
  uint8_t Next() {
    if (size_ == 0) {
      return 0;
    }
    --size_;
    return *data_++;
  }
  int Below(int n) { return Next() % n; }
  std::string Text() {
    std::string text;
    for (int length = Below(12); length > 0; --length) {
      text += static_cast<char>(Next());
    }
    return text;
  }

 private:
  const uint8_t* data_;
  size_t size_;
};

const char* InputName(Bytes* bytes) {
  stillray_input_info info = STILLRAY_INPUT_INFO_INIT;
  return stillray_input_at(static_cast<size_t>(bytes->Below(24)), &info) == STILLRAY_OK ? info.name
                                                                                        : "none";
}

/// A description, with memory for its pixels if it is valid.
/// \param tame  always valid, of the size of most others
stillray_image MakeImage(Bytes* bytes, bool id, std::vector<std::vector<uint8_t>>* memory,
                         bool tame = false) {
  const int odd = tame ? 15 : bytes->Next();
  const int width = odd % 8 == 0 ? bytes->Below(40) - 4 : 16;
  const int height = odd % 8 == 1 ? bytes->Below(40) - 4 : 12;
  const int channels = odd % 16 == 2 ? bytes->Below(8) - 1 : id ? 1 : 3;
  const int format = odd % 16 == 3 ? bytes->Next() : id ? 3 : 1 + bytes->Below(2);
  const auto w = static_cast<size_t>(std::clamp(width, 1, 4 * kMaxSide));
  const auto h = static_cast<size_t>(std::clamp(height, 1, 4 * kMaxSide));
  memory->emplace_back(w * h * 16 + 64, bytes->Next());
  std::vector<uint8_t>& pixels = memory->back();
  for (size_t i = 0; i + 4 <= pixels.size() && format == STILLRAY_FORMAT_FLOAT; i += 4) {
    const float value = static_cast<float>(bytes->Next()) / 32.0f;
    std::memcpy(&pixels[i], &value, 4);
  }
  stillray_image image = bytes->Below(2) == 0
                             ? stillray_interleaved(pixels.data(), format, channels, width, height)
                             : stillray_planar(pixels.data(), format, channels, width, height);
  if (odd % 16 == 4) {
    // Strides that are refused, or that stay within the memory.
    image.pixel_stride = bytes->Below(17);
    image.row_stride = image.pixel_stride == 0 ? 0 : static_cast<ptrdiff_t>(w) * 16;
    image.channel_stride = bytes->Below(2) == 0 ? 0 : PTRDIFF_MAX - bytes->Next();
  }
  return image;
}

int Progress(void* user, double) {
  return --*static_cast<int*>(user) < 0 ? 1 : 0;
}

void Change(Bytes* bytes, stillray_denoiser* d) {
  stillray_parameter p = STILLRAY_PARAMETER_INIT;
  const char* text = nullptr;
  if (stillray_parameter_at(static_cast<size_t>(bytes->Below(50)), &p) != STILLRAY_OK) {
    stillray_denoiser_set(d, bytes->Text().c_str(), bytes->Text().c_str());
    return;
  }
  if (p.choice_count > 0 && bytes->Below(4) != 0) {
    stillray_denoiser_set(d, p.name, p.choices[bytes->Next() % p.choice_count]);
  } else {
    const int kind = bytes->Below(3);
    const std::string value = kind == 0   ? bytes->Text()
                              : kind == 1 ? std::to_string(bytes->Next())
                                          : std::to_string(p.max * bytes->Next() / 255.0);
    stillray_denoiser_set(d, p.name, value.c_str());
  }
  stillray_denoiser_get(d, p.name, &text);
}

void History(Bytes* bytes, stillray_denoiser* d, std::vector<uint8_t>* saved) {
  size_t size = 0;
  if (bytes->Below(2) == 0) {
    if (stillray_denoiser_save_history(d, nullptr, 0, &size) == STILLRAY_OK) {
      saved->resize(size);
      stillray_denoiser_save_history(d, saved->data(), saved->size() - bytes->Below(2), &size);
    }
    return;
  }
  std::vector<uint8_t> damaged = *saved;
  for (int n = bytes->Below(4); n > 0 && !damaged.empty(); --n) {
    damaged[bytes->Next() % std::min<size_t>(damaged.size(), 64)] ^= bytes->Next();
  }
  stillray_denoiser_restore_history(d, damaged.data(), damaged.size());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  Bytes bytes(data, size);
  stillray_device* device = nullptr;
  stillray_denoiser* d = nullptr;
  std::vector<std::vector<uint8_t>> memory;
  std::vector<uint8_t> saved;
  int patience = 0;
  if (stillray_device_create(STILLRAY_ABI_VERSION, 1, &device) != STILLRAY_OK ||
      stillray_denoiser_create(device, stillray_preset_name(bytes.Below(4)), &d) != STILLRAY_OK) {
    std::abort();
  }
  stillray_device_release(device);
  // A whole frame to begin with, so that few bytes reach the filter.
  for (size_t i = 0; i < stillray_input_count(); ++i) {
    stillray_input_info info = STILLRAY_INPUT_INFO_INIT;
    stillray_input_at(i, &info);
    const stillray_image image =
        MakeImage(&bytes, std::strcmp(info.name, "id") == 0, &memory, true);
    stillray_denoiser_set_input(d, info.name, &image);
  }
  const stillray_image colour = MakeImage(&bytes, false, &memory, true);
  stillray_denoiser_set_output(d, "colour", &colour);
  for (int step = 0; step < 24 && !bytes.empty(); ++step) {
    switch (bytes.Below(14)) {
      case 0:
      case 1: {
        const std::string name = InputName(&bytes);
        const stillray_image image = MakeImage(&bytes, name == "id", &memory);
        stillray_denoiser_set_input(d, name.c_str(), bytes.Below(4) == 0 ? nullptr : &image);
        break;
      }
      case 2: {
        const char* name = stillray_denoiser_output_name(d, bytes.Next() % 48);
        const std::string wanted = name != nullptr && bytes.Below(3) != 0 ? name : "colour";
        const stillray_image image = MakeImage(&bytes, false, &memory);
        stillray_denoiser_set_output(d, wanted.c_str(), bytes.Below(6) == 0 ? nullptr : &image);
        break;
      }
      case 3:
        Change(&bytes, d);
        break;
      case 4:
        History(&bytes, d, &saved);
        break;
      case 5:
        patience = bytes.Below(6);
        stillray_denoiser_set_progress(d, bytes.Below(2) == 0 ? Progress : nullptr, &patience);
        break;
      case 6:
        bytes.Below(2) == 0
            ? stillray_denoiser_reset(d)
            : stillray_denoiser_resize(d, bytes.Below(kMaxSide) - 2, bytes.Below(kMaxSide) - 2);
        break;
      case 7:
        stillray_denoiser_set_preset(d, stillray_preset_name(bytes.Below(5)));
        break;
      case 8:
        stillray_denoiser_push(d, static_cast<int32_t>(bytes.Below(5)) - 1);
        break;
      case 9: {
        int32_t pulled = 0;
        stillray_denoiser_finish(d);
        stillray_denoiser_pull(d, &pulled);
        break;
      }
      case 10: {
        stillray_memory_need need = STILLRAY_MEMORY_NEED_INIT;
        stillray_denoiser_memory_need(d, &need);
        break;
      }
      default:
        if (stillray_denoiser_execute(d) != STILLRAY_OK && *stillray_error_message(d) == '\0') {
          std::abort();  // a failure without a word
        }
    }
  }
  stillray_denoiser_release(d);
  return 0;
}
