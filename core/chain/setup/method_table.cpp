#include "core/chain/setup/method_table.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/chain/setup/sensor_kind.hpp"
#include "core/contact/scene_draws.hpp"
#include "core/frame/few_taxels.hpp"
#include "core/patch/square_blocks.hpp"
#include "core/reading/fit/fit.hpp"
#include "core/reading/pressure_maps/make_pressure_maps.hpp"

namespace slipd {
namespace {

// Printed by `slipd-lab method-table` (lab/method_table.cpp).
constexpr MethodTableRow kRows[] = {
#include "core/chain/setup/method_table_rows.inc"
};

Scene with_objects(Scene scene) {
  if (scene.objects.empty()) scene.objects = paper_objects();
  return scene;
}

// Where a size lies between two rows: taxels of the contact, which the time of a frame grows with.
double share_between(double low, double high, double at) {
  if (at <= low || !(high > low)) return 0;
  return std::min(1.0, (at * at - low * low) / (high * high - low * low));
}

TradeoffRow row_at(double taxels_along_radius, Method method, bool under_skin) {
  const MethodTableRow *low = nullptr, *high = nullptr;
  for (const MethodTableRow& row : kRows) {
    if (row.method != method || row.under_skin != under_skin) continue;
    if (low == nullptr || row.taxels_along_radius <= taxels_along_radius) low = &row;
    high = &row;
    if (row.taxels_along_radius > taxels_along_radius) break;
  }
  const double share =
      share_between(low->taxels_along_radius, high->taxels_along_radius, taxels_along_radius);
  const auto between = [share](double from, double to) { return from + share * (to - from); };
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  TradeoffRow out;
  out.method = to_string(method);
  out.p95_error = out.right = out.within_sigma = out.within_two_sigma = out.claims_safer = kUnknown;
  out.mean_error = between(low->mean_error, high->mean_error);
  out.answered = between(low->answered, high->answered);
  out.p50_us = between(low->p50_us, high->p50_us);
  out.p99_us = between(low->p99_us, high->p99_us);
  return out;
}

}  // namespace

std::span<const MethodTableRow> method_table() noexcept {
  return kRows;
}

bool blocks_pay(const TaxelLayout& layout, const Scene& scene) {
  constexpr double kTaxelsAcross = 2;  // of a first block
  return layout.size() > kFewTaxels && SquareBlocks::fits(layout) &&
         mean_contact_radius_m(with_objects(scene)) >
             kTaxelsAcross * FitOptions::in_blocks().first_blocks_along_radius * layout.side_m();
}

WorkPrecision expected_work(const ChainSetup& setup) {
  if (!has_contact_model(kind_of(setup))) return {};
  const double taxels = mean_contact_radius_m(with_objects(setup.scene)) / setup.layout.side_m();
  WorkPrecision work{.rows = {}, .processor = kMethodTableProcessor};
  if (sensed_depth_m(setup) > 0) {
    work.rows.push_back(row_at(taxels, Method::fit, true));
    if (reads_pressure_maps(setup.layout, setup.scene.skin))
      work.rows.push_back(row_at(taxels, Method::closing, true));
    return work;
  }
  work.rows.push_back(row_at(taxels, Method::moments, false));
  if (blocks_pay(setup.layout, setup.scene)) work.rows.push_back(row_at(taxels, Method::block_fit, false));
  work.rows.push_back(row_at(taxels, Method::fit, false));
  return work;
}

WorkPrecision expected_work_of(const ChainSetup& setup, Method method) {
  WorkPrecision work = expected_work(setup);
  std::erase_if(work.rows, [name = to_string(method)](const TradeoffRow& row) { return row.method != name; });
  return work;
}

double frame_budget_us(const ChainSetup& setup) noexcept {
  constexpr double kAtSurface = 100;  // a tenth of a frame at 1 kHz
  if (setup.estimator.budget_us) return *setup.estimator.budget_us;
  return sensed_depth_m(setup) > 0 ? std::numeric_limits<double>::infinity() : kAtSurface;
}

AutoChoice choose_for(const ChainSetup& setup, const WorkPrecision& work) {
  if (work.rows.empty()) return {Method::fit, false};
  const double budget_us = frame_budget_us(setup);
  const std::string& name = work.rows[choose(work.rows, budget_us)].method;
  if (!(sensed_depth_m(setup) > 0)) {
    for (const Method method : {Method::moments, Method::block_fit})
      if (name == to_string(method)) return {method, true};
    return {Method::fit, true};
  }
  if (work.rows.size() == 1) return {Method::fit, false};
  // fit needs no closing that was seen: where there is time for it, closing only stands beside it.
  const double fit_us = work.rows[0].p50_us, closing_us = work.rows[1].p50_us;
  if (fit_us <= budget_us) return {Method::fit, fit_us + closing_us <= budget_us};
  return {name == to_string(Method::closing) ? Method::closing : Method::fit, false};
}

std::size_t choose(std::span<const TradeoffRow> rows, double budget_us) {
  const auto cost = [](const TradeoffRow& row) {
    return std::isfinite(row.mean_error) ? row.mean_error + 0.25 * (1 - row.answered) : 1.0;
  };
  std::size_t best = rows.size(), fastest = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].p50_us < rows[fastest].p50_us) fastest = i;
    if (rows[i].p50_us <= budget_us && (best == rows.size() || cost(rows[i]) < cost(rows[best]))) best = i;
  }
  return best == rows.size() ? fastest : best;
}

}  // namespace slipd
