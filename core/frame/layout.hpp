// Where a sensor's taxels are. A layout is made once, while setting up, and then only read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace slipd {

// What a sensor can carry: pressure and shear per taxel, one force vector, or pressure only.
enum class SensorClass : std::uint8_t { array3, wrench, normal };

// Taxels are squares of one side length, which average what they feel over their area. Positions are those of
// their centres, in metres, in the sensor's own frame (x to the right, y up, origin in the middle of a grid).
class TaxelLayout {
 public:
  struct Grid {
    std::size_t columns = 0;
    std::size_t rows = 0;
    double pitch_m = 0;
    bool operator==(const Grid&) const = default;
  };

  // A regular grid about the origin, rows from y small to large, x fastest. Throws std::invalid_argument
  // unless both counts are 1…4096 and the pitch is finite and positive.
  static TaxelLayout grid(std::size_t columns, std::size_t rows, double pitch_m);

  // Taxels anywhere. Their side is the median distance to the nearest neighbour. Throws std::invalid_argument
  // for no taxel, coordinates that are not finite, or two taxels in one place.
  static TaxelLayout scattered(std::vector<double> x_m, std::vector<double> y_m);

  // One force vector for the whole pad: a single taxel at the origin, of the pad's side.
  static TaxelLayout wrench(double side_m);

  std::size_t size() const noexcept { return x_m_.size(); }
  std::span<const double> x_m() const noexcept { return x_m_; }
  std::span<const double> y_m() const noexcept { return y_m_; }
  double side_m() const noexcept { return side_m_; }
  double area_m2() const noexcept { return side_m_ * side_m_; }          // of one taxel
  const std::optional<Grid>& regular() const noexcept { return grid_; }  // set for a grid
  bool operator==(const TaxelLayout&) const = default;

 private:
  TaxelLayout(std::vector<double> x_m, std::vector<double> y_m, double side_m, std::optional<Grid> grid);
  std::vector<double> x_m_, y_m_;
  double side_m_;
  std::optional<Grid> grid_;
};

}  // namespace slipd
