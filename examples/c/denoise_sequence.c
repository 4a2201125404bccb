/* SPDX-FileCopyrightText: the stillray developers
 * SPDX-License-Identifier: Apache-2.0 */

/* Denoises a sequence with past and future frames: frames are pushed as they are rendered, and
 * pulled some frames later. The camera pans over a wall that is lit with one noisy sample per
 * pixel. Writes denoised.ppm of the first frame, which has no past.
 *   cc denoise_sequence.c $(pkg-config --cflags --libs stillray) -lm && ./a.out [FOLDER] */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <stillray/stillray.h>

enum { WIDTH = 320, HEIGHT = 180, PIXELS = WIDTH * HEIGHT, FRAMES = 40, PAN = 2 };

static float light[PIXELS * 3], albedo[PIXELS * 3], normal[PIXELS * 3];
static float depth[PIXELS], motion[PIXELS * 2], clean[PIXELS * 3];

static float uniform(uint32_t frame, uint32_t pixel) {
  uint32_t h = frame * 0x9E3779B9u ^ pixel * 0x85EBCA6Bu;
  h = (h ^ h >> 16) * 0x7FEB352Du;
  h = (h ^ h >> 15) * 0x846CA68Bu;
  return (float)((h ^ h >> 16) >> 8) / 16777216.0f;
}

/* Irradiance over pi at the point of the wall that is visible in pixel i of a frame. */
static float arriving(int frame, int i) {
  const int u = i % WIDTH + PAN * frame;
  return 0.6f + 0.4f * sinf((float)u * 0.02f) * cosf((float)(i / WIDTH) * 0.03f);
}

static void render(int frame) {
  int i, c;
  for (i = 0; i < PIXELS; ++i) {
    const float random = uniform((uint32_t)frame, (uint32_t)i);
    for (c = 0; c < 3; ++c) {
      albedo[3 * i + c] = 0.3f + 0.2f * (float)c;
      light[3 * i + c] = random < 0.25f ? 4 * albedo[3 * i + c] * arriving(frame, i) : 0.0f;
      normal[3 * i + c] = c == 2 ? 1.0f : 0.0f;
    }
    depth[i] = 5.0f;
    motion[2 * i] = (float)PAN;
    motion[2 * i + 1] = 0.0f;
  }
}

static double rms_error(const float* picture, int frame) {
  double sum = 0;
  int i;
  for (i = 0; i < PIXELS * 3; ++i) {
    const double error = picture[i] - albedo[i] * arriving(frame, i / 3);
    sum += error * error;
  }
  return sqrt(sum / (PIXELS * 3));
}

static void write_ppm(const char* folder, const char* name, const float* picture) {
  char path[1024];
  FILE* file;
  int i;
  snprintf(path, sizeof(path), "%s/%s", folder, name);
  file = fopen(path, "wb");
  if (file == NULL) {
    perror(path);
    exit(1);
  }
  fprintf(file, "P6\n%d %d\n255\n", WIDTH, HEIGHT);
  for (i = 0; i < PIXELS * 3; ++i) {
    const float shown = powf(fminf(fmaxf(picture[i], 0.0f), 1.0f), 1.0f / 2.2f);
    fputc((int)(shown * 255.0f + 0.5f), file);
  }
  if (fclose(file) != 0) {
    perror(path);
    exit(1);
  }
}

/* Exits with the denoiser's message if a call failed. */
static void check(stillray_error error, const stillray_denoiser* denoiser) {
  if (error != STILLRAY_OK) {
    fprintf(stderr, "%s: %s\n", stillray_error_name(error), stillray_error_message(denoiser));
    exit(1);
  }
}

static void set_input(stillray_denoiser* denoiser, const char* name, float* data, int channels) {
  const stillray_image image =
      stillray_interleaved(data, STILLRAY_FORMAT_FLOAT, channels, WIDTH, HEIGHT);
  check(stillray_denoiser_set_input(denoiser, name, &image), denoiser);
}

int main(int argc, char** argv) {
  const char* folder = argc > 1 ? argv[1] : ".";
  const stillray_image result =
      stillray_interleaved(clean, STILLRAY_FORMAT_FLOAT, 3, WIDTH, HEIGHT);
  stillray_memory_need need = STILLRAY_MEMORY_NEED_INIT;
  stillray_device* device;
  stillray_denoiser* denoiser;
  double noisy = 0;
  int32_t pulled;
  int frame;
  int done = 0;

  check(stillray_device_create(STILLRAY_ABI_VERSION, 0, &device), NULL);
  check(stillray_denoiser_create(device, "default", &denoiser), NULL);
  stillray_device_release(device); /* the denoiser holds its own reference */
  set_input(denoiser, "direct_diffuse", light, 3);
  set_input(denoiser, "albedo", albedo, 3);
  set_input(denoiser, "normal", normal, 3);
  set_input(denoiser, "depth", depth, 1);
  set_input(denoiser, "motion", motion, 2);
  check(stillray_denoiser_set_output(denoiser, "colour", &result), denoiser);
  check(stillray_denoiser_memory_need(denoiser, &need), denoiser);
  printf("memory: %.0f MB at most\n", (double)need.most / 1e6);

  for (frame = 0; frame <= FRAMES; ++frame) {
    if (frame < FRAMES) {
      render(frame);
      check(stillray_denoiser_push(denoiser, STILLRAY_CUT_FIND), denoiser);
    } else {
      check(stillray_denoiser_finish(denoiser), denoiser);
    }
    noisy = frame == 0 ? rms_error(light, 0) : noisy;
    for (;; ++done) { /* all finished frames */
      check(stillray_denoiser_pull(denoiser, &pulled), denoiser);
      if (!pulled) {
        break;
      }
      if (done == 0) {
        printf("rms error: noisy %.4f, denoised %.4f\n", noisy, rms_error(clean, 0));
        write_ppm(folder, "denoised.ppm", clean);
      }
    }
  }
  printf("%d frames\n", done);
  stillray_denoiser_release(denoiser);
  return done == FRAMES ? 0 : 1;
}
