#include "tools/slipctl/view.hpp"

#include <algorithm>
#include <utility>

#include "tools/slipctl/margin_plot.hpp"
#include "tools/slipctl/number_text.hpp"
#include "tools/slipctl/palette.hpp"
#include "tools/slipctl/taxel_map.hpp"

namespace slipctl {
namespace {

constexpr Style kPlain{};
constexpr Style kStrong{std::nullopt, std::nullopt, true};
constexpr Style kSimulated{kViolet, std::nullopt, true};

const EstimateValues& estimate_of(const SensorWatch& sensor) {
  static const EstimateValues nothing_yet;
  return sensor.latest ? *sensor.latest : nothing_yet;
}

// Right-aligned text that ends before column `end`; returns its first column.
int text_up_to(Canvas& canvas, int end, int row, const std::string& text, const Style& style) {
  const int begin = end - static_cast<int>(characters(text));
  canvas.text(begin, row, text, style);
  return begin;
}

std::string pace(const SensorWatch& sensor) {
  return rate(sensor.counts ? sensor.counts->rate_hz : std::nullopt) + "  " +
         fixed(estimate_of(sensor).latency_us, 1, "µs");
}

// An alert that does not come from the margin says so.
std::string alert_text(const EstimateValues& estimate) {
  return estimate.alert_cause == "sliding" ? estimate.alert + ": slides" : estimate.alert;
}

std::string sliding_text(const EstimateValues& estimate) {
  if (estimate.sliding.empty()) return "–";
  if (!estimate.sliding_for_ms) return estimate.sliding;
  return estimate.sliding + " " + fixed(*estimate.sliding_for_ms / 1000, 1, "s");
}

void draw_title(Canvas& canvas, const Box& box, const SensorWatch& sensor) {
  const EstimateValues& estimate = estimate_of(sensor);
  int right = text_up_to(canvas, box.columns, box.row, " " + alert_text(estimate) + " ",
                         alert_style(estimate.alert)) -
              1;
  right = text_up_to(canvas, right, box.row, pace(sensor), kPlain) - 1;
  int at = canvas.text(0, box.row, sensor.info.name, kStrong, right) + 2;
  if (sensor.info.simulated)
    at = canvas.text(at, box.row, "simulated", kSimulated, std::max(0, right - at)) + 2;
  const std::string what = sensor.info.driver + " · " + std::to_string(sensor.info.taxels) + " taxels · " +
                           (estimate.method.empty() ? sensor.info.method : estimate.method);
  canvas.text(at, box.row, what, kFaint, std::max(0, right - at));
}

void draw_margin(Canvas& canvas, const Box& box, const SensorWatch& sensor) {
  const EstimateValues& estimate = estimate_of(sensor);
  constexpr int kStateColumns = 14;
  std::string numbers = "  " + with_sigma(estimate.gamma, estimate.sigma);
  if (sensor.info.simulated) numbers += "  true " + fixed(estimate.true_gamma, 2);
  numbers += "  class " + (estimate.slip_class ? std::to_string(*estimate.slip_class) : "–");
  // A fixed width, so that numbers keep their place while others appear and disappear.
  const int numbers_columns = sensor.info.simulated ? 33 : 22;
  const int bar_columns = std::max(0, box.columns - kStateColumns - numbers_columns);
  canvas.text(0, box.row, estimate.state, {estimate.state == "ok" ? kGreen : kYellow, std::nullopt, true},
              kStateColumns);
  draw_bar(canvas, {kStateColumns, box.row, bar_columns, 1}, estimate.gamma, estimate.true_gamma);
  canvas.text(kStateColumns + bar_columns, box.row, numbers, kPlain);
}

void draw_last_seconds(Canvas& canvas, const Box& box, const SensorWatch& sensor, double now_s) {
  canvas.text(0, box.row, "1", kFaint);
  if (box.rows > 1) canvas.text(0, box.row + box.rows - 1, "0", kFaint);
  draw_history(canvas, {2, box.row, box.columns - 2, box.rows}, sensor.history, now_s);
}

// The time of the last seconds' line.
void draw_time_axis(Canvas& canvas, const Box& box) {
  canvas.text(2, box.row, "-" + fixed(kHistorySeconds, 0, "s"), kFaint);
  const std::string half = "-" + fixed(kHistorySeconds / 2, 0, "s");
  canvas.text(2 + (box.columns - 2 - static_cast<int>(half.size())) / 2, box.row, half, kFaint);
  text_up_to(canvas, box.columns, box.row, "now", kFaint);
}

using Figure = std::pair<const char*, std::string>;

std::vector<Figure> figures_of(const SensorWatch& sensor) {
  const EstimateValues& r = estimate_of(sensor);
  std::vector<Figure> figures{
      {"normal", fixed(r.normal_n, 2, "N")},
      {"shear", fixed(r.shear_n, 2, "N")},
      {"torque", r.torque_nmm ? signed_fixed(*r.torque_nmm, 2) + " Nmm" : "–"},
      {"friction", with_sigma(r.friction, r.friction_sigma)},
      {"slides", sliding_text(r)},
      {"centre", r.center_x_mm ? fixed(r.center_x_mm, 1) + ", " + fixed(r.center_y_mm, 1, "mm") : "–"},
      {"radius", fixed(r.radius_mm, 2, "mm")},
      {"a/R", fixed(r.a_over_r, 2)},
      {"slips in", fixed(r.time_to_slip_ms, 0, "ms")},
      {"grip by", r.grip_increase_n ? signed_fixed(*r.grip_increase_n, 2) + " N" : "–"},
      {"age", fixed(r.age_ms, 1, "ms")}};
  if (sensor.info.simulated) figures.insert(figures.begin() + 4, {" true", fixed(r.true_friction, 2)});
  if (!sensor.counts) return figures;
  const SensorCounts& counts = *sensor.counts;
  figures.emplace_back("skipped", std::to_string(counts.skipped));
  figures.emplace_back("gaps", std::to_string(counts.gaps));
  figures.emplace_back("p99", fixed(counts.latency_p99_us, 0, "µs"));
  return figures;
}

// Top down, then in a next column where there is room.
void draw_figures(Canvas& canvas, const Box& box, const std::vector<Figure>& figures) {
  constexpr int kFigureColumns = 24;
  constexpr int kNameColumns = 10;
  int row = 0;
  int column = 0;
  for (const auto& [label, value] : figures) {
    if (column > 0 && column + kFigureColumns > box.columns) return;
    canvas.text(box.column + column, box.row + row, label, kFaint, std::max(0, box.columns - column));
    canvas.text(box.column + column + kNameColumns, box.row + row, value, kPlain,
                std::max(0, std::min(kFigureColumns - kNameColumns, box.columns - column - kNameColumns)));
    if (++row < box.rows) continue;
    row = 0;
    column += kFigureColumns;
  }
}

// The box's first row holds captions, the rows below maps and numbers.
void draw_maps(Canvas& canvas, const Box& box, const SensorWatch& sensor, ColourDepth depth) {
  constexpr int kGap = 2;
  constexpr int kFigureColumns = 25;
  const Box inner{0, box.row + 1, box.columns, box.rows - 1};
  const int limit = (box.columns - kFigureColumns - 2 * kGap) / 2;
  int at = 0;
  if (!sensor.frame.normal_pa.empty() && limit >= 6) {
    const auto [columns, rows] = map_size(sensor.frame, inner.rows, limit);
    const EstimateValues& estimate = estimate_of(sensor);
    const auto friction = estimate.friction ? estimate.friction : estimate.true_friction;
    canvas.text(0, box.row, "pressure ≤ " + fixed(sensor.peak_pa / 1000, 1, "kPa"), kFaint,
                columns + kGap - 1);
    draw_pressure(canvas, {0, inner.row, columns, rows}, sensor.frame, sensor.peak_pa, depth);
    at = columns + kGap;
    canvas.text(at, box.row, friction ? "shear / µ pressure" : "shear / pressure", kFaint,
                columns + kGap - 1);
    draw_shear(canvas, {at, inner.row, columns, rows}, sensor.frame, sensor.peak_pa, friction, depth);
    at += columns + kGap;
  }
  draw_figures(canvas, {at, inner.row, box.columns - at, inner.rows}, figures_of(sensor));
}

void draw_sensor(Canvas& canvas, const Box& box, const SensorWatch& sensor, double now_s, ColourDepth depth) {
  draw_title(canvas, box, sensor);
  if (box.rows < 2) return;
  draw_margin(canvas, {0, box.row + 1, box.columns, 1}, sensor);
  constexpr int kSmallestMaps = 4;  // rows; with fewer, the maps are left out
  const int rest = box.rows - 2;
  const bool maps = rest >= kSmallestMaps + 2;
  const int course_rows = !maps ? rest : rest >= 18 ? 4 : rest >= 12 ? 3 : rest >= 9 ? 2 : 1;
  if (course_rows > 0) draw_last_seconds(canvas, {0, box.row + 2, box.columns, course_rows}, sensor, now_s);
  const int axis_rows = course_rows >= 3 ? 1 : 0;
  if (axis_rows > 0) draw_time_axis(canvas, {0, box.row + 2 + course_rows, box.columns, axis_rows});
  const int above = course_rows + axis_rows;
  if (maps) draw_maps(canvas, {0, box.row + 2 + above, box.columns, rest - above}, sensor, depth);
}

// One row: name, state, bar, number, alert.
void draw_grasp(Canvas& canvas, int row, const EstimateValues& grasp) {
  constexpr int kNameColumns = 14;
  constexpr int kNumberColumns = 26;
  canvas.text(0, row, grasp.name, kStrong, kNameColumns - 1);
  const int bar_columns = std::max(0, canvas.columns() - kNameColumns - kNumberColumns);
  draw_bar(canvas, {kNameColumns, row, bar_columns, 1}, grasp.gamma, std::nullopt);
  canvas.text(kNameColumns + bar_columns + 2, row, grasp.gamma ? fixed(grasp.gamma, 2) : grasp.state, kPlain,
              16);
  text_up_to(canvas, canvas.columns(), row, " " + alert_text(grasp) + " ", alert_style(grasp.alert));
}

// One row: what slipd-grip does, why, and with what force.
void draw_grip(Canvas& canvas, int row, const GripWatch& grip) {
  constexpr int kNameColumns = 14;
  canvas.text(0, row, "slipd-grip", kStrong, kNameColumns - 1);
  std::string text = grip.state;
  if (grip.force_n) text += "  " + fixed(grip.force_n, 1, "N a finger");
  if (grip.width_mm) text += "  " + fixed(grip.width_mm, 1, "mm wide");
  const bool well = grip.trouble.empty();
  if (well && !grip.why.empty()) text += "  (" + grip.why + ")";
  if (!well) text += "  gripper: " + grip.trouble;
  canvas.text(kNameColumns, row, text, well ? kPlain : Style{kYellow, std::nullopt, true},
              canvas.columns() - kNameColumns);
}

}  // namespace

Canvas draw_watch(const WatchState& state, int columns, int rows, ColourDepth depth) {
  Canvas canvas(columns, rows);
  constexpr Style kHeader{kWhite, Rgb{40, 60, 90}, true};
  for (int column = 0; column < canvas.columns(); ++column) canvas.put(column, 0, U' ', kHeader);
  const std::string right = fixed(state.elapsed_s, 1, "s") + "  q quits ";
  const int end = text_up_to(canvas, canvas.columns(), 0, right, kHeader);
  canvas.text(1, 0, (state.connected ? "slipd  " : "slipd is gone, waiting for it  ") + state.socket, kHeader,
              std::max(0, end - 2));

  const int sensors = static_cast<int>(state.sensors.size());
  if (sensors == 0) canvas.text(1, 2, "the daemon has no sensors");
  // A sensor needs two rows; the last row counts the sensors without room.
  const int spare = std::max(0, canvas.rows() - 1 - 2 * sensors);
  const int grip = state.grip && spare > 0 ? 1 : 0;
  const int grasps = std::min(static_cast<int>(state.grasps.size()), spare - grip);
  const int space = canvas.rows() - 1 - grasps - grip;
  if (grip > 0) draw_grip(canvas, canvas.rows() - 1, *state.grip);
  for (int i = 0; i < grasps; ++i)
    draw_grasp(canvas, 1 + space + i, state.grasps[static_cast<std::size_t>(i)]);
  const int shown = 2 * sensors <= space ? sensors : std::max(0, (space - 1) / 2);
  const int left_out = sensors - shown;
  const int share = shown > 0 ? (space - (left_out > 0 ? 1 : 0)) / shown : 0;
  for (int i = 0; i < shown; ++i) {
    const int gap = shown > 1 && share > 4 ? 1 : 0;
    draw_sensor(canvas, {0, 1 + i * share, canvas.columns(), share - gap},
                state.sensors[static_cast<std::size_t>(i)], state.elapsed_s, depth);
  }
  if (left_out > 0)
    canvas.text(0, space, "and " + std::to_string(left_out) + " more: make the window higher", kFaint);
  return canvas;
}

std::string plain_line(const SensorWatch& sensor, double elapsed_s) {
  const EstimateValues& estimate = estimate_of(sensor);
  std::string line = fixed(elapsed_s, 2, "s") + "  " + sensor.info.name + "  " + estimate.state +
                     "  margin " + with_sigma(estimate.gamma, estimate.sigma);
  if (estimate.true_gamma) line += "  true " + fixed(estimate.true_gamma, 2);
  if (estimate.slip_class) line += "  class " + std::to_string(*estimate.slip_class);
  line += "  normal " + fixed(estimate.normal_n, 2, "N") + "  shear " + fixed(estimate.shear_n, 2, "N") +
          "  torque " + fixed(estimate.torque_nmm, 2, "Nmm") + "  friction " +
          with_sigma(estimate.friction, estimate.friction_sigma) + "  slides " + sliding_text(estimate) +
          "  alert " + alert_text(estimate) + "  " + pace(sensor);
  return line + (estimate.simulated || sensor.info.simulated ? "  simulated" : "");
}

}  // namespace slipctl
