// One row of the work-precision table: what a method is worth on a scene, and what it costs. Plain values.
#pragma once

#include "core/estimate/estimate.hpp"

namespace slipd {

struct TradeoffRow {
  Method method = Method::none;
  double mean_error = 0, p95_error = 0;  // of |gamma - truth| where it answered; NaN where it never did
  double right = 0, answered = 0;  // shares of the contacts: class right among the answered, answered at all
  double within_sigma = 0, within_two_sigma = 0;  // of the answered
  double p50_us = 0, p99_us = 0;                  // time per frame on this processor, contact patch included
};

}  // namespace slipd
