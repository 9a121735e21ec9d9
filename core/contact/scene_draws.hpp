// Contacts that a scene expects, drawn at random as in docs/methods.md §26.1. Set-up and tools.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/contact/scene.hpp"

namespace slipd {

// One contact. SI units.
struct ContactDraw {
  double normal_n = 0;
  double friction = 0;
  double radius_m = 0;    // R2, infinity: flat
  double modulus_pa = 0;  // E2
  double poisson = 0;     // nu2
  double x_m = 0;         // its centre
  double y_m = 0;
};

// Contact `index` of the sequence that `seed` names. Throws std::invalid_argument for a scene without objects
// or without any weight on them.
ContactDraw draw_contact(const Scene& scene, std::uint64_t seed, std::size_t index);

// The mean radius of a scene's contacts, m. Throws as draw_contact does.
double mean_contact_radius_m(const Scene& scene);

}  // namespace slipd
