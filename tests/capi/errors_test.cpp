// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Every wrong call gives the documented error and harms nothing.
#include <climits>
#include <thread>

#include <gmock/gmock.h>

#include "capi/capi_frames.h"

namespace stillray::test::errors_test {
namespace {

using testing::HasSubstr;

constexpr stillray_error kInvalid = STILLRAY_ERROR_INVALID_ARGUMENT;

struct ErrorsTest : testing::Test {
  DenoiserHandle handle = MakeDenoiser();
  stillray_denoiser* denoiser = handle.get();
  float value[64] = {};
  stillray_image image = stillray_interleaved(value, STILLRAY_FORMAT_FLOAT, 3, 4, 4);

  std::string Message() const { return stillray_error_message(denoiser); }
  static std::string ThreadMessage() { return stillray_error_message(nullptr); }
};

TEST_F(ErrorsTest, NullDenoiserEverywhere) {
  stillray_statistics statistics = STILLRAY_STATISTICS_INIT;
  const char* text = nullptr;
  size_t size = 0;
  EXPECT_EQ(stillray_denoiser_set_preset(nullptr, "default"), kInvalid);
  EXPECT_EQ(stillray_denoiser_set(nullptr, "alpha_min", "0.1"), kInvalid);
  EXPECT_EQ(stillray_denoiser_get(nullptr, "alpha_min", &text), kInvalid);
  EXPECT_EQ(stillray_denoiser_set_input(nullptr, "depth", &image), kInvalid);
  EXPECT_EQ(stillray_denoiser_set_output(nullptr, "colour", &image), kInvalid);
  EXPECT_EQ(stillray_denoiser_output_count(nullptr), 0u);
  EXPECT_EQ(stillray_denoiser_output_name(nullptr, 0), nullptr);
  EXPECT_EQ(stillray_denoiser_set_jitter(nullptr, 0, 0), kInvalid);
  EXPECT_EQ(stillray_denoiser_set_focal_pixels(nullptr, 100), kInvalid);
  EXPECT_EQ(stillray_denoiser_set_progress(nullptr, nullptr, nullptr), kInvalid);
  EXPECT_EQ(stillray_denoiser_execute(nullptr), kInvalid);
  EXPECT_EQ(stillray_denoiser_resize(nullptr, 1, 1), kInvalid);
  EXPECT_EQ(stillray_denoiser_reset(nullptr), kInvalid);
  EXPECT_EQ(stillray_denoiser_save_history(nullptr, nullptr, 0, &size), kInvalid);
  EXPECT_EQ(stillray_denoiser_restore_history(nullptr, value, 4), kInvalid);
  EXPECT_EQ(stillray_denoiser_statistics(nullptr, &statistics), kInvalid);
  EXPECT_EQ(ThreadMessage(), "denoiser is NULL");
  stillray_denoiser_release(nullptr);
  stillray_device_release(nullptr);
  EXPECT_EQ(stillray_device_threads(nullptr), 0);
}

TEST_F(ErrorsTest, NullArguments) {
  const char* text = nullptr;
  EXPECT_EQ(stillray_denoiser_set_preset(denoiser, nullptr), kInvalid);
  EXPECT_EQ(Message(), "preset is NULL");
  EXPECT_EQ(stillray_denoiser_set(denoiser, nullptr, "1"), kInvalid);
  EXPECT_EQ(Message(), "name is NULL");
  EXPECT_EQ(stillray_denoiser_set(denoiser, "alpha_min", nullptr), kInvalid);
  EXPECT_EQ(Message(), "value is NULL");
  EXPECT_EQ(stillray_denoiser_get(denoiser, nullptr, &text), kInvalid);
  EXPECT_EQ(stillray_denoiser_get(denoiser, "alpha_min", nullptr), kInvalid);
  EXPECT_EQ(stillray_denoiser_set_input(denoiser, nullptr, &image), kInvalid);
  EXPECT_EQ(stillray_denoiser_set_output(denoiser, nullptr, &image), kInvalid);
  EXPECT_EQ(stillray_denoiser_save_history(denoiser, value, 4, nullptr), kInvalid);
  EXPECT_EQ(stillray_denoiser_restore_history(denoiser, nullptr, 4), kInvalid);
  EXPECT_EQ(stillray_denoiser_statistics(denoiser, nullptr), kInvalid);
  EXPECT_EQ(Message(), "statistics is NULL");
}

TEST_F(ErrorsTest, Tables) {
  stillray_input_info info = STILLRAY_INPUT_INFO_INIT;
  stillray_parameter parameter = STILLRAY_PARAMETER_INIT;
  EXPECT_EQ(stillray_input_at(0, nullptr), kInvalid);
  EXPECT_EQ(stillray_input_at(stillray_input_count(), &info), kInvalid);
  EXPECT_THAT(ThreadMessage(), HasSubstr("there is no input"));
  EXPECT_EQ(stillray_parameter_at(0, nullptr), kInvalid);
  EXPECT_EQ(stillray_parameter_at(SIZE_MAX, &parameter), kInvalid);
  EXPECT_EQ(stillray_preset_name(stillray_preset_count()), nullptr);
  EXPECT_STREQ(stillray_preset_name(0), "default");
  EXPECT_STREQ(stillray_error_name(STILLRAY_ERROR_CANCELLED), "cancelled");
  EXPECT_STREQ(stillray_error_name(-1), "unknown error");
  EXPECT_STREQ(stillray_error_name(99), "unknown error");
  EXPECT_EQ(stillray_abi_version(), STILLRAY_ABI_VERSION);
}

TEST_F(ErrorsTest, Creation) {
  stillray_device* device = reinterpret_cast<stillray_device*>(&image);
  EXPECT_EQ(stillray_device_create(STILLRAY_ABI_VERSION + 1, 0, &device),
            STILLRAY_ERROR_UNSUPPORTED);
  EXPECT_EQ(device, nullptr);
  EXPECT_THAT(ThreadMessage(), HasSubstr("ABI version"));
  EXPECT_EQ(stillray_device_create(STILLRAY_ABI_VERSION, -1, &device), kInvalid);
  EXPECT_EQ(ThreadMessage(), "threads is -1, expected 0 to 1024");
  EXPECT_EQ(stillray_device_create(STILLRAY_ABI_VERSION, 1025, &device), kInvalid);
  EXPECT_EQ(stillray_device_create(STILLRAY_ABI_VERSION, 0, nullptr), kInvalid);
  stillray_denoiser* made = reinterpret_cast<stillray_denoiser*>(&image);
  EXPECT_EQ(stillray_denoiser_create(nullptr, "default", &made), kInvalid);
  EXPECT_EQ(made, nullptr);
  EXPECT_EQ(ThreadMessage(), "device is NULL");
  ASSERT_EQ(stillray_device_create(STILLRAY_ABI_VERSION, 0, &device), STILLRAY_OK);
  EXPECT_GE(stillray_device_threads(device), 1);
  EXPECT_EQ(stillray_denoiser_create(device, "nicest", &made), kInvalid);
  EXPECT_THAT(ThreadMessage(), HasSubstr("'nicest'"));
  EXPECT_EQ(stillray_denoiser_create(device, "default", nullptr), kInvalid);
  stillray_device_release(device);
}

TEST_F(ErrorsTest, Devices) {
  stillray_device* device = reinterpret_cast<stillray_device*>(&image);
  EXPECT_EQ(stillray_device_create_on(STILLRAY_ABI_VERSION, 0, "gpu", &device), kInvalid);
  EXPECT_EQ(device, nullptr);
  EXPECT_EQ(ThreadMessage(),
            "device is 'gpu', expected auto, cpu, vulkan or vulkan:N, did you mean vulkan?");
  EXPECT_EQ(stillray_device_create_on(STILLRAY_ABI_VERSION, 0, nullptr, &device), kInvalid);
  EXPECT_EQ(ThreadMessage(), "name is NULL");
  EXPECT_NE(stillray_device_create_on(STILLRAY_ABI_VERSION, 0, "vulkan:77", &device), STILLRAY_OK);
  EXPECT_EQ(device, nullptr);
  EXPECT_STREQ(stillray_device_description(nullptr), "");
  ASSERT_EQ(stillray_device_create(STILLRAY_ABI_VERSION, 0, &device), STILLRAY_OK);
  EXPECT_STREQ(stillray_device_description(device), "cpu");
  stillray_device_release(device);
}

TEST_F(ErrorsTest, MessagesOfThreadsAreTheirOwn) {
  EXPECT_EQ(stillray_denoiser_execute(nullptr), kInvalid);
  std::string other = "unset";
  std::thread([&] { other = stillray_error_message(nullptr); }).join();
  EXPECT_EQ(other, "");
  EXPECT_EQ(ThreadMessage(), "denoiser is NULL");
}

TEST_F(ErrorsTest, Settings) {
  const char* text = nullptr;
  EXPECT_EQ(stillray_denoiser_set(denoiser, "alpha", "0.1"), kInvalid);
  EXPECT_THAT(Message(), HasSubstr("unknown parameter 'alpha'"));
  EXPECT_EQ(stillray_denoiser_set(denoiser, "alpha_min", "2"), kInvalid);
  EXPECT_THAT(Message(), HasSubstr("alpha_min"));
  EXPECT_EQ(stillray_denoiser_set(denoiser, "alpha_min", ""), kInvalid);
  EXPECT_EQ(stillray_denoiser_set_preset(denoiser, "nicest"), kInvalid);
  EXPECT_EQ(stillray_denoiser_get(denoiser, "alpha", &text), kInvalid);
  EXPECT_EQ(text, nullptr);
  ASSERT_EQ(stillray_denoiser_get(denoiser, "alpha_min", &text), STILLRAY_OK);
  EXPECT_STREQ(text, "0.1");
}

TEST_F(ErrorsTest, ImageDescriptions) {
  const auto refuses = [&](const stillray_image& wrong, const std::string& why,
                           const char* name = "albedo") {
    EXPECT_EQ(stillray_denoiser_set_input(denoiser, name, &wrong), kInvalid) << why;
    EXPECT_THAT(Message(), HasSubstr(why));
    EXPECT_THAT(Message(), HasSubstr(name));
  };
  const auto with = [&](auto change) {
    stillray_image changed = image;
    change(&changed);
    return changed;
  };
  refuses(with([](stillray_image* i) { i->data = nullptr; }), "NULL");
  refuses(with([](stillray_image* i) { i->format = 0; }), "unknown format 0");
  refuses(with([](stillray_image* i) { i->format = 77; }), "unknown format 77");
  refuses(with([](stillray_image* i) { i->format = STILLRAY_FORMAT_UINT32; }), "FLOAT or HALF");
  refuses(with([](stillray_image* i) { i->channels = 1; }), "id", "id");
  refuses(with([](stillray_image* i) { i->width = 0; }), "0x4");
  refuses(with([](stillray_image* i) { i->height = -1; }), "4x-1");
  refuses(with([](stillray_image* i) { i->width = INT_MAX; }), "expected 1x1 to 32768x32768");
  refuses(with([](stillray_image* i) { i->channels = 2; }), "2 channels, expected 3 to 4");
  refuses(with([](stillray_image* i) { i->channels = 5; }), "5 channels");
  refuses(with([](stillray_image* i) { i->pixel_stride = 4; }), "overlaps itself");
  refuses(with([](stillray_image* i) { i->row_stride = 12; }), "overlaps itself");
  refuses(with([](stillray_image* i) { i->channel_stride = 2; }), "overlaps itself");
  refuses(with([](stillray_image* i) { i->row_stride = PTRDIFF_MIN; }), "stride");
  refuses(with([](stillray_image* i) { i->pixel_stride = PTRDIFF_MAX; }), "stride");
  refuses(with([](stillray_image* i) { i->channel_stride = PTRDIFF_MAX / 2; }), "stride");
  refuses(with([](stillray_image* i) { i->pixel_stride = ptrdiff_t{1} << 44; }), "stride");
  refuses(image, "unknown input 'colour'", "colour");
  EXPECT_EQ(stillray_denoiser_set_output(denoiser, "color", &image), kInvalid);
  EXPECT_THAT(Message(), HasSubstr("unknown output 'color'; outputs are: colour, "));
  EXPECT_EQ(stillray_denoiser_set_output(denoiser, "color", nullptr), kInvalid);
  EXPECT_EQ(stillray_denoiser_set_input(denoiser, "color", nullptr), kInvalid);
  EXPECT_EQ(stillray_denoiser_set_output(denoiser, "colour", nullptr), STILLRAY_OK);
}

TEST_F(ErrorsTest, ExecuteBeforeSetup) {
  EXPECT_EQ(stillray_denoiser_execute(denoiser), kInvalid);
  EXPECT_EQ(Message(), "no input is set");
  ASSERT_EQ(stillray_denoiser_set_input(denoiser, "direct_diffuse", &image), STILLRAY_OK);
  EXPECT_EQ(stillray_denoiser_execute(denoiser), kInvalid);
  EXPECT_EQ(Message(), "no output is set");
  ASSERT_EQ(stillray_denoiser_set_output(denoiser, "colour", &image), STILLRAY_OK);
  ASSERT_EQ(stillray_denoiser_set_input(denoiser, "direct_diffuse", nullptr), STILLRAY_OK);
  ASSERT_EQ(stillray_denoiser_set_input(denoiser, "normal", &image), STILLRAY_OK);
  EXPECT_EQ(stillray_denoiser_execute(denoiser), kInvalid);
  EXPECT_THAT(Message(), HasSubstr("no signals"));
}

TEST_F(ErrorsTest, MotionThatIsMissingIsNamed) {
  CallerFrame caller(MakeBusyFrame(16, 12, 0));
  caller.Give(denoiser);
  ASSERT_EQ(stillray_denoiser_set_input(denoiser, "motion", nullptr), STILLRAY_OK);
  EXPECT_EQ(stillray_denoiser_execute(denoiser), STILLRAY_OK) << Message();  // a first frame
  EXPECT_EQ(stillray_denoiser_execute(denoiser), kInvalid);
  EXPECT_THAT(Message(), HasSubstr("image 'motion' is missing, expected 16x12: 'temporal'"));
  ASSERT_EQ(stillray_denoiser_set_input(denoiser, "motion", &caller.inputs["motion"].image),
            STILLRAY_OK);
  for (const char* name : {"depth", "normal", "albedo", "specular_albedo", "id", "roughness",
                           "emission", "background", "samples"}) {
    ASSERT_EQ(stillray_denoiser_set_input(denoiser, name, nullptr), STILLRAY_OK);
    EXPECT_EQ(stillray_denoiser_execute(denoiser), STILLRAY_OK) << Message();
  }
  for (int k = 0; k < 4; ++k) {
    stillray_denoiser_set_input(denoiser, SignalName(static_cast<SignalKind>(k)), nullptr);
  }
  EXPECT_EQ(stillray_denoiser_execute(denoiser), kInvalid);
  EXPECT_THAT(Message(), HasSubstr("no signals"));
}

TEST_F(ErrorsTest, SizesThatDiffer) {
  CallerFrame caller(MakeBusyFrame(16, 12, 0));
  CallerFrame other(MakeBusyFrame(16, 11, 0));
  caller.Give(denoiser);
  for (const auto& [name, buffer] : other.inputs) {
    if (name == "direct_diffuse") {
      continue;  // sets the size
    }
    stillray_denoiser_set_input(denoiser, name.c_str(), &buffer.image);
    EXPECT_EQ(stillray_denoiser_execute(denoiser), kInvalid);
    EXPECT_EQ(Message(), "image '" + name + "' is 16x11, expected 16x12 as 'direct_diffuse'");
    stillray_denoiser_set_input(denoiser, name.c_str(), &caller.inputs[name].image);
  }
  stillray_denoiser_set_output(denoiser, "colour", &other.colour.image);
  EXPECT_EQ(stillray_denoiser_execute(denoiser), kInvalid);
  EXPECT_EQ(Message(), "image 'colour' is 16x11, expected 16x12 as 'direct_diffuse'");
  stillray_denoiser_set_output(denoiser, "colour", &caller.colour.image);
  EXPECT_EQ(stillray_denoiser_execute(denoiser), STILLRAY_OK);
}

TEST_F(ErrorsTest, OutputThatTheSettingsDoNotHave) {
  CallerFrame caller(MakeBusyFrame(16, 12, 0));
  caller.Give(denoiser);
  ASSERT_EQ(stillray_denoiser_set_output(denoiser, "variance", &caller.colour.image), STILLRAY_OK);
  ASSERT_EQ(stillray_denoiser_set_preset(denoiser, "temporal"), STILLRAY_OK);
  EXPECT_EQ(stillray_denoiser_execute(denoiser), kInvalid);
  EXPECT_THAT(Message(), HasSubstr("unknown output 'variance'"));
  EXPECT_EQ(stillray_denoiser_set_output(denoiser, "variance", nullptr), STILLRAY_OK);
  EXPECT_EQ(stillray_denoiser_execute(denoiser), STILLRAY_OK) << Message();
}

TEST_F(ErrorsTest, SettingsThatContradictEachOtherAreToldByExecute) {
  CallerFrame caller(MakeBusyFrame(16, 12, 0));
  caller.Give(denoiser);
  ASSERT_EQ(stillray_denoiser_set(denoiser, "feedback", "5"), STILLRAY_OK);
  ASSERT_EQ(stillray_denoiser_set(denoiser, "steps", "1,2"), STILLRAY_OK);
  EXPECT_EQ(stillray_denoiser_execute(denoiser), kInvalid);
  EXPECT_THAT(Message(), HasSubstr("feedback"));
  ASSERT_EQ(stillray_denoiser_set(denoiser, "feedback", "2"), STILLRAY_OK);
  EXPECT_EQ(stillray_denoiser_execute(denoiser), STILLRAY_OK) << Message();
}

TEST_F(ErrorsTest, JitterAndSize) {
  EXPECT_EQ(stillray_denoiser_set_jitter(denoiser, 0.6f, 0), kInvalid);
  EXPECT_EQ(stillray_denoiser_set_jitter(denoiser, 0, std::nanf("")), kInvalid);
  EXPECT_THAT(Message(), HasSubstr("jitter"));
  EXPECT_EQ(stillray_denoiser_set_jitter(denoiser, -0.5f, 0.5f), STILLRAY_OK);
  EXPECT_EQ(stillray_denoiser_set_focal_pixels(denoiser, -1), kInvalid);
  EXPECT_EQ(stillray_denoiser_set_focal_pixels(denoiser, std::nanf("")), kInvalid);
  EXPECT_THAT(Message(), HasSubstr("focal_pixels"));
  EXPECT_EQ(stillray_denoiser_set_focal_pixels(denoiser, 100), STILLRAY_OK);
  EXPECT_EQ(stillray_denoiser_resize(denoiser, 0, 5), kInvalid);
  EXPECT_EQ(stillray_denoiser_resize(denoiser, -1, -1), kInvalid);
  EXPECT_EQ(stillray_denoiser_resize(denoiser, 32769, 5), kInvalid);
  EXPECT_THAT(Message(), HasSubstr("32769x5"));
}

}  // namespace
}  // namespace stillray::test::errors_test
