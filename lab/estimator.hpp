// The estimators that commands measure: a method on a layout, with the model that it needs.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>

#include "core/chain/chain.hpp"
#include "paper/model/model.hpp"

namespace lab {

// "16x16 fit": what progress is shown of.
std::string title_of(std::size_t side, const std::string& method);

// A chain for the paper's contacts on a square grid of `side` by `side` taxels, up to 2 mm off its middle;
// the pad is 16 mm wide, that of 4 x 4 has the pitch of commercial fingertips. noise: half-width, a fraction.
slipd::ChainSetup paper_chain(std::size_t side, slipd::MethodChoice method, double noise);

struct Estimator {
  slipd::ChainSetup setup;
  std::shared_ptr<const slipd::Model> model;  // null where the method needs none

  slipd::EstimatorChain chain() const { return {setup, model}; }
  // The method that a chain takes for this layout.
  slipd::Method method() const { return chain().method(); }
};

// Trains the model, if the method needs one.
Estimator make_estimator(slipd::ChainSetup setup, unsigned threads);

}  // namespace lab
