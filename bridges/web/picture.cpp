#include "bridges/web/picture.hpp"

#include <algorithm>
#include <bit>
#include <boost/archive/iterators/binary_from_base64.hpp>
#include <boost/archive/iterators/transform_width.hpp>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <vector>

namespace slipd::web {
namespace {

using Json = nlohmann::json;
static_assert(std::endian::native == std::endian::little);

constexpr float kPressureSteps = 255, kShearSteps = 127;

// Throws for text that is no base64 of whole float32.
std::vector<float> floats_in(const Json& text) {
  using namespace boost::archive::iterators;
  using Bytes = transform_width<binary_from_base64<const char*>, 8, 6>;
  const auto& digits = text.get_ref<const std::string&>();
  const std::size_t length =
      digits.size() - static_cast<std::size_t>(std::count(digits.begin(), digits.end(), '='));
  constexpr std::size_t kGroupDigits = 4, kGroupBytes = 3;
  const std::size_t bytes = length * kGroupBytes / kGroupDigits;
  if (digits.size() % kGroupDigits != 0 || digits.size() - length > 2 || bytes % sizeof(float) != 0)
    throw std::runtime_error("slipd's frame is no base64 of float32");
  std::vector<float> values(bytes / sizeof(float));
  Bytes in(digits.data());
  auto* const out = reinterpret_cast<char*>(values.data());
  for (std::size_t i = 0; i < bytes; ++i, ++in) out[i] = *in;
  return values;
}

// The largest finite magnitude; at least 0.
float peak_of(const std::vector<float>& values) {
  float peak = 0;
  for (const float value : values) {
    if (std::isfinite(value)) peak = std::max(peak, std::abs(value));
  }
  return peak;
}

// What is not finite is 0.
void append_steps(std::string& out, const std::vector<float>& values, float peak, float steps, float low) {
  const float scale = peak > 0 ? steps / peak : 0;
  for (const float value : values) {
    const float step = std::isfinite(value) ? std::clamp(std::round(scale * value), low, steps) : 0;
    out += static_cast<char>(static_cast<int>(step));
  }
}

std::string with_head(const Json& head, std::size_t room) {
  const std::string text = head.dump(-1, ' ', true, Json::error_handler_t::replace);
  // float32 begin at a multiple of four.
  const std::string padded = text + std::string((4 - text.size() % 4) % 4, ' ');
  const auto length = static_cast<std::uint32_t>(padded.size());
  std::string message;
  message.reserve(sizeof length + padded.size() + room);
  message.append(reinterpret_cast<const char*>(&length), sizeof length);
  return message += padded;
}

}  // namespace

std::string frame_picture(const std::string& sensor, std::string_view answer) {
  const Json frame = Json::parse(answer);
  const auto normal = floats_in(frame.at("normal_pa"));
  const auto x = floats_in(frame.at("shear_x_pa")), y = floats_in(frame.at("shear_y_pa"));
  if (x.size() != normal.size() || y.size() != normal.size())
    throw std::runtime_error("slipd's frame has channels of different sizes");
  const float peak = peak_of(normal), shear = std::max(peak_of(x), peak_of(y));
  std::string message = with_head({{"kind", "frame"},
                                   {"sensor", sensor},
                                   {"taxels", normal.size()},
                                   {"seq", frame.at("seq")},
                                   {"peak_pa", peak},
                                   {"peak_shear_pa", shear}},
                                  3 * normal.size());
  append_steps(message, normal, peak, kPressureSteps, 0);
  append_steps(message, x, shear, kShearSteps, -kShearSteps);
  append_steps(message, y, shear, kShearSteps, -kShearSteps);
  return message;
}

std::string layout_picture(const std::string& sensor, std::string_view answer) {
  const Json frame = Json::parse(answer);
  const auto x = frame.at("x_mm").get<std::vector<float>>(), y = frame.at("y_mm").get<std::vector<float>>();
  if (x.size() != y.size()) throw std::runtime_error("slipd's frame has places of different numbers");
  std::string message =
      with_head({{"kind", "layout"}, {"sensor", sensor}, {"taxels", x.size()}}, 2 * x.size() * sizeof(float));
  for (const auto* axis : {&x, &y})
    message.append(reinterpret_cast<const char*>(axis->data()), axis->size() * sizeof(float));
  return message;
}

}  // namespace slipd::web
