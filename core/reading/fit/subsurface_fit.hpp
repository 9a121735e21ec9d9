// Maximum likelihood for contacts that are elliptic or under a skin (docs/methods.md §23.5): as Fit, but both
// components of the shear are fitted, and the direction of the pull and the ellipse are unknown as well.
//
// A fit takes its first steps on some of the taxels, the last ones on all of them (docs/methods.md §23.7).
//
// Unknown are the centre, the mean radius s (a b = s^2), the peak pressure p0, the load T = Q/P, Gamma, the
// direction of the pull, and for an ellipse e (cos 2 phi, sin 2 phi) with e = log(a/b) and the direction phi
// of the long axis:
//   p = p0 D(1),   q = p0 T (D(1) - k D(k)) / (1 - Gamma),   k^3 = Gamma,
// with D(x) the dome of unit height over the ellipse x times as large, as it is read at the taxels' depth;
// and the depth, with what was known of it before. A fit starts from an ellipse where the pressure's moments
// show one. It ends with one where the taxels show that the contact is not round.
//
// Under a skin no taxel is free of the contact, so that the noise is that of the residuals.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/contact/scene.hpp"
#include "core/contact/subsurface/subsurface.hpp"
#include "core/patch/hertz_deviation.hpp"
#include "core/reading/fit/fit_options.hpp"
#include "core/reading/fit/margin_parabola.hpp"
#include "core/reading/fit/normal_equations/contact_shape.hpp"
#include "core/reading/fit/normal_equations/design_columns.hpp"
#include "core/reading/method/method.hpp"
#include "core/reading/method/skin_depth.hpp"

namespace slipd {

// Checked with `slipd-lab tradeoff --shapes`. side: a taxel's side.
struct SubsurfaceFitOptions {
  // Taxels up to this many depths outside the patch's disc are used; 0 … 5. Too small: the shear's flank,
  // which shows the margin, is left out. Too large: costs time.
  double reach_depths = 1;
  // What the start subtracts from the square of the measured radius for the skin's spread, over depth^2, and
  // adds to the measured Q/P, over that, for a depth of one radius; 0 … 5. Too small and too large: more
  // steps.
  double start_spread = 2;
  // Log of long over short axis up to which an ellipse is searched; 0.5 … 1.5. Too small: long contacts are
  // refused. Too large: noise stretches small contacts.
  double max_log_axes = 1.1;
  // A step that gains less than this of log likelihood is the last one, and nothing is evaluated at its end;
  // nats, 1e-4 … 0.5. Too small: costs time. Too large: what is not
  // linear in the unknowns shows.
  double settled_nats = 0.1;
  // Change of the log of the shear's noise over the pressure's from which on the fit is repeated; 0.02 … 0.5.
  // Too small: costs time. Too large: channels have wrong weights.
  double other_weights = 0.15;
  // Residual of the pressure, over its peak, from which on no margin is given; 0.005 … 0.1. Too small: real
  // skins are refused. Too large: double contacts and edges get margins.
  double max_residual = 0.03;
};

// Of an array; see FewTaxelsSubsurfaceFit for others.
class SubsurfaceFit {
 public:
  virtual ~SubsurfaceFit() = default;
  // depth_m: of the taxels, >= 0. depth_sigma: standard deviation of its log; 0: it is exact. bonded_poisson:
  // see Skin.
  SubsurfaceFit(const TaxelLayout& layout, Range friction_expected, double depth_m, const FitOptions& fit,
                const SubsurfaceFitOptions& options = {}, double depth_sigma = 0,
                std::optional<double> bonded_poisson = std::nullopt);

  // Estimate thread. Allocates nothing. `start`: of the moments, at depth 0; under a skin only its load is
  // used. in_model as that of Fit.
  Reading estimate(const ContactPatch& patch, const MomentRatio& start) noexcept;

  // Half of -2 log likelihood of the last frame, nats up to a constant, with the noise of its own residuals:
  // of fits of one frame at several depths, the likeliest depth has the least. The fits must use the same
  // taxels: reach_depths times the depth must be alike. NaN for a frame that was not fitted.
  double misfit_nats() const noexcept;
  // The last frame's taxels, residuals and noise.
  const ContactShape& model() const noexcept { return model_; }

  // The contact was lost: what its frames showed of the depth is forgotten.
  void forget() noexcept { depth_.forget(); }

  int steps() const noexcept { return frame_.steps; }         // that the last frame took
  bool elliptic() const noexcept { return frame_.elliptic; }  // whether the last frame's contact was
  std::size_t memory_bytes() const noexcept {
    return sizeof(*this) + model_.memory_bytes() +
           sizeof(double) * (shear_.size() + unsheared_.size() + columns_.size());
  }

 protected:
  using Unknown = ContactShape::Unknown;
  using Vector = ContactShape::Vector;
  using Square = ContactShape::Square;
  using Full = ContactShape::Full;

