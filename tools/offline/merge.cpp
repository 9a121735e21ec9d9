// The command merge: the parts of a sweep, made with --shard, joined to the result of one run.
#include <CLI/CLI.hpp>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "tools/offline/command.hpp"
#include "tools/offline/sweep.hpp"

namespace offline {
namespace {

void run_merge(const std::vector<std::string>& files) {
  std::vector<nlohmann::ordered_json> parts;
  for (const std::string& file : files) {
    std::ifstream in(file);
    auto part = nlohmann::ordered_json::parse(in, nullptr, false);
    if (part.is_discarded())
      throw WrongUse(file + " is not JSON, or not all of it: was the shard cut short? Measure it again");
    parts.push_back(std::move(part));
  }
  std::cout << merged(parts, files).dump(2) << '\n';
}

}  // namespace

void add_merge(CLI::App& app) {
  auto* command = app.add_subcommand("merge", "join the parts that shards of a sweep have printed");
  auto files = std::make_shared<std::vector<std::string>>();
  command->add_option("parts", *files, "what each shard printed")->required()->check(CLI::ExistingFile);
  command->callback([files] { run_merge(*files); });
}

}  // namespace offline
