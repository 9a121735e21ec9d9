#include "drivers/hid/descriptor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <string>

#include "drivers/decode/profile_parts.hpp"

namespace slipd::hid {
namespace {

using Bytes = std::span<const std::uint8_t>;

// Items by the upper six bits of their first byte.
enum class Item : std::uint8_t {
  input = 0x80,
  usage_page = 0x04,
  logical_minimum = 0x14,
  logical_maximum = 0x24,
  physical_minimum = 0x34,
  physical_maximum = 0x44,
  unit_exponent = 0x54,
  unit = 0x64,
  report_size = 0x74,
  report_id = 0x84,
  report_count = 0x94,
  push = 0xA4,
  pop = 0xB4,
  usage = 0x08,
  usage_minimum = 0x18,
  usage_maximum = 0x28,
  long_item = 0xFE
};
constexpr std::uint8_t kMainType = 0, kConstant = 1;
constexpr std::size_t kDeepest = 16;
constexpr std::uint32_t kMostBits = 4096 * 8;
constexpr std::size_t kMostFields = 4096;  // of all reports: a few bytes of descriptor can claim any number
constexpr std::uint32_t kForceInDyne = 0xE111;  // SI linear: cm g s^-2
constexpr double kNewtonPerDyne = 1e-5;

// The item state table: global items hold until they are replaced.
struct Global {
  std::uint32_t page = 0, unit = 0, size = 0, count = 0;
  Range logical, physical;
  int exponent = 0;
  std::uint8_t report = 0;
};

class Parser {
 public:
  explicit Parser(Bytes in) {
    while (!in.empty()) {
      if (static_cast<Item>(in[0]) == Item::long_item) return;  // the standard defines none
      const std::size_t size = (in[0] & 3U) == 3U ? 4 : in[0] & 3U;
      if (in.size() <= size) return;
      if (!take(in[0], in.subspan(1, size))) return;
      in = in.subspan(1 + size);
    }
  }

  std::vector<InputField> fields;
  std::map<std::uint8_t, std::size_t> bits;  // of each input report

 private:
  static std::uint32_t natural(Bytes data) {
    std::uint32_t out = 0;
    for (std::size_t i = 0; i < data.size(); ++i) out |= std::uint32_t{data[i]} << (8 * i);
    return out;
  }
  static std::int32_t whole(Bytes data) {
    const unsigned unused = data.empty() ? 0 : 32U - 8U * static_cast<unsigned>(data.size());
    return static_cast<std::int32_t>(natural(data) << unused) >> unused;
  }
  // A maximum has a sign only where its minimum is negative: devices state 65535 in two bytes.
  static std::int64_t maximum(Bytes data, std::int64_t minimum) {
    return minimum < 0 ? std::int64_t{whole(data)} : std::int64_t{natural(data)};
  }

  // One item. False: parsing ends.
  bool take(std::uint8_t head, Bytes data) {
    const auto item = static_cast<Item>(head & 0xFCU);
    switch (item) {
      case Item::input:
        return input(natural(data));
      case Item::push:
        if (kept_.size() >= kDeepest) return false;
        kept_.push_back(global_);
        break;
      case Item::pop:
        if (kept_.empty()) return false;
        global_ = kept_.back();
        kept_.pop_back();
        break;
      case Item::usage:
        usages_.push_back(data.size() == 4 ? natural(data) : global_.page << 16 | natural(data));
        break;
      case Item::usage_minimum:
        usage_low_ = natural(data);
        break;
      case Item::usage_maximum:
        for (std::uint32_t usage = usage_low_; usage <= natural(data) && usages_.size() < kMostBits; ++usage)
          usages_.push_back(global_.page << 16 | usage);
        break;
      default:
        set_global(item, data);
    }
    if ((head & 0x0CU) >> 2 == kMainType) usages_.clear();
    return true;
  }

  void set_global(Item item, Bytes data) {
    switch (item) {
      case Item::usage_page:
        global_.page = natural(data);
        break;
      case Item::logical_minimum:
        global_.logical.minimum = whole(data);
        break;
      case Item::logical_maximum:
        global_.logical.maximum = maximum(data, global_.logical.minimum);
        break;
      case Item::physical_minimum:
        global_.physical.minimum = whole(data);
        break;
      case Item::physical_maximum:
        global_.physical.maximum = maximum(data, global_.physical.minimum);
        break;
      case Item::unit_exponent:  // four bits, signed
        global_.exponent = static_cast<int>(natural(data) & 0xFU);
        global_.exponent -= global_.exponent > 7 ? 16 : 0;
        break;
      case Item::unit:
        global_.unit = natural(data);
        break;
      case Item::report_size:
        global_.size = natural(data);
        break;
      case Item::report_id:
        global_.report = static_cast<std::uint8_t>(natural(data));
        break;
      case Item::report_count:
        global_.count = natural(data);
        break;
      default:  // of no consequence to input fields
        break;
    }
  }

