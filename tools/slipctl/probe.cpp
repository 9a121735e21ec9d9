#include "tools/slipctl/probe.hpp"

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <ostream>
#include <sstream>

#include "drivers/decode/profile.hpp"
#include "tools/slipctl/table.hpp"

namespace slipctl {
namespace {

using json = nlohmann::ordered_json;
using slipd::decode::HidMatch;
using slipd::decode::Profile;
namespace fs = std::filesystem;

constexpr const char* kCanInterface = "280";  // ARPHRD_CAN

std::string line_of(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

std::vector<fs::path> entries(const fs::path& folder) {
  std::vector<fs::path> out;
  std::error_code absent;
  for (const auto& entry : fs::directory_iterator(folder, absent)) out.push_back(entry.path());
  std::ranges::sort(out);
  return out;
}

unsigned hex(const std::string& text) {
  try {
    return static_cast<unsigned>(std::stoul(text, nullptr, 16));
  } catch (const std::logic_error&) {
    return 0;
  }
}

std::string id_text(unsigned vendor, unsigned product) {
  std::ostringstream text;
  text << std::hex;
  text.fill('0');
  for (const auto& [number, after] : {std::pair{vendor, ":"}, {product, ""}}) {
    text.width(4);
    text << number << after;
  }
  return text.str();
}

class Prober {
 public:
  explicit Prober(fs::path sys) : sys_(std::move(sys)) {
    for (const std::string& name : slipd::decode::profile_names()) {
      try {
        profiles_.emplace(name, slipd::decode::find_profile(name));
      } catch (const slipd::DriverError&) {
        // slipd --check-config reports the fault once a configuration names this profile
      }
    }
  }

  json found() {
    usb();
    hid();
    can();
    serial_lines();
    std::ranges::stable_sort(
        found_, [](const json& a, const json& b) { return !a["profiles"].empty() && b["profiles"].empty(); });
    return found_;
  }

 private:
  template <class Fits>
  std::vector<std::string> names(const std::string& driver, Fits fits) const {
    std::vector<std::string> out;
    for (const auto& [name, profile] : profiles_)
      if (profile.driver == driver && fits(profile)) out.push_back(name);
    return out;
  }

  void add(const char* driver, const std::string& id, const std::string& name, const std::string& serial,
           const std::string& place, const std::vector<std::string>& profiles, const json& device) {
    found_.push_back({{"driver", driver},
                      {"id", id},
                      {"name", name},
                      {"serial", serial},
                      {"place", place},
                      {"profiles", profiles},
                      {"device", device}});
  }

  void usb() {
    for (const fs::path& device : entries(sys_ / "bus/usb/devices")) {
      const std::string vendor = line_of(device / "idVendor");
      const std::string kind = line_of(device / "bDeviceClass");
      if (vendor.empty() || kind == "09") continue;  // an interface, or a hub
      const unsigned v = hex(vendor), p = hex(line_of(device / "idProduct"));
      const std::string serial = line_of(device / "serial"), port = device.filename();
      const auto fits = [&](const Profile& profile) {
        return std::ranges::any_of(profile.usb->devices,
                                   [&](const HidMatch& m) { return m.vendor == v && m.product == p; });
      };
      add("usb", id_text(v, p), line_of(device / "product"), serial, port, names("usb", fits),
          serial.empty() ? json{{"port", port}} : json{{"serial", serial}});
    }
  }

  void hid() {
    for (const fs::path& node : entries(sys_ / "class/hidraw")) {
      std::map<std::string, std::string> facts;
      std::ifstream in(node / "device/uevent");
      for (std::string line; std::getline(in, line);) {
        const std::size_t equals = line.find('=');
        if (equals != std::string::npos) facts[line.substr(0, equals)] = line.substr(equals + 1);
      }
      const std::string id = facts["HID_ID"];  // 0003:0000256F:0000C635
      const std::size_t first = id.find(':'), second = id.rfind(':');
      if (first == std::string::npos || second == first) continue;
      const unsigned v = hex(id.substr(first + 1, second - first - 1)), p = hex(id.substr(second + 1));
      const auto fits = [&](const Profile& profile) {
        return profile.hid->vendor == v && (profile.hid->product == 0 || profile.hid->product == p);
      };
      const std::string serial = facts["HID_UNIQ"], path = "/dev/" + node.filename().string();
      add("hid", id_text(v, p), facts["HID_NAME"], serial, path, names("hid", fits),
          serial.empty() ? json{{"path", path}} : json{{"serial", serial}});
    }
  }

  void can() {
    for (const fs::path& interface : entries(sys_ / "class/net")) {
      if (line_of(interface / "type") != kCanInterface) continue;
      const std::string name = interface.filename();
      add("can", "", "CAN interface, " + line_of(interface / "operstate"), "", name,
          names("can", [](const Profile&) { return true; }), {{"interface", name}});
    }
  }

  void serial_lines() {
    const auto any = [](const Profile&) { return true; };
    const auto streams = names("serial", any), rtu = names("modbus", any);
    for (const fs::path& line : entries(sys_ / "class/tty")) {
      const std::string name = line.filename();
      if (!name.starts_with("ttyUSB") && !name.starts_with("ttyACM")) continue;
      add("serial", "", "serial line", "", "/dev/" + name, streams, {{"path", "/dev/" + name}});
      add("modbus", "", "serial line", "", "/dev/" + name, rtu, {{"serial_line", "/dev/" + name}});
    }
  }

  fs::path sys_;
  std::map<std::string, Profile> profiles_;
  std::vector<json> found_;
};

}  // namespace

json probe(const fs::path& sys) {
  return Prober(sys).found();
}

void print_probe(bool as_json, std::ostream& out) {
  json found = probe();
  if (as_json) {
    out << json{{"found", found}}.dump() << '\n';
    return;
  }
  if (found.empty()) {
    out << "nothing that may carry a sensor; Modbus TCP cannot be probed\n";
    return;
  }
  for (json& one : found) {
    std::string names;
    for (const json& name : one["profiles"]) names += (names.empty() ? "" : ", ") + name.get<std::string>();
    one["profiles"] = names.empty() ? "none" : names;
    one["device"] = one["device"].dump();
  }
  out << table_of(found, {"driver", "profiles", "device", "place", "id", "name"});
}

}  // namespace slipctl
