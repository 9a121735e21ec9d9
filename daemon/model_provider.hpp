// Provides trained models: from the cache, or by `sliplab train` as a child process, so that training takes
// neither memory nor CPU time of slipd's own process.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/chain/chain.hpp"

namespace slipd {

// Thread-safe between set-up and io.
class ModelProvider {
 public:
  // `trainer`: the program sliplab.
  explicit ModelProvider(std::filesystem::path trainer) : trainer_(std::move(trainer)) {}

  // Called from one thread: set-up. The model of this scene. A cached one that is damaged or foreign is
  // logged and trained anew. A failure to save a new one is logged only. May take minutes. Throws
  // std::runtime_error if there is no model, and soon after stop.
  std::shared_ptr<const TrainedModel> get(const std::string& sensor, const ChainSetup& setup);

  // Called from any thread. Ends a training soon, and lets none begin.
  void stop() noexcept { stop_.store(true, std::memory_order_relaxed); }

 private:
  std::vector<std::uint8_t> train(const std::string& sensor, const std::string& setup_json);
  std::filesystem::path trainer_;
  std::map<std::filesystem::path, std::weak_ptr<const TrainedModel>>
      loaded_;                     // shared by sensors of the same scene
  std::atomic<bool> stop_{false};  // relaxed: no other memory is read because of it
};

// sliplab in the running program's folder, else by PATH. Called from any thread.
std::filesystem::path trainer_beside_program();

}  // namespace slipd
