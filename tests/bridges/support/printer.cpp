// A bridge with nothing but the skeleton: prints what the feed tells it, one line each.
#include <iostream>

#include "bridges/support/feed.hpp"
#include "bridges/support/program.hpp"

namespace {

using namespace slipd::bridges;

constexpr std::string_view kSchema =
    R"({"type": "object", "additionalProperties": false, "required": ["socket"],
  "properties": {"socket": {"type": "string"}, "word": {"type": "string", "default": "none"}}})";

class Printer : public Service {
 public:
  Printer(const nlohmann::json& settings, Loop& loop) : feed_(loop, options_of(settings), listener()) {
    std::cout << "word " << settings.at("word").get<std::string>() << std::endl;
  }
  ~Printer() override { std::cout << "end" << std::endl; }

 private:
  static FeedOptions options_of(const nlohmann::json& settings) {
    FeedOptions options;
    options.socket = settings.at("socket");
    options.texts = true;
    options.max_age_s = 10;
    options.refresh = std::chrono::milliseconds(100);
    return options;
  }
  static FeedListener listener() {
    FeedListener listener;
    listener.serves = [](const Inventory& all) {
      std::cout << "serves";
      for (const SensorFacts& sensor : all.sensors) std::cout << ' ' << sensor.name;
      std::cout << std::endl;
    };
    listener.away = [](std::string_view) { std::cout << "away" << std::endl; };
    listener.estimate = [](const slipd_estimate& estimate, std::string_view text) {
      const auto sent = nlohmann::json::parse(text);
      const bool same = sent.at("sensor") == estimate.name && sent.at("seq") == estimate.sequence;
      std::cout << (same ? "estimate " : "wrong ") << estimate.name << std::endl;
    };
    return listener;
  }
  Feed feed_;
};

}  // namespace

int main(int argc, char** argv) {
  return run_program(
      {"bridge-printer", "Prints what slipd tells a bridge", kSchema}, argc, argv,
      [](const nlohmann::json& settings, Loop& loop) { return std::make_unique<Printer>(settings, loop); });
}
