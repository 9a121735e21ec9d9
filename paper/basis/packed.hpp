// A matrix kept without its zeros, in blocks of columns: what a contact does not touch takes no memory and no
// time. Training only.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "paper/basis/packed_kernels.hpp"
#include "paper/dataset/column_source.hpp"

namespace slipd {

class PackedColumns {
 public:
  // Makes every column of the source once. None: they would take more than `most_bytes`.
  static std::optional<PackedColumns> of(const ColumnSource& source, std::size_t most_bytes, unsigned threads,
                                         const std::function<void(double)>& progress = {});

  std::size_t rows() const noexcept { return rows_; }
  double squares() const noexcept { return squares_; }  // sum over all entries

  // X X' Q, double across lanes. q: as many rows, at most PackedKernels::kWidest columns.
  Eigen::MatrixXd multiply(const Eigen::MatrixXf& q, unsigned threads,
                           const std::function<void(double)>& progress = {}) const;
  // Q' X: a row for each of q's columns.
  Eigen::MatrixXf project(const Eigen::MatrixXf& q, unsigned threads) const;

 private:
  struct PackedBlock {
    std::vector<TaxelRun> runs;
    std::vector<float> values;
    std::vector<std::size_t> runs_to, values_to;  // of each column, where they end
    PackedColumn column(std::size_t index) const noexcept;
    void pack(const Eigen::Map<const Eigen::MatrixXf>& columns);
    std::size_t bytes() const noexcept;
  };

  std::size_t rows_ = 0, columns_ = 0;
  double squares_ = 0;
  std::vector<PackedBlock> blocks_;
};

}  // namespace slipd
