// Where a chain's trained model comes from: the cache, or `sliplab train`, started as a child so that
// training takes neither memory nor time of the process that estimates. Called by the set-up thread; stop by
// io.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/estimate/chain.hpp"

namespace slipd {

class ModelProvider {
 public:
  // `trainer`: the program sliplab.
  explicit ModelProvider(std::filesystem::path trainer) : trainer_(std::move(trainer)) {}

  // The model of this scene. A cached one that is damaged or foreign is named in the log and made anew; one
  // that the disk does not take is used nevertheless. May take minutes. Throws std::runtime_error if none can
  // be had, or if stop came first.
  std::shared_ptr<const Model> get(const std::string& sensor, const ChainSetup& setup);

  // Any thread: a training under way ends soon, and none begins.
  void stop() noexcept { stop_.store(true, std::memory_order_relaxed); }

 private:
  std::vector<std::uint8_t> train(const std::string& sensor, const std::string& setup_json);
  std::filesystem::path trainer_;
  std::map<std::filesystem::path, std::weak_ptr<const Model>> loaded_;  // shared by sensors of one scene
  std::atomic<bool> stop_{false};  // relaxed: looked at again and again, nothing else is read on its word
};

// sliplab beside the running program, else the one that PATH finds.
std::filesystem::path trainer_beside_program();

}  // namespace slipd
