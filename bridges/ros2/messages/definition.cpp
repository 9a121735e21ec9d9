#include "bridges/ros2/messages/definition.hpp"

#include <algorithm>

namespace slipd::ros2 {
namespace {

constexpr std::string_view kMiddle = "/msg/";

std::string with_middle(std::string_view name, std::string_view middle) {
  const std::size_t at = name.find(kMiddle);
  return std::string(name.substr(0, at)) + std::string(middle) +
         std::string(name.substr(at + kMiddle.size()));
}

// As Python's json.dumps writes it with the separators ", " and ": ".
std::string individual_description(const Definition& definition) {
  std::string fields;
  for (const Field& field : definition.fields) {
    fields += std::string(fields.empty() ? "" : ", ") + R"({"name": ")" + field.name +
              R"(", "type": {"type_id": )" + std::to_string(field.type_id) + R"(, "capacity": )" +
              std::to_string(field.capacity) + R"(, "string_capacity": )" +
              std::to_string(field.string_capacity) + R"(, "nested_type_name": ")" + field.nested + R"("}})";
  }
  return R"({"type_name": ")" + definition.name + R"(", "fields": [)" + fields + "]}";
}

}  // namespace

std::string short_name(std::string_view name) {
  return with_middle(name, "/");
}

std::string dds_name(std::string_view name) {
  return with_middle(name, "::msg::dds_::") + "_";
}

std::string msg_text(const Definition& definition) {
  std::string text = definition.constants;
  for (const Field& field : definition.fields) text += field.type_text + " " + field.name + "\n";
  return text;
}

std::string msg_text(const std::vector<Definition>& definitions) {
  constexpr std::size_t kRuleColumns = 80;
  std::string text;
  for (const Definition& definition : definitions) {
    if (!text.empty())
      text.append(kRuleColumns, '=').append("\nMSG: ").append(short_name(definition.name)).append("\n");
    text += msg_text(definition);
  }
  return text;
}

std::string type_description(const std::vector<Definition>& definitions) {
  std::vector<Definition> referenced(definitions.begin() + 1, definitions.end());
  std::sort(referenced.begin(), referenced.end(),
            [](const Definition& a, const Definition& b) { return a.name < b.name; });
  std::string others;
  for (const Definition& definition : referenced)
    others += (others.empty() ? "" : ", ") + individual_description(definition);
  return R"({"type_description": )" + individual_description(definitions.front()) +
         R"(, "referenced_type_descriptions": [)" + others + "]}";
}

}  // namespace slipd::ros2
