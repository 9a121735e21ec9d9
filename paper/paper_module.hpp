// The contract between slipd and the module slipd-paper.so: what the daemon calls of the paper's method,
// which it loads only where a scene names svd-knn or registered. So neither the daemon nor what it needs to
// run contains the data set, the SVD and the nearest neighbours.
//
// C++ objects cross this border: a module belongs to the slipd of its own version and to no other.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "core/chain/chain.hpp"
#include "core/reading/method/trained_model.hpp"

namespace slipd {

// The table that the module returns. Everything in it lives until the process ends. All functions are for
// set-up threads, any number of them at once; each `setup` is one that needs_model.
struct PaperModule {
  // kPaperAbi of the headers that the module was built with.
  std::uint32_t abi;
  // Of the slipd that it was built with, "0.2.0".
  const char* version;
  // Where the model of this set-up is kept. Throws std::runtime_error where the environment names no place.
  std::filesystem::path (*cache_file)(const ChainSetup& setup);
  // The kept model. Throws std::runtime_error, which names the file, for none, a damaged or a foreign one.
  std::shared_ptr<const TrainedModel> (*load)(const ChainSetup& setup);
  // What `sliplab train --setup` reads: JSON.
  std::string (*training_setup)(const ChainSetup& setup);
  // The model in the bytes of such a file. Throws std::runtime_error for damaged ones.
  std::shared_ptr<const TrainedModel> (*decode)(std::span<const std::uint8_t> bytes);
};

// Version of this contract. A module of another version is not loaded.
inline constexpr std::uint32_t kPaperAbi = 1;
// The symbol that the module exports.
inline constexpr const char* kPaperSymbol = "slipd_paper_module";

}  // namespace slipd
