// paths-bench: what stands between device and client, piece by piece: decoding by each profile, the hand-over
// of frames and estimates between threads, and an estimate as text.
#include <benchmark/benchmark.h>

#include <atomic>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/frame/latest.hpp"
#include "core/frame/mailbox.hpp"
#include "daemon/rpc/methods/estimate_text.hpp"
#include "drivers/decode/decoder.hpp"
#include "tests/bench/scenes.hpp"
#include "tests/bench/times.hpp"

namespace slipd::bench {
namespace {

// One scan of a device's first sensor, packet by packet as its profile lays them out; what cuts packets out
// of a stream of bytes is not in it.
struct Scan {
  struct Packet {
    std::uint32_t id;
    std::vector<std::uint8_t> bytes;
  };
  std::vector<Packet> packets;

  explicit Scan(const std::vector<decode::PacketRule>& rules) {
    for (const auto& rule : rules) {
      Packet packet{rule.id, std::vector<std::uint8_t>(rule.length, 1)};
      if (rule.match.mask != 0) packet.bytes[rule.match.offset] = rule.match.value;
      packets.push_back(std::move(packet));
    }
  }

  // A device's count of its scans goes on, and its clock.
  void count(const std::vector<decode::PacketRule>& rules, std::uint64_t number) noexcept {
    for (std::size_t i = 0; i < rules.size(); ++i) {
      for (const auto& round : {rules[i].clock, rules[i].counter}) {
        if (!round) continue;
        for (std::size_t b = 0; b < round->bytes; ++b) {
          const std::size_t shift = 8 * (round->big_endian ? round->bytes - 1 - b : b);
          packets[i].bytes[round->offset + b] = static_cast<std::uint8_t>(number >> shift);
        }
      }
    }
  }
};

void decode_profile(benchmark::State& state, const std::string& name) {
  const decode::Profile profile = decode::find_profile(name);
  decode::Decoder decoder(profile, 0, 1);
  Scan scan(decoder.rules());
  std::vector<float> memory(3 * profile.layout.size());
  FrameSlot slot;
  const std::span all(memory);
  slot.normal_pa = all.first(profile.layout.size());
  slot.shear_x_pa = all.subspan(profile.layout.size(), profile.layout.size());
  slot.shear_y_pa = all.last(profile.layout.size());
  Times times;
  std::uint64_t number = 0, frames = 0;
  std::int64_t time_ns = 0;
  for (auto _ : state) {
    scan.count(decoder.rules(), ++number);
    time_ns += 2 * profile.scan_timeout_ns;
    decode::Outcome outcome = decode::Outcome::foreign;
    const std::int64_t since = now_ns();
    for (const auto& packet : scan.packets) outcome = decoder.take(packet.id, packet.bytes, time_ns, slot);
    times.add(since);
    frames += outcome == decode::Outcome::frame ? 1 : 0;
  }
  times.report(state);
  state.counters["taxels"] = static_cast<double>(profile.layout.size());
  state.counters["packets"] = static_cast<double>(scan.packets.size());
  if (frames == 0) state.SkipWithError("what its packets are only the device says");
}

// Both sides of a mailbox in one thread: what the atomic operations cost by themselves.
void mailbox_alone(benchmark::State& state) {
  FrameMailbox mailbox(static_cast<std::size_t>(state.range(0)));
  for (auto _ : state) {
    mailbox.publish(mailbox.writable());
    benchmark::DoNotOptimize(mailbox.take());
  }
}

// From one core's hands into another's: the frame written here, its first and last value read there.
void mailbox_across(benchmark::State& state) {
  const auto taxels = static_cast<std::size_t>(state.range(0));
  FrameMailbox mailbox(taxels);
  std::atomic<bool> stop{false};
  std::atomic<std::int64_t> taken{0};
  std::thread taker([&] {
    while (!stop.load(std::memory_order_relaxed)) {
      if (const FrameSlot* slot = mailbox.take())
        taken.store(static_cast<std::int64_t>(slot->sequence), std::memory_order_release);
    }
  });
  const std::vector<float> frame(taxels, 1.0F);
  Times times;
  std::int64_t number = 0;
  for (auto _ : state) {
    FrameSlot slot = mailbox.writable();
    slot.sequence = static_cast<std::uint64_t>(++number);
    for (const auto& channel : {slot.normal_pa, slot.shear_x_pa, slot.shear_y_pa})
      std::copy(frame.begin(), frame.end(), channel.begin());
    const std::int64_t since = now_ns();
    mailbox.publish(slot);
    while (taken.load(std::memory_order_acquire) != number) {
    }
    times.add(since);
  }
  stop.store(true, std::memory_order_relaxed);
  taker.join();
  times.report(state);
}

void latest(benchmark::State& state) {
  Latest<Estimate> board;
  Estimate estimate;
  for (auto _ : state) {
    ++estimate.sequence;
    board.store(estimate);
    benchmark::DoNotOptimize(board.load());
  }
}

Estimate usual_estimate() {
  Estimate estimate;
  estimate.sequence = 123456;
  estimate.time_ns = 8'123'456'789;
  estimate.published_ns = estimate.time_ns + 35'200;
  estimate.gamma = 0.62345678901;
  estimate.sigma = 0.012345678;
  estimate.friction = 0.4567890123;
  estimate.friction_sigma = 0.0223344556;
  estimate.normal_n = 2.123456789;
  estimate.shear_n = 0.3612345678;
  estimate.center_x_m = 1.2345678e-4;
  estimate.center_y_m = -4.345678901e-4;
  estimate.radius_m = 3.123456789e-3;
  estimate.a_over_r = 0.3123456789;
  estimate.grip_increase_n = 0;
  estimate.state = State::ok;
  estimate.method = Method::registered;
  return estimate;
}

void as_text(benchmark::State& state) {
  const Estimate estimate = usual_estimate();
  const Now now{8'123'999'999, 1'790'000'000'000'000'000};
  Times times;
  for (auto _ : state) {
    const std::int64_t since = now_ns();
    std::string text;
    EstimateText(estimate, "left", false).append_to(text, now);
    benchmark::DoNotOptimize(text.data());
    times.add(since);
  }
  times.report(state);
}

void register_all() {
  for (const std::string& name : decode::profile_names()) {
    benchmark::RegisterBenchmark(("decode/" + name).c_str(), [name](benchmark::State& s) {
      decode_profile(s, name);
    })->UseRealTime();
  }
  benchmark::RegisterBenchmark("mailbox/alone", mailbox_alone)->Arg(10000)->UseRealTime();
  benchmark::RegisterBenchmark("mailbox/across", mailbox_across)->Arg(16)->Arg(10000)->UseRealTime();
  benchmark::RegisterBenchmark("board/latest", latest)->UseRealTime();
  benchmark::RegisterBenchmark("estimate/text", as_text)->UseRealTime();
}

}  // namespace
}  // namespace slipd::bench

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  slipd::bench::register_all();
  benchmark::RunSpecifiedBenchmarks();
}
