#include "lab/faults/report.hpp"

#include <cstdio>
#include <string>

namespace lab {
namespace {

// What most grasps say of the fault: a health, or that there is no margin.
std::string reported_as(const FaultLine& line) {
  if (line.named > 0) return "`" + std::string(slipd::to_string(line.as)) + "`";
  return line.reported > 0 ? "no margin" : "–";
}

// What stands before the number of taxels.
std::string kind_of(const FaultLine& line) {
  return line.preset == slipd::sim::Preset::ideal ? "" : std::string(to_string(line.preset)) + " ";
}

std::string frames(long count) {
  return count < 0 ? "–" : std::to_string(count);
}

}  // namespace

void print_table(const std::vector<FaultLine>& lines, const FaultSetup& setup) {
  std::printf("%zu random grasps a line; of ideal sensors frames %g ms apart and noise %g.\n\n", setup.grasps,
              1e3 * setup.sensing.frame_s, setup.sensing.noise);
  std::printf(
      "| fault | taxels | method | most often | reported, %% | of these named, %% | without effect, %% | "
      "frames "
      "until reported: middle, last | in state ok | "
      "overestimates by the fault | overestimates without it "
      "|\n|---|---|---|---|---:|---:|---:|---:|---:|---:|---:|\n");
  for (const FaultLine& line : lines) {
    std::printf(
        "| `%s` | %s%zu x %zu | %s | %s | %.1f | %.1f | %.1f | %s, %s | %llu | %llu | %llu of %llu |\n",
        std::string(name_of(line.fault)).c_str(), kind_of(line).c_str(), line.columns, line.columns,
        line.method.c_str(), reported_as(line).c_str(), percent(line.reported, line.grasps),
        percent(line.named, line.grasps), percent(line.without_effect, line.grasps),
        frames(line.median_frames).c_str(), frames(line.last_frames).c_str(),
        static_cast<unsigned long long>(line.answered), static_cast<unsigned long long>(line.too_safe),
        static_cast<unsigned long long>(line.sound_too_safe),
        static_cast<unsigned long long>(line.sound_answered));
  }
  std::printf("\nFrames of the healthy sensor with another health than good:\n");
  const FaultLine* last = nullptr;
  for (const FaultLine& line : lines) {  // each sensor and method once: all faults share the sound frames
    if (last != nullptr && line.preset == last->preset && line.columns == last->columns &&
        line.method == last->method)
      continue;
    last = &line;
    std::printf("%s%zu x %zu %s: %llu of %llu", kind_of(line).c_str(), line.columns, line.columns,
                line.method.c_str(), static_cast<unsigned long long>(line.false_alarms),
                static_cast<unsigned long long>(line.sound_frames));
    if (line.false_alarms > 0)
      std::printf(", in %zu of %zu grasps, most often %s", line.grasps_with_false_alarms, line.grasps,
                  std::string(slipd::to_string(line.false_as)).c_str());
    std::printf("\n");
  }
}

offline::SweepResult to_sweep(const std::vector<FaultLine>& lines, const FaultSetup& setup) {
  auto rows = nlohmann::ordered_json::array();
  for (const FaultLine& line : lines) {
    rows.push_back({{"fault", name_of(line.fault)},
                    {"preset", to_string(line.preset)},
                    {"columns", line.columns},
                    {"method", line.method},
                    {"grasps", line.grasps},
                    {"reported", line.reported},
                    {"named", line.named},
                    {"as", slipd::to_string(line.as)},
                    {"without_effect", line.without_effect},
                    {"median_frames", line.median_frames},
                    {"last_frames", line.last_frames},
                    {"answered", line.answered},
                    {"too_safe", line.too_safe},
                    {"sound_answered", line.sound_answered},
                    {"sound_too_safe", line.sound_too_safe},
                    {"false_alarms", line.false_alarms},
                    {"grasps_with_false_alarms", line.grasps_with_false_alarms},
                    {"false_as", slipd::to_string(line.false_as)},
                    {"sound_frames", line.sound_frames}});
  }
  return result_of({{"grasps", setup.grasps}, {"seed", setup.seed}}, {{"lines", std::move(rows)}});
}

}  // namespace lab
