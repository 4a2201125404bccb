// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "common/console.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>

namespace stillray {
namespace {

bool output_was_closed = false;
int first_output_error = 0;

bool IsClosed(int descriptor) {
  return ::fcntl(descriptor, F_GETFD) < 0;
}

}  // namespace

void WriteText(std::FILE* stream, std::string_view text) {
  const bool written = std::fwrite(text.data(), 1, text.size(), stream) == text.size();
  if (!written && stream == stdout && first_output_error == 0) {
    first_output_error = errno;
  }
}

void OccupyClosedStreams() {
  output_was_closed = IsClosed(STDOUT_FILENO);
  // open() returns the lowest free number.
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (IsClosed(descriptor) &&
        ::open("/dev/null", descriptor == STDIN_FILENO ? O_WRONLY : O_RDONLY) < 0) {
      return;
    }
  }
}

int OutputError() {
  if (std::fflush(stdout) != 0 && first_output_error == 0) {
    first_output_error = errno;
  }
  if (std::ferror(stdout) != 0 && first_output_error == 0) {
    first_output_error = EIO;
  }
  return output_was_closed ? 0 : first_output_error;
}

}  // namespace stillray
