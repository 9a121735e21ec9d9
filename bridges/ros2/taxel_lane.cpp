#include "bridges/ros2/taxel_lane.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "bridges/ros2/messages/sensor_messages.hpp"

namespace slipd::ros2 {
namespace {

// How long slipd may take for a frame, s: also how long the end of the thread may take.
constexpr double kAnswer = 0.5;

// An array of numbers; null is unknown, and so is all of an array that is absent.
template <class T>
std::vector<T> numbers(const nlohmann::json& frame, const char* key, T factor, std::size_t size) {
  std::vector<T> values(size, static_cast<T>(kUnknown));
  const auto found = frame.find(key);
  if (found == frame.end() || !found->is_array() || found->size() != size) return values;
  for (std::size_t i = 0; i < size; ++i) {
    if ((*found)[i].is_number()) values[i] = factor * (*found)[i].get<T>();
  }
  return values;
}

}  // namespace

TaxelLane::TaxelLane(const std::string& socket, double rate_hz, std::vector<TaxelSource> sources,
                     StampOf stamp_of)
    : slipd_(socket),
      rate_hz_(rate_hz),
      sources_(std::move(sources)),
      stamp_of_(std::move(stamp_of)),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

void TaxelLane::run(const std::stop_token& stop) {
  const auto period = std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 / rate_hz_));
  auto due = std::chrono::steady_clock::now();
  std::unique_lock lock(mutex_);
  while (!stopped_.wait_until(lock, stop, due, [&] { return stop.stop_requested(); }) &&
         !stop.stop_requested()) {
    for (TaxelSource& source : sources_) {
      if (!source.output->wanted()) continue;
      char* answer = nullptr;
      // Without an answer there are no taxels; the other topics say that slipd is away.
      if (slipd_frame(slipd_.get(), source.sensor.c_str(), kAnswer, &answer) != SLIPD_DONE) continue;
      const std::unique_ptr<char, void (*)(char*)> owned(answer, slipd_free);
      try {
        publish(source, answer);
      } catch (const nlohmann::json::exception&) {  // a sensor that has had no frame yet
      }
    }
    due = std::max(due + period, std::chrono::steady_clock::now());
  }
}

// The answer to `frame` as a cloud. Throws nlohmann::json::exception.
void TaxelLane::publish(TaxelSource& source, const char* answer) {
  const nlohmann::json frame = nlohmann::json::parse(answer);
  const auto seq = frame.at("seq").get<std::uint64_t>();
  const std::size_t taxels = frame.at("normal_pa").size();
  if (taxels == 0 || std::exchange(source.sent, seq) == seq) return;
  const auto x = numbers(frame, "x_mm", 1e-3, taxels);
  const auto y = numbers(frame, "y_mm", 1e-3, taxels);
  const auto normal = numbers(frame, "normal_pa", 1.0F, taxels);
  const auto shear_x = numbers(frame, "shear_x_pa", 1.0F, taxels);
  const auto shear_y = numbers(frame, "shear_y_pa", 1.0F, taxels);
  Header header;
  header.frame_id = source.frame_id;
  header.stamp = time_of(stamp_of_(source.sensor, seq, frame.at("time_ns").get<std::int64_t>()));
  fill_cloud(header, {x, y, normal, shear_x, shear_y}, cloud_);
  source.output->put_now(Moment::now(), [&]() -> const PointCloud2& { return cloud_; });
}

}  // namespace slipd::ros2
