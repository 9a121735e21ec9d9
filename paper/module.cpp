// slipd-paper.so: the table by which the daemon finds the paper's method.
#include <nlohmann/json.hpp>

#include "paper/model/model_file.hpp"
#include "paper/model/setup_json.hpp"
#include "paper/model_setup.hpp"
#include "paper/paper_module.hpp"

namespace slipd {
namespace {

std::filesystem::path cache_file(const ChainSetup& setup) {
  return model_cache_file(model_setup_of(setup), model_cache_directory());
}

std::shared_ptr<const TrainedModel> load(const ChainSetup& setup) {
  return std::make_shared<const Model>(load_cached_model(model_setup_of(setup), model_cache_directory()));
}

std::string training_setup(const ChainSetup& setup) {
  return to_json(model_setup_of(setup)).dump();
}

std::shared_ptr<const TrainedModel> decode(std::span<const std::uint8_t> bytes) {
  return std::make_shared<const Model>(decode_model(bytes));
}

constexpr PaperModule kTable{kPaperAbi, SLIPD_VERSION, cache_file, load, training_setup, decode};

}  // namespace
}  // namespace slipd

extern "C" __attribute__((visibility("default"))) const slipd::PaperModule* slipd_paper_module() {
  return &slipd::kTable;
}
