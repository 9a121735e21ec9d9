// Moments of the shear under a skin, whatever the contact went through: shear is a sum of domes about one
// centre, and the taxels show by least squares how much of it each of a few domes carries.
#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "core/contact/shear_moments.hpp"
#include "core/frame/model_errors.hpp"
#include "core/frame/significance.hpp"
#include "core/numeric/norm.hpp"
#include "core/reading/fit/subsurface_fit.hpp"
#include "core/reading/method/method.hpp"

namespace slipd {
namespace {

using Sheet = contact::SubsurfaceSheet;

using contact::kDiscRadii;

// Fitted with the domes: the pressure's place, size and height, which a load that is not monotonic has drawn
// aside.
enum PressureColumn : std::size_t { by_x = kDiscRadii.size(), by_y, by_size, by_peak };
constexpr std::size_t kColumns = by_peak + 1;
constexpr auto kRows = static_cast<Eigen::Index>(kColumns);
using ColumnMatrix = Eigen::Matrix<double, kRows, kRows>;
using ColumnVector = Eigen::Matrix<double, kRows, 1>;

}  // namespace

std::size_t SubsurfaceFit::moment_columns() noexcept {
  return kColumns;
}

double* SubsurfaceFit::column(std::size_t which) noexcept {
  return columns_.data() + which * 3 * layout_.size();
}

void SubsurfaceFit::fill_column(double* to, DesignColumn of) noexcept {
  of.per_normal = 1 / model_.noise().normal_pa;
  of.per_shear = 1 / model_.noise().shear_pa;
  fill_sensed(of, model_.count(), to);
}

// What each channel reads of the pressure, in units of noise, by its unknowns over their own scale.
void SubsurfaceFit::fill_pressure(const Full& at, const Sheet& outer) noexcept {
  const contact::Ellipse ellipse = ContactShape::ellipse_of(at, 1);
  const double p = at[ContactShape::peak], a = at[ContactShape::size];
  const auto fill = [&](double* to, Sheet::Of of, double pressed_pa) {
    const SensedRows rows = sensed_rows(outer, of);
    fill_column(to, {.dome = rows, .other = rows, .pressed_pa = pressed_pa});
  };
  fill(column(by_x), Sheet::d_u, -p * a);
  fill(column(by_y), Sheet::d_v, -p * a);
  fill(column(by_peak), Sheet::value, p);
  fill(column(by_size), Sheet::d_a, p * ellipse.a_m);
  if (ellipse.round()) return;
  fill(shear_.data(), Sheet::d_b, p * ellipse.b_m);
  double* const size = column(by_size);
  for (std::size_t i = 0; i < 3 * model_.count(); ++i) size[i] += shear_[i];
}

// The same of the shear of each dome, 1 N along the pull; the first is the whole contact's.
void SubsurfaceFit::fill_domes(const Full& at, const ContactPatch& patch, const Sheet& outer) noexcept {
  const double area_m2 = std::numbers::pi * at[ContactShape::size] * at[ContactShape::size];
  for (std::size_t dome = 0; dome < kDiscRadii.size(); ++dome) {
    const double x = kDiscRadii[dome], per_n = 1.5 / (x * x * area_m2);
    const SensedRows rows =
        sensed_rows(dome == 0 ? outer : model_.show_part(at, x, ContactShape::Detail::rough), Sheet::value);
    fill_column(column(dome), {.dome = rows,
                               .other = rows,
                               .pulled_x_pa = per_n * patch.direction_x,
                               .pulled_y_pa = per_n * patch.direction_y});
  }
}

void SubsurfaceFit::find_moments(const ContactPatch& patch, const Full& at, Reading& out) noexcept {
  const std::size_t rows = 3 * model_.count();
  const auto residuals = model_.residuals();
  const Sheet& outer = model_.show_slopes(at);
  fill_pressure(at, outer);
  fill_shear(at, at[ContactShape::margin], outer);
  for (std::size_t i = 0; i < rows; ++i) unsheared_[i] = at[ContactShape::load] * shear_[i] - residuals[i];
  fill_domes(at, patch, outer);
  ColumnMatrix products;
  ColumnVector sensed, slip = ColumnVector::Zero(), legendre = slip, force = slip, legendre_by_size = slip;
  std::array<const double*, kColumns + 1> columns;
  for (std::size_t i = 0; i < kColumns; ++i) columns[i] = column(i);
  columns[kColumns] = unsheared_.data();
  std::array<double, (kColumns + 1) * (kColumns + 2) / 2> multiplied;
  multiply_columns(columns, rows, multiplied.data());
  const double* next = multiplied.data();
  for (Eigen::Index i = 0; i < kRows; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) products(i, j) = products(j, i) = *next++;
  }
  for (Eigen::Index i = 0; i < kRows; ++i) sensed[i] = *next++;
  const double normal_n =
      2.0 / 3 * std::numbers::pi * at[ContactShape::size] * at[ContactShape::size] * at[ContactShape::peak];
  for (std::size_t i = 0; i < kDiscRadii.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const double u = kDiscRadii[i] * kDiscRadii[i];  // of a disc <u> = 2 u/5, <u^2> = 8 u^2/35
    force[row] = 1;
    const contact::ShearMoments of_disc = contact::moments_of_disc(u);
    slip[row] = of_disc.slip_moment_n;
    legendre[row] = of_disc.second_legendre_n;
    legendre_by_size[row] = 24.0 / 5 * u - 4 * 48.0 / 35 * u * u;
    products(row, row) += 1 / (normal_n * normal_n);  // no dome carries much more than P
  }
  const Eigen::LDLT<ColumnMatrix> solved(products);
  const ColumnVector found = solved.solve(sensed);
  // The domes are those of the contact before it was made larger by as much.
  const double shear_n = force.dot(found), grown = found[by_size];
  slip[by_size] = 2 * (5.0 / 3 * shear_n - slip.dot(found));
  legendre[by_size] = legendre_by_size.dot(found);
  out.moments = {slip.dot(found), legendre.dot(found)};
  const double common_n = kUnevenShare * std::fabs(shear_n);
  const auto sigma_of = [&](const ColumnVector& of) { return std::sqrt(of.dot(solved.solve(of))); };
  out.moments_sigma = {norm(sigma_of(slip), common_n), norm(sigma_of(legendre), 2 * common_n)};
  out.moments_common_sigma = {common_n, 2 * common_n};
  out.normal_n = normal_n * (1 + 2 * grown + found[by_peak]);
  out.shear_n = shear_n;
}

bool SubsurfaceFit::looks_monotonic(const Reading& estimate) const noexcept {
  const double sigma_n = estimate.moments_sigma.slip_moment_n;
  if (!std::isfinite(sigma_n)) return true;
  // Q (5/3 - rho), with rho of (7.1).
  const auto slip_moment_n = [&](double gamma) {
    const double k = std::cbrt(std::clamp(gamma, fit_.min_gamma, fit_.max_gamma)), k3 = k * k * k;
    return estimate.shear_n * (5.0 / 3 - (1 - k3 * k * k) / (1 - k3));
  };
  const double expected_n = slip_moment_n(estimate.gamma),
               open_n = 0.5 * (slip_moment_n(estimate.gamma - estimate.sigma) -
                               slip_moment_n(estimate.gamma + estimate.sigma));
  return std::fabs(estimate.moments.slip_moment_n - expected_n) < kClearSigmas * norm(sigma_n, open_n);
}

}  // namespace slipd
