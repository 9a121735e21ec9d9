// Measures every method with every setting on every layout and noise, on contacts outside the training data.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "lab/cramer_rao_bound.hpp"
#include "paper/validation/tradeoff.hpp"
#include "tools/offline/sweep.hpp"

namespace lab {

struct Noise {
  slipd::NoiseKind kind;  // what the half-width is a fraction of
  double half_width;      // of uniform noise, a fraction
};

struct TradeoffOptions {
  // Taxels along each side of the pad, or "wrench".
  std::vector<std::string> layouts{"100", "32", "16", "8", "4", "wrench"};
  std::vector<Noise> noises{{slipd::NoiseKind::relative, 0.01},
                            {slipd::NoiseKind::relative, 0.05},
                            {slipd::NoiseKind::relative, 0.10},
                            {slipd::NoiseKind::sensor, 0.01},
                            {slipd::NoiseKind::sensor, 0.05}};
  std::size_t contacts = 500;  // per line
  bool models = true;          // false: only methods without a trained model
  std::uint64_t seed = 1;      // of contacts and noise
  unsigned threads = 2;        // for training only
  offline::Shard shard;        // of layouts and noises
};

struct Line {
  std::string layout;  // as in TradeoffOptions
  Noise noise;
  std::string when;  // part of a grasp; empty: single frames without history
  slipd::TradeoffRow row;
  CramerRaoBound limit;  // NaN where a single frame has none
  bool front =
      false;  // on the Pareto front: no other line of its layout and noise is faster and more accurate
  std::size_t unit = 0;  // number of its layout and noise in the sweep
};

// Called before each line is measured.
using Tell = std::function<void(double share, const char* layout)>;
std::vector<Line> measure_tradeoffs(const TradeoffOptions& options, const Tell& tell);

// Marks the Pareto front among the lines of one layout and noise that give a margin for most contacts.
void mark_front(std::vector<Line>& lines);

}  // namespace lab
