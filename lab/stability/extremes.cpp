#include "lab/stability/extremes.hpp"

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <limits>

#include "core/contact/cattaneo_mindlin.hpp"
#include "core/contact/history.hpp"
#include "paper/dataset/alpha.hpp"

namespace lab {
namespace {

using Precise =
    boost::multiprecision::number<boost::multiprecision::cpp_bin_float<60>, boost::multiprecision::et_off>;
using slipd::RandomStream;
namespace contact = slipd::contact;

// Boost 1.74 computes what its functions need at their first call and without a lock: a second thread's first
// call would take what is half done. So the first calls are made before there is a second thread.
const Precise kFirstCalls = atan(pow(Precise(2), Precise(1) / 3));

constexpr double kSkinRadius = 0.01, kSkinModulus = 0.5e6, kSkinPoisson = 0.45;

// What both kinds of Traction have in common, in one order.
template <class Real>
std::array<Real, 7> listed(const Traction<Real>& t) {
  return {t.radius, t.peak, t.stick_radius, t.shear_n, t.pressure, t.shear, t.angle};
}

template <class Real>
double worst_of(const std::array<Real, 7>& got, const std::array<Precise, 7>& want) {
  double worst = 0;
  for (std::size_t i = 0; i < want.size(); ++i) {
    if (want[i] == 0) continue;
    const double value = static_cast<double>(got[i]);
    const double off = std::isfinite(value) ? static_cast<double>(abs((Precise(value) - want[i]) / want[i]))
                                            : std::numeric_limits<double>::infinity();
    worst = std::max(worst, off);
  }
  return worst;
}

double logarithmic(const RandomStream& random, std::uint64_t i, double low, double high) {
  return low * std::pow(high / low, random.uniform(i));
}

}  // namespace

std::string_view name_of(Axis axis) noexcept {
  static constexpr std::array<std::string_view, std::size(kAxes)> kNames{"E2/E1", "1-Gamma", "Gamma", "P/N",
                                                                         "mu",    "R1/R2",   "a/R"};
  return kNames[static_cast<std::size_t>(axis)];
}

std::vector<double> places_on(Axis axis) {
  const auto decades = [](int from, int to, double last) {
    std::vector<double> places;
    for (int decade = from; decade <= to; ++decade) places.push_back(std::pow(10.0, decade));
    if (last > 0) places.push_back(last);
    return places;
  };
  switch (axis) {
    case Axis::stiffness:
      return decades(-3, 8, 0);
    case Axis::load:
    case Axis::margin:
      return decades(-12, -1, 0.5);
    case Axis::force:
      return decades(-9, 3, 0);
    case Axis::friction:
      return decades(-6, 0, 5);
    case Axis::curvature:
      return {-0.999999, -0.999, -0.9, -0.5, -0.1, 0, 0.1, 1, 10, 1000};
    case Axis::size:
      return decades(-6, 0, 0);
  }
  return {};
}

Case draw_case(Axis axis, double place, const RandomStream& u) {
  const bool stiff = u.uniform(0) < 0.5, flat = u.uniform(1) < 0.5;
  Case in{.modulus_1 = kSkinModulus,
          .poisson_1 = kSkinPoisson,
          .radius_1 = kSkinRadius,
          .modulus_2 = stiff ? u.uniform(2, 1e11, 3e11) : logarithmic(u, 2, 0.1e6, 10e6),
          .poisson_2 = stiff ? u.uniform(3, 0.2, 0.3) : u.uniform(3, 0.35, 0.45),
          .radius_2 = flat ? std::numeric_limits<double>::infinity() : u.uniform(4, 0.01, 0.05),
          .normal_n = u.uniform(5, 1, 5),
          .friction = u.uniform(6, 0.1, 0.9),
          .load = u.uniform(7),
          .s = 0};
  if (axis == Axis::stiffness) in.modulus_2 = place * in.modulus_1;
  if (axis == Axis::load) in.load = place;
  if (axis == Axis::margin) in.load = 1 - place;
  if (axis == Axis::force) in.normal_n = place;
  if (axis == Axis::friction) in.friction = place;
  if (axis == Axis::curvature)
    in.radius_2 = place == 0 ? std::numeric_limits<double>::infinity() : in.radius_1 / place;
  if (axis == Axis::size) {
    const auto pair = contact::make_body_pair({in.radius_1, in.modulus_1, in.poisson_1},
                                              {in.radius_2, in.modulus_2, in.poisson_2});
    in.normal_n = pair.disc_force_n(place * pair.radius_m);
  }
  const double k = std::cbrt(1 - in.load), where = u.uniform(8);
  in.s = where < 0.4   ? u.uniform(9)
         : where < 0.7 ? 1 - logarithmic(u, 9, 1e-12, 0.1)
                       : std::min(1 - 1e-12, k * (1 + 1e-6 * u.uniform(9, -1, 1)));
  return in;
}

ContactModelError model_error_at(Axis axis, double place, std::size_t cases, std::uint64_t seed) {
  ContactModelError worst{axis, place, 0, 0, 0, 0, 0};
  const RandomStream random = RandomStream(seed).stream(static_cast<std::uint64_t>(axis));
  for (std::size_t i = 0; i < cases; ++i) {
    const Case in = draw_case(axis, place, random.stream(i));
    const auto want = listed(textbook<Precise>(in));
    const auto pair = contact::make_body_pair({in.radius_1, in.modulus_1, in.poisson_1},
                                              {in.radius_2, in.modulus_2, in.poisson_2});
    const contact::CattaneoMindlin rising(pair, in.normal_n, in.friction, in.load);
    const auto at = rising.at(in.s);
    worst.closed_form = std::max(
        worst.closed_form,
        worst_of(std::array{rising.contact_radius_m(), rising.peak_pressure_pa(), rising.stick_radius_m(),
                            rising.shear_n(), at.pressure_pa, at.shear_pa, at.angle_rad},
                 want));
    contact::LoadHistory history(pair);
    history.move_to(in.normal_n, 0, in.friction);
    history.move_to(in.normal_n, rising.shear_n(), in.friction);
    const double sensed = history.shear_pa(in.s * history.contact_radius_m());
    const double largest =
        in.friction * rising.peak_pressure_pa() * std::sqrt(-std::expm1(2.0 / 3 * std::log1p(-in.load)));
    worst.history = std::max(worst.history, static_cast<double>(abs(Precise(sensed) - want[5])) / largest);
    const float p = static_cast<float>(at.pressure_pa), q = static_cast<float>(at.shear_pa), none = 0;
    float angle = 0;
    slipd::alpha_of({&p, 1}, {&q, 1}, {&none, 1}, {}, {&angle, 1});
    worst.single_angle =
        std::max(worst.single_angle, static_cast<double>(abs((Precise(angle) - want[6]) / want[6])));
    worst.textbook_double = std::max(worst.textbook_double, worst_of(listed(textbook<double>(in)), want));
    worst.textbook_single = std::max(worst.textbook_single, worst_of(listed(textbook<float>(in)), want));
  }
  return worst;
}

}  // namespace lab
