// Reads an estimate from JSON as it is parsed, without a tree of values: libslipd reads every estimate of a
// subscription, up to thousands a second. The handlers have the interface of nlohmann's json_sax, which
// documents each function; false ends the parsing. Any one thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "clients/c/estimate_values.hpp"

namespace slipd::client {

// A handler that gets each value of a document as a Scalar. `Derived` has value(), key(), start_object(),
// end_object(), start_array() and end_array().
template <typename Derived>
struct ScalarHandler {
  // Empty: null, or bytes, which JSON text does not have.
  using Scalar = std::variant<std::monostate, bool, std::int64_t, std::uint64_t, double, std::string_view>;

  bool null() { return self().value({}); }
  bool boolean(bool value) { return self().value(value); }
  bool number_integer(std::int64_t value) { return self().value(value); }
  bool number_unsigned(std::uint64_t value) { return self().value(value); }
  bool number_float(double value, const std::string& /*text*/) { return self().value(value); }
  bool string(const std::string& value) { return self().value(std::string_view(value)); }
  bool binary(const Json::binary_t& /*value*/) { return self().value({}); }
  bool parse_error(std::size_t /*at*/, const std::string& /*token*/, const Json::exception& /*why*/) {
    return false;
  }

 private:
  Derived& self() { return static_cast<Derived&>(*this); }
};

// An estimate without any member: nothing that could be taken for a safe grip.
EstimateValues absent_estimate();

// Of the object that slipd sends for a sensor or a grasp. What has another type than docs/socket.md says
// (an older or newer slipd) is absent; unknown members are passed over.
class EstimateReader : public ScalarHandler<EstimateReader> {
 public:
  // Of the last object.
  EstimateValues& values() noexcept { return values_; }

  bool value(const Scalar& scalar);
  bool key(std::string_view name);
  bool start_object(std::size_t elements);
  bool end_object();
  bool start_array(std::size_t elements);
  bool end_array();

 private:
  // Which member of the object the parser is in.
  enum class Part { field, center, truth, other };

  void open(Part its);

  EstimateValues values_ = absent_estimate();
  int depth_ = 0;  // of open objects and lists
  Part part_ = Part::other;
  std::size_t field_ = 0, next_ = 0;  // indices of fields: the present one, and that expected after it
  bool of_grasp_ = false;
  std::optional<double>* truth_ = nullptr;  // the present member of `truth`; null: another
  std::array<std::optional<double>, 2> center_;
  std::size_t coordinates_ = 0;  // of the centre, so far
};

// Of a whole notification. Anything else (an answer, an error) ends the parsing.
class NotificationReader : public ScalarHandler<NotificationReader> {
 public:
  // After a parse that was not ended: whether it had parameters.
  bool complete() const noexcept { return has_params_; }
  EstimateValues& values() { return estimate_.values(); }
  const std::string& method() const noexcept { return method_; }

  bool value(const Scalar& scalar);
  bool key(std::string_view name);
  bool start_object(std::size_t elements);
  bool end_object();
  bool start_array(std::size_t elements);
  bool end_array();

 private:
  enum class Member { other, method, params };

  EstimateReader estimate_;
  std::string method_ = "estimate";
  Member member_ = Member::other;
  int depth_ = 0;
  bool has_params_ = false;
};

}  // namespace slipd::client
