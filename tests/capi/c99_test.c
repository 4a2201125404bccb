/* SPDX-FileCopyrightText: the stillray developers
 * SPDX-License-Identifier: Apache-2.0 */

/* A C99 program's use of the whole API: compiled with -std=c99 -pedantic-errors -Werror. */
#include <stdlib.h>
#include <string.h>

#include "stillray/stillray.h"

enum { kWidth = 24, kHeight = 16, kPixels = kWidth * kHeight };

static int CountCalls(void* user, double fraction) {
  (void)fraction;
  ++*(int*)user;
  return 0;
}

/* Returns NULL, or what went wrong. */
const char* StillrayC99Test(void);
const char* StillrayC99Test(void) {
  static float light[kPixels * 3], normal[kPixels * 3], albedo[kPixels * 3], depth[kPixels],
      motion[kPixels * 2], colour[kPixels * 3];
  static char message[256];
  stillray_device* device = NULL;
  stillray_denoiser* denoiser = NULL;
  stillray_image image;
  stillray_statistics statistics = STILLRAY_STATISTICS_INIT;
  stillray_waiting waiting = STILLRAY_WAITING_INIT;
  stillray_memory_need need = STILLRAY_MEMORY_NEED_INIT;
  int32_t pulled = 0;
  size_t i, size = 0;
  int calls = 0;
  stillray_input_info input = STILLRAY_INPUT_INFO_INIT;
  stillray_parameter parameter = STILLRAY_PARAMETER_INIT;

  for (i = 0; i < kPixels; ++i) {
    light[3 * i] = light[3 * i + 1] = light[3 * i + 2] = 0.25f;
    albedo[3 * i] = albedo[3 * i + 1] = albedo[3 * i + 2] = 0.5f;
    normal[3 * i + 2] = 1.0f;
    depth[i] = 4.0f;
  }
  if (stillray_device_create(STILLRAY_ABI_VERSION, 1, &device) != STILLRAY_OK) {
    return "device";
  }
  if (stillray_denoiser_create(device, "default", &denoiser) != STILLRAY_OK) {
    return "denoiser";
  }
  stillray_device_release(device);
  image = stillray_interleaved(light, STILLRAY_FORMAT_FLOAT, 3, kWidth, kHeight);
  stillray_denoiser_set_input(denoiser, "direct_diffuse", &image);
  image = stillray_interleaved(normal, STILLRAY_FORMAT_FLOAT, 3, kWidth, kHeight);
  stillray_denoiser_set_input(denoiser, "normal", &image);
  image = stillray_interleaved(albedo, STILLRAY_FORMAT_FLOAT, 3, kWidth, kHeight);
  stillray_denoiser_set_input(denoiser, "albedo", &image);
  image = stillray_interleaved(depth, STILLRAY_FORMAT_FLOAT, 1, kWidth, kHeight);
  stillray_denoiser_set_input(denoiser, "depth", &image);
  image = stillray_interleaved(motion, STILLRAY_FORMAT_FLOAT, 2, kWidth, kHeight);
  stillray_denoiser_set_input(denoiser, "motion", &image);
  image = stillray_interleaved(colour, STILLRAY_FORMAT_FLOAT, 3, kWidth, kHeight);
  stillray_denoiser_set_output(denoiser, "colour", &image);
  stillray_denoiser_set_progress(denoiser, CountCalls, &calls);
  if (stillray_denoiser_execute(denoiser) != STILLRAY_OK) {
    strncpy(message, stillray_error_message(denoiser), sizeof(message) - 1);
    stillray_denoiser_release(denoiser);
    return message;
  }
  stillray_denoiser_save_history(denoiser, NULL, 0, &size);
  stillray_denoiser_statistics(denoiser, &statistics);
  stillray_denoiser_memory_need(denoiser, &need);
  stillray_denoiser_push(denoiser, STILLRAY_CUT_FIND);
  stillray_denoiser_finish(denoiser);
  stillray_denoiser_waiting(denoiser, &waiting);
  memset(colour, 0, sizeof(colour));
  if (need.most == 0 || waiting.ready != 1 ||
      stillray_denoiser_pull(denoiser, &pulled) != STILLRAY_OK || pulled != 1) {
    stillray_denoiser_release(denoiser);
    return "a frame that was pushed could not be pulled";
  }
  stillray_denoiser_release(denoiser);
  for (i = 0; i < kPixels * 3; ++i) {
    if (!(colour[i] > 0.2499f && colour[i] < 0.2501f)) {
      return "a constant did not stay constant";
    }
  }
  if (stillray_input_at(0, &input) != STILLRAY_OK ||
      stillray_parameter_at(0, &parameter) != STILLRAY_OK || input.name == NULL ||
      parameter.name == NULL) {
    return "tables";
  }
  if (calls < 2 || size == 0 || statistics.memory_bytes == 0) {
    return "progress, history size or statistics";
  }
  return NULL;
}
