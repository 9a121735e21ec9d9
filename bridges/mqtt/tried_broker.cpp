#include "bridges/mqtt/tried_broker.hpp"

#include <fstream>
#include <system_error>
#include <utility>

namespace slipd::mqtt {

TriedBroker::TriedBroker(std::filesystem::path file) : file_(std::move(file)) {
  std::ifstream in(file_);
  if (std::string line; in && std::getline(in, line) && !line.empty()) left_behind_ = line;
}

TriedBroker::~TriedBroker() {
  std::error_code ignored;
  std::filesystem::remove(file_, ignored);
}

void TriedBroker::note(const std::string& broker) {
  if (broker == noted_) return;
  std::ofstream out(file_);
  if (out << broker << '\n' << std::flush) noted_ = broker;
}

}  // namespace slipd::mqtt
