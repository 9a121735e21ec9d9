#include "paper/basis/svd.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/numeric/random.hpp"
#include "paper/basis/packed.hpp"
#include "paper/dataset/blocks.hpp"

namespace slipd {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::MatrixXf;
using Eigen::VectorXd;

// What columns may take when they are kept; else they are made again for every pass.
constexpr std::size_t kMostKeptBytes = std::size_t{256} * 1024 * 1024;
// Of the first passes' bar that making the columns takes.
constexpr double kMaking = 0.5;

// Orthonormal columns that span those of y, in double: columns of very different size lose nothing.
MatrixXf orthonormal(const MatrixXd& y) {
  const Eigen::HouseholderQR<MatrixXd> qr(y);
  MatrixXd thin = MatrixXd::Identity(y.rows(), y.cols());
  thin.applyOnTheLeft(qr.householderQ());
  return thin.cast<float>();
}

MatrixXf random_start(Index rows, Index columns, std::uint64_t seed) {
  const RandomStream draws(seed);
  MatrixXd start(rows, columns);
  for (Index c = 0; c < columns; ++c) {
    const RandomStream column = draws.stream(static_cast<std::uint64_t>(c));
    for (Index r = 0; r < rows; ++r) start(r, c) = column.noise(static_cast<std::uint64_t>(r));
  }
  return orthonormal(start);
}

struct Pass {
  MatrixXd image;  // X X' Q
  double squares = 0;
};

Pass multiply(const ColumnSource& source, const MatrixXf& q, unsigned threads,
              const std::function<void(double)>& progress) {
  std::array<MatrixXf, kLanes> sums;
  std::array<double, kLanes> squares{};
  for (auto& sum : sums) sum = MatrixXf::Zero(q.rows(), q.cols());
  for_each_block(
      source, threads,
      [&](const Block& block) {
        const MatrixXf projected = block.values.transpose() * q;
        sums[block.lane].noalias() += block.values * projected;
        for (Index c = 0; c < block.values.cols(); ++c) {
          squares[block.lane] += static_cast<double>(block.values.col(c).squaredNorm());
        }
      },
      progress);
  Pass pass{MatrixXd::Zero(q.rows(), q.cols()), 0};
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    pass.image += sums[lane].cast<double>();
    pass.squares += squares[lane];
  }
  return pass;
}

}  // namespace

Svd randomized_svd(const ColumnSource& source, const SvdOptions& options, const Progress& progress) {
  const auto rows = static_cast<Index>(source.rows());
  const Index side = std::min(rows, static_cast<Index>(source.columns()));
  const Index rank = std::min<Index>(options.rank, side);
  const Index settled = options.settled > 0 ? std::min<Index>(options.settled, rank) : rank;
  const Index width = std::min<Index>(rank + options.oversampling, side);

  const auto say = [&](double share) {
    if (progress) progress(share, "singular vectors");
  };
  const bool narrow = static_cast<std::size_t>(width) <= PackedKernels::kWidest;
  const auto kept = narrow ? PackedColumns::of(source, kMostKeptBytes, options.threads,
                                               [&](double share) { say(kMaking * share); })
                           : std::nullopt;
  const double made = kept ? kMaking : 0;
  Svd result;
  MatrixXf q = random_start(rows, width, options.seed);
  VectorXd before = VectorXd::Zero(rank);
  for (result.passes = 1;; ++result.passes) {
    // How many passes it takes is not known before: the bar comes nearer to its end without arriving.
    const double from = 1 - std::pow(0.7, result.passes - 1), to = 1 - std::pow(0.7, result.passes);
    const auto passing = [&](double share) { say(made + (1 - made) * (from + (to - from) * share)); };
    const Pass pass = kept ? Pass{kept->multiply(q, options.threads, passing), kept->squares()}
                           : multiply(source, q, options.threads, passing);
    result.total_variance = pass.squares;
    // Rayleigh–Ritz: the best that the subspace holds. Q'(XX')Q is symmetric but for rounding.
    const MatrixXd small = q.cast<double>().transpose() * pass.image;
    const Eigen::SelfAdjointEigenSolver<MatrixXd> ritz(0.5 * (small + small.transpose()));
    const VectorXd values = ritz.eigenvalues().reverse().head(rank).cwiseMax(0).cwiseSqrt();
    const double change =
        ((values - before).array().abs() / values.array().max(1e-300)).head(settled).maxCoeff();
    before = values;
    if ((result.passes > 1 && change < options.tolerance) || result.passes >= options.max_passes ||
        width == rows) {
      const MatrixXd vectors = ritz.eigenvectors().rowwise().reverse().leftCols(rank);
      result.basis = (q.cast<double>() * vectors).cast<float>();
      result.singular_values = values;
      if (options.coordinates) {
        result.coordinates = kept ? kept->project(result.basis, options.threads)
                                  : project(source, result.basis, options.threads);
      }
      return result;
    }
    q = orthonormal(pass.image);
  }
}

MatrixXf project(const ColumnSource& source, const MatrixXf& basis, unsigned threads,
                 const Progress& progress) {
  MatrixXf result(basis.cols(), static_cast<Index>(source.columns()));
  for_each_block(
      source, threads,
      [&](const Block& block) {
        result.middleCols(static_cast<Index>(block.first), block.values.cols()).noalias() =
            basis.transpose() * block.values;
      },
      [&](double share) {
        if (progress) progress(share, "projections");
      });
  return result;
}

}  // namespace slipd
