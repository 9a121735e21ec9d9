#include "clients/c/estimate_reader.hpp"

#include <algorithm>
#include <array>
#include <type_traits>

namespace slipd::client {
namespace {

using Scalar = EstimateReader::Scalar;
using Values = EstimateValues;

// A text, and what it is if it is absent.
struct Text {
  std::string Values::*member;
  const char* otherwise = "";
};
// 0 if it is absent; of `Count` also if it is negative.
using Count = std::uint64_t Values::*;
using Time = std::int64_t Values::*;
using Number = std::optional<double> Values::*;
using Class = std::optional<int> Values::*;
using Flag = bool Values::*;

struct Field {
  std::string_view key;
  std::variant<Text, Count, Time, Number, Class, Flag> member;
};

// In the order of slipd's messages: the next key is most often the next field.
constexpr std::array kFields{
    Field{"sensor", Text{&Values::name}},
    Field{"grasp", Text{&Values::name}},
    Field{"seq", &Values::sequence},
    Field{"time_ns", &Values::time_ns},
    Field{"state", Text{&Values::state, "fault"}},
    Field{"gamma", &Values::gamma},
    Field{"sigma", &Values::sigma},
    Field{"class", &Values::slip_class},
    Field{"gamma_low", &Values::gamma_low},
    Field{"friction", &Values::friction},
    Field{"friction_sigma", &Values::friction_sigma},
    Field{"normal_n", &Values::normal_n},
    Field{"shear_n", &Values::shear_n},
    Field{"shear_x_n", &Values::shear_x_n},
    Field{"shear_y_n", &Values::shear_y_n},
    Field{"torque_nmm", &Values::torque_nmm},
    Field{"torque_sigma_nmm", &Values::torque_sigma_nmm},
    Field{"radius_mm", &Values::radius_mm},
    Field{"a_over_r", &Values::a_over_r},
    Field{"time_to_slip_ms", &Values::time_to_slip_ms},
    Field{"grip_increase_n", &Values::grip_increase_n},
    Field{"grip_increase_sigma_n", &Values::grip_increase_sigma_n},
    Field{"alert", Text{&Values::alert, "slip"}},
    Field{"alert_cause", Text{&Values::alert_cause}},
    Field{"sliding", Text{&Values::sliding}},
    Field{"sliding_for_ms", &Values::sliding_for_ms},
    Field{"method", Text{&Values::method}},
    Field{"simulated", &Values::simulated},
    Field{"latency_us", &Values::latency_us},
    Field{"age_ms", &Values::age_ms},
    Field{"dropped", &Values::dropped},
};
constexpr double kMostClass = 5;
constexpr std::string_view kSensor = kFields[0].key, kGrasp = kFields[1].key;

// The index of `key`, sought from `first` on and then before; the number of fields if there is none.
std::size_t field_of(std::string_view key, std::size_t first) noexcept {
  for (std::size_t i = first; i < kFields.size(); ++i) {
    if (kFields[i].key == key) return i;
  }
  for (std::size_t i = 0; i < first; ++i) {
    if (kFields[i].key == key) return i;
  }
  return kFields.size();
}

std::optional<double> number(const Scalar& scalar) noexcept {
  if (const auto* const real = std::get_if<double>(&scalar)) return *real;
  if (const auto* const whole = std::get_if<std::uint64_t>(&scalar)) return static_cast<double>(*whole);
  if (const auto* const whole = std::get_if<std::int64_t>(&scalar)) return static_cast<double>(*whole);
  return std::nullopt;
}

template <typename Whole>
Whole whole(const Scalar& scalar) noexcept {
  if (const auto* const some = std::get_if<std::uint64_t>(&scalar)) return static_cast<Whole>(*some);
  const auto* const some = std::get_if<std::int64_t>(&scalar);
  return some != nullptr && (std::is_signed_v<Whole> || *some >= 0) ? static_cast<Whole>(*some) : 0;
}

struct Set {
  Values& to;
  const Scalar& scalar;

