#include "tests/support/subscriber.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <charconv>
#include <cstring>
#include <stdexcept>
#include <string_view>

namespace slipd::testing {
namespace {

using nlohmann::json;

std::int64_t realtime_ns() {
  return std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count();
}

// The text after `"key":` as far as the next comma or brace; without quotes.
std::string_view member(std::string_view line, std::string_view key) {
  const auto at = line.find(key);
  if (at == std::string_view::npos) return {};
  std::string_view rest = line.substr(at + key.size());
  rest = rest.substr(0, rest.find_first_of(",}"));
  if (rest.starts_with('"')) rest = rest.substr(1, rest.size() - 2);
  return rest;
}

std::uint64_t number(std::string_view text) {
  std::uint64_t value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

}  // namespace

Subscriber::Subscriber(const std::filesystem::path& socket_path, const json& params)
    : fd_(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, socket_path.c_str(), sizeof address.sun_path - 1);
  if (connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    close(fd_);
    throw std::runtime_error("connect to " + socket_path.string());
  }
  const std::string request =
      json{{"jsonrpc", "2.0"}, {"id", 0}, {"method", "subscribe"}, {"params", params}}.dump() + "\n";
  if (send(fd_, request.data(), request.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(request.size())) {
    close(fd_);
    throw std::runtime_error("subscribe");
  }
}

Subscriber::~Subscriber() {
  close(fd_);
}

bool Subscriber::read(std::chrono::milliseconds patience, std::size_t most_bytes) {
  pollfd ready{fd_, POLLIN, 0};
  if (poll(&ready, 1, static_cast<int>(patience.count())) <= 0) return false;
  const std::size_t had = input_.size();
  input_.resize(had + most_bytes);
  const auto got = recv(fd_, input_.data() + had, most_bytes, 0);
  input_.resize(had + static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
  const std::int64_t now_ns = realtime_ns();
  std::size_t start = 0;
  for (auto end = input_.find('\n'); end != std::string::npos; end = input_.find('\n', start)) {
    take_line(std::string_view(input_).substr(start, end - start), now_ns);
    start = end + 1;
  }
  input_.erase(0, start);
  return got > 0;
}

void Subscriber::take_line(std::string_view line, std::int64_t now_ns) {
  if (!line.starts_with('{') || !json::accept(line)) {
    ++broken_;
    return;
  }
  const std::string_view name = member(line, R"("sensor":)");
  if (name.empty()) return;  // the answer to the subscription
  Counts& counts = counts_[std::string(name)];
  const std::uint64_t sequence = number(member(line, R"("seq":)"));
  const bool another = sequence != counts.last_sequence;
  ++counts.events;
  counts.frames += another ? 1 : 0;
  counts.dropped += number(member(line, R"("dropped":)"));
  counts.last_sequence = sequence;
  counts.last_state = member(line, R"("state":)");
  if (another && keep_latencies_) {
    const auto sampled_ns = static_cast<std::int64_t>(number(member(line, R"("time_ns":)")));
    const std::lock_guard lock(mutex_);
    latencies_.delivered_us.push_back(1e-3 * static_cast<double>(now_ns - sampled_ns));
    latencies_.published_us.push_back(static_cast<double>(number(member(line, R"("latency_us":)"))));
  }
}

Subscriber::Latencies Subscriber::take_latencies() {
  const std::lock_guard lock(mutex_);
  return std::exchange(latencies_, {});
}

Subscriber::Counts Subscriber::total() const {
  Counts all;
  for (const auto& [name, counts] : counts_) {
    all.events += counts.events;
    all.frames += counts.frames;
    all.dropped += counts.dropped;
  }
  return all;
}

BackgroundReader::BackgroundReader(Subscriber& subscriber, std::chrono::milliseconds pause)
    : thread_([&subscriber, pause](const std::stop_token& stop) {
        const bool slow = pause.count() > 0;
        while (!stop.stop_requested()) {
          if (slow) std::this_thread::sleep_for(pause);
          subscriber.read(std::chrono::milliseconds(20), slow ? 4096 : 65536);
        }
      }) {}

}  // namespace slipd::testing
