// Any bytes as a sensor's bias on disk: refused with a message, or as many finite numbers as the sensor has
// channels. The first byte selects whether the rest is the whole file or the body of one with a matching
// checksum.
#include <cmath>

#include "daemon/state/bias_file.hpp"
#include "tests/fuzz/demand.hpp"
#include "tests/fuzz/sealed.hpp"

namespace {

using namespace slipd;
using fuzz::demand;

const BiasIdentity kSensor{"can", "xela-xr1944", R"({"interface":"can0"})", "board 1", 2};
constexpr Now kNow{.monotonic_ns = 5'000, .realtime_ns = 1'790'000'000'000'000'000};

void use(const Bias& zero) {
  demand(zero.bias_pa.size() == 3 * kSensor.taxels && zero.noise_pa.size() == 3 * kSensor.taxels);
  for (const auto* list : {&zero.bias_pa, &zero.noise_pa}) {
    for (const float value : *list) demand(std::isfinite(value));
  }
  demand(decode_bias(encode_bias(kSensor, zero, kNow), kSensor, kNow).bias_pa == zero.bias_pa);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  std::vector<std::uint8_t> bytes(data + 1, data + size);
  if ((data[0] & 1U) != 0) bytes = fuzz::sealed("slipd-zero", 1, std::move(bytes));
  try {
    use(decode_bias(bytes, kSensor, kNow));
  } catch (const BiasError& error) {
    demand(*error.what() != '\0');
  }
  return 0;
}
