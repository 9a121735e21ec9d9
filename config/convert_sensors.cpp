// Converts the list of sensors.
#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "config/convert.hpp"
#include "core/frame/significance.hpp"

namespace slipd {
namespace {

using nlohmann::json;

constexpr double kPascalPerKilopascal = 1e3;

class SensorConverter {
 public:
  SensorConverter(const json& written, std::vector<Problem>& problems)
      : written_(written), found_(problems), problems_(problems) {}

  std::vector<SensorSettings> sensors(const json& list) {
    std::vector<SensorSettings> converted;
    std::vector<std::size_t> well_formed;
    check_names_differ(list, "/sensors", problems_);
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::string at = pointer_to("/sensors", i);
      if (has_problem_at(found_, at)) continue;
      converted.push_back(sensor(list[i], at));
      if (list[i].contains("skin")) converted.back().skin_keys = keys_of(written_[i]["skin"]);
      distinguishable(list, well_formed, i);
      well_formed.push_back(i);
    }
    return converted;
  }

 private:
  void add(const std::string& pointer, const json& value, const std::string& what) {
    problems_.push_back(problem_of(pointer, value, what));
  }

  // Two sensors may share a device (a board with two pads) if an option distinguishes them.
  void distinguishable(const json& list, const std::vector<std::size_t>& others, std::size_t i) {
    const json& device = list[i]["device"];
    if (device.empty()) return;
    for (const std::size_t j : others) {
      if (list[j]["driver"] != list[i]["driver"] || list[j]["device"] != device ||
          list[j]["options"] != list[i]["options"]) {
        continue;
      }
      add(pointer_to("/sensors", i) + "/device", device,
          "is the device of " + pointer_to("/sensors", j) +
              " with the same options; they need to differ in one");
      return;
    }
  }

  SensorSettings sensor(const json& in, const std::string& at) {
    SensorSettings s{.setup = {.name = in["name"],
                               .layout = layout(in, at),
                               .rate_hz = in["rate_hz"],
                               .profile = in.value("profile", ""),
                               .device = in["device"],
                               .options = in["options"]},
                     .driver = in["driver"],
                     .friction = std::nullopt,
                     .full_scale = std::nullopt,
                     .contact = {},
                     .gain = {}};
    gain(in, at, s);
    if (in.contains("friction")) friction(in["friction"], at + "/friction", s);
    if (in["contact"].contains("min_normal_n")) s.contact.min_normal_n = in["contact"]["min_normal_n"];
    if (in.contains("full_scale_kpa")) {
      const json& most = in["full_scale_kpa"];
      const auto pa = [&most](std::size_t channel) {
        return kPascalPerKilopascal * most[channel].get<double>();
      };
      s.full_scale = FullScale{pa(0), pa(1), pa(2)};
    }
    if (in.contains("skin")) {
      skin(in["skin"], at + "/skin", s);
      pillars(in, at + "/skin/base", s.setup);
    }
    if (in.contains("profile") && in.contains("layout"))
      add(at + "/layout", in["layout"], "the profile brings its own; expected only one of the two");
    stale_after(in, at, s);
    return s;
  }

  void friction(const json& in, const std::string& at, SensorSettings& s) {
    if (in.is_number()) {
      s.friction = in.get<double>();
      return;
    }
    const Range range{in[0], in[1]};
    if (range.low > range.high) add(at, in, "falls; expected [low, high] with low not above high");
    s.friction = range;
  }

  // With a profile the number of taxels is checked when the device is opened.
  void gain(const json& in, const std::string& at, SensorSettings& s) {
    const json& value = in["gain"];
    s.gain = value.is_array() ? value.get<std::vector<float>>() : std::vector<float>{value.get<float>()};
    const std::size_t taxels = s.setup.layout.size();
    if (in.contains("profile") || !value.is_array() || s.gain.size() == taxels) return;
    add(at + "/gain", value,
        "has " + std::to_string(s.gain.size()) + " values; expected one for each of the " +
            std::to_string(taxels) + " taxels, or one number");
  }

  TaxelLayout layout(const json& sensor, const std::string& sensor_at) {
    TaxelLayout usual = TaxelLayout::grid(100, 100, metres_of_mm(0.144));
    if (!sensor.contains("layout")) return usual;
    const json& in = sensor["layout"];
    const std::string at = sensor_at + "/layout";
    if (in.contains("grid") == in.contains("taxels")) {
      add(at, in,
          "expected either grid (columns and rows) with pitch_mm, or taxels (a list of [x, y] in mm)");
      return usual;
    }
    if (in.contains("grid") != in.contains("pitch_mm")) {
      if (in.contains("grid"))
        problems_.push_back({at + "/pitch_mm", "", "is missing; the grid needs it, in mm"});
      if (in.contains("taxels")) add(at + "/pitch_mm", in["pitch_mm"], "belongs to grid, not to taxels");
      return usual;
    }
    return in.contains("grid") ? grid(in, at, usual) : taxels(in, at, usual);
  }

