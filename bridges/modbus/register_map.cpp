#include "bridges/modbus/register_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string_view>

namespace slipd::modbus {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr double kMsPerS = 1e3;
constexpr std::uint64_t kLow15 = 0x7FFF, kLow31 = 0x7FFFFFFF;

double low_bits(std::uint64_t number, std::uint64_t mask) {
  return static_cast<double>(number & mask);
}

// Whether anything is known of it.
bool current(const slipd_estimate& e) {
  return e.state != SLIPD_STATE_STALE && e.state != SLIPD_STATE_DISCONNECTED;
}
double if_current(const slipd_estimate& e, double value) {
  return current(e) ? value : kNothing;
}

// A raised alert stands until frames show its end. "None" is no fact without frames.
double alert(const slipd_estimate& e) {
  if (e.alert == SLIPD_ALERT_UNKNOWN) return kNothing;
  return e.alert == SLIPD_ALERT_NONE ? if_current(e, e.alert) : e.alert;
}

// An alert without a cause is of an older libslipd.
double alert_cause(const slipd_estimate& e) {
  const bool known = (e.alert_cause == SLIPD_CAUSE_NONE) == (e.alert == SLIPD_ALERT_NONE) &&
                     e.alert_cause != SLIPD_CAUSE_UNKNOWN;
  return known && !std::isnan(alert(e)) ? e.alert_cause : kNothing;
}

constexpr std::array<Register<Header>, 6> kHeader{{
    {0, RegisterType::u16, 1, "", "map_version", "1. Rises when a register changes its meaning",
     [](const Header&) -> double { return kMapVersion; }},
    {1, RegisterType::u16, 1, "", "heartbeat",
     "rises by 1 every 100 ms while slipd works, and wraps at 65535 to 0. It stands still when slipd does "
     "not work",
     [](const Header& h) { return static_cast<double>((h.alive_ms / kHeartbeatMs) & 0xFFFF); }},
    {2, RegisterType::u16, 1, "", "alive", "1: slipd works; 2: it does not, and no margin is valid",
     [](const Header& h) { return h.alive ? 1.0 : 2.0; }},
    {3, RegisterType::u16, 1, "", "blocks", "number of blocks in use",
     [](const Header& h) -> double { return h.blocks; }},
    {4, RegisterType::u16, 1, "", "first_block", "address of block 0: 16",
     [](const Header&) -> double { return kFirstBlock; }},
    {5, RegisterType::u16, 1, "", "block_size", "registers of a block: 32. Block n begins at 16 + 32 n",
     [](const Header&) -> double { return kBlockSize; }},
}};

constexpr std::array<Register<slipd_estimate>, 18> kBlock{{
    {0, RegisterType::u16, 1, "", "state",
     "0 ok, 1 no_contact, 2 learning, 3 out_of_model, 4 no_shear, 5 unzeroed, 6 stale, 7 fault, 8 "
     "disconnected",
     [](const slipd_estimate& e) -> double { return e.state; }},
    {1, RegisterType::u16, 1, "", "frame", "low 15 bits of the frame's number: changes with each frame",
     [](const slipd_estimate& e) { return if_current(e, low_bits(e.sequence, kLow15)); }},
    {2, RegisterType::u16, 1e-4, "", "gamma", "safety margin, 0 to 1; known in state 0 only",
     [](const slipd_estimate& e) { return slipd_margin(&e); }},
    {3, RegisterType::u16, 1e-4, "", "gamma_low", "the margin that holds with 95 % confidence",
     [](const slipd_estimate& e) { return if_current(e, e.gamma_low); }},
    {4, RegisterType::u16, 1e-4, "", "sigma", "standard deviation of gamma",
     [](const slipd_estimate& e) { return if_current(e, e.sigma); }},
    {5, RegisterType::u16, 1e-3, "", "friction", "coefficient of friction",
     [](const slipd_estimate& e) { return if_current(e, e.friction); }},
    {6, RegisterType::u16, 0.01, "N", "normal_force", "normal force",
     [](const slipd_estimate& e) { return if_current(e, e.normal_n); }},
    {7, RegisterType::u16, 0.01, "N", "shear_force", "tangential force",
     [](const slipd_estimate& e) { return if_current(e, e.shear_n); }},
    {8, RegisterType::s16, 1e-4, "N m", "torque", "torque about the contact's normal",
     [](const slipd_estimate& e) { return if_current(e, e.torque_nm); }},
    {9, RegisterType::s16, 0.01, "N", "grip_increase",
     "normal force to add; negative: a smaller force suffices",
     [](const slipd_estimate& e) { return if_current(e, e.grip_increase_n); }},
    {10, RegisterType::u16, 1, "", "alert",
     "0 none, 1 warn, 2 slip; 1 and 2 stand until frames show their end, also in states 6 to 8", alert},
    {11, RegisterType::u16, 1, "", "sliding", "0 none, 1 disturbed, 2 translation, 3 rotation",
     [](const slipd_estimate& e) {
       return e.sliding == SLIPD_SLIDING_UNKNOWN ? kNothing : if_current(e, e.sliding);
     }},
    {12, RegisterType::u16, 1, "ms", "time_to_slip", "at the present trend",
     [](const slipd_estimate& e) { return if_current(e, kMsPerS * e.time_to_slip_s); }},
    {13, RegisterType::u16, 1, "", "simulated", "0 real sensor, 1 simulated",
     [](const slipd_estimate& e) { return if_current(e, e.simulated); }},
    {14, RegisterType::u32, 1, "ms", "age", "age of the frame when the register was read",
     [](const slipd_estimate& e) {
       return e.state == SLIPD_STATE_DISCONNECTED || std::isinf(e.age_s) ? kNothing : kMsPerS * e.age_s;
     }},
    {16, RegisterType::u32, 1, "", "frame_number", "low 31 bits of the frame's number",
     [](const slipd_estimate& e) { return if_current(e, low_bits(e.sequence, kLow31)); }},
    {18, RegisterType::u16, 1e-4, "", "friction_sigma", "standard deviation of friction",
     [](const slipd_estimate& e) { return if_current(e, e.friction_sigma); }},
    {19, RegisterType::u16, 1, "", "alert_cause", "0 no alert, 1 the margin is small, 2 the object slides",
     alert_cause},
}};

// The count for a scaled value, within [least, most].
std::int64_t count_of(double value, double scale, std::int64_t least, std::int64_t most) {
  return static_cast<std::int64_t>(
      std::clamp(std::round(value / scale), static_cast<double>(least), static_cast<double>(most)));
}

// The sentinel is beyond the limits of known values.
void write_value(RegisterType type, double scale, double value, std::span<std::uint16_t> at) {
  constexpr int kWordBits = 16;
  switch (type) {
    case RegisterType::u16:
      at[0] =
          std::isnan(value) ? kUnknown : static_cast<std::uint16_t>(count_of(value, scale, 0, kUnknown - 1));
      return;
    case RegisterType::s16:
      at[0] = std::isnan(value) ? kUnknownSigned
                                : static_cast<std::uint16_t>(count_of(value, scale, -INT16_MAX, INT16_MAX));
      return;
    case RegisterType::u32: {
      const auto count = std::isnan(value)
                             ? kUnknownLong
                             : static_cast<std::uint32_t>(count_of(value, scale, 0, kUnknownLong - 1));
      at[0] = static_cast<std::uint16_t>(count >> kWordBits);
      at[1] = static_cast<std::uint16_t>(count);
      return;
    }
  }
}

template <typename Source>
void write_all(std::span<const Register<Source>> table, const Source& source, std::span<std::uint16_t> out) {
  std::fill(out.begin(), out.end(), kUnknown);
  for (const auto& each : table)
    write_value(each.type, each.scale, each.value(source),
                out.subspan(static_cast<std::size_t>(each.offset)));
}

std::string_view name_of(RegisterType type) {
  static constexpr std::array<std::string_view, 3> kNames{"u16", "s16", "u32"};
  return kNames[static_cast<std::size_t>(type)];
}
std::string_view sentinel_of(RegisterType type) {
  static constexpr std::array<std::string_view, 3> kSentinels{"0xFFFF", "0x8000", "0xFFFFFFFF"};
  return kSentinels[static_cast<std::size_t>(type)];
}

template <typename Source>
void add_csv(std::ostream& out, std::span<const Register<Source>> table, int base) {
  for (const auto& each : table)
    out << base + each.offset << ',' << each.name << ',' << name_of(each.type) << ',' << each.scale << ','
        << each.unit << ',' << sentinel_of(each.type) << ",\"" << each.meaning << "\"\n";
}

template <typename Source>
void add_markdown(std::ostream& out, std::span<const Register<Source>> table, const char* base) {
  out << "| register | name | type | one count | not known | meaning |\n|---|---|---|---|---|---|\n";
  for (const auto& each : table)
    out << "| " << base << each.offset << " | `" << each.name << "` | " << name_of(each.type) << " | "
        << each.scale << (*each.unit != 0 ? " " : "") << each.unit << " | " << sentinel_of(each.type) << " | "
        << each.meaning << " |\n";
}

}  // namespace

std::span<const Register<Header>> header_registers() {
  return kHeader;
}
std::span<const Register<slipd_estimate>> block_registers() {
  return kBlock;
}

void write_header(const Header& header, std::span<std::uint16_t> registers) {
  write_all(header_registers(), header, registers.first(kFirstBlock));
}

void write_block(const slipd_estimate& estimate, std::span<std::uint16_t> registers) {
  write_all(block_registers(), estimate, registers.first(kBlockSize));
}

std::string map_as_csv() {
  std::ostringstream out;
  out << "address,name,type,scale,unit,not_known,meaning\n";
  add_csv(out, header_registers(), 0);
  add_csv(out, block_registers(), kFirstBlock);
  return out.str();
}

std::string map_as_markdown() {
  std::ostringstream out;
  add_markdown(out, header_registers(), "");
  out << '\n';
  add_markdown(out, block_registers(), "block + ");
  return out.str();
}

}  // namespace slipd::modbus
