#include "tools/offline/sweep.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <iostream>
#include <map>
#include <utility>

namespace offline {
namespace {

using nlohmann::ordered_json;

constexpr const char* kProcessor = "processor";  // the only key of a head that shards may differ in

// The options that the result depends on, as given.
ordered_json settings_of(const Common& common, const CLI::App& command) {
  constexpr std::array kOthers{"--shard", "--threads", "--help"};
  ordered_json settings{{"--seed", {std::to_string(common.seed)}}};
  for (const CLI::Option* option : command.get_options()) {
    const std::string name = option->get_name();
    if (std::find(kOthers.begin(), kOthers.end(), name) != kOthers.end()) continue;
    settings[name] = option->count() > 0 ? option->results() : std::vector{option->get_default_str()};
  }
  return settings;
}

// `key` of the part of this name. Throws WrongUse if it is none.
const ordered_json& key_of(const ordered_json& part, const char* key, const std::string& name) {
  if (!part.is_object() || !part.contains("sliplab_part") || !part.contains(key))
    throw WrongUse(name + " is no part of a sweep: make parts with --shard I/N");
  return part.at(key);
}

void require_same(const ordered_json& one, const ordered_json& other, const std::string& what,
                  const std::string& one_name, const std::string& other_name) {
  if (one != other)
    throw WrongUse(one_name + " and " + other_name + " are of different sweeps: " + what + " differs, " +
                   one.dump() + " and " + other.dump());
}

// Heads are equal but for the processors, which are listed.
void merge_heads(ordered_json& into, const ordered_json& from, const std::string& one,
                 const std::string& other) {
  if (!into.is_object()) return;
  for (auto& [key, value] : into.items()) {
    const ordered_json& theirs = from.at(key);
    if (key != kProcessor) {
      require_same(value, theirs, key, one, other);
    } else if (const std::string name = theirs; value.get<std::string>().find(name) == std::string::npos) {
      value = value.get<std::string>() + "; " + name;
    }
  }
}

void require_all(const std::map<std::size_t, std::string>& found, std::size_t of) {
  std::string missing;
  for (std::size_t i = 1; i <= of; ++i) {
    if (!found.contains(i))
      missing += (missing.empty() ? "" : ", ") + std::to_string(i) + "/" + std::to_string(of);
  }
  if (!missing.empty()) throw WrongUse("parts are missing: " + missing);
}

}  // namespace

Shard shard_of(std::string_view text) {
  const auto slash = text.find('/');
  const auto number = [&](std::string_view part) {
    std::size_t value = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    return error == std::errc{} && end == part.data() + part.size() ? value : 0;
  };
  const std::size_t one = slash == std::string_view::npos ? 0 : number(text.substr(0, slash));
  const std::size_t of = slash == std::string_view::npos ? 0 : number(text.substr(slash + 1));
  if (one < 1 || one > of)
    throw WrongUse("--shard " + std::string(text) + ": give I/N with 1 <= I <= N, such as 2/8");
  return {one - 1, of};
}

void SweepResult::add_row(std::size_t unit, ordered_json row) {
  if (units.empty() || units.back().unit != unit) units.push_back({unit, ordered_json::array()});
  units.back().value.push_back(std::move(row));
}

ordered_json assembled(const SweepResult& sweep) {
  ordered_json result = sweep.head, rows = ordered_json::array();
  bool keys = false;
  for (const UnitResult& unit : sweep.units) {
    if (unit.value.is_object()) {
      keys = true;
      result.update(unit.value);
    } else {
      rows.insert(rows.end(), unit.value.begin(), unit.value.end());
    }
  }
  if (result.is_null()) return rows;
  if (!keys) result["rows"] = std::move(rows);
  return result;
}

void add_shard_option(CLI::App& command, Shard& shard) {
  command.add_option_function<std::string>(
      "--shard", [&shard](const std::string& text) { shard = shard_of(text); },
      "I/N: measure only each N-th unit of the sweep, from the I-th on, and print a part for merge");
}

void refuse_files(const Shard& shard, const Common& common) {
  if (!shard.whole() && !common.out.empty())
    throw WrongUse("--out and --shard do not go together: a part has no tables or plots");
}

ordered_json part_of(const SweepResult& sweep, const Shard& shard, const Common& common,
                     const CLI::App& command) {
  ordered_json units = ordered_json::array();
  for (const UnitResult& unit : sweep.units) units.push_back({{"unit", unit.unit}, {"value", unit.value}});
  return {{"sliplab_part", SLIPD_VERSION},
          {"command", command.get_name()},
          {"settings", settings_of(common, command)},
          {"shard", {shard.index + 1, shard.of}},
          {"head", sweep.head},
          {"units", std::move(units)}};
}

void print_json(const SweepResult& sweep, const Shard& shard, const Common& common, const CLI::App& command) {
  std::cout << (shard.whole() ? assembled(sweep) : part_of(sweep, shard, common, command)).dump(2) << '\n';
}

ordered_json merged(const std::vector<ordered_json>& parts, const std::vector<std::string>& names) {
  if (parts.empty()) throw WrongUse("there are no parts to merge");
  SweepResult sweep;
  std::map<std::size_t, std::string> found;
  std::size_t of = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const std::string& name = names[i];
    for (const char* key : {"sliplab_part", "command", "settings"})
      require_same(key_of(parts.front(), key, names.front()), key_of(parts[i], key, name), key, names.front(),
                   name);
    const auto shard = key_of(parts[i], "shard", name).get<std::array<std::size_t, 2>>();
    if (i == 0) {
      of = shard[1];
      sweep.head = key_of(parts[i], "head", name);
    } else {
      require_same(of, shard[1], "the number of shards", names.front(), name);
      merge_heads(sweep.head, key_of(parts[i], "head", name), names.front(), name);
    }
    if (const auto [at, added] = found.emplace(shard[0], name); !added)
      throw WrongUse(at->second + " and " + name + " are the same part");
    for (const ordered_json& unit : key_of(parts[i], "units", name))
      sweep.units.push_back({unit.at("unit").get<std::size_t>(), unit.at("value")});
  }
  require_all(found, of);
  std::sort(sweep.units.begin(), sweep.units.end(),
            [](const UnitResult& one, const UnitResult& other) { return one.unit < other.unit; });
  return assembled(sweep);
}

}  // namespace offline
