// Sweeps that several processes or computers measure. A sweep consists of units that do not depend on each
// other, such as a layout with a noise. A shard measures some of them and prints a part; the parts of all
// shards merge to what one run prints.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "tools/offline/command.hpp"

namespace CLI {
class App;
}

namespace offline {

// Each `of`-th unit, from unit `index` on; 0 <= index < of.
struct Shard {
  std::size_t index = 0, of = 1;
  bool has(std::size_t unit) const noexcept { return unit % of == index; }
  bool whole() const noexcept { return of == 1; }
};

// From "I/N", 1 <= I <= N. Throws WrongUse.
Shard shard_of(std::string_view text);

// What a unit adds to the result: rows, as an array, or keys of the result, as an object.
struct UnitResult {
  std::size_t unit = 0;  // its number in the sweep, from 0
  nlohmann::ordered_json value;
};

struct SweepResult {
  // The result but for what the units add. null: the result is the array of the rows.
  nlohmann::ordered_json head;
  std::vector<UnitResult> units;  // by their numbers

  // Appends a row to the rows of the unit.
  void add_row(std::size_t unit, nlohmann::ordered_json row);
};

// What one run prints with --json: rows are the array `rows` of the head.
nlohmann::ordered_json assembled(const SweepResult& sweep);

// Adds --shard to a command.
void add_shard_option(CLI::App& command, Shard& shard);

// A shard has no tables or plots of its own: throws WrongUse if it is to write files.
void refuse_files(const Shard& shard, const Common& common);

// What a shard prints, of the command as it was called.
nlohmann::ordered_json part_of(const SweepResult& sweep, const Shard& shard, const Common& common,
                               const CLI::App& command);

// Prints what a run with --json prints, or the part of a shard.
void print_json(const SweepResult& sweep, const Shard& shard, const Common& common, const CLI::App& command);

// The result of one run from the parts of all its shards, in any order. Throws WrongUse where they are not of
// one sweep, or not all of it; `names` are those of the parts, for the message.
nlohmann::ordered_json merged(const std::vector<nlohmann::ordered_json>& parts,
                              const std::vector<std::string>& names);

}  // namespace offline
