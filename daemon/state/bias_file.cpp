#include "daemon/state/bias_file.hpp"

#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>

#include "core/storage/crc64.hpp"
#include "core/storage/sealed.hpp"
#include "core/storage/whole_file.hpp"
#include "daemon/state/state_folder.hpp"

namespace slipd {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr SealedKind kKind{"slipd-zero", 1, "is no zero of slipd's", "is of version "};
static_assert(std::endian::native == std::endian::little,
              "lists of numbers are stored in little-endian order");

json to_json(const BiasIdentity& identity) {
  return {{"driver", identity.driver},
          {"profile", identity.profile},
          {"device", identity.device},
          {"part", identity.part},
          {"taxels", identity.taxels}};
}

BiasIdentity identity_of(const json& in) {
  return {in.at("driver"), in.at("profile"), in.at("device"), in.at("part"), in.at("taxels")};
}

json pack(const std::vector<float>& list) {
  std::vector<std::uint8_t> bytes(list.size() * sizeof(float));
  if (!list.empty()) std::memcpy(bytes.data(), list.data(), bytes.size());
  return json::binary(std::move(bytes));
}

// Throws BiasError unless there are `expected` finite numbers.
std::vector<float> unpack(const json& from, std::size_t expected) {
  const auto& bytes = from.get_binary();
  if (bytes.size() != expected * sizeof(float)) throw BiasError("holds another number of values than taxels");
  std::vector<float> list(expected);
  if (expected > 0) std::memcpy(list.data(), bytes.data(), bytes.size());
  for (const float value : list) {
    if (!std::isfinite(value)) throw BiasError("holds a value that is no number");
  }
  return list;
}

// Empty if the file has none: it was written before slipd kept it, or slipd did not end by itself.
std::vector<float> last_reading(const json& body, std::size_t expected) {
  const auto found = body.find("last_pa");
  if (found == body.end() || found->get_binary().empty()) return {};
  return unpack(*found, expected);
}

BiasOrigin origin_of(const std::string& name) {
  for (const BiasOrigin origin : {BiasOrigin::command, BiasOrigin::no_load}) {
    if (name == to_string(origin)) return origin;
  }
  throw BiasError("holds a zero of unknown origin");
}

}  // namespace

std::string to_string(const BiasIdentity& identity) {
  std::string text = identity.driver;
  for (const std::string* part : {&identity.profile, &identity.device, &identity.part}) {
    if (!part->empty()) text += " " + *part;
  }
  return text + ", " + std::to_string(identity.taxels) + " taxels";
}

std::vector<std::uint8_t> encode_bias(const BiasIdentity& identity, const Bias& zero, const Now& now) {
  return seal(kKind, {{"sensor", to_json(identity)},
                      {"origin", to_string(zero.origin)},
                      {"taken_realtime_ns", now.realtime_of(zero.taken_ns)},
                      {"confirmed_realtime_ns", now.realtime_of(zero.confirmed_ns)},
                      {"bias_pa", pack(zero.bias_pa)},
                      {"noise_pa", pack(zero.noise_pa)},
                      {"last_pa", pack(zero.last_pa)}});
}

Bias decode_bias(std::span<const std::uint8_t> bytes, const BiasIdentity& identity, const Now& now) {
  try {
    const json body = unsealed(kKind, bytes);
    if (const BiasIdentity of = identity_of(body.at("sensor")); !(of == identity)) {
      throw BiasError("is another sensor's: " + to_string(of) + ", and this is " + to_string(identity));
    }
    const auto monotonic = [&](const char* key) {
      return now.monotonic_ns - (now.realtime_ns - body.at(key).get<std::int64_t>());
    };
    return {.bias_pa = unpack(body.at("bias_pa"), 3 * identity.taxels),
            .noise_pa = unpack(body.at("noise_pa"), 3 * identity.taxels),
            .origin = origin_of(body.at("origin")),
            .taken_ns = monotonic("taken_realtime_ns"),
            .confirmed_ns = monotonic("confirmed_realtime_ns"),
            .last_pa = last_reading(body, 3 * identity.taxels)};
  } catch (const SealError& error) {
    throw BiasError(error.what());
  } catch (const json::exception& error) {
    throw BiasError(std::string("is damaged or cut: ") + error.what());
  }
}

fs::path bias_file_path(const BiasIdentity& identity) {
  const std::string text = to_json(identity).dump(-1, ' ', true, json::error_handler_t::replace);
  const auto* const bytes = reinterpret_cast<const std::uint8_t*>(text.data());
  char name[40];
  std::snprintf(name, sizeof name, "zero-%016llx.cbor",
                static_cast<unsigned long long>(crc64({bytes, text.size()})));
  return state_folder() / "zero" / name;
}

std::optional<Bias> load_bias(const fs::path& file, const BiasIdentity& identity) {
  std::error_code error;
  if (!fs::exists(file, error) && !error) return std::nullopt;
  constexpr std::size_t kLargest = std::size_t{64} << 20U;  // bytes; 5 million taxels fit, more is no bias
  std::vector<std::uint8_t> bytes;
  try {
    bytes = read_own_file(file, kLargest);
  } catch (const std::runtime_error& trouble) {
    throw BiasError(trouble.what());
  }
  try {
    return decode_bias(bytes, identity, Now::read());
  } catch (const BiasError& trouble) {
    throw BiasError(file.string() + ": " + trouble.what());
  }
}

void save_bias(const fs::path& file, const BiasIdentity& identity, const Bias& zero) {
  write_whole_file(file, encode_bias(identity, zero, Now::read()), 0640);
}

}  // namespace slipd
