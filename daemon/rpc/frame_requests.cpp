#include "daemon/rpc/frame_requests.hpp"

#include <new>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "daemon/rpc/request_params.hpp"
#include "daemon/rt/clock.hpp"

namespace slipd {
namespace {

using json = nlohmann::ordered_json;  // results, in the order in which a person reads them
using rpc::Reply;

// Of the text of a frame, as measured on frames of which half the taxels are loaded.
constexpr std::size_t kFrameBytesPerTaxel = 40;
// Of answers that all clients together have requested and not read, beyond which there are no more frames.
constexpr std::size_t kMostOwedToAll = std::size_t{24} * 1024 * 1024;

json frame_json(const FrameCopy::Content& frame, const TaxelLayout& layout, const Now& now) {
  std::vector<double> x_mm(layout.x_m().begin(), layout.x_m().end());
  std::vector<double> y_mm(layout.y_m().begin(), layout.y_m().end());
  for (auto* axis : {&x_mm, &y_mm}) {
    for (double& value : *axis) value *= 1e3;
  }
  return {{"seq", frame.sequence},
          {"time_ns", now.realtime_of(frame.time_ns)},
          {"normal_pa", frame.normal_pa},
          {"shear_x_pa", frame.shear_x_pa},
          {"shear_y_pa", frame.shear_y_pa},
          {"x_mm", x_mm},
          {"y_mm", y_mm}};
}

}  // namespace

FrameRequests::FrameRequests(ServiceContext& context)
    : context_(context), pending_(context.board.sensors.size()) {}

void FrameRequests::add(Client& client, const nlohmann::json& params, const Reply& reply) {
  const std::size_t sensor = required_sensor(params, context_.board);
  SensorStatus& status = *context_.board.sensors[sensor];
  const auto layout = status.facts().layout;
  if (!layout) throw rpc::Error(rpc::kNotPossible, "no frame of this sensor has come yet");
  if (context_.owed_bytes() > kMostOwedToAll) {
    ++refused_;
    throw rpc::Error(rpc::kTooMuch,
                     "slipd keeps too many answers that its clients do not read; ask again later");
  }
  pending_[sensor].push_back({reply, client.promise(kFrameBytesPerTaxel * layout->size())});
  status.frame_copy.request(layout->size());
  context_.ring_estimate();
}

std::optional<std::chrono::steady_clock::time_point> FrameRequests::complete() {
  const auto begin = std::chrono::steady_clock::now();
  if (begin < next_) return next_;
  for (std::size_t i = 0; i < pending_.size(); ++i) complete_of(i);
  const auto end = std::chrono::steady_clock::now();
  next_ = end + (end - begin);
  return std::nullopt;
}

// All get the same frame. Its text is made once.
void FrameRequests::complete_of(std::size_t sensor) {
  SensorStatus& status = *context_.board.sensors[sensor];
  const FrameCopy::Content* frame = status.frame_copy.result();
  if (frame == nullptr) return;
  const auto waiting = std::exchange(pending_[sensor], {});
  const auto layout = status.facts().layout;
  const bool usable = frame->has_frame && layout && layout->size() == frame->normal_pa.size();
  std::string text;
  const char* trouble = usable ? nullptr : "no frame of this sensor has come yet";
  try {
    if (usable) text = frame_json(*frame, *layout, Now::read()).dump();
  } catch (const std::bad_alloc&) {
    trouble = "slipd has not enough memory for this";
  }
  status.frame_copy.release();
  for (const Pending& wanted : waiting) {
    if (trouble == nullptr) {
      wanted.reply.text(text);
    } else {
      wanted.reply.error(rpc::kNotPossible, trouble);
    }
  }
}

void FrameRequests::fail(const char* why) {
  for (auto& waiting : pending_) {
    for (const Pending& wanted : std::exchange(waiting, {})) wanted.reply.error(rpc::kNotPossible, why);
  }
}

}  // namespace slipd
