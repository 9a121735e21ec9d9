// A model of release-acquire memory, in one thread: it tries exhaustively all values that lock-free code can
// read on any processor, not only those that the present processor produces.
//
// The code under test is the real one, with Atomic of this file in place of std::atomic. Each location keeps
// all values that it ever had, in order. Each thread has a view: for each location, the oldest value that it
// may still read. A load may give any value that is not older than the view, which covers store buffers,
// caches and every order in which loads may be served. An acquire that reads a release takes over the view
// behind it. (Batty et al. 2011 in the operational form of Kang et al. 2017. A load is not served after a
// store that follows it in the program; seq_cst is not modelled.) Plain memory is checked for races by the
// same views. choose() tries all choices, depth first.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <vector>

namespace slipd::testing {

// Thrown by explore(): an observed violation.
class Violation : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

inline void demand(bool holds, const char* what) {
  if (!holds) throw Violation(what);
}

class WeakMemory {
 public:
  enum class Access : std::uint8_t { load, store, exchange };

  // Replaces the memory order of an access: tests weaken it to show that the stronger one is needed.
  using Weaken =
      std::function<std::memory_order(std::size_t location, std::size_t thread, Access, std::memory_order)>;

  static constexpr std::size_t kThreads = 3;  // thread 0 makes the others and sees everything they share

  // Runs `body` once for each possible sequence of choices; returns the number of sequences. Throws
  // Violation.
  static std::size_t explore(const std::function<void(WeakMemory&)>& body, const Weaken& weaken = {});

  static WeakMemory& current();

  // Chooses one of `options` ways to go on.
  std::size_t choose(std::size_t options);

  void run_as(std::size_t thread) { thread_ = thread; }
  // Everything that thread `from` has done so far happens before what thread `to` does next: a doorbell rang.
  void synchronize(std::size_t from, std::size_t to) { views_[to].join(views_[from]); }
  // After this many accesses from now, loads give the newest value. It ends a loop that repeats until it has
  // read a consistent value. (What a failed round has seen leaves fewer choices to the next round, not more,
  // so no violation is missed.)
  void settle_after(std::size_t accesses) { settled_after_ = accesses_ + accesses; }

  // Memory without atomics, named by the test. A race is a violation.
  std::size_t add_plain();
  void write_plain(std::size_t place);
  void read_plain(std::size_t place);

  std::size_t add_location(std::uint64_t initial);
  std::uint64_t load(std::size_t location, std::memory_order order);
  void store(std::size_t location, std::uint64_t value, std::memory_order order);
  std::uint64_t exchange(std::size_t location, std::uint64_t value, std::memory_order order);

 private:
  struct View {
    std::vector<std::size_t> newest;   // by location: index of the oldest value that may still be read
    std::size_t clock[kThreads] = {};  // by thread: how many of its accesses happen before
    void join(const View& other);
    std::size_t& at(std::size_t location);
  };
  struct Value {
    std::uint64_t value;
    View behind;  // the view that an acquire of this value takes over
  };
  struct Plain {
    std::size_t written[kThreads] = {}, read[kThreads] = {};  // clocks of the last accesses
  };

  explicit WeakMemory(const Weaken& weaken) : weaken_(weaken) {}
  std::memory_order order_of(std::size_t location, Access access, std::memory_order order);
  void step() { ++views_[thread_].clock[thread_], ++accesses_; }
  bool next_path();

  const Weaken& weaken_;
  std::vector<std::vector<Value>> locations_;
  std::vector<Plain> plain_;
  View views_[kThreads];
  std::size_t thread_ = 0, accesses_ = 0, settled_after_ = static_cast<std::size_t>(-1);
  struct Choice {
    std::size_t taken, options;
  };
  std::vector<Choice> path_;
  std::size_t depth_ = 0;
  const char* seen_ = nullptr;  // thrown at the path's end: the code under test may be noexcept
};

// Replaces std::atomic, with the operations that slipd's own code uses.
template <typename T>
class CheckedAtomic {
 public:
  CheckedAtomic(T initial = T{})
      : location_(WeakMemory::current().add_location(static_cast<std::uint64_t>(initial))) {}
  CheckedAtomic(const CheckedAtomic&) = delete;
  CheckedAtomic& operator=(const CheckedAtomic&) = delete;

  T load(std::memory_order order) const {
    return static_cast<T>(WeakMemory::current().load(location_, order));
  }
  void store(T value, std::memory_order order) {
    WeakMemory::current().store(location_, static_cast<std::uint64_t>(value), order);
  }
  T exchange(T value, std::memory_order order) {
    return static_cast<T>(
        WeakMemory::current().exchange(location_, static_cast<std::uint64_t>(value), order));
  }

 private:
  std::size_t location_;
};

}  // namespace slipd::testing
