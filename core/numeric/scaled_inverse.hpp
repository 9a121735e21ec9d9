// Diagonal of the inverse of a matrix whose unknowns differ by many decades in their units: it is scaled to a
// unit diagonal first, which improves its condition number.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <limits>

namespace slipd {

// Matrix: square, symmetric and positive definite, such as the information of a fit. Allocates nothing where
// Matrix has a fixed largest size.
template <class Matrix>
class ScaledInverse {
 public:
  explicit ScaledInverse(const Matrix& matrix) noexcept
      : scale_(matrix.diagonal().cwiseSqrt().cwiseInverse()),
        decomposed_(Matrix(scale_.asDiagonal() * matrix * scale_.asDiagonal())) {}

  // The element in row and column `unknown`: the variance of that unknown. Infinite where the matrix is
  // singular to within rounding.
  double variance(int unknown) const noexcept {
    constexpr double kMostScaled = 1e12;  // of the scaled inverse: beyond it only rounding is left
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    if (!scale_.allFinite()) return kInfinite;
    Vector column = Vector::Zero(scale_.size());
    column[unknown] = 1;
    const double scaled = Vector(decomposed_.solve(column))[unknown];
    return scaled > 0 && scaled < kMostScaled ? scaled * scale_[unknown] * scale_[unknown] : kInfinite;
  }

 private:
  using Vector =
      Eigen::Matrix<double, Matrix::RowsAtCompileTime, 1, Eigen::ColMajor, Matrix::MaxRowsAtCompileTime, 1>;
  Vector scale_;
  Eigen::LDLT<Matrix> decomposed_;
};

}  // namespace slipd
