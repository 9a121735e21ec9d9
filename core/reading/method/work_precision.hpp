// One row of the work-precision table: what a method is worth on a scene, and what it costs. Plain values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace slipd {

enum class Precision : std::uint8_t { single_precision, double_precision };
constexpr const char* to_string(Precision precision) noexcept {
  return precision == Precision::single_precision ? "single" : "double";
}

// What a method was set to. 0: it has no such setting.
struct MethodSettings {
  int rank = 0;                                       // SVD bases
  int rings = 0;                                      // of the standard frame
  int neighbours = 0;                                 // k
  Precision precision = Precision::double_precision;  // in which it adds up taxels
  std::size_t memory_bytes = 0;                       // what it keeps, its model included
};

struct TradeoffRow {
  std::string method;  // as on the socket
  MethodSettings settings;
  double mean_error = 0, p95_error = 0;  // of |gamma - truth| where it answered; NaN where it never did
  double right = 0, answered = 0;  // shares of the contacts: class right among the answered, answered at all
  double within_sigma = 0, within_two_sigma = 0;  // of the answered
  double p50_us = 0, p99_us = 0;                  // time per frame on this processor, contact patch included
  double claims_safer = 0;                        // share of the answered more than 0.2 above the truth
};

// A table and what it was made on.
struct WorkPrecision {
  std::vector<TradeoffRow> rows;
  std::string processor;  // on which the times were taken
};

}  // namespace slipd
