// closed-loop [TASKS [SEED [TRACE.csv]]]: whether a gripper that receives slipd's CAN messages holds what a
// gripper without them drops, and at what force. Each task is carried twice from the same seed, in frame
// time. Prints a table; writes the first task over time as CSV.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "tests/support/gripper/carry.hpp"

namespace {

using namespace slipd;

constexpr std::size_t kSide = 24;
constexpr double kPadSide_m = 0.016;

ChainSetup setup_for(MethodChoice method) {
  ChainSetup setup{.layout = TaxelLayout::grid(kSide, kSide, kPadSide_m / kSide),
                   .scene = {},
                   .estimator = {},
                   .alerts = {},
                   .friction = {}};
  setup.scene.objects = paper_objects();
  setup.estimator.method = method;
  return setup;
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void tell(const char* name, MethodChoice method, std::size_t tasks, std::uint64_t seed) {
  const ChainSetup setup = setup_for(method);
  std::size_t deaf_slips = 0, slips = 0;
  double deaf_s = 0, slid_s = 0;
  std::vector<double> forces, constant_forces;
  for (std::size_t i = 0; i < tasks; ++i) {
    const gripper::CarryTask task = gripper::draw_carry_task(seed + i);
    const gripper::CarryResult deaf = gripper::carry(task, setup, false),
                               held = gripper::carry(task, setup, true);
    if (deaf.sliding_s > 0) ++deaf_slips;
    if (held.sliding_s > 0) ++slips;
    deaf_s += deaf.sliding_s;
    slid_s += held.sliding_s;
    forces.push_back(held.force_share);
    constant_forces.push_back(held.constant_share);
  }
  std::printf("%-8s  %7zu   %4zu, %6.2f s   %4zu, %6.2f s   %10.2f   %10.2f\n", name, tasks, deaf_slips,
              deaf_s, slips, slid_s, median(forces), median(constant_forces));
  std::fflush(stdout);
}

void trace(const char* file, std::uint64_t seed) {
  const gripper::CarryTask task = gripper::draw_carry_task(seed);
  const ChainSetup setup = setup_for(MethodChoice::moments);
  const auto deaf = gripper::carry(task, setup, false), held = gripper::carry(task, setup, true);
  std::ofstream out(file);
  out << "time_s,force_n,deaf_force_n,least_n,gamma,deaf_gamma,heard\n";
  for (std::size_t i = 0; i < held.samples.size(); ++i) {
    const auto &sample = held.samples[i], &without = deaf.samples[i];
    out << sample.time_s << ',' << sample.force_n << ',' << without.force_n << ',' << sample.least_n << ','
        << sample.truth.gamma << ',' << without.truth.gamma << ',' << sample.received.value_or(kUnknown)
        << '\n';
  }
  if (!out.flush()) throw std::runtime_error(std::string("cannot write ") + file);
}

}  // namespace

int main(int argc, char** argv) try {
  const auto number = [&](int i, unsigned long otherwise) {
    return argc > i ? std::strtoul(argv[i], nullptr, 10) : otherwise;
  };
  const std::size_t tasks = std::max(1UL, number(1, 100));
  const std::uint64_t seed = number(2, 1);
  if (argc > 3) trace(argv[3], seed);
  std::printf(
      "                      deaf: slips,     listening: slips,   median force over the least possible:\n"
      "method    errands     time sliding     time sliding        listening    constant\n");
  tell("moments", MethodChoice::moments, tasks, seed);
  tell("fit", MethodChoice::fit, tasks, seed);
} catch (const std::exception& error) {
  std::cerr << "closed-loop: " << error.what() << '\n';
  return 1;
}
