// The orders of a person: a Unix socket of slipd-grip's own. A line "open", "close" or "status" comes, a JSON
// object goes back in a line, and the connection ends. The loop's thread; and what asks there, a program's
// own.
#pragma once

#include <functional>
#include <list>
#include <memory>
#include <string>

#include "bridges/support/loop.hpp"

namespace slipd::grip {

class OrderSocket {
 public:
  // The answer to a line, without its end.
  using Answer = std::function<std::string(const std::string& line)>;

  // Replaces a socket that nobody listens on. Throws std::runtime_error.
  OrderSocket(bridges::Loop& loop, const std::string& path, Answer answer);
  ~OrderSocket();
  OrderSocket(const OrderSocket&) = delete;
  OrderSocket& operator=(const OrderSocket&) = delete;

 private:
  struct Peer;
  void admit();
  void hear(Peer& peer);

  bridges::Loop& loop_;
  std::string path_;
  Answer answer_;
  int listener_ = -1;
  std::list<Peer> peers_;
  bridges::Loop::Watch watch_;
};

// Asks a running slipd-grip. Throws std::runtime_error.
std::string ask(const std::string& path, const std::string& line);

}  // namespace slipd::grip
