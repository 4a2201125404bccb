/* SPDX-FileCopyrightText: the stillray developers
 * SPDX-License-Identifier: Apache-2.0 */

/* The smallest renderer loop around the denoiser: a chequered wall, over which the camera pans, lit
 * with one noisy sample per pixel. Writes noisy.ppm and denoised.ppm of the last frame.
 *   cc denoise.c $(pkg-config --cflags --libs stillray) -lm && ./a.out [FOLDER] */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <stillray/stillray.h>

enum { WIDTH = 320, HEIGHT = 180, PIXELS = WIDTH * HEIGHT, FRAMES = 16, PAN = 2 };

static float light[PIXELS * 3];  /* noisy, linear RGB, albedo multiplied in */
static float truth[PIXELS * 3];  /* converged radiance */
static float albedo[PIXELS * 3]; /* reflectance of the surface */
static float normal[PIXELS * 3]; /* world space */
static float depth[PIXELS];      /* linear view z */
static float motion[PIXELS * 2]; /* previous minus current position, in pixels */
static float clean[PIXELS * 3];

static float uniform(uint32_t frame, uint32_t pixel) {
  uint32_t h = frame * 0x9E3779B9u ^ pixel * 0x85EBCA6Bu;
  h = (h ^ h >> 16) * 0x7FEB352Du;
  h = (h ^ h >> 15) * 0x846CA68Bu;
  return (float)((h ^ h >> 16) >> 8) / 16777216.0f;
}

static void render(int frame) {
  int x, y, c;
  for (y = 0; y < HEIGHT; ++y) {
    for (x = 0; x < WIDTH; ++x) {
      const int i = y * WIDTH + x;
      const int u = x + PAN * frame; /* position on the wall */
      const float arriving = 0.6f + 0.4f * sinf((float)u * 0.02f) * cosf((float)y * 0.03f);
      /* One sample hits the light with probability 1/4, and is then weighted by 4. */
      const float sample = uniform((uint32_t)frame, (uint32_t)i) < 0.25f ? 4.0f * arriving : 0.0f;
      for (c = 0; c < 3; ++c) {
        albedo[3 * i + c] = (u / 16 + y / 16) % 2 == 0 ? 0.8f : 0.2f + 0.2f * (float)c;
        truth[3 * i + c] = albedo[3 * i + c] * arriving;
        light[3 * i + c] = albedo[3 * i + c] * sample;
        normal[3 * i + c] = c == 2 ? 1.0f : 0.0f;
      }
      depth[i] = 5.0f;
      motion[2 * i] = (float)PAN;
      motion[2 * i + 1] = 0.0f;
    }
  }
}

static double rms_error(const float* picture) {
  double sum = 0;
  int i;
  for (i = 0; i < PIXELS * 3; ++i) {
    sum += (picture[i] - truth[i]) * (picture[i] - truth[i]);
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
  stillray_device* device;
  stillray_denoiser* denoiser;
  int frame;

  check(stillray_device_create(STILLRAY_ABI_VERSION, 0, &device), NULL);
  check(stillray_denoiser_create(device, "default", &denoiser), NULL);
  stillray_device_release(device); /* the denoiser holds its own reference */

  /* Memory is described once, since all frames use the same buffers. */
  set_input(denoiser, "direct_diffuse", light, 3);
  set_input(denoiser, "albedo", albedo, 3);
  set_input(denoiser, "normal", normal, 3);
  set_input(denoiser, "depth", depth, 1);
  set_input(denoiser, "motion", motion, 2);
  check(stillray_denoiser_set_output(denoiser, "colour", &result), denoiser);

  for (frame = 0; frame < FRAMES; ++frame) {
    render(frame);
    check(stillray_denoiser_execute(denoiser), denoiser);
  }
  printf("rms error: noisy %.4f, denoised %.4f\n", rms_error(light), rms_error(clean));
  write_ppm(folder, "noisy.ppm", light);
  write_ppm(folder, "denoised.ppm", clean);
  stillray_denoiser_release(denoiser);
  return 0;
}
