// slipd-grip's command line; slipd-grip(8). The service, and what gives orders to it.
#include <CLI/CLI.hpp>
#include <cstring>
#include <exception>
#include <iostream>

#include "bridges/support/line_socket.hpp"
#include "bridges/support/program.hpp"
#include "embedded/slipd_grip_schema.hpp"
#include "grip/controller.hpp"
#include "grip/release_notice.hpp"
#include "grip/settings.hpp"

namespace {

using namespace slipd;
using namespace slipd::grip;

constexpr const char* kDefaultOrders = "/run/slipd-grip/orders.sock";

class Service final : public bridges::Service {
 public:
  Service(const Settings& settings, bridges::Loop& loop)
      : controller_(settings),
        notice_(settings.socket, settings.fingers),
        orders_(loop, settings.orders, [this](const std::string& line) { return obey(line); }) {}

 private:
  std::string obey(const std::string& line) {
    nlohmann::json answer = controller_.status();
    const bool opens = line == "open";
    if (opens || line == "close") {
      controller_.wish(opens ? Wish::open : Wish::close);
      opens ? notice_.opens() : notice_.closes();
      answer = {{"taken", line}};
    } else if (line != "status") {
      answer = {{"error", "orders are open, close and status"}};
    }
    return answer.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  }

  Controller controller_;
  ReleaseNotice notice_;
  bridges::LineSocket orders_;
};

bool is_order(const char* word) {
  return std::strcmp(word, "open") == 0 || std::strcmp(word, "close") == 0 ||
         std::strcmp(word, "status") == 0;
}

// slipd-grip open|close|status [--orders SOCKET]
int give_order(int argc, char** argv) {
  CLI::App app{"Gives an order to a running slipd-grip", "slipd-grip"};
  std::string order, path = kDefaultOrders;
  app.add_option("order", order, "open, close, or status")->required();
  app.add_option("--orders", path, "Its socket for orders")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  std::cout << bridges::ask(path, order) << "\n";
  return 0;
}

int run(int argc, char** argv) {
  if (argc > 1 && is_order(argv[1])) return give_order(argc, argv);
  if (argc > 1 && std::strcmp(argv[1], "diagram") == 0) {
    std::cout << diagram();
    return 0;
  }
  return bridges::run_program({.name = "slipd-grip",
                               .summary = "Holds an object with the least force that keeps slipd's margin. "
                                          "Orders to it: slipd-grip open|close|status [--orders SOCKET]; "
                                          "its states: slipd-grip diagram",
                               .schema = slipd_grip_schema,
                               .further = problems_of},
                              argc, argv, [](const nlohmann::json& settings, bridges::Loop& loop) {
                                return std::make_unique<Service>(settings_of(settings), loop);
                              });
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "slipd-grip: " << error.what() << "\n";
    return 1;
  }
}
