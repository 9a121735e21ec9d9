#include "daemon/driver_list.hpp"

#include <nlohmann/json.hpp>
#include <ostream>

namespace slipd {
namespace {

using nlohmann::json;

// "number, kPa, 0 to 10, default 1": as much of it as the schema says.
std::string form_of(const json& option) {
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  const auto plain = [](const json& value) {
    return value.is_string() ? value.get<std::string>() : value.dump();
  };
  if (option.contains("type")) add(plain(option["type"]));
  if (option.contains("enum")) {
    std::string choices;
    for (const json& choice : option["enum"]) choices += (choices.empty() ? "" : " | ") + plain(choice);
    add(choices);
  }
  if (option.contains("unit")) add(plain(option["unit"]));
  const bool from = option.contains("minimum");
  const bool to = option.contains("maximum");
  if (from && to) add(plain(option["minimum"]) + " to " + plain(option["maximum"]));
  if (from && !to) add("at least " + plain(option["minimum"]));
  if (to && !from) add("at most " + plain(option["maximum"]));
  if (option.contains("default")) add("default " + option["default"].dump());
  return text;
}

void print_option(const std::string& key, const json& option, std::ostream& out) {
  const std::string form = form_of(option);
  out << "    " << key << (form.empty() ? "" : " (" + form + ")");
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
