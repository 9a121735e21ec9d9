// Measures the rows of the table that `auto` chooses by (core/chain/setup/method_table.hpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/chain/setup/method_table.hpp"

namespace lab {

// Sizes of contacts that have rows, in taxels along a contact's radius.
inline constexpr double kMethodTableSizes[] = {1, 1.5, 2, 3, 4, 6, 8, 12, 16, 24, 32};

struct MethodTableWork {
  // Contacts that a repeat measures, > 0.
  std::size_t contacts = 250;
  // How often the same methods measure other contacts, > 1. Errors are means over all of them. Times are
  // those of the fastest repeat: whatever else the machine does makes a repeat slower, and nothing makes it
  // faster.
  std::size_t repeats = 8;
  std::uint64_t seed = 1;
};

struct MeasuredTableRow {
  slipd::MethodTableRow row;
  // Standard deviation of row.mean_error, of the repeats' scatter.
  double error_sigma = 0;
};

// One row for each method that reads such contacts: moments, block-fit where blocks hold several taxels, and
// fit; under a skin at a quarter of the contact's radius fit and closing, which sees the gripper close
// before. In the calling thread, whose processor time is measured.
std::vector<MeasuredTableRow> measure_method_table_rows(double taxels_along_radius, bool under_skin,
                                                        const MethodTableWork& work);

}  // namespace lab
