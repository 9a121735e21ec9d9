#include "core/frame/layout.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/numeric/norm.hpp"

namespace slipd {
namespace {

// Compares all pairs: half a million for 1000 taxels. It runs once a sensor.
double median_nearest_distance(const std::vector<double>& x, const std::vector<double>& y) {
  std::vector<double> nearest(x.size(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (std::size_t j = i + 1; j < x.size(); ++j) {
      const double d = norm(x[i] - x[j], y[i] - y[j]);
      if (d == 0) {
        throw std::invalid_argument("taxels " + std::to_string(i) + " and " + std::to_string(j) +
                                    " are in the same place");
      }
      nearest[i] = std::min(nearest[i], d);
      nearest[j] = std::min(nearest[j], d);
    }
  }
  const auto middle = nearest.begin() + static_cast<std::ptrdiff_t>(nearest.size() / 2);
  std::nth_element(nearest.begin(), middle, nearest.end());
  return *middle;
}

}  // namespace

TaxelLayout::TaxelLayout(std::vector<double> x_m, std::vector<double> y_m, double side_m,
                         std::optional<Grid> grid)
    : x_m_(std::move(x_m)), y_m_(std::move(y_m)), side_m_(side_m), grid_(grid) {}

TaxelLayout TaxelLayout::grid(std::size_t columns, std::size_t rows, double pitch_m) {
  if (columns < 1 || columns > 4096 || rows < 1 || rows > 4096) {
    throw std::invalid_argument("a grid has 1 to 4096 columns and rows");
  }
  if (!std::isfinite(pitch_m) || pitch_m <= 0) throw std::invalid_argument("a grid's pitch must be positive");
  std::vector<double> x(columns * rows), y(columns * rows);
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t c = 0; c < columns; ++c) {
      x[r * columns + c] = (static_cast<double>(c) - 0.5 * static_cast<double>(columns - 1)) * pitch_m;
      y[r * columns + c] = (static_cast<double>(r) - 0.5 * static_cast<double>(rows - 1)) * pitch_m;
    }
  }
  return {std::move(x), std::move(y), pitch_m, Grid{columns, rows, pitch_m}};
}

TaxelLayout TaxelLayout::scattered(std::vector<double> x_m, std::vector<double> y_m) {
  if (x_m.empty() || x_m.size() != y_m.size())
    throw std::invalid_argument("a layout needs at least one taxel");
  const auto finite = [](double v) { return std::isfinite(v); };
  if (!std::all_of(x_m.begin(), x_m.end(), finite) || !std::all_of(y_m.begin(), y_m.end(), finite)) {
    throw std::invalid_argument("taxel positions must be finite");
  }
  if (x_m.size() == 1)
    throw std::invalid_argument("a single taxel has no neighbour to give its size: use a wrench layout");
  const double side = median_nearest_distance(x_m, y_m);
  return {std::move(x_m), std::move(y_m), side, std::nullopt};
}

TaxelLayout TaxelLayout::wrench(double side_m) {
  if (!std::isfinite(side_m) || side_m <= 0) throw std::invalid_argument("a pad's side must be positive");
  return {{0.0}, {0.0}, side_m, std::nullopt};
}

}  // namespace slipd
