#include "paper/basis/packed.hpp"

#include <array>
#include <atomic>

#include "core/simd/instruction_sets.hpp"
#include "paper/dataset/blocks.hpp"

namespace slipd {
namespace {

using Eigen::Index;
// A row's values side by side, with zeros up to a whole number of vectors.
using ByRow = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

ByRow widened(const Eigen::MatrixXf& q) {
  constexpr auto kStep = static_cast<Index>(PackedKernels::kStep);
  ByRow wide = ByRow::Zero(q.rows(), (q.cols() + kStep - 1) / kStep * kStep);
  wide.leftCols(q.cols()) = q;
  return wide;
}

}  // namespace

void PackedColumns::PackedBlock::pack(const Eigen::Map<const Eigen::MatrixXf>& columns) {
  const auto rows = static_cast<std::uint32_t>(columns.rows());
  for (Index c = 0; c < columns.cols(); ++c) {
    const float* const column = columns.col(c).data();
    for (std::uint32_t i = 0; i < rows;) {
      if (column[i] == 0) {
        ++i;
        continue;
      }
      const std::uint32_t first = i;
      while (i < rows && column[i] != 0) ++i;
      runs.push_back({first, i});
      values.insert(values.end(), column + first, column + i);
    }
    runs_to.push_back(runs.size());
    values_to.push_back(values.size());
  }
  runs.shrink_to_fit();
  values.shrink_to_fit();
}

PackedColumn PackedColumns::PackedBlock::column(std::size_t index) const noexcept {
  const std::size_t first = index == 0 ? 0 : runs_to[index - 1];
  return {std::span(runs).subspan(first, runs_to[index] - first),
          values.data() + (index == 0 ? 0 : values_to[index - 1])};
}

std::size_t PackedColumns::PackedBlock::bytes() const noexcept {
  return sizeof(TaxelRun) * runs.capacity() + sizeof(float) * values.capacity() +
         2 * sizeof(std::size_t) * runs_to.capacity();
}

std::optional<PackedColumns> PackedColumns::of(const ColumnSource& source, std::size_t most_bytes,
                                               unsigned threads,
                                               const std::function<void(double)>& progress) {
  PackedColumns made;
  made.rows_ = source.rows();
  made.columns_ = source.columns();
  made.blocks_.resize(blocks_of(source.columns()));
  std::atomic<std::size_t> bytes{0};  // relaxed: a number of its own
  std::array<double, kLanes> squares{};
  for_each_block(
      source, threads,
      [&](const Block& block) {
        if (bytes.load(std::memory_order_relaxed) > most_bytes) return;
        PackedBlock& to = made.blocks_[block.first / kBlockColumns];
        to.pack(block.values);
        bytes.fetch_add(to.bytes(), std::memory_order_relaxed);
        for (Index c = 0; c < block.values.cols(); ++c)
          squares[block.lane] += static_cast<double>(block.values.col(c).squaredNorm());
      },
      progress);
  if (bytes.load(std::memory_order_relaxed) > most_bytes) return std::nullopt;
  for (const double each : squares) made.squares_ += each;
  return made;
}

Eigen::MatrixXd PackedColumns::multiply(const Eigen::MatrixXf& q, unsigned threads,
                                        const std::function<void(double)>& progress) const {
  const ByRow wide = widened(q);
  const auto width = static_cast<std::size_t>(wide.cols());
  std::array<ByRow, kLanes> sums;
  for (auto& sum : sums) sum = ByRow::Zero(wide.rows(), wide.cols());
  for_each_index(
      blocks_.size(), threads,
      [&](std::size_t, std::size_t lane, std::size_t index) {
        const PackedKernels& kernels = best_kernels<PackedKernels>();
        const PackedBlock& block = blocks_[index];
        std::array<float, PackedKernels::kWidest> z;
        for (std::size_t c = 0; c < block.runs_to.size(); ++c) {
          const PackedColumn x = block.column(c);
          kernels.project(x, wide.data(), width, z.data());
          kernels.add_product(x, z.data(), width, sums[lane].data());
        }
      },
      progress);
  Eigen::MatrixXd image = Eigen::MatrixXd::Zero(q.rows(), q.cols());
  for (const auto& sum : sums) image += sum.leftCols(q.cols()).cast<double>();
  return image;
}

Eigen::MatrixXf PackedColumns::project(const Eigen::MatrixXf& q, unsigned threads) const {
  const ByRow wide = widened(q);
  Eigen::MatrixXf result(q.cols(), static_cast<Index>(columns_));
  for_each_index(blocks_.size(), threads, [&](std::size_t, std::size_t, std::size_t index) {
    const PackedBlock& block = blocks_[index];
    std::array<float, PackedKernels::kWidest> z;
    for (std::size_t c = 0; c < block.runs_to.size(); ++c) {
      best_kernels<PackedKernels>().project(block.column(c), wide.data(),
                                            static_cast<std::size_t>(wide.cols()), z.data());
      result.col(static_cast<Index>(index * kBlockColumns + c)) =
          Eigen::Map<const Eigen::VectorXf>(z.data(), q.cols());
    }
  });
  return result;
}

}  // namespace slipd
