// The container of files that slipd keeps for itself: one CBOR map {format, version, crc64, body}. The body
// is a byte string that holds CBOR again, so that the checksum is verified before the body is parsed. Called
// from any thread.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <stdexcept>
#include <vector>

namespace slipd {

// A kind of file.
struct SealedKind {
  // The map's "format".
  const char* format;
  // The map's "version"; a file of another version is refused.
  int version;
  // Message for bytes of another format: "is no ...".
  const char* foreign;
  // Message for another version, before its number: "is of version ".
  const char* older;
};

// A file that cannot be used; what() begins with a verb, to be put behind the file's name.
class SealError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The bytes of a file with this body.
std::vector<std::uint8_t> seal(const SealedKind& kind, const nlohmann::json& body);

// The body of a file. Throws SealError for bytes that are cut, damaged, of another kind or version, or nested
// too deep for a recursive parser. Throws nlohmann::json::exception for a map that lacks a member.
nlohmann::json unsealed(const SealedKind& kind, std::span<const std::uint8_t> bytes);

}  // namespace slipd
