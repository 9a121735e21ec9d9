// What taxels under a skin sense of a pull, from what they sensed of a pressure. A shear mu p in one
// direction is sensed as the pressure p is, after one filter more: in Fourier space (docs/theory.md §5.4),
// with the wave number k, the ratio of the two kernels
//   R = (1 - d k k^T/k)/(1 + k d),   a symmetric tensor that is nowhere larger than 1.
// So it amplifies no noise. Regular grids only; the pressure beyond the grid is taken for 0.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/frame/layout.hpp"

namespace slipd {

class ShearFromPressureFilter {
 public:
  // The logs of depths over the nominal one that set_depth is exact to three digits within.
  static constexpr double kReach = 0.3;

  // depth_m: of the taxels, >= 0. least_sensed: wave numbers of which a smaller share of the pressure is
  // sensed, (1 + k d) exp(-k d), are left out, 0 … 1. Allocates.
  ShearFromPressureFilter(const TaxelLayout::Grid& grid, double depth_m, double least_sensed = 0);

  // Another depth; log: of it over the nominal one, within kReach. Estimate thread; allocates nothing.
  void set_depth(double log) noexcept;

  // Shear sensed along i from a pull along j, and the pressure sensed from pulls along x and along y, each of
  // the grid's size; all are overwritten.
  struct Sensed {
    std::span<float> xx, xy, yy, nx, ny;
  };
  // normal: the pressure sensed, of the grid's size; the result has its unit. Estimate thread; allocates
  // nothing. About 10 log2(16 n) operations for each of 4 n taxels, four times.
  void apply(std::span<const float> normal, const Sensed& out) noexcept;

  // The shear that the pressure alone is sensed as, along x and along y: -i k d/(1 + k d). By the same kernel
  // a pull is sensed as pressure.
  void press(std::span<const float> normal, std::span<float> x, std::span<float> y) noexcept;

  // Variance of one taxel's shear after the filter, the mean of its two components summed, over the variance
  // of white noise before: the mean of |R t|^2 over all wave numbers.
  double noise_gain() const noexcept { return noise_gain_; }
  // The same of the pressure that is sensed from a pull.
  double pressing_gain() const noexcept { return pressing_gain_; }
  // Beside the object itself.
  std::size_t memory_bytes() const noexcept;

 private:
  // A plane of complex numbers.
  struct Plane {
    std::vector<float> re, im;
    void resize(std::size_t size) {
      re.resize(size);
      im.resize(size);
    }
  };
  // Roots of unity of a transform, exp(-2 pi i j/length) for j below length/2.
  struct Roots {
    explicit Roots(std::size_t length);
    const std::size_t length;
    std::vector<float> cosine, sine;
  };

  static void forward(Plane& plane, const Roots& roots, std::size_t width) noexcept;
  static void backward(Plane& plane, const Roots& roots, std::size_t width) noexcept;
  static void turn(const Plane& from, Plane& to, std::size_t rows, std::size_t columns) noexcept;
  void transform(std::span<const float> normal) noexcept;
  void transform_back() noexcept;
  void filter(const std::vector<float>& kernel_re, const std::vector<float>& kernel_im,
              std::span<float> out_re, std::span<float> out_im) noexcept;

  const std::size_t columns_;
  const Roots along_x_, along_y_;  // of twice the grid's width and height, or more
  // Over the transforms' lengths, in the order of spectrum_: the ratio, and that of pressing, x and i y.
  struct Kernels {
    std::vector<float> xx, xy, yy, press_re, press_im;
  };
  Kernels kernels_at(double depth_sides, double nominal_sides, double least_sensed);
  std::array<Kernels, 3> nodes_;  // at -kReach, 0 and kReach
  Kernels now_;
  Plane spectrum_;  // wave number along x, then along y, each with its bits reversed
  Plane product_;   // the same, filtered
  Plane lines_;     // y, then x
  double noise_gain_ = 1, pressing_gain_ = 0;
};

}  // namespace slipd
