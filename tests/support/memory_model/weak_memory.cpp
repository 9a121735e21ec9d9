#include "tests/support/memory_model/weak_memory.hpp"

#include <algorithm>

namespace slipd::testing {
namespace {

WeakMemory* the_one = nullptr;

bool acquires(std::memory_order order) {
  return order == std::memory_order_acquire || order == std::memory_order_acq_rel;
}

bool releases(std::memory_order order) {
  return order == std::memory_order_release || order == std::memory_order_acq_rel;
}

}  // namespace

void WeakMemory::View::join(const View& other) {
  newest.resize(std::max(newest.size(), other.newest.size()));
  for (std::size_t i = 0; i < other.newest.size(); ++i) newest[i] = std::max(newest[i], other.newest[i]);
  for (std::size_t i = 0; i < kThreads; ++i) clock[i] = std::max(clock[i], other.clock[i]);
}

std::size_t& WeakMemory::View::at(std::size_t location) {
  newest.resize(std::max(newest.size(), location + 1));
  return newest[location];
}

WeakMemory& WeakMemory::current() {
  if (the_one == nullptr) throw std::logic_error("CheckedAtomic outside of explore()");
  return *the_one;
}

std::size_t WeakMemory::explore(const std::function<void(WeakMemory&)>& body, const Weaken& weaken) {
  std::vector<Choice> path;
  for (std::size_t paths = 1;; ++paths) {
    WeakMemory memory(weaken);
    memory.path_ = std::move(path);
    the_one = &memory;
    try {
      body(memory);
    } catch (...) {
      the_one = nullptr;
      throw;
    }
    the_one = nullptr;
    if (memory.seen_ != nullptr) throw Violation(memory.seen_);
    if (!memory.next_path()) return paths;
    path = std::move(memory.path_);
  }
}

bool WeakMemory::next_path() {
  while (!path_.empty() && path_.back().taken + 1 == path_.back().options) path_.pop_back();
  if (path_.empty()) return false;
  ++path_.back().taken;
  return true;
}

std::size_t WeakMemory::choose(std::size_t options) {
  if (options == 1) return 0;
  if (depth_ == path_.size()) path_.push_back({0, options});
  if (path_[depth_].options != options) throw std::logic_error("the code under test is not deterministic");
  return path_[depth_++].taken;
}

std::size_t WeakMemory::add_location(std::uint64_t initial) {
  locations_.push_back({{initial, views_[thread_]}});
  return locations_.size() - 1;
}

std::memory_order WeakMemory::order_of(std::size_t location, Access access, std::memory_order order) {
  return weaken_ ? weaken_(location, thread_, access, order) : order;
}

std::uint64_t WeakMemory::load(std::size_t location, std::memory_order order) {
  step();
  const auto& values = locations_[location];
  std::size_t& known = views_[thread_].at(location);
  const std::size_t which =
      accesses_ > settled_after_ ? values.size() - 1 : known + choose(values.size() - known);
  known = which;
  const Value& value = values[which];
  if (acquires(order_of(location, Access::load, order))) views_[thread_].join(value.behind);
  return value.value;
}

void WeakMemory::store(std::size_t location, std::uint64_t value, std::memory_order order) {
  step();
  View& view = views_[thread_];
  const std::size_t which = locations_[location].size();
  if (view.at(location) + 1 != which) seen_ = "two threads store to one location";
  view.at(location) = which;
  Value stored{value, {}};
  if (releases(order_of(location, Access::store, order))) {
    stored.behind = view;
  } else {
    stored.behind.at(location) = which;
  }
  locations_[location].push_back(std::move(stored));
}

std::uint64_t WeakMemory::exchange(std::size_t location, std::uint64_t value, std::memory_order order) {
  step();
  View& view = views_[thread_];
  const std::memory_order real = order_of(location, Access::exchange, order);
  const std::size_t which = locations_[location].size();
  const Value before = locations_[location].back();  // an exchange reads the newest value
  if (acquires(real)) view.join(before.behind);
  view.at(location) = which;
  Value stored{value, before.behind};  // the head of a release sequence is kept
  if (releases(real)) stored.behind.join(view);
  stored.behind.at(location) = which;
  locations_[location].push_back(std::move(stored));
  return before.value;
}

std::size_t WeakMemory::add_plain() {
  plain_.emplace_back();
  return plain_.size() - 1;
}

void WeakMemory::write_plain(std::size_t place) {
  step();
  const View& view = views_[thread_];
  for (std::size_t other = 0; other < kThreads; ++other) {
    if (plain_[place].written[other] > view.clock[other]) seen_ = "written by two at once";
    if (plain_[place].read[other] > view.clock[other]) seen_ = "written while another reads it";
  }
  plain_[place].written[thread_] = view.clock[thread_];
}

void WeakMemory::read_plain(std::size_t place) {
  step();
  const View& view = views_[thread_];
  for (std::size_t other = 0; other < kThreads; ++other) {
    if (plain_[place].written[other] > view.clock[other]) seen_ = "read while another writes it";
  }
  plain_[place].read[thread_] = view.clock[thread_];
}

}  // namespace slipd::testing
