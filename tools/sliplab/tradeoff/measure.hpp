// Every method in every setting on every layout and noise, on contacts that nothing was trained on.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/estimate/tradeoff.hpp"
#include "tools/sliplab/limit.hpp"

namespace sliplab {

struct Noise {
  slipd::NoiseKind kind;
  double half_width;  // a fraction, see NoiseKind
};
const char* name_of(slipd::NoiseKind kind) noexcept;

struct TradeoffOptions {
  std::vector<std::string> layouts{"100", "32", "16", "8", "4", "wrench"};
  std::vector<Noise> noises{{slipd::NoiseKind::relative, 0.01},
                            {slipd::NoiseKind::relative, 0.05},
                            {slipd::NoiseKind::relative, 0.10},
                            {slipd::NoiseKind::sensor, 0.01},
                            {slipd::NoiseKind::sensor, 0.05}};
  std::size_t contacts = 500;
  bool models = true;  // what has to be trained, too
  std::uint64_t seed = 1;
  unsigned threads = 2;  // for training only
};

struct Line {
  std::string layout;
  Noise noise;
  std::string when;  // empty: each frame for itself; else the part of a grasp
  slipd::TradeoffRow row;
  Limit limit;         // NaN where a single frame has none
  bool front = false;  // nothing measured beside it is both faster and nearer to the truth
};

// Told before each line is measured.
using Tell = std::function<void(double share, const char* layout)>;
std::vector<Line> measure_tradeoffs(const TradeoffOptions& options, const Tell& tell);

// Marks the front among the lines of one layout and noise, which answer most of their contacts.
void mark_front(std::vector<Line>& lines);

}  // namespace sliplab
