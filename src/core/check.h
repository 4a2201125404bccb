// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Checks of internal invariants: a failure is a defect of stillray, so both values are printed and
/// the program aborts. Errors of callers and files are reported as a Status instead.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <sstream>

namespace stillray::internal {

[[noreturn]] inline void CheckFailed(const char* file, int line, const std::string& what) {
  std::fprintf(stderr, "%s:%d: internal check failed: %s\n", file, line, what.c_str());
  std::abort();
}

template <typename A, typename B>
std::string Describe(const char* text, const A& a, const B& b) {
  std::ostringstream out;
  out << text << " (" << a << " vs. " << b << ")";
  return out.str();
}

}  // namespace stillray::internal

#define STILLRAY_CHECK(condition)                                        \
  do {                                                                   \
    if (!(condition)) {                                                  \
      ::stillray::internal::CheckFailed(__FILE__, __LINE__, #condition); \
    }                                                                    \
  } while (false)
#define STILLRAY_CHECK_OP_(a, b, op)                                                    \
  do {                                                                                  \
    const auto& stillray_a_ = (a);                                                      \
    const auto& stillray_b_ = (b);                                                      \
    if (!(stillray_a_ op stillray_b_)) {                                                \
      ::stillray::internal::CheckFailed(                                                \
          __FILE__, __LINE__,                                                           \
          ::stillray::internal::Describe(#a " " #op " " #b, stillray_a_, stillray_b_)); \
    }                                                                                   \
  } while (false)
#define STILLRAY_CHECK_EQ(a, b) STILLRAY_CHECK_OP_(a, b, ==)
#define STILLRAY_CHECK_LE(a, b) STILLRAY_CHECK_OP_(a, b, <=)
#define STILLRAY_CHECK_LT(a, b) STILLRAY_CHECK_OP_(a, b, <)
