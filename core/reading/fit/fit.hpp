// Maximum likelihood: the contact model itself, averaged over every taxel, fitted to pressure and shear
// together (docs/methods.md §23). The method that costs most time, and the one that
// comes near what the noise allows (the Cramer-Rao limit), on any layout, with part of the contact beyond the
// sensor's edge, or with taxels dead. As method block-fit it reads taxels summed in square blocks, in a fifth
// of the time where a contact is many taxels wide (docs/methods.md §24).
//
// Unknown are the centre, the radius a, the pressure's height B = p0/a, the load T = Q/P and Gamma:
//   p = B A(a),   q = B T (A(a) - A(k a)) / (1 - Gamma),   k^3 = Gamma,   A(x) the average of sqrt(x^2 -
//   r^2).
// T and Gamma stay well apart at any load, where mu and k would not: near no load only mu (1 - k) is sensed.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/contact/scene.hpp"
#include "core/contact/subsurface/dome.hpp"
#include "core/reading/fit/fit_options.hpp"
#include "core/reading/fit/fit_samples.hpp"
#include "core/reading/fit/margin_parabola.hpp"
#include "core/reading/fit/normal_equations/dome_products.hpp"
#include "core/reading/fit/subsurface_fit.hpp"
#include "core/reading/method/friction_prior.hpp"
#include "core/reading/method/method.hpp"
#include "core/reading/moments/moments.hpp"

namespace slipd {

// Samples are taxels, or sums of several. Estimate thread; allocates in constructors only.
class Fit : public SlipMethod {
 public:
  Method name() const noexcept override { return Method::fit; }
  void forget() noexcept override {}
  MethodSettings settings() const noexcept override { return {.memory_bytes = memory_bytes()}; }

  // Levenberg-Marquardt from the moments' start, at most kMostSteps steps. Not in the model if it did not
  // converge or if the residual is more than noise and the skin's unevenness explain.
  Reading estimate(const Frame& frame, const ContactPatch& patch) noexcept final;

  int steps() const noexcept { return frame_.steps; }  // that the last frame took

 protected:
  enum Unknown { center_x, center_y, radius, height, load, margin, kUnknowns };
  using Vector = Eigen::Matrix<double, kUnknowns, 1>;
  using Square = Eigen::Matrix<double, kUnknowns, kUnknowns>;

  struct Minimum {
    Vector at;
    Square hessian;
    bool converged = false;
  };

  // A dome averaged over each sample.
  struct Dome {
    std::vector<double> value, d_x, d_u, d_v;

    explicit Dome(std::size_t most) : value(most), d_x(most), d_u(most), d_v(most) {}
    contact::DomeAverages averages() noexcept { return {value, d_x, d_u, d_v}; }
    DomePointers pointers() const noexcept { return {value.data(), d_x.data(), d_u.data(), d_v.data()}; }
  };

  // samples: what collect() fills; outlives this.
  Fit(const TaxelLayout& layout, Range friction_expected, const FitOptions& options, FitSamples& samples);
  virtual std::size_t memory_bytes() const noexcept = 0;
  // Of samples and domes.
  std::size_t samples_bytes() const noexcept;

  // The samples of a contact.
  virtual void collect(const ContactPatch& patch) noexcept = 0;
  // A frame whose samples and moments are there.
  virtual void read(const ContactPatch& patch, const MomentRatio& ratio, Reading& out) noexcept = 0;

  // Of the samples as they are now.
  void set_noise(const ContactPatch& patch) noexcept;
  Vector start(const ContactPatch& patch, const MomentRatio& ratio) const noexcept;
  // Half the squared residuals in units of noise, their gradient and Gauss-Newton's Hessian. Pressure and
  // shear are linear in height and load; these are set to what fits best with the others as they are. Not
  // finite, and nothing is set, where no sample is in the contact.
  double evaluate(Vector& at, Vector& gradient, Square& hessian) noexcept;
  Minimum minimise(const Vector& start) noexcept;
  // From the moments; none: there is no load, or there are too few samples.
  std::optional<Vector> start_of(const ContactPatch& patch, const MomentRatio& ratio) noexcept;
  // What a minimum says of a contact with many samples.
  void conclude(const ContactPatch& patch, const MomentRatio& ratio, const Minimum& minimum,
                Reading& out) noexcept;
  // One step of Newton's method; the domes follow linearly. False if it is too long for that.
  bool take_last_step(Minimum& minimum) noexcept;
  // Centre and radius of the contact into `out`.
  static void place(const ContactPatch& patch, const Vector& at, Reading& out) noexcept;
  // Mean square residuals over rings: in units of noise, and of noise and an uneven skin.
  struct RingMisfit {
    double by_noise = 0;
    double by_skin = 0;
  };
  RingMisfit ring_misfit(const Vector& at) const noexcept;
  double residual_pressure(const Vector& at) const noexcept;
  static MarginParabola<Square> parabola(const Minimum& minimum) noexcept {
    return {minimum.hessian, margin, load};
  }
  // share: of the profile, see weigh_profile.
  void weigh_by_prior(const Vector& at, double share, Reading& out) noexcept;

