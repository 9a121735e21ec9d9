#include "paper/dataset/fold.hpp"

#include <algorithm>
#include <cmath>

namespace slipd {

Eigen::MatrixXf Fold::unfold(const Eigen::MatrixXf& folded) const {
  Eigen::MatrixXf spread(static_cast<Eigen::Index>(orbit.size()), folded.cols());
  for (std::size_t i = 0; i < orbit.size(); ++i) {
    spread.row(static_cast<Eigen::Index>(i)) =
        folded.row(static_cast<Eigen::Index>(orbit[i])) / weight[orbit[i]];
  }
  return spread;
}

std::optional<Fold> fold(const TaxelLayout& layout) {
  if (!layout.regular() || layout.regular()->columns != layout.regular()->rows) return std::nullopt;
  const std::size_t side = layout.regular()->columns;
  constexpr auto kNone = static_cast<std::size_t>(-1);
  Fold result;
  result.orbit.resize(side * side);
  std::vector<std::size_t> orbit_of_key(side * side, kNone), count;
  for (std::size_t row = 0; row < side; ++row) {
    for (std::size_t column = 0; column < side; ++column) {
      // Reflections in the axes, then in the diagonal: one eighth of the square names the orbit.
      const std::size_t x = std::min(column, side - 1 - column), y = std::min(row, side - 1 - row);
      std::size_t& orbit = orbit_of_key[std::max(x, y) * side + std::min(x, y)];
      if (orbit == kNone) {
        orbit = count.size();
        count.push_back(0);
        result.representative.push_back(row * side + column);
      }
      ++count[orbit];
      result.orbit[row * side + column] = orbit;
    }
  }
  for (const std::size_t n : count) result.weight.push_back(std::sqrt(static_cast<float>(n)));
  return result;
}

}  // namespace slipd
