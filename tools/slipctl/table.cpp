#include "tools/slipctl/table.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tools/slipctl/number_text.hpp"

namespace slipctl {
namespace {

using json = nlohmann::ordered_json;

bool numeric(const std::string& text) {
  return text == "–" || (!text.empty() && text.find_first_not_of("0123456789.+-") == std::string::npos);
}

// At most four decimals, without trailing zeros.
std::string short_number(double value) {
  std::string text = fixed(value, 4);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

std::string cell(const json& value) {
  if (value.is_null()) return "–";
  if (value.is_string()) return value.get<std::string>();
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_number_float()) return short_number(value.get<double>());
  if (!value.is_array() && !value.is_object()) return value.dump();
  std::string text;
  for (const auto& [key, item] : value.items())
    text += (text.empty()       ? ""
             : value.is_array() ? ", "
                                : "  ") +
            (value.is_array() ? "" : key + " ") + cell(item);
  return text.empty() ? "–" : text;
}

bool list_of_objects(const json& value) {
  return value.is_array() && !value.empty() &&
         std::all_of(value.begin(), value.end(), [](const json& each) { return each.is_object(); });
}

std::string indented(const std::string& text, int indent) {
  std::string all;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    all += std::string(static_cast<std::size_t>(indent), ' ') + text.substr(begin, end - begin) + "\n";
    begin = end + 1;
  }
  return all;
}

}  // namespace

std::string table(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows)
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (i == widths.size()) widths.push_back(0);
      widths[i] = std::max(widths[i], characters(row[i]));
    }
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string blanks(widths[i] - characters(row[i]), ' ');
      line += (i == 0 ? "" : "  ") + (numeric(row[i]) ? blanks + row[i] : row[i] + blanks);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::string table_of(const json& objects, const std::vector<const char*>& keys) {
  std::vector<std::vector<std::string>> rows{{keys.begin(), keys.end()}};
  for (const json& object : objects) {
    std::vector<std::string> row;
    row.reserve(keys.size());
    for (const char* key : keys) row.push_back(object.contains(key) ? cell(object[key]) : "–");
    rows.push_back(std::move(row));
  }
  return table(rows);
}

std::string tree(const json& value, int indent) {
  if (!value.is_object()) return indented(cell(value) + "\n", indent);
  std::vector<std::vector<std::string>> plain;
  std::string nested;
  for (const auto& [key, item] : value.items()) {
    if (list_of_objects(item)) {
      std::string text;
      for (const json& each : item) {
        const std::string name = each.value("name", "");
        json rest = each;
        rest.erase("name");
        text += (name.empty() ? "-" : name) + "\n" + tree(rest, 2);
      }
      nested += key + "\n" + indented(text, 2);
    } else if (item.is_object() && !item.empty()) {
      nested += key + "\n" + tree(item, 2);
    } else {
      plain.push_back({key, cell(item)});
    }
  }
  for (auto& row : plain) row[0] += " ";
  // Names and values: the values stay to the left, under one another.
  std::string text;
  std::size_t widest = 0;
  for (const auto& row : plain) widest = std::max(widest, characters(row[0]));
  for (const auto& row : plain)
    text += row[0] + std::string(widest - characters(row[0]) + 1, ' ') + row[1] + "\n";
  return indented(text + nested, indent);
}

}  // namespace slipctl
