/* SPDX-FileCopyrightText: the stillray developers
 * SPDX-License-Identifier: Apache-2.0 */

/* bin/NAME of an archive: starts libexec/NAME beside it. The libraries in lib/ are always
 * those of the archive. Those in lib/host/ are used by graphics drivers of the machine, too, which
 * may need newer ones: they are taken from the archive only where the machine has none, or older
 * ones than the program needs. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { kExitBadInput = 2 };

/* A library of the machine, and the newest symbol that the program needs of it. */
typedef struct Probe {
  const char* folder; /* in lib/host/: it and what it needs */
  const char* library;
  const char* symbol;
  const char* version;
} Probe;

static const Probe kProbes[] = {
    /* std::__glibcxx_assert_fail */
    {"cxx", "libstdc++.so.6", "_ZSt21__glibcxx_assert_failPKciS0_S0_", "GLIBCXX_3.4.30"},
    {"cxx", "libgcc_s.so.1", "_Unwind_Resume", "GCC_3.0"},
    {"z", "libz.so.1", "inflateReset2", "ZLIB_1.2.3.4"},
    {"x11", "libX11.so.6", "XOpenDisplay", NULL},
    {"gl", "libOpenGL.so.0", "glClear", NULL},
};

static int Fail(const char* what, const char* value) {
  fprintf(stderr, "stillray: error: %s%s%s: %s\n", what, value[0] != '\0' ? " " : "", value,
          strerror(errno));
  return kExitBadInput;
}

static int IsOnThisMachine(const Probe* probe) {
  void* library = dlopen(probe->library, RTLD_LAZY | RTLD_LOCAL);
  if (library == NULL) {
    return 0;
  }
  return (probe->version != NULL ? dlvsym(library, probe->symbol, probe->version)
                                 : dlsym(library, probe->symbol)) != NULL;
}

/* The archive's folder: that of bin/NAME, whichever link it was started by. */
static int FindFolder(char* folder, char* name) {
  const ssize_t length = readlink("/proc/self/exe", folder, PATH_MAX - 1);
  if (length < 0) {
    return 0;
  }
  folder[length] = '\0';
  const char* file = strrchr(folder, '/');
  strcpy(name, file != NULL ? file + 1 : folder);
  for (int levels = 2; levels > 0; --levels) {
    char* slash = strrchr(folder, '/');
    if (slash == NULL) {
      errno = ENOENT;
      return 0;
    }
    *slash = '\0';
  }
  return 1;
}

/* Puts folders of the archive before those that the caller has set. */
static int AddToLibraryPath(const char* folder, const char* name) {
  const char* before = getenv("LD_LIBRARY_PATH");
  char* path = NULL;
  if (asprintf(&path, "%s/lib/host/%s%s%s", folder, name,
               before != NULL && before[0] != '\0' ? ":" : "", before != NULL ? before : "") < 0) {
    return 0;
  }
  const int error = setenv("LD_LIBRARY_PATH", path, 1);
  free(path);
  return error == 0;
}

int main(int argc, char** argv) {
  char folder[PATH_MAX];
  char name[PATH_MAX];
  (void)argc;
  if (!FindFolder(folder, name)) {
    return Fail("the folder of the program cannot be found by", "/proc/self/exe");
  }
  const char* added = "";
  for (size_t i = 0; i < sizeof(kProbes) / sizeof(kProbes[0]); ++i) {
    const Probe* probe = &kProbes[i];
    if (strcmp(added, probe->folder) == 0 || IsOnThisMachine(probe)) {
      continue;
    }
    if (strpbrk(folder, ":;") != NULL) {
      fprintf(
          stderr,
          "stillray: error: %s is not on this machine, and is not found in %s, whose name has a "
          "':' or ';': move the folder\n",
          probe->library, folder);
      return kExitBadInput;
    }
    if (!AddToLibraryPath(folder, probe->folder)) {
      return Fail("no memory for", "LD_LIBRARY_PATH");
    }
    added = probe->folder;
  }
  char program[2 * PATH_MAX + 16];
  snprintf(program, sizeof(program), "%s/libexec/%s", folder, name);
  execv(program, argv);
  return Fail("could not start", program);
}
