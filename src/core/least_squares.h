// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Small problems of least squares.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace stillray {

/// Normal equations of a least-squares problem with N unknowns.
template <int N>
struct NormalEquations {
  std::array<std::array<double, N>, N> squares{};
  std::array<double, N> products{};

  void Add(const std::array<double, N>& row, double value, double weight) {
    for (size_t i = 0; i < N; ++i) {
      for (size_t j = 0; j <= i; ++j) {
        squares[i][j] += weight * row[i] * row[j];
      }
      products[i] += weight * row[i] * value;
    }
  }

  void Add(const NormalEquations& other) {
    for (size_t i = 0; i < N; ++i) {
      for (size_t j = 0; j <= i; ++j) {
        squares[i][j] += other.squares[i][j];
      }
      products[i] += other.products[i];
    }
  }

  /// Cholesky. \param ridge  relative to the largest square; keeps unknowns that no equation
  /// determines at zero
  std::array<double, N> Solve(double ridge) const {
    double largest = 1e-300;
    for (size_t i = 0; i < N; ++i) {
      largest = std::max(largest, squares[i][i]);
    }
    auto l = squares;
    std::array<double, N> x = products;
    for (size_t i = 0; i < N; ++i) {
      l[i][i] += ridge * largest;
      for (size_t j = 0; j <= i; ++j) {
        for (size_t k = 0; k < j; ++k) {
          l[i][j] -= l[i][k] * l[j][k];
        }
        l[i][j] = i == j ? std::sqrt(std::max(l[i][i], 1e-300)) : l[i][j] / l[j][j];
      }
      for (size_t k = 0; k < i; ++k) {
        x[i] -= l[i][k] * x[k];
      }
      x[i] /= l[i][i];
    }
    for (size_t i = N; i-- > 0;) {
      for (size_t k = i + 1; k < N; ++k) {
        x[i] -= l[k][i] * x[k];
      }
      x[i] /= l[i][i];
    }
    return x;
  }
};

}  // namespace stillray