  bool input(std::uint32_t flags) {
    std::size_t& at = bits[global_.report];
    if (global_.size > kMostBits || global_.count > kMostBits ||
        at + std::size_t{global_.size} * global_.count > kMostBits ||
        fields.size() + global_.count > kMostFields)
      return false;
    for (std::uint32_t i = 0; i < global_.count; ++i, at += global_.size) {
      if ((flags & kConstant) != 0 || usages_.empty()) continue;  // padding
      fields.push_back(field(usages_[std::min<std::size_t>(i, usages_.size() - 1)], at));
    }
    usages_.clear();
    return true;
  }

  InputField field(std::uint32_t usage, std::size_t bit) const {
    const Range &logical = global_.logical, &physical = global_.physical;
    InputField out{global_.report, usage, bit, global_.size, logical.minimum < 0, logical, physical, 0, 0};
    const bool mapped = !logical.is_empty() && !physical.is_empty();
    const double slope = mapped ? static_cast<double>(physical.maximum - physical.minimum) /
                                      static_cast<double>(logical.maximum - logical.minimum)
                                : 1.0;
    const double unit_n = global_.unit == kForceInDyne ? kNewtonPerDyne : 1.0;
    out.newtons_a_count = slope * std::pow(10.0, global_.exponent) * unit_n;
    out.zero_count =
        mapped ? static_cast<double>(logical.minimum) - static_cast<double>(physical.minimum) / slope : 0;
    return out;
  }

  Global global_;
  std::vector<Global> kept_;
  std::vector<std::uint32_t> usages_;
  std::uint32_t usage_low_ = 0;
};

std::string hex(std::uint32_t usage) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "0x%08x", usage);
  return text.data();
}

std::string text_of(const Range& range) {
  return std::to_string(range.minimum) + " to " + std::to_string(range.maximum);
}

// Without a rising range a count has no scale. A descriptor without a physical range means the logical one.
void check_ranges(const InputField& field) {
  const std::string where = "the input of usage " + hex(field.usage) + " in the device's report descriptor";
  const std::string instead = ", whose maximum is not above its minimum: name its value by offset and type";
  if (field.logical.is_empty())
    throw DriverError(where + " has counts from " + text_of(field.logical) + instead);
  if (field.physical != Range{} && field.physical.is_empty())
    throw DriverError(where + " has a physical range from " + text_of(field.physical) + instead);
}

const InputField& readable_input(const std::vector<InputField>& fields, std::uint32_t usage) {
  const auto found = std::ranges::find(fields, usage, &InputField::usage);
  if (found == fields.end())
    throw DriverError("the device has no input of usage " + hex(usage) + ", which the profile names");
  if (found->bit % 8 != 0 || (found->bits != 8 && found->bits != 16 && found->bits != 32)) {
    throw DriverError("the input of usage " + hex(usage) + " has " + std::to_string(found->bits) +
                      " bits from bit " + std::to_string(found->bit) + " on; only whole bytes can be read");
  }
  check_ranges(*found);
  return *found;
}

}  // namespace

std::vector<InputField> input_fields(Bytes descriptor) {
  return Parser(descriptor).fields;
}

std::size_t report_length(Bytes descriptor, std::uint8_t report) {
  const Parser parser(descriptor);
  const auto found = parser.bits.find(report);
  return found == parser.bits.end() ? 0 : (found->second + 7) / 8;
}

void resolve_usages(decode::Profile& profile, Bytes descriptor) {
  const Parser parser(descriptor);
  for (std::size_t i = 0; i < profile.scan.size(); ++i) {
    decode::PacketRule& rule = profile.scan[i];
    const std::string at = pointer_to("/scan/packets", i);
    const InputField* first = nullptr;
    for (decode::Field& field : rule.fields) {
      if (field.usage == 0) continue;
      const InputField& found = readable_input(parser.fields, field.usage);
      if (first == nullptr) first = &found;
      if (found.report != first->report) {
        throw DriverError("the profile's packet " + at + " has usages " + hex(first->usage) + " and " +
                          hex(found.usage) + ", which are in the device's reports " +
                          std::to_string(first->report) + " and " + std::to_string(found.report) +
                          ": give each report a packet of its own");
      }
      field.offset = found.bit / 8;
      field.type = {found.is_signed ? decode::NumberKind::whole : decode::NumberKind::natural,
                    static_cast<std::uint8_t>(found.bits / 8), false};
      field.zero = found.zero_count;
      field.gain_pa *= found.newtons_a_count / profile.layout.area_m2();
    }
    if (first == nullptr) continue;
    rule.id = first->report;
    rule.length = report_length(descriptor, first->report);
    std::vector<Problem> problems;
    decode::find_misplaced(profile, rule, at, problems);
    if (problems.empty()) continue;
    throw DriverError(problems.front().in("the profile") + ". Report " + std::to_string(rule.id) + " has " +
                      std::to_string(rule.length) +
                      " bytes by the device's report descriptor: correct the profile's offsets");
  }
}

std::vector<std::uint8_t> descriptor_of(const std::filesystem::path& device) {
  const auto path =
      std::filesystem::path("/sys/class/hidraw") / device.filename() / "device/report_descriptor";
  std::ifstream in(path, std::ios::binary);
  std::vector<std::uint8_t> bytes(std::istreambuf_iterator<char>(in), {});
  if (bytes.empty())
    throw DriverError("HID device " + device.string() + ": " + path.string() +
                      " cannot be read, which says where its values stand");
  return bytes;
}

}  // namespace slipd::hid
