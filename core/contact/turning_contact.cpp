#include "core/contact/turning_contact.hpp"

#include <algorithm>
#include <cmath>

#include "core/contact/averages.hpp"

namespace slipd::contact {
namespace {

constexpr std::size_t kGrid = PartialSlip::kAcross;

// A cell's middle from the grid's, m.
double place_m(std::size_t index, double side_m) noexcept {
  return (static_cast<double>(index) - (static_cast<double>(kGrid) - 1) / 2) * side_m;
}

// The cell below a place and how far the place is towards the next one, both kept on the grid.
struct Between {
  std::size_t low;
  double part;
};
Between between(double at_m, double side_m) noexcept {
  const double place =
      std::clamp(at_m / side_m + (static_cast<double>(kGrid) - 1) / 2, 0.0, static_cast<double>(kGrid) - 1);
  const auto low = std::min(static_cast<std::size_t>(place), kGrid - 2);
  return {low, place - static_cast<double>(low)};
}

}  // namespace

TurningContact::TurningContact(const BodyPair& pair, const TurningContactOptions& options)
    : pair_(pair), options_(options), hertz_(unit_hertz_surface()) {}

void TurningContact::release() noexcept {
  active_ = false;
  normal_n_ = radius_m_ = friction_ = 0;
  load_ = {};
}

void TurningContact::begin(const LoadHistory& from) noexcept {
  active_ = true;
  normal_n_ = from.normal_n();
  radius_m_ = from.contact_radius_m();
  friction_ = from.friction();
  load_ = {.shear_x_n = from.shear_n(), .shear_y_n = 0, .torque_nm = 0};
  const double side_m = 2 * kSpare * radius_m_ / static_cast<double>(kGrid);
  slip_.release(side_m);
  old_x_n_.fill(0);
  old_y_n_.fill(0);
  const double scale = pair_.disc_scale_pa_per_m() * side_m * side_m;
  for (std::size_t cell = 0; cell < old_x_n_.size(); ++cell) {
    const double u = place_m(cell % kGrid, side_m), v = place_m(cell / kGrid, side_m);
    double shear = 0;
    for (const DiscTerm& term : from.shear_terms())
      shear += term.coefficient * disc_average_exact(term.radius_m, u, v, side_m);
    old_x_n_[cell] = static_cast<float>(scale * shear);
  }
  slip_.restart(old_x_n_, old_y_n_);
  press(normal_n_);
}

void TurningContact::press(double normal_n) noexcept {
  normal_n_ = normal_n;
  radius_m_ = pair_.contact_radius_m(normal_n);
  choose_grid();
  const double side_m = slip_.side_m(), scale = pair_.disc_scale_pa_per_m() * side_m * side_m;
  for (std::size_t cell = 0; cell < normal_each_n_.size(); ++cell) {
    const double u = place_m(cell % kGrid, side_m), v = place_m(cell / kGrid, side_m);
    normal_each_n_[cell] = static_cast<float>(scale * disc_average(radius_m_, u, v, side_m));
  }
}

// A grid that the contact fills; tractions move to a new one by interpolation.
void TurningContact::choose_grid() noexcept {
  const double side_m = slip_.side_m(), half_m = side_m * static_cast<double>(kGrid) / 2;
  if (radius_m_ < half_m && radius_m_ > options_.least_filled * half_m) return;
  const double new_side_m = 2 * kSpare * radius_m_ / static_cast<double>(kGrid);
  const double area = new_side_m * new_side_m / (side_m * side_m);
  for (std::size_t cell = 0; cell < old_x_n_.size(); ++cell) {
    const double u = place_m(cell % kGrid, new_side_m), v = place_m(cell / kGrid, new_side_m);
    old_x_n_[cell] = old_y_n_[cell] = 0;
    if (std::max(std::fabs(u), std::fabs(v)) > half_m) continue;
    const Between x = between(u, side_m), y = between(v, side_m);
    for (const std::size_t row : {0, 1}) {
      for (const std::size_t column : {0, 1}) {
        const std::size_t from = (y.low + row) * kGrid + x.low + column;
        const double weight = area * (row == 0 ? 1 - y.part : y.part) * (column == 0 ? 1 - x.part : x.part);
        old_x_n_[cell] += static_cast<float>(weight * static_cast<double>(slip_.shear_x_n()[from]));
        old_y_n_[cell] += static_cast<float>(weight * static_cast<double>(slip_.shear_y_n()[from]));
      }
    }
  }
  slip_.release(new_side_m);
  slip_.restart(old_x_n_, old_y_n_);
}

void TurningContact::step_to(double normal_n, const PlaneLoad& load, double friction) noexcept {
  if (normal_n != normal_n_) press(normal_n);
  friction_ = friction;
  load_ = load;
  slip_.carry(normal_each_n_, friction, load);
}

void TurningContact::move_to(double normal_n, const PlaneLoad& load, double friction) noexcept {
  const double from_n = normal_n_;
  const PlaneLoad from = load_;
  const double most_n = friction * std::max(normal_n, from_n);
  const double way_n = std::max(
      {friction * std::fabs(normal_n - from_n), std::fabs(load.shear_x_n - from.shear_x_n),
       std::fabs(load.shear_y_n - from.shear_y_n),
       std::fabs(load.torque_nm - from.torque_nm) / pair_.contact_radius_m(std::max(normal_n, from_n))});
  constexpr double kMostParts = 40;
  const int parts = static_cast<int>(std::clamp(std::ceil(way_n / (kIncrement * most_n)), 1.0, kMostParts));
  for (int i = 1; i <= parts; ++i) {
    const double part = static_cast<double>(i) / parts;
    const auto at = [part](double a, double b) { return part == 1 ? b : a + part * (b - a); };
    step_to(at(from_n, normal_n),
            {at(from.shear_x_n, load.shear_x_n), at(from.shear_y_n, load.shear_y_n),
             at(from.torque_nm, load.torque_nm)},
            friction);
  }
  // A load that slides stays no longer than it slides.
  load_ = load;
}

double TurningContact::safety_margin() const noexcept {
  const double ratio = hertz_
                           .least_friction(load_.shear_x_n / normal_n_, load_.shear_y_n / normal_n_,
                                           load_.torque_nm / (normal_n_ * radius_m_))
                           .ratio;
  return std::clamp(1 - ratio / friction_, 0.0, 1.0);
}

// Between the middles of cells that are in contact.
TurningContact::Mobilised TurningContact::utilisation(double x_m, double y_m) const noexcept {
  const Between x = between(x_m, slip_.side_m()), y = between(y_m, slip_.side_m());
  Mobilised sum;
  double weights = 0;
  for (const std::size_t row : {0, 1}) {
    for (const std::size_t column : {0, 1}) {
      const std::size_t cell = (y.low + row) * kGrid + x.low + column;
      const auto limit = static_cast<double>(slip_.limit_n()[cell]);
      if (!(limit > 0)) continue;
      const double weight = (row == 0 ? 1 - y.part : y.part) * (column == 0 ? 1 - x.part : x.part);
      weights += weight;
      sum.x += weight * static_cast<double>(slip_.shear_x_n()[cell]) / limit;
      sum.y += weight * static_cast<double>(slip_.shear_y_n()[cell]) / limit;
    }
  }
  if (!(weights > 0)) return {};
  return {sum.x / weights, sum.y / weights};
}

void TurningContact::taxel_averages(const TaxelLayout& layout, double center_x_m, double center_y_m,
                                    std::span<float> normal_pa, std::span<float> shear_x_pa,
                                    std::span<float> shear_y_pa) const noexcept {
  constexpr double kMostParts = 8;  // of a taxel along each side; about one for each cell
  const double scale = pair_.disc_scale_pa_per_m(), side_m = layout.side_m();
  const double reach_m = radius_m_ + side_m * 0.7072;
  const int parts = static_cast<int>(std::clamp(std::ceil(side_m / slip_.side_m()), 1.0, kMostParts));
  const double part_m = side_m / parts;
  for (std::size_t i = 0; i < layout.size(); ++i) {
    const double u = layout.x_m()[i] - center_x_m, v = layout.y_m()[i] - center_y_m;
    normal_pa[i] = shear_x_pa[i] = shear_y_pa[i] = 0;
    if (u * u + v * v >= reach_m * reach_m) continue;
    normal_pa[i] = static_cast<float>(scale * disc_average(radius_m_, u, v, side_m));
    double x = 0, y = 0;
    for (int part = 0; part < parts * parts; ++part) {
      const int column = part % parts, row = part / parts;
      const double at_x = u + (column + 0.5) * part_m - side_m / 2;
      const double at_y = v + (row + 0.5) * part_m - side_m / 2;
      const double pressure = disc_average(radius_m_, at_x, at_y, part_m);
      if (!(pressure > 0)) continue;
      const Mobilised used = utilisation(at_x, at_y);
      x += pressure * used.x;
      y += pressure * used.y;
    }
    const double unit = friction_ * scale / (parts * parts);
    shear_x_pa[i] = static_cast<float>(unit * x);
    shear_y_pa[i] = static_cast<float>(unit * y);
  }
}

}  // namespace slipd::contact
