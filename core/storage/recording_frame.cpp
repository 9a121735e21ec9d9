#include "core/storage/recording_frame.hpp"

namespace slipd {
namespace {

constexpr std::uint64_t kEntries = 8;  // of a frame without estimate
constexpr std::uint64_t kEstimateEntries = 11;
constexpr std::uint64_t kEstimateEntriesBeforeTorque = 9;
constexpr std::uint64_t kEstimateEntriesBeforeSliding = 7;
constexpr std::size_t kMostBesideTaxels = 448;  // bytes of a frame beside its taxels' values; it takes less

// Calls `body` with the name and the value of each number. Writing and reading use the same list.
template <typename Estimate, typename Body>
void for_each_number(Estimate& estimate, Body body) {
  body("gamma", estimate.gamma);
  body("sigma", estimate.sigma);
  body("friction", estimate.friction);
  body("normal_n", estimate.normal_n);
  body("shear_n", estimate.shear_n);
}

template <typename Estimate, typename Body>
void for_each_number_of_turning(Estimate& estimate, Body body) {
  body("torque_nm", estimate.torque_nm);
  body("turned_rad", estimate.turned_rad);
}

void put_estimate(cbor::Writer& out, const RecordedEstimate& estimate) noexcept {
  out.text("estimate");
  out.map(kEstimateEntries);
  out.text("state");
  out.unsigned_integer(estimate.state);
  out.text("alert");
  out.unsigned_integer(estimate.alert);
  const auto put_number = [&out](const char* name, double value) {
    out.text(name);
    out.float64_or_null(value);
  };
  for_each_number(estimate, put_number);
  out.text("sliding");
  if (estimate.sliding == RecordedEstimate::kNoSliding) {
    out.null();
  } else {
    out.integer(estimate.sliding);
  }
  out.text("alert_cause");
  out.unsigned_integer(estimate.alert_cause);
  for_each_number_of_turning(estimate, put_number);
}

// False: the estimate's map has another number of entries.
bool take_estimate(cbor::Reader& in, RecordedEstimate& estimate) noexcept {
  in.text("estimate");
  const std::uint64_t entries = in.map();
  if (in.ok() && entries != kEstimateEntries && entries != kEstimateEntriesBeforeTorque &&
      entries != kEstimateEntriesBeforeSliding)
    return false;
  in.text("state");
  estimate.state = static_cast<std::uint8_t>(in.unsigned_integer());
  in.text("alert");
  estimate.alert = static_cast<std::uint8_t>(in.unsigned_integer());
  const auto take_number = [&in](const char* name, double& value) {
    in.text(name);
    value = in.float64_or_null();
  };
  for_each_number(estimate, take_number);
  if (entries == kEstimateEntriesBeforeSliding) return true;
  in.text("sliding");
  estimate.sliding = static_cast<std::uint8_t>(in.integer_or_null().value_or(RecordedEstimate::kNoSliding));
  in.text("alert_cause");
  estimate.alert_cause = static_cast<std::uint8_t>(in.unsigned_integer());
  if (entries == kEstimateEntries) for_each_number_of_turning(estimate, take_number);
  return true;
}

}  // namespace

std::size_t largest_frame_bytes(std::size_t taxels) noexcept {
  return kMostBesideTaxels + 3 * taxels * sizeof(float);
}

void put_frame(cbor::Writer& out, const FrameSlot& frame, const RecordedEstimate* estimate) noexcept {
  out.map(estimate != nullptr ? kEntries + 1 : kEntries);
  out.text("seq");
  out.unsigned_integer(frame.sequence);
  out.text("time_ns");
  out.integer(frame.time_ns);
  out.text("device_time_ns");
  if (frame.device_time_ns < 0) {
    out.null();
  } else {
    out.integer(frame.device_time_ns);
  }
  out.text("truth_gamma");
  out.float64_or_null(frame.truth.gamma);
  out.text("truth_friction");
  out.float64_or_null(frame.truth.friction);
  out.text("normal_pa");
  out.float32_array(frame.normal_pa);
  out.text("shear_x_pa");
  out.float32_array(frame.shear_x_pa);
  out.text("shear_y_pa");
  out.float32_array(frame.shear_y_pa);
  if (estimate != nullptr) put_estimate(out, *estimate);
}

const char* take_frame(cbor::Reader& in, FrameSlot& out, std::optional<RecordedEstimate>* estimate) noexcept {
  const std::uint64_t entries = in.map();
  if (in.ok() && entries != kEntries && entries != kEntries + 1)
    return "a map of 8 entries, a frame, or 9 with an estimate";
  in.text("seq");
  out.sequence = in.unsigned_integer();
  in.text("time_ns");
  out.time_ns = in.integer();
  in.text("device_time_ns");
  out.device_time_ns = in.integer_or_null().value_or(-1);
  in.text("truth_gamma");
  out.truth.gamma = in.float64_or_null();
  in.text("truth_friction");
  out.truth.friction = in.float64_or_null();
  in.text("normal_pa");
  in.float32_array(out.normal_pa);
  in.text("shear_x_pa");
  in.float32_array(out.shear_x_pa);
  in.text("shear_y_pa");
  in.float32_array(out.shear_y_pa);
  if (RecordedEstimate recorded; entries == kEntries + 1) {
    if (!take_estimate(in, recorded)) return "an estimate";
    if (estimate != nullptr) *estimate = recorded;
  }
  return in.fault();
}

}  // namespace slipd
