// closed-loop [--lever MM] [--method NAME] [TASKS [SEED [TRACE.csv]]]: whether a gripper that receives
// slipd's CAN messages holds what a gripper without them drops, and at what force. Each task is carried twice
// from the same seed, in frame time. --lever: objects are held so far off their centre of mass. --method:
// moments or fit alone. Prints a table; writes the first task over time as CSV.
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

struct CarryRun {
  double lever_m = 0;
  std::size_t tasks = 0;
  std::uint64_t seed = 0;
};

void tell(const char* name, MethodChoice method, const CarryRun& run) {
  const ChainSetup setup = setup_for(method);
  std::size_t deaf_slips = 0, slips = 0;
  double deaf_s = 0, slid_s = 0;
  std::vector<double> forces, constant_forces;
  for (std::size_t i = 0; i < run.tasks; ++i) {
    const gripper::CarryTask task = gripper::draw_carry_task(run.seed + i, run.lever_m);
    const gripper::CarryResult deaf = gripper::carry(task, setup, false),
                               held = gripper::carry(task, setup, true);
    if (deaf.sliding_s > 0) ++deaf_slips;
    if (held.sliding_s > 0) ++slips;
    deaf_s += deaf.sliding_s;
    slid_s += held.sliding_s;
    forces.push_back(held.force_share);
    constant_forces.push_back(held.constant_share);
  }
  std::printf("%-8s  %7zu   %4zu, %6.2f s   %4zu, %6.2f s   %10.2f   %10.2f\n", name, run.tasks, deaf_slips,
              deaf_s, slips, slid_s, median(forces), median(constant_forces));
  std::fflush(stdout);
}

void trace(const char* file, const CarryRun& run) {
  const gripper::CarryTask task = gripper::draw_carry_task(run.seed, run.lever_m);
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
  std::vector<std::string> given(argv + 1, argv + argc);
  CarryRun run;
  std::string only;
  while (given.size() > 1 && (given[0] == "--lever" || given[0] == "--method")) {
    if (given[0] == "--lever") {
      run.lever_m = 1e-3 * std::strtod(given[1].c_str(), nullptr);
    } else {
      only = given[1];
    }
    given.erase(given.begin(), given.begin() + 2);
  }
  if (!only.empty() && only != "moments" && only != "fit")
    throw std::runtime_error("--method is moments or fit, not " + only);
  const auto number = [&](std::size_t i, unsigned long otherwise) {
    return given.size() > i ? std::strtoul(given[i].c_str(), nullptr, 10) : otherwise;
  };
  run.tasks = std::max(1UL, number(0, 100));
  run.seed = number(1, 1);
  if (given.size() > 2) trace(given[2].c_str(), run);
  std::printf(
      "                      deaf: slips,     listening: slips,   median force over the least possible:\n"
      "method    errands     time sliding     time sliding        listening    constant\n");
  if (only != "fit") tell("moments", MethodChoice::moments, run);
  if (only != "moments") tell("fit", MethodChoice::fit, run);
} catch (const std::exception& error) {
  std::cerr << "closed-loop: " << error.what() << '\n';
  return 1;
}
