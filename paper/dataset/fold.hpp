// Taxels that a contact in the middle cannot tell apart: the orbits of a square grid under the square's 8
// symmetries (docs/methods.md §26.3). Data that are the same on each orbit need one row an orbit, an eighth
// of the work.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/frame/layout.hpp"

namespace slipd {

struct Fold {
  std::vector<std::size_t> representative;  // of each orbit: a taxel
  std::vector<float> weight;       // of each orbit: sqrt(how many taxels), so that norms stay what they were
  std::vector<std::size_t> orbit;  // of each taxel

  // A basis of the folded rows, spread over all taxels again; orthonormal columns stay orthonormal.
  Eigen::MatrixXf unfold(const Eigen::MatrixXf& folded) const;
};

// Nothing unless the layout is a square grid.
std::optional<Fold> fold(const TaxelLayout& layout);

}  // namespace slipd
