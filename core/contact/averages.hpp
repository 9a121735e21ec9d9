// What taxels sense: disc terms averaged over each taxel's square (docs/theory.md §5). Closed form at the
// rim, where any quadrature converges slowly; Gauss-Legendre inside, where it has converged to better than a
// float resolves.
#pragma once

#include <span>

#include "core/contact/history.hpp"
#include "core/frame/layout.hpp"

namespace slipd::contact {

// The integral of sqrt(x^2 - u^2 - v^2) over the rectangle between (0, 0) and (u, v) in m^3, where the root
// is real: signed, odd in u and in v. The four corners of any rectangle give its integral by inclusion and
// exclusion.
double hemisphere_over_rectangle(double radius_m, double u_m, double v_m) noexcept;

// The average of sqrt(radius^2 - r^2) (0 outside) in m over a square of `side_m` about (u, v), r from the
// disc's centre. Exact to rounding.
double disc_average_exact(double radius_m, double u_m, double v_m, double side_m) noexcept;

// The same within 1e-8 of the radius, several times faster away from the rim.
double disc_average(double radius_m, double u_m, double v_m, double side_m) noexcept;

// Pressure and signed shear in Pa on every taxel of `layout`, the contact's centre at (x, y). Both spans have
// the layout's size and are overwritten. Allocates nothing.
void taxel_averages(const TaxelLayout& layout, double center_x_m, double center_y_m,
                    const LoadHistory& contact, std::span<float> normal_pa,
                    std::span<float> shear_pa) noexcept;

}  // namespace slipd::contact
