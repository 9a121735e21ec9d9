#include "bridges/web/answers/picture.hpp"

#include <algorithm>
#include <bit>
#include <boost/archive/iterators/binary_from_base64.hpp>
#include <boost/archive/iterators/transform_width.hpp>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <vector>

namespace slipd::web {
namespace {

using Json = nlohmann::json;
static_assert(std::endian::native == std::endian::little);

constexpr std::size_t kChannels = 3;  // pressure, shear x, shear y

// Throws for text that is no base64 of whole taxels: a byte of pressure and two of shear.
std::string taxels_in(const Json& text) {
  using namespace boost::archive::iterators;
  using Bytes = transform_width<binary_from_base64<const char*>, 8, 6>;
  const auto& digits = text.get_ref<const std::string&>();
  const std::size_t length =
      digits.size() - static_cast<std::size_t>(std::count(digits.begin(), digits.end(), '='));
  constexpr std::size_t kGroupDigits = 4, kGroupBytes = 3;
  const std::size_t bytes = length * kGroupBytes / kGroupDigits;
  if (digits.size() % kGroupDigits != 0 || digits.size() - length > 2 || bytes % kChannels != 0)
    throw std::runtime_error("slipd's frame is no base64 of whole taxels");
  std::string values(bytes, '\0');
  std::copy_n(Bytes(digits.data()), bytes, values.begin());
  return values;
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

std::string frame_picture(const std::string& sensor, const Answer& answer, double max_age_ms) {
  const Json frame = Json::parse(answer.text);
  const double age_ms = frame.at("age_ms").get<double>() + answer.waited_ms();
  if (age_ms > max_age_ms || frame.at("state") == "stale") throw std::runtime_error("slipd's frame is old");
  const std::string values = taxels_in(frame.at("values"));
  const Json head{{"kind", "frame"},
                  {"sensor", sensor},
                  {"taxels", values.size() / kChannels},
                  {"seq", frame.at("seq")},
                  {"age_ms", age_ms},
                  {"made_ms", answer.had_ms},
                  {"peak_pa", frame.at("peak_pa")},
                  {"peak_shear_pa", frame.at("peak_shear_pa")}};
  return with_head(head, values.size()) += values;
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
