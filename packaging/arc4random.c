/* SPDX-FileCopyrightText: the stillray developers
 * SPDX-License-Identifier: Apache-2.0 */

/* The one function of glibc 2.36 that Debian 12's libstdc++ uses, for std::random_device: with it
 * beside libstdc++, the archive runs with glibc 2.35. */
#include <errno.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/random.h>

uint32_t arc4random(void) {
  uint32_t value = 0;
  while (getrandom(&value, sizeof(value), 0) != (ssize_t)sizeof(value)) {
    if (errno != EINTR) {
      abort();
    }
  }
  return value;
}
