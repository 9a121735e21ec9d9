#include "drivers/decode/decoder.hpp"

#include <algorithm>
#include <cmath>

namespace slipd::decode {

std::uint32_t with_board_number(std::uint32_t id, const std::optional<unsigned>& board_shift,
                                unsigned board) noexcept {
  return board_shift ? id + (board << *board_shift) : id;
}

Decoder::Decoder(const Profile& profile, std::size_t sensor, unsigned board)
    : rules_(profile.scan),
      sensor_class_(profile.sensor_class),
      timeout_ns_(profile.scan_timeout_ns),
      key_offset_(profile.key_offset) {
  for (PacketRule& rule : rules_) {
    rule.id = with_board_number(rule.id, rule.board_shift, board);
    std::erase_if(rule.fields, [sensor](const Field& field) { return field.sensor != sensor; });
  }
}

bool Decoder::matches(const PacketRule& rule, std::uint32_t id,
                      std::span<const std::uint8_t> bytes) const noexcept {
  if (rule.id != id) return false;
  return rule.match.mask == 0 || (rule.match.offset < bytes.size() &&
                                  (bytes[rule.match.offset] & rule.match.mask) == rule.match.value);
}

bool Decoder::fits_some_rule(std::uint32_t id, std::size_t bytes) const noexcept {
  return std::any_of(rules_.begin(), rules_.end(),
                     [&](const PacketRule& rule) { return rule.id == id && rule.length == bytes; });
}

std::string Decoder::why_no_frames(const std::string& packets) const {
  if (!misfit_) return {};
  const bool numbered =
      std::any_of(rules_.begin(), rules_.end(), [](const auto& rule) { return rule.id != 0; });
  std::string expected;
  for (std::size_t i = 0; i < rules_.size(); ++i) {
    const auto same = [&](const PacketRule& rule) {
      return rule.length == rules_[i].length && rule.id == rules_[i].id;
    };
    if (std::find_if(rules_.begin(), rules_.end(), same) != rules_.begin() + static_cast<std::ptrdiff_t>(i))
      continue;
    expected += (expected.empty() ? "" : ", ") + std::to_string(rules_[i].length);
    if (numbered) expected += " with id " + std::to_string(rules_[i].id);
  }
  return packets + " of " + std::to_string(misfit_->bytes) + " bytes" +
         (numbered ? " with id " + std::to_string(misfit_->id) : "") + " arrive, the profile expects " +
         expected + ": choose or correct the profile";
}

bool Decoder::of_another_scan(std::span<const std::uint8_t> bytes) const noexcept {
  return key_offset_ && *key_offset_ < bytes.size() && bytes[*key_offset_] != key_;
}

void Decoder::drop() noexcept {
  if (next_ == 0) return;
  next_ = 0;
  ++counts_.incomplete;
  ++sequence_;
}

Outcome Decoder::drop_malformed() noexcept {
  ++counts_.malformed;
  if (next_ == 0) ++sequence_;  // the packet would have begun a scan
  drop();
  return Outcome::dropped;
}

void Decoder::mark_packet_lost() noexcept {
  if (next_ == 0 && rules_.size() == 1) ++sequence_;
  drop();
}

void Decoder::reset() noexcept {
  next_ = 0;
  misfit_.reset();
  clock_ = counter_ = {};
  clock_ns_ = 0;
}

void Decoder::WrappingCounter::read(const std::optional<WrappingNumber>& of_packet,
                                    std::span<const std::uint8_t> bytes) noexcept {
  if (!of_packet) return;
  rule = of_packet;
  now = wire::read_bits(bytes.data() + rule->offset, rule->bytes, rule->big_endian);
}

std::optional<std::uint64_t> Decoder::WrappingCounter::step() noexcept {
  const bool first = !last;
  const std::int64_t moved = wire::steps(last.value_or(now), now, rule->bytes);
  last = now;
  if (first || moved < 0) return std::nullopt;
  return static_cast<std::uint64_t>(moved);
}

// The sequence follows the device's count of scans. A scan with the same count as the last is dropped. So is
// one whose count goes back (it was overtaken, or the device restarted); later scans are counted from there.
// False: drop the scan.
bool Decoder::follow_counter() noexcept {
  if (!counter_.rule) return true;
  const bool first = !counter_.last;
  const std::optional<std::uint64_t> step = counter_.step();
  if (first) return true;
  if (step.value_or(0) == 0) {
    ++counts_.repeated;
    return false;
  }
  sequence_ = last_sequence_ + *step;
  return true;
}

std::int64_t Decoder::device_time_ns() noexcept {
  if (!clock_.rule) return -1;
  const std::optional<std::uint64_t> step = clock_.step();
  const double unit_ns = clock_.rule->unit_ns;
  clock_ns_ =
      step ? clock_ns_ + static_cast<double>(*step) * unit_ns : static_cast<double>(clock_.now) * unit_ns;
  return clock_ns_ < 9e18 ? static_cast<std::int64_t>(clock_ns_) : -1;
}

bool Decoder::fill(const PacketRule& rule, std::span<const std::uint8_t> bytes, FrameSlot& slot) noexcept {
  for (const Field& field : rule.fields) {
    const double raw = wire::read_number(bytes.data() + field.offset, field.type);
    const auto value = static_cast<float>((raw - field.zero) * field.gain_pa);
    if (!std::isfinite(value)) return false;
    const auto& channel = field.channel == Channel::normal    ? slot.normal_pa
                          : field.channel == Channel::shear_x ? slot.shear_x_pa
                                                              : slot.shear_y_pa;
    channel[field.taxel] = value;
  }
  return true;
}

Outcome Decoder::take(std::uint32_t id, std::span<const std::uint8_t> bytes, std::int64_t time_ns,
                      FrameSlot& slot) noexcept {
  const auto of_id = [&](const PacketRule& rule) { return rule.id == id; };
  const bool expected = matches(rules_[next_], id, bytes);
  if (!expected && std::none_of(rules_.begin(), rules_.end(), of_id)) {
    misfit_ = {id, bytes.size()};
    return Outcome::foreign;
  }
  ++counts_.packets;
  if (!fits_some_rule(id, bytes.size())) {
    misfit_ = {id, bytes.size()};
    return drop_malformed();
  }

  const bool was_begun = next_ != 0;
  const bool late = was_begun && time_ns - begun_ns_ > timeout_ns_;
  bool lost = false;
  if (!expected || late || (was_begun && of_another_scan(bytes))) {
    lost = was_begun;
    drop();
    if (!matches(rules_[0], id, bytes)) {
      ++counts_.stray;
      return lost ? Outcome::dropped : Outcome::partial;
    }
  }
  const PacketRule& rule = rules_[next_];
  if (bytes.size() != rule.length || !fill(rule, bytes, slot)) return drop_malformed();
  if (next_ == 0) {
    begun_ns_ = time_ns;
    if (key_offset_) key_ = bytes[*key_offset_];
  }
  clock_.read(rule.clock, bytes);
  counter_.read(rule.counter, bytes);
  if (++next_ < rules_.size()) return lost ? Outcome::dropped : Outcome::partial;
  next_ = 0;
  if (!follow_counter()) return Outcome::dropped;
  if (sensor_class_ == SensorClass::normal) {
    std::fill(slot.shear_x_pa.begin(), slot.shear_x_pa.end(), 0.0F);
    std::fill(slot.shear_y_pa.begin(), slot.shear_y_pa.end(), 0.0F);
  }
  last_sequence_ = sequence_++;
  slot.sequence = last_sequence_;
  slot.time_ns = begun_ns_;
  slot.device_time_ns = device_time_ns();
  slot.truth = {};
  return Outcome::frame;
}

}  // namespace slipd::decode
