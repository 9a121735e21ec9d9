#include "bridges/web/reader.hpp"

#include <sys/epoll.h>

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <utility>

#include "bridges/support/log.hpp"
#include "bridges/web/answers/live_message.hpp"
#include "bridges/web/answers/picture.hpp"

namespace slipd::web {
namespace {

using Json = nlohmann::json;
using namespace std::chrono_literals;

constexpr double kAnswerS = 0.4;    // slipd may take this long; the page says that it is silent after 0.8 s
constexpr double kOldAge = 1e6;     // s: the subscription is for its events, ages are judged elsewhere
constexpr auto kStatusPeriod = 1s;  // the status has no events
constexpr auto kLayoutPeriod = 5s;  // a reload may have changed where taxels are
constexpr auto kPulse = 1s;         // in which the server's thread must run once
constexpr int kEvents = SLIPD_EVENT_ESTIMATE | SLIPD_EVENT_ALERT | SLIPD_EVENT_STATE;

std::string quoted(const std::string& text) {
  return Json(text).dump(-1, ' ', true, Json::error_handler_t::replace);
}

}  // namespace

Reader::Reader(bridges::Loop& loop, Settings settings)
    : loop_(loop),
      settings_(std::move(settings)),
      period_(std::chrono::duration_cast<Clock::duration>(
          std::chrono::duration<double>(1 / settings_.max_rate_hz))),
      requests_(settings_.slipd_socket),
      bell_(std::make_unique<bridges::Bell>()),
      estimates_(loop, [this] { send_live(); }),
      beat_(loop, [this] { send_live(); }),
      status_(loop, [this] { send_status(); }),
      pictures_(loop, [this] { send_pictures(); }),
      pulse_(loop, [this] { check_server(); }),
      rung_(loop, bell_->fd(), EPOLLIN, [this](std::uint32_t) { wanted_changed(); }) {
  server_ = std::make_unique<Server>(settings_, [bell = bell_.get()] { bell->ring(); });
  check_server();
}

Reader::~Reader() = default;

void Reader::wanted_changed() {
  bell_->hear();
  wanted_ = server_->wanted();
  if (wanted_.browsers > 0 && !events_) begin();
  if (wanted_.browsers == 0 && events_) end();
  if (wanted_.method) send_method();
  plan_pictures();
}

// This thread feeds the watchdog, and only while the server's thread runs too.
void Reader::check_server() {
  pulse_.start(kPulse);
  loop_.feed_watchdog(server_->answers());
}

Reader::Clock::duration Reader::until_next(Clock::time_point last) const {
  return std::max(Clock::duration::zero(), last + period_ - Clock::now());
}

void Reader::begin() {
  events_.emplace(settings_.slipd_socket);
  event_ = bridges::Loop::Watch(loop_, events_->fd(), EPOLLIN, [this](std::uint32_t) { take_events(); });
  status_.start(0s);
  send_live();
}

// Until slipd has taken it. From then on libslipd renews it.
void Reader::subscribe() {
  subscribed_ =
      slipd_subscribe(events_->get(), nullptr, settings_.max_rate_hz, kEvents, kAnswerS) == SLIPD_DONE;
  if (subscribed_) take_events();  // one read may have brought estimates behind the answer
}

// Nobody looks: slipd is not asked for anything.
void Reader::end() {
  for (auto* timer : {&estimates_, &beat_, &status_, &pictures_}) timer->stop();
  event_ = {};
  events_.reset();
  subscribed_ = false;
}

// Something is new: the estimates are sent once the period has passed.
void Reader::take_events() {
  slipd_estimate estimate;
  bool news = false;
  for (;;) {
    const int code = slipd_next(events_->get(), kOldAge, 0, &estimate);
    if (code == SLIPD_TIMEOUT) break;
    news = true;
    if (code != SLIPD_DONE) break;
  }
  if (news && !estimates_.running()) estimates_.start(until_next(sent_));
}

void Reader::send_live() {
  sent_ = Clock::now();
  estimates_.stop();
  beat_.start(kHeartbeat);
  try {
    live_ = live_message(ask("gamma"), settings_.max_age_ms);
    server_->publish_live(live_);
    if (!away_.empty()) bridges::log(bridges::LogLevel::notice, "slipd is there again");
    if (!away_.empty()) laid_out_.clear();
    away_.clear();
    if (!subscribed_) subscribe();
  } catch (const std::exception& error) {
    if (away_.empty())
      bridges::log(bridges::LogLevel::warning, std::string("slipd is not reached: ") + error.what());
    away_ = error.what();
    server_->publish_live(away_message(away_, live_));
  }
}

void Reader::send_status() {
  status_.start(kStatusPeriod);
  if (!away_.empty()) return;
  try {
    server_->publish_status(status_message(ask("sensors").text, ask("status").text));
  } catch (const std::exception&) {
    // The next estimates say why.
  }
}

// The server says when a browser is ready for the next one. A sensor without pictures is asked again later,
// and does not delay the others.
void Reader::plan_pictures() {
  const bool due = std::any_of(wanted_.looks.begin(), wanted_.looks.end(),
                               [&](const std::string& sensor) { return !without_.contains(sensor); });
  if (due) return pictures_.start(until_next(pictured_));
  if (!wanted_.looks.empty() && !pictures_.running()) pictures_.start(kHeartbeat);
}

void Reader::send_pictures() {
  wanted_ = server_->wanted();
  // In step with the last one, so that neither a late timer nor the work below makes the rate lower.
  const auto now = Clock::now();
  pictured_ = now - pictured_ < 2 * period_ ? pictured_ + period_ : now;
  std::erase_if(without_, [&](const auto& each) { return each.second <= now; });
  for (const std::string& sensor : wanted_.looks) {
    if (without_.contains(sensor) || (away_.empty() && send_picture(sensor))) continue;
    without_[sensor] = Clock::now() + kHeartbeat;
  }
  plan_pictures();
}

// False: there is none now.
bool Reader::send_picture(const std::string& sensor) {
  try {
    const std::string name = R"({"sensor":)" + quoted(sensor);
    auto& asked = laid_out_[sensor];
    if (asked == Clock::time_point{} || Clock::now() - asked > kLayoutPeriod) {
      server_->publish_layout(sensor, layout_picture(sensor, ask("frame", name + "}").text));
      asked = Clock::now();
    }
    server_->publish_picture(
        sensor, frame_picture(sensor, ask("frame", name + R"(,"encoding":"bytes"})"), settings_.max_age_ms));
    return true;
  } catch (const std::exception&) {
    laid_out_.erase(sensor);  // a browser may look at what is no sensor
    return false;
  }
}

std::string Reader::tradeoff_of(const std::string& sensor) {
  try {
    return ask("tradeoff", R"({"sensor":)" + quoted(sensor) + "}").text;
  } catch (const std::exception& error) {
    return Json{{"trouble", error.what()}}.dump(-1, ' ', true, Json::error_handler_t::replace);
  }
}

void Reader::send_method() {
  wanted_.method = false;
  Json answer;
  try {
    answer = Json::parse(ask("sensors").text);
    for (Json& sensor : answer.at("sensors")) {
      Json tradeoff = Json::parse(tradeoff_of(sensor.at("name")));
      if (tradeoff.contains("trouble")) {
        sensor["trouble"] = tradeoff.at("trouble");
      } else {
        sensor["tradeoff"] = std::move(tradeoff);
      }
    }
  } catch (const std::exception& error) {
    answer = {{"trouble", std::string("slipd is not reached: ") + error.what()}};
  }
  server_->publish_method(answer.dump(-1, ' ', true, Json::error_handler_t::replace));
}

Answer Reader::ask(const char* method, const std::string& params) {
  const auto now_ms = [] {
    return std::chrono::duration<double, std::milli>(Clock::now().time_since_epoch()).count();
  };
  const double asked_ms = now_ms();
  std::string text = requests_.call(method, params, -1, kAnswerS);
  return {std::move(text), asked_ms, now_ms()};
}

}  // namespace slipd::web
