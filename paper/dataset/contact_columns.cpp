#include "paper/dataset/contact_columns.hpp"

#include <utility>

#include "core/contact/scene_draws.hpp"

namespace slipd {
namespace {

// Streams that no contact has: contacts are counted from 0.
constexpr std::uint64_t kNoiseStream = ~std::uint64_t{1};
constexpr std::uint64_t kLoadStream = ~std::uint64_t{2};

}  // namespace

ContactColumns::ContactColumns(Scene scene, std::uint64_t seed, const FrameChoice& choice)
    : scene_(std::move(scene)), seed_(seed), choice_(choice) {}

double ContactColumns::gamma(std::size_t column) const {
  const std::size_t step = column % choice_.size.loads;
  if (!choice_.random_loads) return gamma_of_step(step, choice_.size.loads);
  return RandomStream(seed_).stream(kLoadStream).stream(contact(column)).uniform(step);
}

double ContactColumns::friction(std::size_t column) const {
  return draw_contact(scene_, seed_, contact(column)).friction;
}

RandomStream ContactColumns::noise(std::size_t column) const noexcept {
  return RandomStream(seed_).stream(kNoiseStream).stream(contact(column)).stream(column % choice_.size.loads);
}

}  // namespace slipd
