// Models on disk (sealed.hpp). Set-up thread and tools only.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "paper/model/model.hpp"

namespace slipd {

// Changed whenever a model made before must not be used any more: its form, or how it is trained.
inline constexpr int kModelVersion = 3;

std::vector<std::uint8_t> encode_model(const ModelData& data);

// Throws ModelError for bytes that are truncated, damaged, no model, or of another version.
Model decode_model(std::span<const std::uint8_t> bytes);

// Writes beside the file, syncs, and renames: the file is the old one or the new one, whole, at any time.
// Makes the folder. Throws ModelError.
void save_model(const ModelData& data, const std::filesystem::path& file);

// Throws ModelError, which names the file.
Model load_model(const std::filesystem::path& file);

// 16 hexadecimal digits that differ for setups that differ.
std::string model_id(const ModelSetup& setup);

// Where models are kept: $STATE_DIRECTORY/models, else $XDG_CACHE_HOME/slipd, else ~/.cache/slipd. Throws
// ModelError where none of these is set.
std::filesystem::path model_cache_directory();

std::filesystem::path model_cache_file(const ModelSetup& setup, const std::filesystem::path& directory);

// The cached model of this setup. Throws ModelError with the reason why there is none to be used: no file, a
// damaged one, or one of another setup.
Model load_cached_model(const ModelSetup& setup, const std::filesystem::path& directory);

}  // namespace slipd
