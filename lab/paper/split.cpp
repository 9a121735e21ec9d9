#include "lab/paper/split.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/numeric/random.hpp"

namespace lab {
namespace {

constexpr double kTrainShare = 0.7;
constexpr std::uint64_t kSplitStream = ~std::uint64_t{9};  // contacts' streams are counted from 0

// For each of `count` things: whether it trains.
std::vector<bool> pick(std::size_t count, std::uint64_t seed) {
  const slipd::RandomStream draws = slipd::RandomStream(seed).stream(kSplitStream);
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return draws.bits(a) < draws.bits(b); });
  std::vector<bool> trains(count, false);
  const auto share = static_cast<std::size_t>(std::llround(kTrainShare * static_cast<double>(count)));
  for (std::size_t i = 0; i < share; ++i) trains[order[i]] = true;
  return trains;
}

}  // namespace

Split split_of(SplitKind kind, const slipd::DataSetSize& size, std::uint64_t seed) {
  const bool whole_contacts = kind == SplitKind::by_contact;
  const std::vector<bool> trains = pick(whole_contacts ? size.contacts : size.columns(), seed);
  Split split;
  for (std::size_t j = 0; j < size.columns(); ++j) {
    (trains[whole_contacts ? j / size.loads : j] ? split.train : split.test).push_back(j);
  }
  return split;
}

}  // namespace lab
