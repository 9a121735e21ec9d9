// The contact model of SubsurfaceFit on the taxels of one frame: residuals, their slopes and normal equations
// (docs/methods.md §23.5). Estimate thread; nothing allocates after construction.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/contact/subsurface/subsurface.hpp"
#include "core/frame/layout.hpp"
#include "core/patch/patch.hpp"
#include "core/reading/fit/normal_equations/axisymmetric_normal_equations.hpp"
#include "core/reading/fit/normal_equations/ellipticity_test.hpp"
#include "core/reading/fit/normal_equations/slope_block.hpp"

namespace slipd {

class ContactShape {
 public:
  // Centre, m; mean radius sqrt(a b), m; peak pressure, Pa; Q/P; Gamma; direction of the pull, rad; log of
  // the taxels' depth over the nominal one; and of an ellipse log(a/b) times cosine and sine of twice the
  // direction of its long axis. Along the sensor's axes.
  enum Unknown {
    center_x,
    center_y,
    size,
    peak,
    load,
    margin,
    direction,
    depth,
    kRound,
    along = kRound,
    across,
    kMost
  };
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMost, 1>;
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMost, kMost>;
  using Full = Eigen::Matrix<double, kMost, 1>;
  using Detail = contact::SubsurfaceSheet::Detail;
  // Information on the log of a depth that is known.
  static constexpr double kHeldDepth = 1e12;
  // Standard deviations of a taxel's pressure and of each of its shears, Pa, > 0.
  struct Noise {
    double normal_pa = 1, shear_pa = 1;
  };
  // Half the squared residuals in units of noise, their gradient and Gauss-Newton's Hessian.
  struct Sums {
    double cost = 0;
    Vector gradient;
    Square hessian;
    void add(double weight, const Sums& other) noexcept;
  };
  // Of all channels, and what the pressure and both shears add to it.
  struct Normal : Sums {
    Sums of_pressure, of_shear;
    // The same in units of another noise.
    void change_noise(const Noise& before, const Noise& after) noexcept;
  };

  // depth_m: of the taxels, >= 0. bonded_poisson: see Skin.
  ContactShape(const TaxelLayout& layout, double depth_m,
               std::optional<double> bonded_poisson = std::nullopt);

  // As nominal; a depth below or above by a factor of 2 at most may be evaluated.
  double depth_m() const noexcept { return depth_m_; }

  // A new frame: the taxels within `reach` about the patch's centre (all of a layout of at most all_below
  // taxels). Its noise is 1 Pa until set_noise.
  void collect(const ContactPatch& patch, const contact::Ellipse& reach, std::size_t all_below) noexcept;
  // All taxels, and no pressure or shear on them.
  void collect_nothing() noexcept;

  // For the first steps of a fit: at least so many of the taxels, evenly chosen, and rough averages.
  void use_part(std::size_t taxels) noexcept;
  // For its last steps: all taxels, and exact averages.
  void use_all() noexcept;
  // Whether use_part is less than use_all.
  bool partial() const noexcept { return frame_.detail != Detail::exact; }

  void set_noise(const Noise& noise) noexcept { frame_.noise = noise; }
  // The same after an evaluation, whose residuals are then in units of this noise.
  void change_noise(const Noise& noise) noexcept;
  const Noise& noise() const noexcept { return frame_.noise; }

  // By so many unknowns, kRound or kMost.
  void evaluate(const Full& at, int unknowns, Normal& normal) noexcept;
  // Of the last evaluation, of a round contact: squared length, in standard deviations, of a step of Newton's
  // method from there to an ellipse.
  double axes_sigmas2(const Full& at) noexcept;
  // The same by the covariance of an ellipse's unknowns, for its axes.
  static double axes_sigmas2(const Square& hessian, const Eigen::Vector2d& axes) noexcept;

  // Of the taxels in use.
  std::size_t count() const noexcept { return frame_.count; }
  // Their numbers in the layout, after use_all.
  std::span<const std::uint32_t> taxels() const noexcept { return {taxel_.data(), frame_.count}; }
  // Of the last evaluation, in units of noise: pressures of all taxels in use, then the shears along x and y.
  std::span<const double> residuals() const noexcept { return {residuals_.data(), 3 * frame_.count}; }
  // Pa, in the same order.
  std::span<const double> data_pa() const noexcept { return {data_.data(), 3 * frame_.count}; }
  // Places from the centre of the last evaluation, or of show().
  std::span<const double> u() const noexcept { return {u_.data(), frame_.count}; }
  std::span<const double> v() const noexcept { return {v_.data(), frame_.count}; }
  // Values of the dome of unit height over the whole contact; and then over a part of it, `scale` times as
  // large.
  const contact::SubsurfaceSheet& show(const Full& at, Detail detail) noexcept;
  // As show(), rough, with slopes.
  const contact::SubsurfaceSheet& show_slopes(const Full& at) noexcept;
  const contact::SubsurfaceSheet& show_part(const Full& at, double scale, Detail detail) noexcept;

  static contact::Ellipse ellipse_of(const Full& at, double scale) noexcept;
  std::size_t memory_bytes() const noexcept;

 private:
  void place(const Full& at) noexcept;
  void set_depth(double log) noexcept;
  void choose(std::size_t count, Detail detail) noexcept;
  // From its centre to the farthest corner of a taxel in use, m.
  double farthest_m(const Full& at) const noexcept;
  static RoundTrial trial_of(const Full& at) noexcept;
  RoundTask task() noexcept;
  bool evaluate_round(const Full& at, Normal& normal) noexcept;
  void evaluate_sheets(const Full& at, int unknowns, Detail detail, bool residuals_given,
                       Normal& normal) noexcept;
  static void spread(const ChannelProducts& products, int unknowns, Normal& normal) noexcept;

  const TaxelLayout layout_;
  double depth_m_, depth_log_ = 0;
  contact::SubsurfaceSheet outer_, inner_;
  AxisymmetricNormalEquations round_;
  EllipticityTest axes_;
  struct ThisFrame {
    std::size_t collected = 0, count = 0;  // taxels; and those in use
    Detail detail = Detail::exact;
    Noise noise;
  };
  ThisFrame frame_;
  std::vector<std::uint32_t> taxel_;
  std::vector<double> x_, y_, u_, v_;
  // Of all collected taxels pressure, shear along x and shear along y; and of those in use.
  std::vector<double> all_data_, data_, residuals_;
};

}  // namespace slipd
