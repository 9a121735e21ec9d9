#include "bridges/modbus/board_finder.hpp"

#include <sys/epoll.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "bridges/support/bell.hpp"

namespace slipd::modbus {
namespace {

// Between two attempts.
constexpr std::chrono::milliseconds kRetry{500};
// slipd may take this long for an answer, s.
constexpr double kAnswerTimeout = 1;

FoundBoard find_board(const std::string& socket) {
  FoundBoard found{client::Connection(socket), {}};
  found.inventory = bridges::ask_inventory(found.slipd, kAnswerTimeout);
  found.slipd.attach({}, kAnswerTimeout);
  return found;
}

}  // namespace

// Of the loop's thread and the finder's. The mutex is held no longer than it takes to move what was found.
struct BoardFinder::Shared {
  std::string socket;
  bridges::Bell bell;
  std::mutex mutex;
  std::condition_variable changed;
  bool wanted = true;
  bool ended = false;
  std::optional<FoundBoard> found;
  std::string why;  // of the last attempt that failed

  void run() {
    std::unique_lock lock(mutex);
    for (;;) {
      changed.wait(lock, [this] { return wanted || ended; });
      if (ended) return;
      lock.unlock();
      std::optional<FoundBoard> board;
      std::string trouble;
      try {
        board = find_board(socket);
      } catch (const std::exception& error) {
        trouble = error.what();
      }
      lock.lock();
      wanted = !board;
      found = std::move(board);
      why = std::move(trouble);
      bell.ring();
      if (wanted) changed.wait_for(lock, kRetry, [this] { return ended; });
    }
  }
};

BoardFinder::BoardFinder(bridges::Loop& loop, const std::string& socket, BoardListener listener)
    : shared_(std::make_shared<Shared>()),
      listener_(std::move(listener)),
      watch_(loop, shared_->bell.fd(), EPOLLIN, [this](std::uint32_t) { hear(); }) {
  shared_->socket = socket;
  std::thread([shared = shared_] { shared->run(); }).detach();
}

BoardFinder::~BoardFinder() {
  const std::lock_guard lock(shared_->mutex);
  shared_->ended = true;
  shared_->changed.notify_one();
}

void BoardFinder::look() {
  const std::lock_guard lock(shared_->mutex);
  if (shared_->wanted || shared_->found) return;
  shared_->wanted = true;
  shared_->changed.notify_one();
}

void BoardFinder::hear() {
  shared_->bell.hear();
  std::optional<FoundBoard> found;
  std::string why;
  {
    const std::lock_guard lock(shared_->mutex);
    found = std::exchange(shared_->found, std::nullopt);
    why = std::exchange(shared_->why, {});
  }
  if (found) return listener_.found(std::move(*found));
  if (!why.empty()) listener_.away(why);
}

}  // namespace slipd::modbus
