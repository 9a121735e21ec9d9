#include "lab/gels/report.hpp"

#include <cmath>
#include <cstdio>

namespace lab {
namespace {

constexpr double kSecondsPerHour = 3600;

bool slides(const GelLine& line) {
  return line.course == GelCourse::drags || line.course == GelCourse::rolls ||
         line.course == GelCourse::falls;
}

double per_hour(const GelLine& line) {
  return kSecondsPerHour * static_cast<double>(line.false_alerts) / line.held_s;
}

}  // namespace

void print_table(const std::vector<GelLine>& lines, const GelSetup& setup) {
  std::printf(
      "Gels in front of a camera of %g pictures a second, %g px of noise, %zu grasps a line. Soon: at most "
      "%g pictures after the slide began, or after the contact was lost.\n\n"
      "            grasps with     false alerts   told before   soon   soon after    told  after, ms: median "
      " "
      "95 %%\n"
      "           a false alert   an hour of hold   the slide           the loss\n",
      setup.rate_hz, setup.noise_px, setup.grasps, GelLine::kSoonPictures);
  for (const GelLine& line : lines) {
    std::printf("  %-9s   %6.1f %%           %6.1f", name_of(line.course), percent(line.alarmed, line.grasps),
                per_hour(line));
    if (slides(line))
      std::printf("        %6.1f %%  %6.1f %%    %6.1f %%  %6.1f %%             %6.0f %6.0f",
                  percent(line.before, line.grasps), percent(line.soon, line.grasps),
                  percent(line.soon_after_loss, line.grasps), percent(line.told, line.grasps),
                  1e3 * line.after_s.median(), 1e3 * line.after_s.quantile(0.95));
    std::printf("\n");
  }
}

offline::SweepResult to_sweep(const std::vector<GelLine>& lines, const GelSetup& setup) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const GelLine& line : lines)
    rows.push_back({{"course", name_of(line.course)},
                    {"grasps", line.grasps},
                    {"held_s", line.held_s},
                    {"false_alerts", line.false_alerts},
                    {"grasps_with_false_alert", line.alarmed},
                    {"told_before", line.before},
                    {"told_soon", line.soon},
                    {"told_soon_after_loss", line.soon_after_loss},
                    {"told", line.told},
                    {"after_s_median", line.after_s.median()},
                    {"after_s_p95", line.after_s.quantile(0.95)}});
  return result_of({{"rate_hz", setup.rate_hz}, {"noise_px", setup.noise_px}}, std::move(rows));
}

}  // namespace lab
