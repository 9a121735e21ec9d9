// A Unix socket of a program's own, where others ask or order something: a line comes, a line goes back, as
// often as the other end likes. The loop's thread; and ask(), any other program's own.
#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <string>

#include "bridges/support/loop.hpp"

namespace slipd::bridges {

struct LineSocketOptions {
  // Longest line that is heard, bytes; who sends more is sent away.
  std::size_t longest_line = 64;
  // Connections at once, 1 or more.
  std::size_t most_peers = 16;
  // What one more connection gets as its only line; empty: it is taken, and the oldest is ended.
  std::string refusal;
};

class LineSocket {
 public:
  // The answer to a line, without its end.
  using Answer = std::function<std::string(const std::string& line)>;

  // Replaces a socket that nobody listens on. Owner and group may connect. Throws std::runtime_error.
  LineSocket(Loop& loop, const std::string& path, Answer answer, LineSocketOptions options = {});
  ~LineSocket();
  LineSocket(const LineSocket&) = delete;
  LineSocket& operator=(const LineSocket&) = delete;

 private:
  struct Peer;
  void admit();
  void hear(Peer& peer);
  bool serve(Peer& peer);

  Loop& loop_;
  std::string path_;
  Answer answer_;
  LineSocketOptions options_;
  int listener_ = -1;
  std::list<Peer> peers_;
  Loop::Watch watch_;
};

// Sends a line to a program that listens at `path`, and waits some seconds for its answer. Throws
// std::runtime_error.
std::string ask(const std::string& path, const std::string& line);

}  // namespace slipd::bridges
