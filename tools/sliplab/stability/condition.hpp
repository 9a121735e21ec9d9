// Error out per error in: how much noise each method makes of noise, and how many bits of a reading it needs.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/estimate/method.hpp"
#include "tools/sliplab/stability/trials.hpp"

namespace sliplab {

struct NamedMethod {
  std::string name;
  std::unique_ptr<slipd::SlipMethod> method;
};
std::vector<NamedMethod> untrained_methods(const TrialSetup& setup);  // moments, fit

// moments, fit, registered (rank 3), svd-knn (rank 8); the last two trained here.
std::vector<NamedMethod> all_methods(const TrialSetup& setup);

// Deviation of the margin over the deviation of a taxel's reading (of the largest p), contacts as in
// scene_of, at noise small enough to be linear. NaN where the method does not answer.
struct Condition {
  double gamma;
  std::vector<double> by_method;
  double limit;  // the Cramér–Rao guide's
};
std::vector<Condition> condition_of(const TrialSetup& setup, std::vector<NamedMethod>& methods,
                                    const Done& done);

// Mean change of the margin when readings keep so many significant bits instead of a float's 24.
struct Bits {
  int bits;
  std::vector<double> by_method;
};
std::vector<Bits> bits_needed(const TrialSetup& setup, std::vector<NamedMethod>& methods, const Done& done);

}  // namespace sliplab
