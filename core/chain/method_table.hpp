// Error against time of the methods that need no training, by how many taxels wide a contact is: what `auto`
// chooses by, so that the same scene has the same method at each start and on each machine. The rows are
// measured by the laboratory (`slipd-lab method-table`), whose processor they name. Set-up and tools.
#pragma once

#include <span>

#include "core/chain/setup.hpp"
#include "core/estimate/estimate.hpp"
#include "core/reading/method/work_precision.hpp"

namespace slipd {

// What one method is worth on contacts of one size, Gamma uniform in (0, 1), loads that only rose, each frame
// for itself, relative noise of 1 %, contacts anywhere within a taxel.
struct MethodTableRow {
  // Whether taxels lie under a skin, at a quarter of the contact's radius.
  bool under_skin = false;
  // The contact's radius over a taxel's side, > 0; the layout is a square grid 4.5 times as many taxels wide.
  double taxels_along_radius = 0;
  Method method = Method::none;
  // Of |gamma - truth| where it answered.
  double mean_error = 0;
  // Share of the frames that it answered, 0 … 1.
  double answered = 0;
  // Time per frame, contact patch included, us: median and 99th percentile.
  double p50_us = 0, p99_us = 0;
};

// Ascending by size within each method.
std::span<const MethodTableRow> method_table() noexcept;

// The processor that the table's times were taken on.
inline constexpr const char* kMethodTableProcessor = "AMD EPYC (virtual), one core";

// Each method that `setup` could use, at the mean size of its scene's contacts: between two rows of the table
// linear in the number of taxels of the contact, beyond its ends the last row. No rows for sensors whose
// method nobody chooses (one force, flat skins, no shear).
WorkPrecision expected_work(const ChainSetup& setup);

// The least mean error among those within the budget, the fastest if none is. A method that is silent on much
// of its scene is not better for being right on the rest. `rows` is not empty.
std::size_t choose(std::span<const TradeoffRow> rows, double budget_us);

// Whether `block-fit` takes less time than `fit` on a scene worth telling: contacts are so many taxels wide,
// on average, that blocks hold several.
bool blocks_pay(const TaxelLayout& layout, const Scene& scene);

}  // namespace slipd
