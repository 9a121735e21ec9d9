#include "tools/slipctl/plot.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "core/estimate/estimate.hpp"
#include "tools/slipctl/client.hpp"
#include "tools/slipctl/margin_plot.hpp"
#include "tools/slipctl/number_text.hpp"
#include "tools/slipctl/palette.hpp"
#include "tools/slipctl/taxel_map.hpp"
#include "tools/slipctl/terminal.hpp"

namespace slipctl {
namespace {

using slipd::FrameSummary;
using slipd::Recorded;
using json = nlohmann::ordered_json;

constexpr int kLabelColumns = 12;
constexpr int kRows = 27;

std::optional<double> known(double value) {
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::optional<double> gamma_of(const FrameSummary& frame) {
  return frame.estimate ? known(frame.estimate->gamma) : std::nullopt;
}

slipd::State state_of(const FrameSummary& frame) {
  constexpr auto kLast = slipd::State::fault;
  const std::uint8_t number = frame.estimate->state;
  return number <= static_cast<std::uint8_t>(kLast) ? static_cast<slipd::State>(number) : kLast;
}

std::optional<slipd::Sliding> sliding_of(const FrameSummary& frame) {
  constexpr auto kLast = static_cast<std::uint8_t>(slipd::Sliding::rotation);
  if (!frame.estimate || frame.estimate->sliding > kLast) return std::nullopt;
  return static_cast<slipd::Sliding>(frame.estimate->sliding);
}

std::optional<slipd::AlertCause> cause_of(const FrameSummary& frame) {
  constexpr auto kLast = static_cast<std::uint8_t>(slipd::AlertCause::sliding);
  if (!frame.estimate || frame.estimate->alert_cause == 0 || frame.estimate->alert_cause > kLast)
    return std::nullopt;
  return static_cast<slipd::AlertCause>(frame.estimate->alert_cause);
}

slipd::Alert alert_of(const FrameSummary& frame) {
  // Of a newer slipd, or of a frame without an estimate.
  if (!frame.estimate || frame.estimate->alert > static_cast<std::uint8_t>(slipd::Alert::unknown))
    return slipd::Alert::unknown;
  return static_cast<slipd::Alert>(frame.estimate->alert);
}

// The extreme of `value` (lowest, or with `highest` the highest) in each of `columns` equal parts of the
// time.
template <typename Value>
Columns in_columns(const Recorded& recorded, int columns, bool highest, Value value) {
  Columns result(static_cast<std::size_t>(columns));
  const double span = std::max(recorded.seconds(), 1e-9);
  for (const FrameSummary& frame : recorded.frames) {
    const std::optional<double> here = value(frame);
    if (!here) continue;
    const auto at =
        std::min(static_cast<std::size_t>(std::max(0.0, frame.time_s / span) * columns), result.size() - 1);
    auto& column = result[at];
    column = !column ? *here : highest ? std::max(*column, *here) : std::min(*column, *here);
  }
  return result;
}

void draw_margin(Canvas& canvas, const Box& box, const Recorded& recorded) {
  const bool has_margin = recorded.has_estimates();
  canvas.text(0, box.row, has_margin ? "margin" : "truth", kFaint, kLabelColumns - 2);
  canvas.text(kLabelColumns - 2, box.row, "1", kFaint);
  canvas.text(kLabelColumns - 2, box.row + box.rows - 1, "0", kFaint);
  const Columns lowest = in_columns(recorded, 2 * box.columns, false, [&](const FrameSummary& frame) {
    return has_margin ? gamma_of(frame) : known(frame.truth_gamma);
  });
  if (std::none_of(lowest.begin(), lowest.end(), [](const auto& column) { return column.has_value(); })) {
    canvas.text(box.column, box.row + box.rows / 2,
                has_margin ? "no margin was known" : "no estimates in it: the flight recorder keeps them",
                kFaint);
  }
  draw_line(canvas, box, lowest, [](std::optional<double> worst) { return margin_colour(worst); });
}

// One character a column: the highest alert, else whether there was a margin.
void draw_states(Canvas& canvas, const Box& box, const Recorded& recorded) {
  canvas.text(0, box.row, "alert", kFaint);
  const Columns alerts = in_columns(recorded, box.columns, true, [](const FrameSummary& frame) {
    const slipd::Alert alert = alert_of(frame);
    return frame.estimate ? std::optional(is_raised(alert) ? static_cast<double>(alert) : 0) : std::nullopt;
  });
  const Columns ok = in_columns(recorded, box.columns, true, [](const FrameSummary& frame) {
    return frame.estimate ? std::optional(state_of(frame) == slipd::State::ok ? 1.0 : 0.0) : std::nullopt;
  });
  for (int i = 0; i < box.columns; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (!alerts[at]) continue;
    if (*alerts[at] >= 2) {
      canvas.put(box.column + i, box.row, U'S', alert_style("slip"));
    } else if (*alerts[at] >= 1) {
      canvas.put(box.column + i, box.row, U'w', alert_style("warn"));
    } else {
      canvas.put(box.column + i, box.row, *ok[at] > 0 ? U'─' : U'·', kFaint);
    }
  }
}

// One character a column: what the object does at most, by the first letter of its name.
void draw_sliding(Canvas& canvas, const Box& box, const Recorded& recorded) {
  canvas.text(0, box.row, "slides", kFaint);
  const Columns most = in_columns(recorded, box.columns, true, [](const FrameSummary& frame) {
    const auto sliding = sliding_of(frame);
    return sliding ? std::optional(static_cast<double>(*sliding)) : std::nullopt;
  });
  for (int i = 0; i < box.columns; ++i) {
    const auto& column = most[static_cast<std::size_t>(i)];
    if (!column) continue;
    const auto sliding = static_cast<slipd::Sliding>(*column);
    if (sliding == slipd::Sliding::none) {
      canvas.put(box.column + i, box.row, U'─', kFaint);
    } else {
      canvas.put(box.column + i, box.row, static_cast<char32_t>(to_string(sliding).front()),
                 alert_style(slides(sliding) ? "slip" : "warn"));
    }
  }
}

template <typename Value>
void draw_force(Canvas& canvas, const Box& box, const Recorded& recorded, const char* name, Rgb colour,
                Value value) {
  Columns highest = in_columns(recorded, 2 * box.columns, true,
                               [&](const FrameSummary& frame) { return std::optional(value(frame)); });
  double peak = 0;
  for (const auto& column : highest) peak = std::max(peak, column.value_or(0));
  for (auto& column : highest) {
    if (column) *column = peak > 0 ? *column / peak : 0;
  }
  canvas.text(0, box.row, name, kFaint);
  canvas.text(0, box.row + 1, "≤ " + fixed(peak, 2, "N"), kFaint, kLabelColumns - 1);
  draw_line(canvas, box, highest, [colour](std::optional<double>) { return colour; });
}

TaxelFrame frame_of(const Recorded& recorded) {
  const auto& layout = recorded.header.layout;
  TaxelFrame frame;
  frame.normal_pa.assign(recorded.normal_pa.begin(), recorded.normal_pa.end());
  frame.shear_x_pa.assign(recorded.shear_x_pa.begin(), recorded.shear_x_pa.end());
  frame.shear_y_pa.assign(recorded.shear_y_pa.begin(), recorded.shear_y_pa.end());
  for (const double x : layout.x_m()) frame.x_mm.push_back(1e3 * x);
  for (const double y : layout.y_m()) frame.y_mm.push_back(1e3 * y);
  return frame;
}

std::vector<std::string> words_of(const FrameSummary& frame) {
  std::vector<std::string> words{"at " + fixed(frame.time_s, 3, "s")};
  if (frame.estimate) {
    const auto& estimate = *frame.estimate;
    words.push_back(std::string(to_string(state_of(frame))) + ", alert " +
                    std::string(to_string(alert_of(frame))));
    if (const auto sliding = sliding_of(frame))
      words.push_back("slides   " + std::string(to_string(*sliding)));
    words.push_back("margin   " + with_sigma(known(estimate.gamma), known(estimate.sigma)));
    words.push_back("friction " + fixed(known(estimate.friction), 2));
  }
  if (std::isfinite(frame.truth_gamma)) words.push_back("true     " + fixed(frame.truth_gamma, 2));
  words.push_back("normal   " + fixed(frame.normal_n, 2, "N"));
  words.push_back("shear    " + fixed(frame.shear_n, 2, "N"));
  return words;
}

void draw_moment(Canvas& canvas, const Box& box, const Recorded& recorded, ColourDepth depth) {
  const FrameSummary& summary = recorded.frames[recorded.shown];
  const TaxelFrame frame = frame_of(recorded);
  constexpr int kWordColumns = 26;
  const int limit = (box.columns - kWordColumns - 4) / 2;
  int at = 0;
  if (frame.x_mm.size() > 1 && limit >= 6 && box.rows >= 4) {
    const double peak = std::max(1.0, *std::max_element(frame.normal_pa.begin(), frame.normal_pa.end()));
    const auto [columns, rows] = map_size(frame, box.rows - 1, limit);
    canvas.text(0, box.row, "pressure ≤ " + fixed(peak / 1000, 1, "kPa"), kFaint, columns + 1);
    draw_pressure(canvas, {0, box.row + 1, columns, rows}, frame, peak, depth);
    at = columns + 2;
    canvas.text(at, box.row, "shear", kFaint, columns + 1);
    const auto friction = summary.estimate ? known(summary.estimate->friction) : std::nullopt;
    draw_shear(canvas, {at, box.row + 1, columns, rows}, frame, peak, friction, depth);
    at += columns + 2;
  }
  int row = box.row;
  for (const std::string& text : words_of(summary)) {
    if (row < box.row + box.rows) canvas.text(at, row++, text);
  }
}

std::string title_of(const Recorded& recorded, const std::string& file) {
  const auto& header = recorded.header;
  return std::filesystem::path(file).filename().string() + "  " + header.sensor + " · " +
         std::to_string(header.layout.size()) + (header.layout.size() == 1 ? " taxel · " : " taxels · ") +
         std::to_string(recorded.frames.size()) + " frames" + (header.simulated ? " · simulated" : "") +
         (header.zeroed ? "" : " · not zeroed");
}

void print_lines(const Recorded& recorded) {
  const auto number = [](double value) { return std::isfinite(value) ? json(value) : json(nullptr); };
  for (const FrameSummary& frame : recorded.frames) {
    json line{{"seq", frame.sequence},
              {"time_s", frame.time_s},
              {"normal_n", number(frame.normal_n)},
              {"shear_n", number(frame.shear_n)},
              {"truth_gamma", number(frame.truth_gamma)},
              {"estimate", nullptr}};
    if (frame.estimate) {
      const auto& estimate = *frame.estimate;
      line["estimate"] = {{"state", to_string(state_of(frame))},
                          {"alert", to_string(alert_of(frame))},
                          {"gamma", number(estimate.gamma)},
                          {"sigma", number(estimate.sigma)},
                          {"friction", number(estimate.friction)},
                          {"normal_n", number(estimate.normal_n)},
                          {"shear_n", number(estimate.shear_n)},
                          {"sliding", nullptr},
                          {"alert_cause", nullptr}};
      if (const auto sliding = sliding_of(frame)) line["estimate"]["sliding"] = to_string(*sliding);
      if (const auto cause = cause_of(frame)) line["estimate"]["alert_cause"] = to_string(*cause);
    }
    std::cout << line.dump() << '\n';
  }
}

Recorded read(const PlotOptions& options) {
  try {
    return slipd::read_recorded(options.file, options.at_s);
  } catch (const std::exception& error) {
    throw ClientError(error.what());
  }
}

}  // namespace

Canvas draw_recorded(const Recorded& recorded, const std::string& title, int columns, int rows,
                     ColourDepth depth) {
  Canvas canvas(columns, rows);
  constexpr Style kHeader{kWhite, Rgb{40, 60, 90}, true};
  for (int column = 0; column < columns; ++column) canvas.put(column, 0, U' ', kHeader);
  canvas.text(1, 0, title, kHeader, columns - 2);
  const int width = std::max(1, columns - kLabelColumns);
  draw_margin(canvas, {kLabelColumns, 1, width, 5}, recorded);
  draw_states(canvas, {kLabelColumns, 6, width, 1}, recorded);
  draw_sliding(canvas, {kLabelColumns, 7, width, 1}, recorded);
  draw_force(canvas, {kLabelColumns, 8, width, 3}, recorded, "normal", kCyan,
             [](const FrameSummary& frame) { return frame.normal_n; });
  draw_force(canvas, {kLabelColumns, 11, width, 3}, recorded, "shear", kViolet,
             [](const FrameSummary& frame) { return frame.shear_n; });
  const std::string end = fixed(recorded.seconds(), 2, "s");
  canvas.text(kLabelColumns, 14, "0", kFaint);
  canvas.text(std::max(kLabelColumns, columns - static_cast<int>(end.size())), 14, end, kFaint);
  const double span = std::max(recorded.seconds(), 1e-9);
  const int mark = static_cast<int>(recorded.frames[recorded.shown].time_s / span * (width - 1));
  canvas.put(kLabelColumns + std::clamp(mark, 0, width - 1), 15, U'▲', kFaint);
  draw_moment(canvas, {0, 16, columns, rows - 16}, recorded, depth);
  return canvas;
}

void plot(const PlotOptions& options) {
  const Recorded recorded = read(options);
  if (!recorded.fault.empty()) std::cerr << "slipctl: " << recorded.fault << "; the rest is shown\n";
  if (options.json) return print_lines(recorded);
  const bool on_terminal = ::isatty(STDOUT_FILENO) == 1;
  const int columns = options.columns > 0 ? options.columns : on_terminal ? terminal_columns() : 80;
  const ColourDepth depth = on_terminal ? colour_depth() : ColourDepth::none;
  const Canvas canvas = draw_recorded(recorded, title_of(recorded, options.file), columns, kRows, depth);
  for (int row = 0; row < canvas.rows(); ++row) {
    std::cout << (depth == ColourDepth::none ? canvas.row_text(row) : encode_row(canvas, row, depth)) << '\n';
  }
  if (options.picture.empty()) return;
  std::ofstream picture(options.picture);
  picture << to_svg(
      draw_recorded(recorded, title_of(recorded, options.file), columns, kRows, ColourDepth::rgb),
      "a recording of slipd");
  picture.close();
  if (!picture) throw ClientError("cannot write " + options.picture);
}

}  // namespace slipctl