  struct Minimum {
    Full at;
    // Where the model was evaluated last for it: `at`, or a short step before it.
    Full evaluated;
    ContactShape::Normal normal;  // there
    bool converged = false;
    bool known = false;    // the normal equations are those of the taxels and unknowns in use
    bool current = false;  // the model's last evaluation was this one
  };
  // How finely the profile of margins is computed.
  virtual ContactShape::Detail profile_detail() const noexcept { return ContactShape::Detail::rough; }
  virtual bool shows_ellipse(const HertzDeviation& deviation) const noexcept {
    return deviation.ellipticity > fit_.elliptic_from;
  }
  // What the minimum says of the contact.
  virtual void read(const ContactPatch& patch, const Minimum& minimum, Reading& out) noexcept;
  static MarginParabola<Square> parabola(const Minimum& minimum) noexcept {
    return {minimum.normal.hessian, ContactShape::margin, ContactShape::load};
  }
  // As in Fit: place and shape are held, and taxels may be averaged roughly: only what another margin changes
  // is.
  void weigh_by_prior(const Full& at, double share, Reading& out) noexcept;
  // Centre and radius of the contact into `out`.
  static void place(const Full& at, Reading& out) noexcept;

 private:
  Full start(const ContactPatch& patch, const MomentRatio& ratio) const noexcept;
  // A step that keeps the unknowns within their ranges.
  Full stepped(const Full& from, const Vector& step) const noexcept;
  void minimise(int unknowns, Minimum& best) noexcept;
  // The model's residuals are those of the minimum.
  void refresh(int unknowns, Minimum& best) noexcept;
  Minimum fit_contact(const ContactPatch& patch, const MomentRatio& ratio) noexcept;
  void fit_part(const ContactPatch& patch, const MomentRatio& ratio, Minimum& best) noexcept;
  void fit_all(Minimum& best) noexcept;
  bool shows_ellipse(Minimum& round) noexcept;
  // Whether the frame is asked for the depth.
  void begin_depth() noexcept;
  // Information on the depth before the frame: of its log.
  double depth_precision() const noexcept;
  // The model's normal equations with what is known of the depth.
  void evaluate(const Full& at, int unknowns, ContactShape::Normal& normal) noexcept;
  void weigh_depth(const Full& at, ContactShape::Normal& normal) const noexcept;
  // Takes what is known of the depth now, and holds it in the normal equations.
  void take_depth(Minimum& best) noexcept;
  // Fills moments and forces of `out` by what the domes and the pressure of a contact of any history make
  // taxels read.
  void find_moments(const ContactPatch& patch, const Full& at, Reading& out) noexcept;
  // Whether the slip moment is that of a monotonic load with the margin of the estimate, or unknown.
  bool looks_monotonic(const Reading& estimate) const noexcept;
  static std::size_t moment_columns() noexcept;
  double* column(std::size_t which) noexcept;
  // In units of noise.
  void fill_column(double* to, DesignColumn of) noexcept;
  void fill_pressure(const Full& at, const contact::SubsurfaceSheet& outer) noexcept;
  void fill_domes(const Full& at, const ContactPatch& patch, const contact::SubsurfaceSheet& outer) noexcept;
  // Whether the noise that is left over has other weights than before.
  bool weights_change(int unknowns, Minimum& at) noexcept;
  double residual_pressure(const Full& at) const noexcept;
  // Mean square of the shear's residuals, ring by ring, over noise and what a real skin is uneven by.
  // held: of each taxel, what it would read of a shear of 1 Pa at the middle that is as large as friction.
  double ring_misfit(const Full& at, std::span<const double> held) const noexcept;
  // Where taxels show the contact.
  contact::Ellipse reach_of(const ContactPatch& patch, const HertzDeviation& deviation) const noexcept;
  // What a contact on a layer that is read as one of half spaces leaves open of Gamma; 0 on a half space.
  double layer_sigma(const Full& at) const noexcept;
  void fill_shear(const Full& at, double gamma, const contact::SubsurfaceSheet& outer) noexcept;
  int unknowns() const noexcept {
    return frame_.elliptic ? int{ContactShape::kMost} : int{ContactShape::kRound};
  }

  const TaxelLayout layout_;
  const FitOptions fit_;
  const SubsurfaceFitOptions options_;
  const FrictionPrior prior_;
  const double depth_m_;
  const bool bonded_;  // to a rigid base
  SkinDepth depth_;
  double margin_by_depth_ = 0;  // of the last frame that was asked for the depth: Gamma by its log
  int unasked_ = 0;             // frames since
  ContactShape model_;
  // Of all channels in units of noise: what the shear alone makes of Q/P = 1, and the data less the
  // pressure's.
  std::vector<double> shear_, unsheared_, columns_;
  struct ThisFrame {
    bool depth_asked = false, fitted = false, elliptic = false;
    int steps = 0;
  };
  ThisFrame frame_;
};

// Of few taxels under a skin: they have no other margin than their profile's.
class FewTaxelsSubsurfaceFit final : public SubsurfaceFit {
 public:
  using SubsurfaceFit::SubsurfaceFit;

 private:
  ContactShape::Detail profile_detail() const noexcept override { return ContactShape::Detail::exact; }
  bool shows_ellipse(const HertzDeviation& /*deviation*/) const noexcept override { return false; }
  void read(const ContactPatch& patch, const Minimum& minimum, Reading& out) noexcept override;
};

std::unique_ptr<SubsurfaceFit> make_subsurface_fit(const TaxelLayout& layout, Range friction_expected,
                                                   const Skin& skin, const FitOptions& options = {});

}  // namespace slipd
