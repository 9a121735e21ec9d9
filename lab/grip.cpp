// `slipd-lab grip`: slipd and slipd-grip, the real programs, hold objects in MuJoCo's physics.
#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "lab/collect.hpp"
#include "lab/command.hpp"
#include "lab/grip/report.hpp"
#include "lab/grip/trial.hpp"
#include "lab/options.hpp"
#include "tools/offline/progress.hpp"

namespace lab {
namespace {

using namespace grip;

struct GripOptions {
  std::size_t tasks = 200;
  std::size_t first = 1;
  unsigned threads = 2;
  bool each = false;
  TrialOptions trial;
};

// How fast a held object creeps at a margin of 0.5, where nothing should move, mm a minute.
double creep_of(const WorldOptions& options) {
  constexpr double kMargin = 0.5, kSettledS = 3, kWatchedS = 6;
  Task task;
  const double force_n = task.mass_kg * 9.81 / (2 * task.friction) / (1 - kMargin);
  World world(task, options);
  double begun_m = 0;
  while (world.time_s() < kSettledS + kWatchedS) {
    world.step(force_n, task.load_n(world.time_s()), task.friction);
    if (world.time_s() < kSettledS) begun_m = world.moved_m()[2];
  }
  constexpr double kMmPerM = 1000, kSecondsPerMinute = 60;
  return std::abs(world.moved_m()[2] - begun_m) * kMmPerM * kSecondsPerMinute / kWatchedS;
}

void print(const TrialResult& trial, const TrialResult& deaf) {
  std::printf(
      "%s\n    moved %.2f mm, mean force %.2f N, most %.1f N, with a margin %.0f %%; deaf moved %.2f mm; "
      "true, until it turns, slipd's, low:",
      describe(trial.task).c_str(), 1e3 * trial.moved_m, trial.mean_force_n, trial.most_force_n,
      100 * trial.known_share, 1e3 * deaf.moved_m);
  for (const Probe& probe : trial.probes)
    std::printf(" %.2f %.2f %.2f %.2f;", probe.truth.until_sliding, probe.truth.until_turning,
                probe.gamma.value_or(std::nan("")), probe.gamma_low.value_or(std::nan("")));
  std::printf("\n");
}

struct Pair {
  TrialResult listening, deaf;
};

Pair run_pair(std::uint64_t number, const GripOptions& options) {
  const Task task = draw_task(number);
  TrialResult listening = hold(task, options.trial);
  TrialResult deaf = hold_deaf(task, listening.mean_force_n, options.trial);
  return {std::move(listening), std::move(deaf)};
}

void run_grip(const offline::Common& common, GripOptions options) {
  const auto here = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  options.trial.bed.programs = here;
  options.trial.bed.modules = here.parent_path() / "drivers";
  options.trial.bed.side = options.trial.world.side;
  options.trial.bed.pitch_m = options.trial.world.pitch_m;
  options.trial.bed.dome_radius_m = options.trial.world.dome_radius_m;
  std::vector<TrialResult> listening, deaf;
  {
    offline::ProgressBar bar("objects held");
    for (Pair& pair : collect(
             options.tasks, options.threads, [&](double share) { bar.show(share, "tasks"); },
             [&](std::size_t i) { return run_pair(options.first + i, options); })) {
      listening.push_back(std::move(pair.listening));
      deaf.push_back(std::move(pair.deaf));
    }
  }
  for (std::size_t i = 0; options.each && i < listening.size(); ++i) print(listening[i], deaf[i]);
  const GripSummary summary = summarise(listening, deaf);
  const double creep = creep_of(options.trial.world);
  if (common.json)
    std::cout << to_json(summary, creep) << "\n";
  else
    print_table(summary, creep);
}

}  // namespace

void add_grip(CLI::App& app, const offline::Common& common) {
  auto* command = app.add_subcommand("grip", "hold objects with slipd and slipd-grip in MuJoCo's physics");
  auto options = std::make_shared<GripOptions>();
  command->add_option("--tasks", options->tasks, "objects to hold")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command->add_option("--first", options->first, "number of the first task")->capture_default_str();
  command->add_option("--target", options->trial.bed.target_margin, "margin that slipd-grip keeps")
      ->check(CLI::Range(0.05, 0.9))
      ->capture_default_str();
  command->add_option("--side", options->trial.world.side, "pillars of a pad along each side")
      ->check(CLI::Range(3, 9))
      ->capture_default_str();
  command->add_flag("--each", options->each, "print each task");
  command->add_flag("--course", options->trial.verbose, "print what happens, three times a second");
  add_threads_option(*command, options->threads);
  command->callback([&common, options] { run_grip(common, *options); });
}

}  // namespace lab
