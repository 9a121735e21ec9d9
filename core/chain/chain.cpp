#include "core/chain/chain.hpp"

#include <utility>

#include "core/chain/displacement_chain.hpp"
#include "core/chain/frame_chain.hpp"
#include "core/chain/pressure_chain.hpp"
#include "core/chain/setup/sensor_kind.hpp"

namespace slipd {
namespace {

std::unique_ptr<FrameChain> make_chain(const ChainSetup& setup,
                                       const std::shared_ptr<const TrainedModel>& model) {
  if (kind_of(setup) == SensorKind::displacement) return std::make_unique<DisplacementChain>(setup);
  return make_pressure_chain(setup, model);
}

}  // namespace

EstimatorChain::EstimatorChain(const ChainSetup& setup, const std::shared_ptr<const TrainedModel>& model)
    : chain_(make_chain(setup, model)) {}
EstimatorChain::EstimatorChain(EstimatorChain&&) noexcept = default;
EstimatorChain& EstimatorChain::operator=(EstimatorChain&&) noexcept = default;
EstimatorChain::~EstimatorChain() = default;

const WorkPrecision& EstimatorChain::tradeoff() const noexcept {
  return chain_->tradeoff();
}

Method EstimatorChain::method() const noexcept {
  return chain_->method();
}

bool EstimatorChain::repeats() const noexcept {
  return chain_->repeats();
}

std::vector<std::string_view> EstimatorChain::stages() const {
  return chain_->stages();
}

void EstimatorChain::set_releasing(bool releasing) noexcept {
  chain_->set_releasing(releasing);
}

Estimate EstimatorChain::estimate(const Frame& frame) noexcept {
  return chain_->estimate(frame);
}

}  // namespace slipd
