// The leading singular vectors of a matrix that only streams by (U_r of docs/methods.md §26.2).
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "paper/dataset/column_source.hpp"

namespace slipd {

struct SvdOptions {
  int rank = 8;             // clipped to the matrix's smaller side
  int oversampling = 10;    // more directions carried along, so that the kept ones converge fast
  int max_passes = 24;      // over the matrix
  double tolerance = 1e-6;  // relative change of the singular values at which it ends
  int settled = 0;          // of how many of them, counted from the largest; 0: of all that are kept
  unsigned threads = 2;
  std::uint64_t seed = 1;  // of the start
  bool coordinates = false;
};

struct Svd {
  Eigen::MatrixXf basis;            // rows x rank, orthonormal columns
  Eigen::VectorXd singular_values;  // rank, falling
  double total_variance = 0;        // sum of squares of all entries: the sum of all squared singular values
  Eigen::MatrixXf coordinates;      // rank x columns, basis' X; empty unless asked for
  int passes = 0;
};

// Not centred. Randomised subspace iteration with Rayleigh–Ritz (docs/methods.md §26.2): each pass
// adds X_B (X_B' Q) over all blocks. The columns are made once and kept without their zeros if that takes no
// more than 256 MB, else anew for each pass. Memory besides: a few rows x (rank + oversampling) arrays and
// one block a thread.
Svd randomized_svd(const ColumnSource& source, const SvdOptions& options, const Progress& progress = {});

// basis' X: rank x columns.
Eigen::MatrixXf project(const ColumnSource& source, const Eigen::MatrixXf& basis, unsigned threads,
                        const Progress& progress = {});

}  // namespace slipd