  void operator()(const Text& text) const {
    const auto* const some = std::get_if<std::string_view>(&scalar);
    to.*text.member = some != nullptr ? *some : std::string_view(text.otherwise);
  }
  void operator()(Count member) const { to.*member = whole<std::uint64_t>(scalar); }
  void operator()(Time member) const { to.*member = whole<std::int64_t>(scalar); }
  void operator()(Number member) const { to.*member = number(scalar); }
  void operator()(Class member) const {
    const std::optional<double> some = number(scalar);
    const bool is_one = some && *some >= 1 && *some <= kMostClass;
    to.*member = is_one ? std::optional(static_cast<int>(*some)) : std::nullopt;
  }
  void operator()(Flag member) const {
    const bool* const some = std::get_if<bool>(&scalar);
    to.*member = some != nullptr && *some;
  }
};

// Hands a document's values to `to`, as a parser does.
void walk(const Json& in, EstimateReader& to) {
  switch (in.type()) {
    case Json::value_t::object:
      to.start_object(in.size());
      for (const auto& [key, value] : in.items()) {
        to.key(key);
        walk(value, to);
      }
      to.end_object();
      return;
    case Json::value_t::array:
      to.start_array(in.size());
      for (const Json& value : in) walk(value, to);
      to.end_array();
      return;
    case Json::value_t::string:
      to.value(std::string_view(in.get_ref<const std::string&>()));
      return;
    case Json::value_t::boolean:
      to.value(in.get<bool>());
      return;
    case Json::value_t::number_integer:
      to.value(in.get<std::int64_t>());
      return;
    case Json::value_t::number_unsigned:
      to.value(in.get<std::uint64_t>());
      return;
    case Json::value_t::number_float:
      to.value(in.get<double>());
      return;
    default:
      to.value({});
  }
}

}  // namespace

EstimateValues absent_estimate() {
  EstimateValues values;
  values.state = "fault";
  values.alert = "slip";
  return values;
}

// A list or an object is the present member's value, which has another type unless it is `its` list or
// object.
void EstimateReader::open(Part its) {
  value({});
  if (depth_++ == 1 && part_ != its) part_ = Part::other;
}

bool EstimateReader::start_object(std::size_t /*elements*/) {
  if (depth_ == 0) {
    values_ = absent_estimate();
    next_ = 0;
    of_grasp_ = false;
  }
  open(Part::truth);
  return true;
}

bool EstimateReader::start_array(std::size_t /*elements*/) {
  open(Part::center);
  return true;
}

bool EstimateReader::end_object() {
  --depth_;
  return true;
}

bool EstimateReader::end_array() {
  if (--depth_ == 1 && part_ == Part::center && coordinates_ == center_.size() && center_[0] && center_[1]) {
    values_.center_x_mm = center_[0];
    values_.center_y_mm = center_[1];
  }
  return true;
}

bool EstimateReader::key(std::string_view name) {
  if (depth_ == 2) {
    truth_ = name == "gamma" ? &values_.true_gamma : name == "friction" ? &values_.true_friction : nullptr;
  }
  if (depth_ != 1) return true;
  if (name == "center_mm") {
    part_ = Part::center;
    coordinates_ = 0;
    values_.center_x_mm = values_.center_y_mm = std::nullopt;
  } else if (name == "truth") {
    part_ = Part::truth;
    values_.true_gamma = values_.true_friction = std::nullopt;
  } else {
    field_ = field_of(name, next_);
    const bool names_sensor_of_grasp = of_grasp_ && name == kSensor;
    part_ = field_ < kFields.size() && !names_sensor_of_grasp ? Part::field : Part::other;
    of_grasp_ = of_grasp_ || name == kGrasp;
    if (part_ == Part::field) next_ = field_ + 1;
  }
  return true;
}

bool EstimateReader::value(const Scalar& scalar) {
  if (depth_ == 1 && part_ == Part::field) std::visit(Set{values_, scalar}, kFields[field_].member);
  if (depth_ != 2) return true;
  if (part_ == Part::truth && truth_ != nullptr) *truth_ = number(scalar);
  if (part_ != Part::center) return true;
  if (coordinates_ < center_.size()) center_[coordinates_] = number(scalar);
  ++coordinates_;
  return true;
}

bool NotificationReader::value(const Scalar& scalar) {
  if (depth_ > 1) return estimate_.value(scalar);
  if (member_ == Member::params) return false;
  const auto* const text = std::get_if<std::string_view>(&scalar);
  if (member_ == Member::method) method_ = text != nullptr ? *text : std::string_view("estimate");
  return depth_ == 1;
}

bool NotificationReader::key(std::string_view name) {
  if (depth_ > 1) return estimate_.key(name);
  member_ = name == "params" ? Member::params : name == "method" ? Member::method : Member::other;
  return member_ != Member::other || name == "jsonrpc";
}

bool NotificationReader::start_object(std::size_t elements) {
  const bool params = depth_ == 1 && member_ == Member::params;
  has_params_ = has_params_ || params;
  return depth_++ == 0 || ((params || depth_ > 2) && estimate_.start_object(elements));
}

bool NotificationReader::end_object() {
  return --depth_ == 0 || estimate_.end_object();
}

bool NotificationReader::start_array(std::size_t elements) {
  return depth_++ > 1 && estimate_.start_array(elements);
}

bool NotificationReader::end_array() {
  --depth_;
  return estimate_.end_array();
}

EstimateValues estimate_from(const Json& message) {
  EstimateReader reader;
  if (message.is_object()) walk(message, reader);
  return reader.values();
}

}  // namespace slipd::client
