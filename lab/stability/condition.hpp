// The condition of each method: the error of the margin over the error of the taxels, and the significant
// bits that it needs.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/reading/method/method.hpp"
#include "lab/stability/trials.hpp"

namespace lab {

struct NamedMethod {
  std::string name;  // for people
  std::unique_ptr<slipd::SlipMethod> method;
};
std::vector<NamedMethod> untrained_methods(const TrialSetup& setup);  // moments, fit

// moments, fit, registered (rank 3), svd-knn (rank 8). Trains the last two.
std::vector<NamedMethod> all_methods(const TrialSetup& setup);

// Standard deviation of the margin over that of a taxel (of the largest p), for contacts of scene_of, at
// noise small enough to be linear.
struct Condition {
  double gamma;                   // the true margin
  std::vector<double> by_method;  // NaN: the method gives no margin
  double limit;                   // the Cramér–Rao bound
};
std::vector<Condition> condition_of(const TrialSetup& setup, std::vector<NamedMethod>& methods,
                                    const Done& done);

// Mean change of the margin when taxels have fewer significant bits than a float's 24.
struct Bits {
  int bits;                       // significant bits
  std::vector<double> by_method;  // mean |change|; NaN: the method gives no margin
};
std::vector<Bits> bits_needed(const TrialSetup& setup, std::vector<NamedMethod>& methods, const Done& done);

}  // namespace lab
