// The table that `auto` chooses by, against the methods as they are.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "lab/method_table/measure.hpp"

namespace lab {
namespace {

using namespace slipd;

const MethodTableRow* printed(const MethodTableRow& like) {
  for (const MethodTableRow& row : method_table()) {
    if (row.method == like.method && row.under_skin == like.under_skin &&
        row.taxels_along_radius == like.taxels_along_radius)
      return &row;
  }
  return nullptr;
}

struct Size {
  double taxels_along_radius;
  bool under_skin;
};

class MethodTableRows : public ::testing::TestWithParam<Size> {};

// Errors only: times are the machine's. Few contacts scatter by error_sigma, which is itself of few repeats;
// 5 of them, and the 2 % that the table scatters by.
TEST_P(MethodTableRows, AreMeasuredAgainWithinTheirStatisticalError) {
  const auto [size, under_skin] = GetParam();
  const auto rows = measure_method_table_rows(size, under_skin, {.contacts = 25, .repeats = 8, .seed = 1000});
  EXPECT_GE(rows.size(), 2U);
  for (const MeasuredTableRow& found : rows) {
    const MethodTableRow* const row = printed(found.row);
    const std::string name(to_string(found.row.method));
    ASSERT_NE(row, nullptr) << name << " at " << size;
    EXPECT_NEAR(found.row.mean_error, row->mean_error, 5 * found.error_sigma + 0.02 * row->mean_error)
        << name << " at " << size;
    const double answered_sigma = std::sqrt(row->answered * (1 - row->answered) / 200);
    EXPECT_NEAR(found.row.answered, row->answered, 4 * answered_sigma + 0.01) << name << " at " << size;
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, MethodTableRows,
                         ::testing::Values(Size{1.5, false}, Size{3, false}, Size{8, false}, Size{2, true},
                                           Size{4, true}));

// Under a skin a contact of more than 24 taxels in radius takes minutes to simulate.
TEST(MethodTable, HasRowsOfEverySize) {
  for (const double size : kMethodTableSizes) {
    EXPECT_NE(printed({.taxels_along_radius = size, .method = Method::moments}), nullptr) << size;
    EXPECT_NE(printed({.taxels_along_radius = size, .method = Method::fit}), nullptr) << size;
    if (size > 24) continue;
    EXPECT_NE(printed({.under_skin = true, .taxels_along_radius = size, .method = Method::fit}), nullptr)
        << size;
    EXPECT_NE(printed({.under_skin = true, .taxels_along_radius = size, .method = Method::closing}), nullptr)
        << size;
  }
}

}  // namespace
}  // namespace lab
