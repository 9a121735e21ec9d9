// The contacts that a scene expects, drawn as in docs/theory.md §9.1.
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

// How much of it: as many columns as contacts x loads. The defaults give the 16000 of docs/theory.md §9.1.
struct DataSetSize {
  std::size_t contacts = 320;
  std::size_t loads = 50;
  std::size_t columns() const noexcept { return contacts * loads; }
  bool operator==(const DataSetSize&) const = default;
};

// As many columns, spread over more contacts: better on contacts that training has not seen.
inline constexpr DataSetSize kUnseenFirst{.contacts = 1600, .loads = 10};

// Contact `index` of the data set that `seed` names. Throws std::invalid_argument for a scene without objects
// or without any weight on them.
ContactDraw draw_contact(const Scene& scene, std::uint64_t seed, std::size_t index);

// The mean radius of a scene's contacts, m. Throws as draw_contact does.
double mean_contact_radius_m(const Scene& scene);

// Safety margin at load step `step` of `loads`: linear from 1 to 0; 1 if there is one step only.
constexpr double gamma_of_step(std::size_t step, std::size_t loads) noexcept {
  return loads < 2 ? 1.0 : static_cast<double>(loads - 1 - step) / static_cast<double>(loads - 1);
}

}  // namespace slipd
