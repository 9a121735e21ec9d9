// What slipd keeps in files of its own: one CBOR map {format, version, crc64, body}, whose body is CBOR once
// more, so that any damage shows before anything of it is used.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <stdexcept>
#include <vector>

namespace slipd {

struct SealedKind {
  const char* format;
  int version;
  const char* foreign;  // said of bytes that are another kind's: "is no ..."
  const char* older;    // said of another version, before its number: "is of version "
};

class SealError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

std::vector<std::uint8_t> seal(const SealedKind& kind, const nlohmann::json& body);

// The body. Throws SealError for bytes that are cut, damaged, of another kind or version, or nested so deep
// that a parser would fall; nlohmann::json::exception for an envelope that lacks a member.
nlohmann::json unsealed(const SealedKind& kind, std::span<const std::uint8_t> bytes);

}  // namespace slipd
