#include "core/contact/scene_draws.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/contact/hertz.hpp"
#include "core/numeric/random.hpp"

namespace slipd {
namespace {

// What each draw of a contact's stream is for. Never renumbered: every model and figure hangs on it.
constexpr std::uint64_t kFamily = 0, kNormal = 1, kFriction = 2, kFlat = 3, kRadius = 4, kModulus = 5,
                        kPoisson = 6, kX = 7, kY = 8;

const ObjectFamily& pick_family(const Scene& scene, double share) {
  double total = 0;
  for (const auto& family : scene.objects) total += family.weight;
  if (!(total > 0) || !std::isfinite(total))
    throw std::invalid_argument("a scene needs objects of positive weight");
  double left = share * total;
  for (const auto& family : scene.objects) {
    if (left < family.weight) return family;
    left -= family.weight;
  }
  return scene.objects.back();
}

}  // namespace

ContactDraw draw_contact(const Scene& scene, std::uint64_t seed, std::size_t index) {
  const RandomStream draws = RandomStream(seed).stream(index);
  const auto within = [&](std::uint64_t purpose, const Range& range) {
    return draws.uniform(purpose, range.low, range.high);
  };
  const ObjectFamily& family = pick_family(scene, draws.uniform(kFamily));
  const Range offset{-scene.offset_m, scene.offset_m};
  const bool flat = draws.uniform(kFlat) < family.flat_share;
  return {.normal_n = within(kNormal, family.normal_n),
          .friction = within(kFriction, family.friction),
          .radius_m = flat ? std::numeric_limits<double>::infinity() : within(kRadius, family.radius_m),
          .modulus_pa = within(kModulus, family.modulus_pa),
          .poisson = within(kPoisson, family.poisson),
          .x_m = within(kX, offset),
          .y_m = within(kY, offset)};
}

double mean_contact_radius_m(const Scene& scene) {
  constexpr std::size_t kDraws = 32;
  double radius_m = 0;
  for (std::size_t i = 0; i < kDraws; ++i) {
    const ContactDraw draw = draw_contact(scene, 1, i);
    const auto pair =
        contact::make_body_pair(contact::body_of(scene.skin), {draw.radius_m, draw.modulus_pa, draw.poisson});
    radius_m += pair.contact_radius_m(draw.normal_n) / kDraws;
  }
  return radius_m;
}

}  // namespace slipd