  TaxelLayout grid(const json& in, const std::string& at, const TaxelLayout& usual) {
    const std::size_t columns = in["grid"][0], rows = in["grid"][1];
    constexpr std::size_t kMost = 1'000'000;  // a mailbox of so many taxels takes 36 MB
    if (columns * rows <= kMost) return TaxelLayout::grid(columns, rows, metres_of_mm(in["pitch_mm"]));
    add(at + "/grid", in["grid"],
        "has " + std::to_string(columns * rows) + " taxels; expected up to 1000000");
    return usual;
  }

  TaxelLayout taxels(const json& in, const std::string& at, const TaxelLayout& usual) {
    std::vector<double> x_m, y_m;
    for (const auto& taxel : in["taxels"]) {
      x_m.push_back(metres_of_mm(taxel[0]));
      y_m.push_back(metres_of_mm(taxel[1]));
    }
    try {
      return TaxelLayout::scattered(std::move(x_m), std::move(y_m));
    } catch (const std::invalid_argument& e) {
      add(at + "/taxels", in["taxels"], e.what());
      return usual;
    }
  }

  void skin(const json& in, const std::string& at, SensorSettings& s) {
    SensorSetup& setup = s.setup;
    const bool flat = in["radius_mm"].is_string();
    setup.skin_radius_m = flat ? std::numeric_limits<double>::infinity() : metres_of_mm(in["radius_mm"]);
    setup.skin_modulus_pa = pascals_of_mpa(in["modulus_mpa"]);
    setup.skin_poisson = in["poisson"];
    depth(in["depth_mm"], at + "/depth_mm", s);
    setup.skin_base = skin_base_of(in["base"].get<std::string>());
  }

  // With a profile the number of taxels is known when the device is opened.
  void pillars(const json& in, const std::string& at, const SensorSetup& setup) {
    const std::size_t taxels = setup.layout.size();
    if (setup.skin_base != SkinBase::pillars || in.contains("profile") ||
        (taxels >= kLeastPillars && taxels <= kMostPillars))
      return;
    add(at, in["skin"]["base"],
        "needs 4 to 64 taxels, each a pillar; the layout has " + std::to_string(taxels));
  }

  static SkinKeys keys_of(const json& skin) {
    return {.radius = skin.contains("radius_mm"),
            .modulus = skin.contains("modulus_mpa"),
            .poisson = skin.contains("poisson"),
            .depth = skin.contains("depth_mm"),
            .base = skin.contains("base")};
  }

  // A range is as wide as the search: three standard deviations on either side of its geometric mean.
  void depth(const json& in, const std::string& at, SensorSettings& s) {
    if (in.is_number()) {
      s.setup.skin_depth_m = metres_of_mm(in);
      return;
    }
    const double low_m = metres_of_mm(in[0]), high_m = metres_of_mm(in[1]);
    if (low_m > high_m) return add(at, in, "falls; expected [low, high] with low not above high");
    s.setup.skin_depth_m = low_m == high_m ? low_m : std::sqrt(low_m * high_m);
    s.skin_depth_sigma = std::log(high_m / low_m) / (2 * kClearSigmas);
  }

  // The default depends on the rate and so cannot be in the schema: a slow sensor must not become stale
  // between two frames.
  void stale_after(const json& in, const std::string& at, SensorSettings& s) {
    const double frame_ms = 1000 / s.setup.rate_hz;
    if (!in.contains("stale_after_ms")) {
      s.stale_after =
          std::max(s.stale_after, std::chrono::milliseconds(std::llround(std::ceil(3 * frame_ms))));
      return;
    }
    s.stale_after = std::chrono::milliseconds(in["stale_after_ms"].get<int>());
    s.stale_after_configured = true;
    if (static_cast<double>(s.stale_after.count()) >= frame_ms) return;
    add(at + "/stale_after_ms", in["stale_after_ms"],
        "is shorter than one frame at rate_hz; expected at least " +
            std::to_string(std::llround(std::ceil(frame_ms))) + " ms");
  }

  const json& written_;               // the list before defaults were filled in
  const std::vector<Problem> found_;  // found by the schema, before this conversion
  std::vector<Problem>& problems_;
};

}  // namespace

std::vector<SensorSettings> convert_sensors(const json& list, const json& written,
                                            std::vector<Problem>& problems) {
  return SensorConverter(written, problems).sensors(list);
}

}  // namespace slipd
