#include "core/storage/sealed.hpp"

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "core/storage/cbor.hpp"
#include "core/storage/crc64.hpp"

namespace slipd {

using nlohmann::json;

std::vector<std::uint8_t> seal(const SealedKind& kind, const json& body) {
  auto packed = json::to_cbor(body);
  const std::uint64_t checksum = crc64(packed);
  return json::to_cbor({{"format", kind.format},
                        {"version", kind.version},
                        {"crc64", checksum},
                        {"body", json::binary(std::move(packed))}});
}

json unsealed(const SealedKind& kind, std::span<const std::uint8_t> bytes) {
  if (!cbor::is_sound(bytes)) throw SealError("is damaged or cut: it is no CBOR item");
  const json envelope = json::from_cbor(bytes.begin(), bytes.end());
  if (!envelope.is_object() || envelope.value("format", json()) != kind.format) throw SealError(kind.foreign);
  if (envelope.at("version") != kind.version) {
    throw SealError(kind.older + envelope.at("version").dump() + ", and this slipd uses version " +
                    std::to_string(kind.version));
  }
  const auto& body = envelope.at("body").get_binary();
  if (envelope.at("crc64") != crc64(body)) throw SealError("is damaged: its checksum does not fit");
  if (!cbor::is_sound(body)) throw SealError("is damaged: what its checksum covers is no CBOR item");
  return json::from_cbor(body);
}

}  // namespace slipd
