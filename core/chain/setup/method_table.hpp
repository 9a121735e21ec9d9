// Error against time of the methods that need no training, by how many taxels wide a contact is: what `auto`
// chooses by, so that the same scene has the same method at each start and on each machine. The rows are
// measured by the laboratory (`slipd-lab method-table`), whose processor they name. Set-up and tools.
#pragma once

#include <span>

#include "core/chain/setup/setup.hpp"
#include "core/estimate/estimate.hpp"
#include "core/reading/method/work_precision.hpp"

namespace slipd {

// What one method is worth on contacts of one size, Gamma uniform in (0, 1), loads that only rose, each frame
// for itself, relative noise of 1 %, contacts anywhere within a taxel. `closing` has seen 40 frames of the
// gripper's closing before.
struct MethodTableRow {
  // Whether taxels lie under a skin, at a quarter of the contact's radius.
  bool under_skin = false;
  // The contact's radius over a taxel's side, > 0; the layout is a square grid 4.5 times as many taxels wide,
  // at least 7.
  double taxels_along_radius = 0;
  Method method = Method::none;
  // Of |gamma - truth| where it answered.
  double mean_error = 0;
  // Share of the frames that it answered, 0 … 1.
  double answered = 0;
  // Processor time per frame, contact patch included, us: median and 99th percentile, each of the fastest of
  // several repeats, since whatever else a machine does only adds to it.
  double p50_us = 0, p99_us = 0;
};

// Ascending by size within each method.
std::span<const MethodTableRow> method_table() noexcept;

// The processor that the table's times were taken on.
inline constexpr const char* kMethodTableProcessor = "AMD EPYC (virtual), one core";

// Each method that `setup` could use, at the mean size of its scene's contacts: between two rows of the table
// linear in the number of taxels of the contact, beyond its ends the last row. Unknown numbers are NaN. No
// rows for sensors whose method nobody chooses (one force, flat skins, no shear).
WorkPrecision expected_work(const ChainSetup& setup);

// The row of one method only; no rows where the table has none (closing at the surface).
WorkPrecision expected_work_of(const ChainSetup& setup, Method method);

// The time per frame that `auto` may spend, us: what the configuration says, else 100 at the surface, and
// infinity under a skin, where fit alone takes several times as long.
double frame_budget_us(const ChainSetup& setup) noexcept;

// What `auto` takes.
struct AutoChoice {
  // Of single frames.
  Method method = Method::none;
  // Whether `closing` reads frames beside it: for those that the method refuses, or reads with a greater
  // sigma.
  bool closing_beside = false;
};

// By the rows of expected_work; without rows fit alone. Under a skin both together are within the budget, or
// only one is taken. At the surface `closing` stands beside every method: it takes time for few frames.
AutoChoice choose_for(const ChainSetup& setup, const WorkPrecision& work);

// The least mean error among those within the budget, the fastest if none is. A method that is silent on much
// of its scene is not better for being right on the rest. `rows` is not empty.
std::size_t choose(std::span<const TradeoffRow> rows, double budget_us);

// Whether `block-fit` takes less time than `fit` on a scene worth telling: contacts are so many taxels wide,
// on average, that blocks hold several.
bool blocks_pay(const TaxelLayout& layout, const Scene& scene);

}  // namespace slipd
