// The contact model beside finite elements that know nothing of it: CalculiX's stresses at the base of a gel
// of 4 mm, averaged over taxels of 1 mm, under the tractions of a contact with a radius of 2 mm and a margin
// of 0.4 (`lab/finite_elements/finite-elements SLIPLAB --cell 0.2 --objects --base
// tests/data/finite-elements-base.csv`).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "core/contact/contact_field.hpp"

namespace slipd::contact {
namespace {

constexpr double kGelModulus_pa = 0.3e6, kGelPoisson = 0.45, kGelThickness_m = 0.004;
constexpr double kContactRadius_m = 0.002, kForceOnGel_n = 0.15, kFrictionOfGel = 0.5, kMarginOnGel = 0.4;

struct BaseStress {
  std::vector<double> normal_pa, shear_x_pa, shear_y_pa;  // of taxels, row by row
};

BaseStress by_finite_elements() {
  std::ifstream in(SLIPD_SOURCE_DIR "/tests/data/finite-elements-base.csv");
  std::string line;
  std::getline(in, line);
  BaseStress read;
  while (std::getline(in, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream words(line);
    double x_mm = 0, y_mm = 0, shear_x_pa = 0, shear_y_pa = 0, normal_pa = 0;
    words >> x_mm >> y_mm >> shear_x_pa >> shear_y_pa >> normal_pa;
    read.normal_pa.push_back(normal_pa);
    read.shear_x_pa.push_back(shear_x_pa);
    read.shear_y_pa.push_back(shear_y_pa);
  }
  return read;
}

std::vector<float> by_model(const ContactGeometry& geometry, std::vector<float>& x, std::vector<float>& y) {
  const double modulus_pa = kGelModulus_pa / (1 - kGelPoisson * kGelPoisson);
  const double sphere_m = 4 * modulus_pa * std::pow(kContactRadius_m, 3) / (3 * kForceOnGel_n);
  LoadHistory contact(make_body_pair({std::numeric_limits<double>::infinity(), kGelModulus_pa, kGelPoisson},
                                     {sphere_m, 1e15, 0.3}));
  contact.move_to(kForceOnGel_n, 0, kFrictionOfGel);
  contact.move_to(kForceOnGel_n, (1 - kMarginOnGel) * kFrictionOfGel * kForceOnGel_n, kFrictionOfGel);
  const auto layout = TaxelLayout::grid(6, 6, 0.001);
  std::vector<float> p(layout.size());
  x.resize(layout.size());
  y.resize(layout.size());
  ContactField(layout, geometry).sense(contact, 0, 0, 0, p, x, y);
  return p;
}

// Root mean square of the differences, over the greatest normal stress.
double off_by(const std::vector<float>& got, const std::vector<double>& wanted, double peak_pa) {
  double sum = 0;
  for (std::size_t i = 0; i < wanted.size(); ++i) sum += std::pow(got[i] - wanted[i], 2);
  return std::sqrt(sum / static_cast<double>(wanted.size())) / peak_pa;
}

TEST(FiniteElements, AGelOnARigidBaseSensesWhatTheContactModelSays) {
  const BaseStress wanted = by_finite_elements();
  ASSERT_EQ(wanted.normal_pa.size(), 36U);
  const double peak_pa = *std::max_element(wanted.normal_pa.begin(), wanted.normal_pa.end());
  std::vector<float> x, y;
  const auto p = by_model({.depth_m = kGelThickness_m, .bonded_poisson = kGelPoisson}, x, y);
  const double normal = off_by(p, wanted.normal_pa, peak_pa), along = off_by(x, wanted.shear_x_pa, peak_pa);
  const double across = off_by(y, wanted.shear_y_pa, peak_pa);
  RecordProperty("off", std::to_string(normal) + " " + std::to_string(along) + " " + std::to_string(across));
  for (const double each : {normal, along, across}) EXPECT_LT(each, 0.05);
  // A half space is another skin: the comparison would notice.
  const auto half_space = by_model({.depth_m = kGelThickness_m}, x, y);
  EXPECT_GT(off_by(half_space, wanted.normal_pa, peak_pa), 2 * normal);
  EXPECT_GT(off_by(y, wanted.shear_y_pa, peak_pa), 2 * across);
}

}  // namespace
}  // namespace slipd::contact
