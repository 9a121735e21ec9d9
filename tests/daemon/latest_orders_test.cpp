// Latest, in every order of events that release and acquire allow.
#include <gtest/gtest.h>

#include "core/frame/latest.hpp"
#include "tests/support/memory_model/weak_memory.hpp"

namespace slipd {
namespace {

using testing::CheckedAtomic;
using testing::demand;
using testing::Violation;
using testing::WeakMemory;
using Access = WeakMemory::Access;

constexpr std::size_t kWriter = 1, kReader = 2;
constexpr std::uint64_t kStores = 6;
constexpr int kLoads = 3;
constexpr std::size_t kWords = 2, kRound = kWords + 4;  // accesses of one attempt of load()

struct Pair {
  std::uint64_t first, second;
};

// All stores come first. This leaves nothing out: the writer does not read what readers write, and a load
// may give each value that no happens-before relation excludes.
template <typename CanSource>
void read_while_written(WeakMemory& memory) {
  CanSource latest(Pair{0, 0});
  memory.synchronize(0, kWriter);
  memory.synchronize(0, kReader);
  const std::size_t known = memory.choose(kStores + 1);  // stores that happen before the first load
  memory.run_as(kWriter);
  for (std::uint64_t i = 1; i <= kStores; ++i) {
    latest.store({i, i});
    if (i == known) memory.synchronize(kWriter, kReader);
  }
  memory.run_as(kReader);
  std::uint64_t last = known;
  for (int i = 0; i < kLoads; ++i) {
    memory.settle_after(kRound);
    const Pair seen = latest.load();
    demand(seen.first == seen.second, "half of one value and half of another");
    demand(seen.first >= last, "a value, and then one from before it");
    last = seen.first;
  }
}

// An earlier form of Latest, in which a reader could go back: a copy counted as valid once it was whole,
// published or not.
class OnceLatest {
 public:
  explicit OnceLatest(Pair initial) { store(initial); }
  void store(Pair value) {
    const std::uint64_t next = 1 - current_.load(std::memory_order_relaxed);
    Copy& copy = copies_[next];
    const std::uint64_t version = copy.version.load(std::memory_order_relaxed);
    copy.version.store(version + 1, std::memory_order_relaxed);
    copy.first.store(value.first, std::memory_order_release);
    copy.second.store(value.second, std::memory_order_release);
    copy.version.store(version + 2, std::memory_order_release);
    current_.store(next, std::memory_order_release);
  }
  Pair load() const {
    for (;;) {
      const Copy& copy = copies_[current_.load(std::memory_order_acquire)];
      const std::uint64_t before = copy.version.load(std::memory_order_acquire);
      const Pair value{copy.first.load(std::memory_order_acquire),
                       copy.second.load(std::memory_order_acquire)};
      const std::uint64_t after = copy.version.load(std::memory_order_relaxed);
      if (before == after && (before & 1U) == 0) return value;
    }
  }

 private:
  struct Copy {
    CheckedAtomic<std::uint64_t> version, first, second;
  };
  std::array<Copy, 2> copies_;
  CheckedAtomic<std::uint64_t> current_;
};

using CanSource = Latest<Pair, CheckedAtomic>;

TEST(Latest, InEveryOrderOfEventsIsWholeAndNeverGoesBack) {
  const std::size_t paths = WeakMemory::explore(read_while_written<CanSource>);
  RecordProperty("paths", static_cast<int>(paths));
  EXPECT_GT(paths, 1000U);
}

TEST(Latest, AsItOnceWasIsFoundToGoBack) {
  try {
    WeakMemory::explore(read_while_written<OnceLatest>);
    FAIL() << "the checker has not found what was wrong";
  } catch (const Violation& violation) {
    EXPECT_STREQ(violation.what(), "a value, and then one from before it");
  }
}

// Locations in the order in which they are made: version and words of either copy, then which copy is
// current.
constexpr std::size_t kCurrent = 2 * (1 + kWords);
bool is_version(std::size_t location) {
  return location != kCurrent && location % (1 + kWords) == 0;
}
bool is_word(std::size_t location) {
  return location != kCurrent && !is_version(location);
}

TEST(Latest, NeedsEachOfItsOrders) {
  struct Site {
    const char* name;
    Access access;
    bool (*of)(std::size_t location);
  };
  const Site sites[] = {
      {"load of a word", Access::load, is_word},
      {"store of a word", Access::store, is_word},
      {"load of a version", Access::load, is_version},
      {"store of a version", Access::store, is_version},
  };
  for (const Site& site : sites) {
    const auto weakened = [&](std::size_t location, std::size_t, Access access, std::memory_order order) {
      return access == site.access && site.of(location) ? std::memory_order_relaxed : order;
    };
    EXPECT_THROW(WeakMemory::explore(read_while_written<CanSource>, weakened), Violation) << site.name;
  }
}

}  // namespace
}  // namespace slipd
