#include "core/contact/hertz.hpp"

#include <cmath>
#include <numbers>
#include <sstream>
#include <string>

namespace slipd::contact {
namespace {

[[noreturn]] void refuse(const char* what, double value, const char* must) {
  std::ostringstream text;
  text.precision(17);
  text << what << " = " << value << ": must be " << must;
  throw ContactError(text.str());
}

void check_body(const Body& body, const char* radius, const char* modulus, const char* poisson) {
  if (std::isnan(body.radius_m) || body.radius_m == 0)
    refuse(radius, body.radius_m, "a radius in m, inf for flat");
  if (!std::isfinite(body.modulus_pa) || body.modulus_pa <= 0) {
    refuse(modulus, body.modulus_pa, "a positive modulus in Pa");
  }
  if (!(body.poisson > -1 && body.poisson <= 0.5)) refuse(poisson, body.poisson, "in (-1, 0.5]");
}

// R1 R2 / (R1 + R2): unlike 1/(1/R1 + 1/R2) exact to rounding when a concave body nearly fits the other,
// because the sum of two doubles of opposite sign and like size is exact.
double effective_radius(double r1, double r2) {
  if (std::isinf(r1)) return r2;
  if (std::isinf(r2)) return r1;
  return r1 * (r2 / (r1 + r2));
}

double compliance(const Body& body) {
  return (1 - body.poisson) * (1 + body.poisson) / body.modulus_pa;
}

}  // namespace

double BodyPair::contact_radius_m(double normal_n) const noexcept {
  return std::cbrt(0.75 * normal_n * (radius_m / modulus_pa));
}

double BodyPair::peak_pressure_pa(double normal_n) const noexcept {
  if (normal_n == 0) return 0;
  const double a = contact_radius_m(normal_n);
  return 1.5 * (normal_n / a) / (std::numbers::pi * a);
}

double BodyPair::disc_scale_pa_per_m() const noexcept {
  return 2 * modulus_pa / (std::numbers::pi * radius_m);
}

double BodyPair::disc_force_n(double x) const noexcept {
  return 4.0 / 3.0 * (modulus_pa / radius_m) * x * x * x;
}

BodyPair make_body_pair(const Body& sensor, const Body& object) {
  check_body(sensor, "R1", "E1", "nu1");
  check_body(object, "R2", "E2", "nu2");
  const double radius = effective_radius(sensor.radius_m, object.radius_m);
  if (!(radius > 0 && std::isfinite(radius))) {
    refuse("1/R1 + 1/R2", 1 / sensor.radius_m + 1 / object.radius_m,
           "positive (bodies that touch in a point first)");
  }
  return {1 / (compliance(sensor) + compliance(object)), radius};
}

void check_normal_force(double normal_n) {
  if (!std::isfinite(normal_n) || normal_n < 0) refuse("P", normal_n, "a normal force in N, 0 or more");
}

void check_friction(double friction) {
  if (!std::isfinite(friction) || friction <= 0) refuse("mu", friction, "a friction coefficient above 0");
}

}  // namespace slipd::contact
