// What a configuration expects to meet: the sensor's skin, the families of objects, the noise. The scene
// decides what is trained, and its hash names the model made for it. SI units.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/contact/skin_base.hpp"

namespace slipd {

struct Range {
  double low = 0;
  double high = 0;
  bool operator==(const Range&) const = default;
};

// What a depth in a data sheet or by a calliper is known to: standard deviation of its log; 0.05 … 0.2. Real
// skins are cast, glued and worn, and 25 % is the most that a wrong one was off. Too small: margins under a
// skin of another depth are off by more than their sigma. Too large: a misfit of another cause passes for a
// depth (`slipd-lab tradeoff --shapes`).
inline constexpr double kUsualDepthSigma = 0.1;

// The greatest friction coefficient that is expected of anything, 1 … 5: the end of the grid of frictions,
// and no single taxel's shear is more of its own pressure. Too small: frictions beyond come out as the end,
// and the rim of a contact is called a spike. Too large: the grid's step grows, and with it what no frame can
// distinguish, and spikes of shear are believed.
inline constexpr double kMostFriction = 2.2;

// The sensor's surface: a sphere. The defaults are those of docs/methods.md §26.1.
struct Skin {
  double radius_m = 0.01;     // infinity: flat, which no Hertzian contact covers
  double modulus_pa = 0.5e6;  // Young's modulus E1
  double poisson = 0.45;      // nu1, 0 … 0.5
  double depth_m = 0;         // of the taxels under the surface, >= 0
  // Standard deviation of the log of depth_m, >= 0; 0: it is exact. Not used at depth 0.
  double depth_sigma = kUsualDepthSigma;
  // Not used at depth 0.
  SkinBase base = SkinBase::half_space;
  // Poisson's ratio of a skin that is a layer bonded to a rigid base, as SubsurfaceSheet takes it; none: the
  // skin is a half space.
  std::optional<double> bonded_poisson() const noexcept {
    return base == SkinBase::rigid ? std::optional(poisson) : std::nullopt;
  }
  bool operator==(const Skin&) const = default;
};

// Objects from which contacts are drawn uniformly. The defaults are the stiff ones of docs/methods.md §26.1.
struct ObjectFamily {
  double weight = 1;  // share among the families, relative
  Range normal_n{1, 5};
  Range friction{0.1, 0.9};
  Range radius_m{0.01, 0.05};  // R2 of those that are not flat
  double flat_share = 0.5;     // 0 … 1
  Range modulus_pa{1e11, 3e11};
  Range poisson{0.2, 0.3};
  bool operator==(const ObjectFamily&) const = default;
};

struct Scene {
  Skin skin;
  std::vector<ObjectFamily> objects;
  double offset_m = 0;  // contacts lie up to this far off the middle, each axis
  double noise = 0;     // half-width of uniform noise, a fraction of each frame's maximum
  bool operator==(const Scene&) const = default;
};

// The two halves of the data set of docs/methods.md §26.1: stiff objects and soft ones.
std::vector<ObjectFamily> paper_objects();

// The friction that a scene's objects may have; that of docs/methods.md §26.1 for a scene without objects.
Range expected_friction(const Scene& scene);

}  // namespace slipd
