#include "camera/surface/printed_grid.hpp"

#include <array>
#include <cstddef>
#include <deque>
#include <opencv2/core.hpp>
#include <optional>

namespace slipd::camera {
namespace {

constexpr double kLeastOnGrid = 0.8;
constexpr std::size_t kLeastDots = 9;
// A dot is a neighbour's neighbour within this of the expected place, spacings: nearer than any other one.
constexpr double kNear = 0.45;
constexpr double kHuberPx = 1;  // dots that a contact moves by more count less
constexpr int kRounds = 10;

using Cells = std::vector<std::optional<cv::Point2i>>;

std::optional<std::size_t> dot_near(std::span<const cv::Point2f> dots, cv::Point2f place, double within) {
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < dots.size(); ++i) {
    const double away = cv::norm(dots[i] - place);
    if (away >= within) continue;
    within = away;
    found = i;
  }
  return found;
}

// Column and row of each dot, counted from dot `first` along its neighbours.
Cells cells_from(std::span<const cv::Point2f> dots, std::size_t first, double spacing_px) {
  Cells cells(dots.size());
  cells[first] = cv::Point2i(0, 0);
  std::deque<std::size_t> open{first};
  for (; !open.empty(); open.pop_front()) {
    const std::size_t from = open.front();
    for (const cv::Point2i step : {cv::Point2i(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
      const cv::Point2f place = dots[from] + cv::Point2f(step) * static_cast<float>(spacing_px);
      const auto next = dot_near(dots, place, kNear * spacing_px);
      if (!next || cells[*next]) continue;
      cells[*next] = *cells[from] + step;
      open.push_back(*next);
    }
  }
  return cells;
}

// Places on the even grid: x and y as linear functions of column and row, by least squares with Huber's
// weights.
std::vector<cv::Point2f> fitted(std::span<const cv::Point2f> dots, const Cells& cells) {
  std::vector<cv::Point2f> places(dots.begin(), dots.end());
  std::vector<double> weights(dots.size(), 1);
  for (int round = 0; round < kRounds; ++round) {
    cv::Matx33d normal = cv::Matx33d::zeros();
    cv::Matx<double, 3, 2> right = cv::Matx<double, 3, 2>::zeros();
    for (std::size_t i = 0; i < dots.size(); ++i) {
      if (!cells[i]) continue;
      const cv::Vec3d row(1, cells[i]->x, cells[i]->y);
      normal += weights[i] * (row * row.t());
      right += weights[i] * (row * cv::Matx12d(dots[i].x, dots[i].y));
    }
    const cv::Matx<double, 3, 2> grid = normal.solve(right, cv::DECOMP_SVD);
    for (std::size_t i = 0; i < dots.size(); ++i) {
      if (!cells[i]) continue;
      const cv::Matx12d at = cv::Matx13d(1, cells[i]->x, cells[i]->y) * grid;
      places[i] = {static_cast<float>(at(0)), static_cast<float>(at(1))};
      const double away = cv::norm(places[i] - dots[i]);
      weights[i] = away > kHuberPx ? kHuberPx / away : 1;
    }
  }
  return places;
}

}  // namespace

std::vector<cv::Point2f> on_printed_grid(std::span<const cv::Point2f> dots, double spacing_px) {
  if (dots.size() < kLeastDots) return {};
  cv::Point2f middle(0, 0);
  for (const cv::Point2f dot : dots) middle += dot * (1 / static_cast<float>(dots.size()));
  const auto first = dot_near(dots, middle, 2 * spacing_px);
  if (!first) return {};
  const Cells cells = cells_from(dots, *first, spacing_px);
  std::size_t placed = 0;
  for (const auto& cell : cells) placed += cell ? 1 : 0;
  if (static_cast<double>(placed) < kLeastOnGrid * static_cast<double>(dots.size())) return {};
  return fitted(dots, cells);
}

}  // namespace slipd::camera
