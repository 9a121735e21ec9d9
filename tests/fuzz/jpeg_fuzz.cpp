// What a camera sends as a JPEG picture: it is decoded whole, is told to be torn, or is none.
#include <cstddef>
#include <cstdint>
#include <span>

#include "camera/picture/jpeg.hpp"
#include "tests/fuzz/demand.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace slipd;
  for (const int shrink : {1, 8}) {
    const camera::Decoded decoded = camera::decode_jpeg(std::as_bytes(std::span(data, size)), shrink);
    fuzz::demand(decoded.torn || !decoded.brightness.empty());
  }
  return 0;
}
