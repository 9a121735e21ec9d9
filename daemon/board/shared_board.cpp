#include "daemon/board/shared_board.hpp"

#include <fcntl.h>
#include <linux/futex.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <new>
#include <system_error>

#include "daemon/rt/clock.hpp"

namespace slipd {
namespace {

using board_layout::Header;
using board_layout::Record;
using board_layout::Slot;

// Since Linux 6.3; not in the headers of Debian 12.
constexpr unsigned kNoExecSeal = 0x0008U;

[[noreturn]] void refuse_memory(const char* what) {
  throw std::system_error(errno, std::generic_category(), std::string("the board's shared memory: ") + what);
}

UniqueFd make_file(std::size_t bytes) {
  constexpr const char* kName = "slipd-board";
  UniqueFd file(memfd_create(kName, MFD_CLOEXEC | MFD_ALLOW_SEALING | kNoExecSeal));
  if (!file) file = UniqueFd(memfd_create(kName, MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!file) refuse_memory("memfd_create");
  if (ftruncate(file.get(), static_cast<off_t>(bytes)) != 0) refuse_memory("ftruncate");
  return file;
}

Header& header_at(std::byte* memory) noexcept {
  return *reinterpret_cast<Header*>(memory);
}

Slot& slot_at(std::byte* memory, std::size_t slot) noexcept {
  return *reinterpret_cast<Slot*>(memory + sizeof(Header) + slot * sizeof(Slot));
}

void construct(std::byte* memory, const std::vector<std::string>& sensors,
               const std::vector<std::string>& grasps) {
  auto* const header = new (memory) Header;
  header->header_bytes = sizeof(Header);
  header->slot_bytes = sizeof(Slot);
  header->sensors = static_cast<std::uint32_t>(sensors.size());
  header->grasps = static_cast<std::uint32_t>(grasps.size());
  header->generation = static_cast<std::uint64_t>(Now::read().realtime_ns);
  header->pid = static_cast<std::uint32_t>(getpid());
  for (std::size_t i = 0; i < sensors.size() + grasps.size(); ++i) {
    auto* const slot = new (&slot_at(memory, i)) Slot;
    const bool grasp = i >= sensors.size();
    const std::string& name = grasp ? grasps[i - sensors.size()] : sensors[i];
    slot->kind = grasp ? 1 : 0;
    // The configuration's names have 32 characters at most.
    std::copy_n(name.begin(), std::min(name.size(), slot->name.size() - 1), slot->name.begin());
  }
}

void wake(std::atomic<std::uint32_t>& word, std::uint32_t readers) noexcept {
  // Not FUTEX_PRIVATE: the readers are other processes.
  syscall(SYS_futex, &word, FUTEX_WAKE, std::min<std::uint32_t>(readers, INT_MAX), nullptr, nullptr, 0);
}

double or_unknown(const std::optional<double>& value) noexcept {
  return value.value_or(board_layout::kUnknown);
}

Record record_of(const Estimate& estimate, bool simulated) noexcept {
  Record record;
  record.sequence = estimate.sequence;
  record.time_ns = estimate.time_ns;
  record.published_ns = estimate.published_ns;
  if (estimate.state == State::ok) record.gamma = or_unknown(estimate.gamma);
  record.sigma = or_unknown(estimate.sigma);
  record.gamma_low = or_unknown(estimate.gamma_low);
  record.friction = or_unknown(estimate.friction);
  record.friction_sigma = or_unknown(estimate.friction_sigma);
  record.normal_n = or_unknown(estimate.normal_n);
  record.shear_n = or_unknown(estimate.shear_n);
  record.torque_nm = or_unknown(estimate.torque_nm);
  record.torque_sigma_nm = or_unknown(estimate.torque_sigma_nm);
  record.center_x_m = or_unknown(estimate.center_x_m);
  record.center_y_m = or_unknown(estimate.center_y_m);
  record.radius_m = or_unknown(estimate.radius_m);
  record.a_over_r = or_unknown(estimate.a_over_r);
  record.time_to_slip_s = or_unknown(estimate.time_to_slip_s);
  record.grip_increase_n = or_unknown(estimate.grip_increase_n);
  record.grip_increase_sigma_n = or_unknown(estimate.grip_increase_sigma_n);
  record.sliding_for_s = or_unknown(estimate.sliding_for_s);
  if (simulated) record.truth_gamma = estimate.truth.gamma;
  if (simulated) record.truth_friction = estimate.truth.friction;
  record.state = static_cast<std::uint8_t>(estimate.state);
  record.alert = static_cast<std::uint8_t>(estimate.alert);
  record.alert_cause = static_cast<std::uint8_t>(estimate.alert_cause);
  record.method = static_cast<std::uint8_t>(estimate.method);
  record.health = static_cast<std::uint8_t>(estimate.health);
  if (estimate.sliding) record.sliding = static_cast<std::uint8_t>(*estimate.sliding);
  record.simulated = simulated ? 1 : 0;
  return record;
}

static_assert(static_cast<std::uint8_t>(State::stale) == board_layout::kStale &&
              static_cast<std::uint8_t>(Alert::unknown) == board_layout::kAlertUnknown &&
              static_cast<std::uint8_t>(Health::unknown) == board_layout::kHealthUnknown);

}  // namespace

SharedBoard::~SharedBoard() {
  close();
  if (std::byte* const memory = memory_.load(std::memory_order_relaxed)) munmap(memory, bytes_);
}

void SharedBoard::open(const std::vector<std::string>& sensors, const std::vector<std::string>& grasps) {
  if (memory_.load(std::memory_order_relaxed) != nullptr) return;
  const std::size_t slots = sensors.size() + grasps.size();
  const std::size_t bytes = board_layout::bytes_for(sensors.size(), grasps.size());
  std::shared_ptr<Use[]> uses(new Use[slots]);  // make_shared of GCC 12 would copy them
  UniqueFd file = make_file(bytes);
  void* const mapped = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, file.get(), 0);
  if (mapped == MAP_FAILED) refuse_memory("mmap");
  // After mmap: F_SEAL_FUTURE_WRITE leaves the mappings that there are.
  if (fcntl(file.get(), F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_FUTURE_WRITE | F_SEAL_SEAL) != 0) {
    const int why = errno;
    munmap(mapped, bytes);
    errno = why;
    refuse_memory("its seals");
  }
  auto* const memory = static_cast<std::byte*>(mapped);
  construct(memory, sensors, grasps);
  file_ = std::move(file);
  bytes_ = bytes;
  slots_ = slots;
  uses_ = std::move(uses);
  memory_.store(memory, std::memory_order_release);  // pairs with Writer::begin_round
}

UniqueFd SharedBoard::descriptor() const {
  UniqueFd other(fcntl(file_.get(), F_DUPFD_CLOEXEC, 0));
  if (!other) refuse_memory("a descriptor of it");
  return other;
}

SharedBoard::Attachment SharedBoard::wait_for(const std::vector<std::size_t>& slots) {
  auto ended = [uses = uses_, slots](const void*) {
    for (const std::size_t slot : slots) uses[slot].waiting.fetch_sub(1, std::memory_order_relaxed);
  };
  // Before the attachment is made: if there is no memory for it, `ended` is called.
  for (const std::size_t slot : slots) uses_[slot].waiting.fetch_add(1, std::memory_order_relaxed);
  return {uses_.get(), std::move(ended)};
}

std::uint64_t SharedBoard::generation() const noexcept {
  return header_at(memory_.load(std::memory_order_relaxed)).generation;
}

void SharedBoard::wake_others() noexcept {
  std::byte* const memory = memory_.load(std::memory_order_relaxed);
  if (memory == nullptr) return;
  for (std::size_t i = 0; i < slots_; ++i) {
    if (!uses_[i].others_due.exchange(false, std::memory_order_relaxed)) continue;
    wake(slot_at(memory, i).published, uses_[i].waiting.load(std::memory_order_relaxed));
  }
}

void SharedBoard::close() noexcept {
  std::byte* const memory = memory_.load(std::memory_order_relaxed);
  if (memory == nullptr) return;
  // Pairs with the reader's acquire: it sees all records that were published before.
  header_at(memory).closed.store(1, std::memory_order_release);
  for (std::size_t i = 0; i < slots_; ++i) {
    // The word changes, or a reader that looked at `closed` just before would sleep on.
    slot_at(memory, i).published.fetch_add(1, std::memory_order_release);
    wake(slot_at(memory, i).published, INT_MAX);
  }
}

// A thread that is stopped between its look at the others and its store makes the heartbeat older, never
// newer; the next round of any writer mends it.
bool SharedBoard::Writer::begin_round(std::int64_t now_ns, bool& is_new) noexcept {
  std::byte* const memory = board_.memory_.load(std::memory_order_acquire);  // pairs with open
  is_new = memory != memory_;
  memory_ = memory;
  if (memory == nullptr) return false;
  round_ns_.store(now_ns, std::memory_order_relaxed);
  std::int64_t oldest_ns = now_ns;
  for (const auto& each : board_.rounds_ns_)
    oldest_ns = std::min(oldest_ns, each.load(std::memory_order_relaxed));
  header_at(memory).heartbeat_ns.store(oldest_ns, std::memory_order_relaxed);
  return true;
}

bool SharedBoard::Writer::publish(std::size_t slot_index, Record& record) noexcept {
  Slot& slot = slot_at(memory_, slot_index);
  Use& use = board_.uses_[slot_index];
  record.number = ++use.published;
  slot.latest.store(record);
  // Release: pairs with the reader's acquire before it looks at the record.
  slot.published.fetch_add(1, std::memory_order_release);
  const std::uint32_t waiting = use.waiting.load(std::memory_order_relaxed);
  if (waiting == 0) return false;
  wake(slot.published, std::min(waiting, kWokenDirectly));
  if (waiting <= kWokenDirectly) return false;
  use.others_due.store(true, std::memory_order_relaxed);
  return true;
}

bool SharedBoard::Writer::publish_sensor(std::size_t sensor, const Estimate& estimate,
                                         bool simulated) noexcept {
  if (memory_ == nullptr) return false;
  Record record = record_of(estimate, simulated);
  return publish(sensor, record);
}

bool SharedBoard::Writer::publish_grasp(std::size_t grasp, const Estimate& estimate, std::int64_t oldest_ns,
                                        bool simulated, std::size_t first_sensor) noexcept {
  if (memory_ == nullptr) return false;
  const std::size_t slot = header_at(memory_).sensors + grasp;
  Record record = record_of(estimate, simulated);
  record.time_ns = oldest_ns;
  record.truth_gamma = board_layout::kUnknown;
  record.truth_friction = board_layout::kUnknown;
  if (estimate.first_gamma) {
    record.first_gamma = *estimate.first_gamma;
    record.first_sensor = static_cast<std::uint32_t>(first_sensor);
  }
  return publish(slot, record);
}

}  // namespace slipd
