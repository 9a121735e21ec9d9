#include "paper/model/model_file.hpp"

#include <array>
#include <bit>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/storage/crc64.hpp"
#include "core/storage/sealed.hpp"
#include "core/storage/whole_file.hpp"
#include "paper/model/setup_json.hpp"

namespace slipd {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr SealedKind kKind{"slipd-model", kModelVersion, "is no slipd model", "is a model of version "};
static_assert(std::endian::native == std::endian::little,
              "lists of numbers are stored in little-endian order");

template <typename T>
json pack(const std::vector<T>& list) {
  std::vector<std::uint8_t> bytes(list.size() * sizeof(T));
  if (!list.empty()) std::memcpy(bytes.data(), list.data(), bytes.size());
  return json::binary(std::move(bytes));
}

template <typename T>
std::vector<T> unpack(const json& from) {
  const auto& bytes = from.get_binary();
  if (bytes.size() % sizeof(T) != 0) throw ModelError("the model's lists are cut");
  std::vector<T> list(bytes.size() / sizeof(T));
  if (!bytes.empty()) std::memcpy(list.data(), bytes.data(), bytes.size());
  return list;
}

json to_json(const ErrorStatistics& errors) {
  return {{"spread_to", pack(errors.spread_to)},
          {"gamma", pack(errors.gamma)},
          {"friction", pack(errors.friction)},
          {"distance_limit", errors.distance_limit},
          {"residual_limit", errors.residual_limit}};
}

ErrorStatistics errors_of(const json& from) {
  return {.spread_to = unpack<float>(from.at("spread_to")),
          .gamma = unpack<float>(from.at("gamma")),
          .friction = unpack<float>(from.at("friction")),
          .distance_limit = from.at("distance_limit"),
          .residual_limit = from.at("residual_limit")};
}

json to_json(const TradeoffRow& row) {
  const MethodSettings& set = row.settings;
  return {row.method,     set.rank,      set.rings, set.neighbours, set.precision,    set.memory_bytes,
          row.mean_error, row.p95_error, row.right, row.answered,   row.within_sigma, row.within_two_sigma,
          row.p50_us,     row.p99_us};
}

TradeoffRow row_of(const json& from) {
  return {.method = from.at(0),
          .settings = {from.at(1), from.at(2), from.at(3), from.at(4), from.at(5)},
          .mean_error = from.at(6),
          .p95_error = from.at(7),
          .right = from.at(8),
          .answered = from.at(9),
          .within_sigma = from.at(10),
          .within_two_sigma = from.at(11),
          .p50_us = from.at(12),
          .p99_us = from.at(13)};
}

json to_json(const WorkPrecision& work_precision) {
  json rows = json::array();
  for (const auto& row : work_precision.rows) rows.push_back(to_json(row));
  return {{"rows", std::move(rows)}, {"processor", work_precision.processor}};
}

WorkPrecision worth_of(const json& from) {
  WorkPrecision work_precision{{}, from.at("processor")};
  for (const auto& row : from.at("rows")) work_precision.rows.push_back(row_of(row));
  return work_precision;
}

ModelData data_of(const json& from) {
  return {.setup = setup_of(from.at("setup")),
          .total_variance = from.at("total_variance"),
          .singular_values = unpack<double>(from.at("singular_values")),
          .basis = unpack<float>(from.at("basis")),
          .coordinates = unpack<float>(from.at("coordinates")),
          .gamma = unpack<float>(from.at("gamma")),
          .friction = unpack<float>(from.at("friction")),
          .errors = errors_of(from.at("errors")),
          .work_precision = worth_of(from.at("worth"))};
}

std::string hexadecimal(std::uint64_t value) {
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(value));
  return text.data();
}

fs::path from_environment(const char* name) {
  const char* value =
      std::getenv(name);  // NOLINT(concurrency-mt-unsafe): set-up, nobody changes the environment
  return value == nullptr ? fs::path() : fs::path(value);
}

}  // namespace

std::vector<std::uint8_t> encode_model(const ModelData& data) {
  return seal(kKind, {{"setup", to_json(data.setup)},
                      {"total_variance", data.total_variance},
                      {"singular_values", pack(data.singular_values)},
                      {"basis", pack(data.basis)},
                      {"coordinates", pack(data.coordinates)},
                      {"gamma", pack(data.gamma)},
                      {"friction", pack(data.friction)},
                      {"errors", to_json(data.errors)},
                      {"worth", to_json(data.work_precision)}});
}

Model decode_model(std::span<const std::uint8_t> bytes) {
  try {
    return Model(data_of(unsealed(kKind, bytes)));
  } catch (const SealError& error) {
    throw ModelError(error.what());
  } catch (const json::exception& error) {
    throw ModelError(std::string("is damaged or cut: ") + error.what());
  } catch (const std::invalid_argument& error) {
    throw ModelError(std::string("holds what is no layout: ") + error.what());
  }
}

void save_model(const ModelData& data, const fs::path& file) {
  try {
    write_whole_file(file, encode_model(data));
  } catch (const std::exception& failure) {
    throw ModelError(failure.what());
  }
}

Model load_model(const fs::path& file) {
  constexpr std::size_t kLargest = std::size_t{1} << 30U;
  std::vector<std::uint8_t> bytes;
  try {
    bytes = read_own_file(file, kLargest);
  } catch (const std::runtime_error& error) {
    throw ModelError(error.what());
  }
  try {
    return decode_model(bytes);
  } catch (const ModelError& error) {
    throw ModelError(file.string() + ": " + error.what());
  }
}

std::string model_id(const ModelSetup& setup) {
  json named = to_json(setup);
  named["version"] = kModelVersion;
  return hexadecimal(crc64(json::to_cbor(named)));
}

fs::path model_cache_directory() {
  if (const fs::path state = from_environment("STATE_DIRECTORY"); !state.empty()) return state / "models";
  if (const fs::path cache = from_environment("XDG_CACHE_HOME"); !cache.empty()) return cache / "slipd";
  if (const fs::path home = from_environment("HOME"); !home.empty()) return home / ".cache" / "slipd";
  throw ModelError("no place for models: set STATE_DIRECTORY, XDG_CACHE_HOME or HOME");
}

fs::path model_cache_file(const ModelSetup& setup, const fs::path& directory) {
  return directory / ("model-" + model_id(setup) + ".cbor");
}

Model load_cached_model(const ModelSetup& setup, const fs::path& directory) {
  const fs::path file = model_cache_file(setup, directory);
  Model model = load_model(file);
  if (!(model.setup() == setup)) throw ModelError(file.string() + ": is a model of another scene or sensor");
  return model;
}

}  // namespace slipd
