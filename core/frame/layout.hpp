// Where a sensor's taxels are. A layout is made while setting up and never changes. Any thread may read it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace slipd {

// What a sensor measures.
enum class SensorClass : std::uint8_t {
  array3,       // pressure and shear at each taxel
  wrench,       // one force vector for the whole pad
  normal,       // pressure at each taxel, no shear
  displacement  // how far points of the surface have moved; no force
};

// Positions of taxels. A taxel is a square that averages over its area; all have the same side. Positions are
// those of the centres, in m, in the sensor's frame: x to the right, y up, the origin in the middle of a
// grid.
class TaxelLayout {
 public:
  // The parameters of a regular grid.
  struct Grid {
    std::size_t columns = 0;  // 1 to 4096, along x
    std::size_t rows = 0;     // 1 to 4096, along y
    double pitch_m = 0;       // distance of neighbouring centres, m; above 0
    bool operator==(const Grid&) const = default;
  };

  // A regular grid about the origin. Taxels are in order of rows from small y to large, x fastest. Throws
  // std::invalid_argument unless both counts are 1 to 4096 and the pitch is finite and positive.
  static TaxelLayout grid(std::size_t columns, std::size_t rows, double pitch_m);

  // Taxels at any positions. Their side is the median distance to the nearest neighbour. Throws
  // std::invalid_argument for fewer than two taxels, for lists of different length, for coordinates that are
  // not finite, and for two taxels at the same position.
  static TaxelLayout scattered(std::vector<double> x_m, std::vector<double> y_m);

  // One taxel at the origin, for a sensor of class wrench. `side_m`: of the pad. Throws std::invalid_argument
  // unless it is finite and positive.
  static TaxelLayout wrench(double side_m);

  // Number of taxels, at least 1.
  std::size_t size() const noexcept { return x_m_.size(); }
  // Centres along x, m; size() values.
  std::span<const double> x_m() const noexcept { return x_m_; }
  // Centres along y, m; size() values.
  std::span<const double> y_m() const noexcept { return y_m_; }
  // Side of one taxel, m.
  double side_m() const noexcept { return side_m_; }
  // Area of one taxel, m^2.
  double area_m2() const noexcept { return side_m_ * side_m_; }
  // The grid's parameters; none for a layout that is not a grid.
  const std::optional<Grid>& regular() const noexcept { return grid_; }
  bool operator==(const TaxelLayout&) const = default;

 private:
  TaxelLayout(std::vector<double> x_m, std::vector<double> y_m, double side_m, std::optional<Grid> grid);
  std::vector<double> x_m_, y_m_;
  double side_m_;
  std::optional<Grid> grid_;
};

}  // namespace slipd
