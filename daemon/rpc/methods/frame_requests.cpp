#include "daemon/rpc/methods/frame_requests.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <boost/archive/iterators/base64_from_binary.hpp>
#include <boost/archive/iterators/transform_width.hpp>
#include <cstddef>
#include <cstring>
#include <new>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>

#include "daemon/rpc/methods/frame_bytes.hpp"
#include "daemon/rpc/protocol/request_params.hpp"
#include "daemon/rt/clock.hpp"

namespace slipd {
namespace {

using json = nlohmann::ordered_json;  // results, in the order in which a person reads them
using rpc::Reply;

// Of the text of a frame, as measured on frames of which half the taxels are loaded.
constexpr std::size_t kFrameBytesPerTaxel = 40;
// Of answers that all clients together have requested and not read, beyond which there are no more frames.
constexpr std::size_t kMostOwedToAll = std::size_t{24} * 1024 * 1024;

std::string base64_of(std::span<const std::byte> bytes) {
  using namespace boost::archive::iterators;
  using Digits = base64_from_binary<transform_width<const char*, 6, 8>>;
  constexpr std::size_t kGroupDigits = 4;
  std::string copy(bytes.size() + 1, 0);  // the iterator reads a byte more where the last group is not full
  std::memcpy(copy.data(), bytes.data(), bytes.size());
  std::string text(Digits(copy.data()), Digits(copy.data() + bytes.size()));
  text.append((kGroupDigits - text.size() % kGroupDigits) % kGroupDigits, '=');
  return text;
}

// Which frame it is, and what it is worth: the last one stays here when no more come.
json about(const FrameCopy::Content& frame, State state, const Now& now) {
  const std::int64_t age_ns = std::max<std::int64_t>(0, now.monotonic_ns - frame.time_ns);
  return {{"seq", frame.sequence},
          {"time_ns", now.realtime_of(frame.time_ns)},
          {"state", to_string(state)},
          {"age_ms", 1e-6 * static_cast<double>(age_ns)}};
}

// float32, little-endian: a third of the time and of the bytes that digits take.
void add_base64(json& answer, const FrameCopy::Content& frame) {
  static_assert(std::endian::native == std::endian::little);
  const auto text_of = [](const std::vector<float>& values) {
    return base64_of(std::as_bytes(std::span(values)));
  };
  answer["normal_pa"] = text_of(frame.normal_pa);
  answer["shear_x_pa"] = text_of(frame.shear_x_pa);
  answer["shear_y_pa"] = text_of(frame.shear_y_pa);
}

void add_bytes(json& answer, const FrameCopy::Content& frame) {
  const FrameBytes bytes = frame_bytes(frame.normal_pa, frame.shear_x_pa, frame.shear_y_pa);
  answer["peak_pa"] = bytes.peak_pa;
  answer["peak_shear_pa"] = bytes.peak_shear_pa;
  answer["values"] = base64_of(std::as_bytes(std::span(bytes.values)));
}

void add_digits(json& answer, const FrameCopy::Content& frame, const TaxelLayout& layout) {
  std::vector<double> x_mm(layout.x_m().begin(), layout.x_m().end());
  std::vector<double> y_mm(layout.y_m().begin(), layout.y_m().end());
  for (auto* axis : {&x_mm, &y_mm}) {
    for (double& value : *axis) value *= 1e3;
  }
  answer["normal_pa"] = frame.normal_pa;
  answer["shear_x_pa"] = frame.shear_x_pa;
  answer["shear_y_pa"] = frame.shear_y_pa;
  answer["x_mm"] = x_mm;
  answer["y_mm"] = y_mm;
}

}  // namespace

FrameRequests::Encoding FrameRequests::encoding_of(const nlohmann::json& params) {
  const auto encoding = params.find("encoding");
  if (encoding == params.end()) return Encoding::digits;
  if (*encoding == "base64") return Encoding::base64;
  if (*encoding == "bytes") return Encoding::bytes;
  throw rpc::Error(rpc::kInvalidParams, "encoding must be \"base64\", \"bytes\" or absent");
}

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
  pending_[sensor].push_back(
      {reply, client.promise(kFrameBytesPerTaxel * layout->size()), encoding_of(params)});
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

// All get the same frame. Its text is made once for each encoding.
void FrameRequests::complete_of(std::size_t sensor) {
  SensorStatus& status = *context_.board.sensors[sensor];
  const FrameCopy::Content* frame = status.frame_copy.result();
  if (frame == nullptr) return;
  const auto waiting = std::exchange(pending_[sensor], {});
  const auto layout = status.facts().layout;
  const bool usable = frame->has_frame && layout && layout->size() == frame->normal_pa.size();
  std::array<std::string, kEncodings> texts;
  const char* trouble = usable ? nullptr : "no frame of this sensor has come yet";
  try {
    const State state = status.latest.load().estimate.state;
    for (const Pending& wanted : waiting) {
      std::string& text = texts[static_cast<std::size_t>(wanted.encoding)];
      if (!usable || !text.empty()) continue;
      json answer = about(*frame, state, Now::read());
      switch (wanted.encoding) {
        case Encoding::digits:
          add_digits(answer, *frame, *layout);
          break;
        case Encoding::base64:
          add_base64(answer, *frame);
          break;
        case Encoding::bytes:
          add_bytes(answer, *frame);
          break;
      }
      text = answer.dump();
    }
  } catch (const std::bad_alloc&) {
    trouble = "slipd has not enough memory for this";
  }
  status.frame_copy.release();
  for (const Pending& wanted : waiting) {
    if (trouble == nullptr) {
      wanted.reply.text(texts[static_cast<std::size_t>(wanted.encoding)]);
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
