// A small matrix in memory, as the source of columns that training streams.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <utility>

#include "core/numeric/random.hpp"
#include "paper/dataset/column_source.hpp"

namespace slipd::testing {

class MatrixSource final : public ColumnSource {
 public:
  explicit MatrixSource(Eigen::MatrixXf matrix) : matrix_(std::move(matrix)) {}
  const Eigen::MatrixXf& matrix() const { return matrix_; }
  std::size_t rows() const noexcept override { return static_cast<std::size_t>(matrix_.rows()); }
  std::size_t columns() const noexcept override { return static_cast<std::size_t>(matrix_.cols()); }
  void fill(std::size_t first, std::size_t count, float* out) const override {
    std::copy_n(matrix_.data() + first * rows(), count * rows(), out);
  }

 private:
  Eigen::MatrixXf matrix_;
};

inline Eigen::MatrixXf random_matrix(Eigen::Index rows, Eigen::Index columns, std::uint64_t seed) {
  Eigen::MatrixXf matrix = Eigen::MatrixXf::Zero(rows, columns);
  RandomStream(seed).add_noise(matrix.data(), static_cast<std::uint64_t>(matrix.size()), 1);
  return matrix;
}

}  // namespace slipd::testing
