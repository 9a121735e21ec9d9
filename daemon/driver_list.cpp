#include "daemon/driver_list.hpp"

#include <nlohmann/json.hpp>
#include <ostream>

namespace slipd {
namespace {

using nlohmann::json;

void print_option(const std::string& key, const json& option, std::ostream& out) {
  out << "    " << key;
  const json type = option.value("type", json());
  if (type.is_string()) out << " (" << type.get<std::string>();
  if (type.is_array()) out << " (" << type.dump();
  if (option.contains("unit")) out << ", " << option["unit"].get<std::string>();
  if (option.contains("minimum") || option.contains("maximum")) {
    out << ", " << option.value("minimum", json("")).dump() << " to "
        << option.value("maximum", json("")).dump();
  }
  if (option.contains("default")) out << ", default " << option["default"].dump();
  out << (type.is_null() ? "" : ")");
  if (option.contains("description")) out << ": " << option["description"].get<std::string>();
  out << '\n';
}

}  // namespace

bool list_drivers(DriverModules& drivers, std::ostream& out) {
  bool all_well = true;
  const auto names = drivers.names();
  out << names.size() << " driver" << (names.size() == 1 ? "" : "s") << " in " << drivers.folder().string()
      << '\n';
  for (const std::string& name : names) {
    const DriverModule* module = drivers.find(name);
    if (module == nullptr) {
      all_well = false;
      out << "  " << name << ": cannot be used: " << drivers.why_not(name) << '\n';
      continue;
    }
    out << "  " << name << ": " << module->summary << '\n';
    const json schema = json::parse(module->options_schema, nullptr, false);
    const json options = schema.is_object() ? schema.value("properties", json::object()) : json::object();
    for (const auto& [key, option] : options.items()) print_option(key, option, out);
  }
  return all_well;
}

}  // namespace slipd