  const TaxelLayout layout_;
  const FitOptions options_;
  const FrictionPrior prior_;
  struct ThisFrame {
    double noise_normal_pa = 1, noise_shear_pa = 1;  // of each sample
    Vector first = Vector::Zero();                   // by the moments
    int steps = 0;
  };
  ThisFrame frame_;
  FitSamples& samples_;
  Dome contact_, stick_;  // of the contact that was evaluated last, and of where it sticks
};

// Few taxels: so few have no parabola, and only the whole profile means anything. Those without load count as
// well.
class FewTaxelsFit final : public Fit {
 public:
  FewTaxelsFit(const TaxelLayout& layout, Range friction_expected, const FitOptions& options = {})
      : FewTaxelsFit(layout, friction_expected, options, std::make_unique<TaxelSamples>(layout)) {}

 private:
  FewTaxelsFit(const TaxelLayout& layout, Range friction_expected, const FitOptions& options,
               std::unique_ptr<TaxelSamples> taxels)
      : Fit(layout, friction_expected, options, *taxels), taxels_(std::move(taxels)) {}
  std::size_t memory_bytes() const noexcept override { return sizeof(*this) + samples_bytes(); }
  void collect(const ContactPatch& patch) noexcept override { taxels_->collect_all(patch); }
  void read(const ContactPatch& patch, const MomentRatio& ratio, Reading& out) noexcept override;

  const std::unique_ptr<TaxelSamples> taxels_;
};

// Many taxels, or blocks of them. Ellipses are read by SubsurfaceFit.
class ArrayFit : public Fit {
 public:
  void forget() noexcept final { ellipses_.forget(); }

 protected:
  ArrayFit(const TaxelLayout& layout, Range friction_expected, const FitOptions& options,
           FitSamples& samples);
  virtual Minimum find_minimum(const ContactPatch& patch, const Vector& start) noexcept = 0;

 private:
  std::size_t memory_bytes() const noexcept final {
    return sizeof(*this) + samples_bytes() + ellipses_.memory_bytes();
  }
  void read(const ContactPatch& patch, const MomentRatio& ratio, Reading& out) noexcept final;

  SubsurfaceFit ellipses_;
};

// Each taxel of an array that is in the contact.
class TaxelFit final : public ArrayFit {
 public:
  TaxelFit(const TaxelLayout& layout, Range friction_expected, const FitOptions& options = {})
      : TaxelFit(layout, friction_expected, options, std::make_unique<TaxelSamples>(layout)) {}

 private:
  TaxelFit(const TaxelLayout& layout, Range friction_expected, const FitOptions& options,
           std::unique_ptr<TaxelSamples> taxels)
      : ArrayFit(layout, friction_expected, options, *taxels), taxels_(std::move(taxels)) {}
  void collect(const ContactPatch& patch) noexcept override { taxels_->collect_inside(patch); }
  Minimum find_minimum(const ContactPatch& patch, const Vector& start) noexcept override;

  const std::unique_ptr<TaxelSamples> taxels_;
};

// Taxels of a grid, summed in square blocks: on large ones, then by one step on small ones. For layouts
// that it fits.
class BlockFit final : public ArrayFit {
 public:
  BlockFit(const TaxelLayout& layout, Range friction_expected,
           const FitOptions& options = FitOptions::in_blocks());
  // Whether a layout's taxels can be summed in blocks: a grid of more than few taxels.
  static bool fits(const TaxelLayout& layout) noexcept;
  Method name() const noexcept override { return Method::block_fit; }

 private:
  BlockFit(const TaxelLayout& layout, Range friction_expected, const FitOptions& options,
           std::unique_ptr<BlockSamples> blocks)
      : ArrayFit(layout, friction_expected, options, *blocks), blocks_(std::move(blocks)) {}
  void collect(const ContactPatch& patch) noexcept override;
  Minimum find_minimum(const ContactPatch& patch, const Vector& start) noexcept override;

  const std::unique_ptr<BlockSamples> blocks_;
};

// Taxels under a skin.
class FitUnderSkin final : public SlipMethod {
 public:
  // skin: with a depth above 0.
  FitUnderSkin(const TaxelLayout& layout, Range friction_expected, const Skin& skin,
               const FitOptions& options = {});
  Method name() const noexcept override { return Method::fit; }
  void forget() noexcept override { fit_->forget(); }
  MethodSettings settings() const noexcept override { return {.memory_bytes = fit_->memory_bytes()}; }
  Reading estimate(const Frame& frame, const ContactPatch& patch) noexcept override;

 private:
  const TaxelLayout layout_;
  const MomentRatioOptions ratio_;
  const std::unique_ptr<SubsurfaceFit> fit_;
};

// The fit of a layout, on a skin. friction_expected: the scene's range; decides only where the frame itself
// leaves the margin open.
std::unique_ptr<SlipMethod> make_fit(const TaxelLayout& layout, Range friction_expected,
                                     const Skin& skin = {}, const FitOptions& options = {});

}  // namespace slipd
