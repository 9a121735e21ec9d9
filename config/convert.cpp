#include "config/convert.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

namespace slipd {
namespace {

using nlohmann::json;

constexpr double kMmPerMetre = 1e3;  // divided by, so that 2 mm is the double nearest to 0.002
constexpr double kPascalPerMpa = 1e6;

double metres(const json& mm) {
  return mm.get<double>() / kMmPerMetre;
}

// The conversion and the problems it adds to.
class Converter {
 public:
  Converter(const json& root, std::vector<Problem>& problems) : root_(root), problems_(problems) {}

  Settings settings() {
    Settings s;
    if (root_.contains("sensors") && root_["sensors"].is_array()) sensors(s);
    if (root_["grasps"].is_array()) grasps(s);
    if (root_["objects"].is_array()) objects(s);
    if (clean("/estimator")) estimator(s);
    if (clean("/alerts")) alerts(s.alerts);
    if (clean("/socket")) socket(s.socket);
    if (root_.contains("can") && clean("/can")) can(s);
    if (clean("/recorder")) recorder(s.recorder);
    if (clean("/realtime")) realtime(s.realtime);
    if (clean("/log")) s.log_level = root_["log"]["level"];
    return s;
  }

 private:
  bool clean(const std::string& pointer) const { return !is_touched(problems_, pointer); }
  void add(const std::string& pointer, const json& value, const std::string& what) {
    problems_.push_back(problem_of(pointer, value, what));
  }

  void sensors(Settings& s) {
    const json& list = root_["sensors"];
    std::vector<std::size_t> well_formed;
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::string at = pointer_to("/sensors", i);
      const bool converts = clean(at);
      unique_name("/sensors", list, i);
      if (!converts) continue;
      s.sensors.push_back(sensor(list[i], at));
      distinguishable(list, well_formed, i);
      well_formed.push_back(i);
    }
    constexpr std::size_t kCanSensors = 31;
    if (root_.contains("can") && list.size() > kCanSensors) {
      add("/sensors", list,
          "has " + std::to_string(list.size()) + " sensors; expected up to 31, more do not go on CAN");
    }
  }

  void unique_name(const std::string& list_at, const json& list, std::size_t i) {
    if (!list[i].is_object() || !list[i].contains("name")) return;
    const json& name = list[i]["name"];
    for (std::size_t j = 0; j < i; ++j) {
      if (!list[j].is_object() || !list[j].contains("name") || list[j]["name"] != name) continue;
      add(pointer_to(list_at, i) + "/name", name,
          "is the name of " + pointer_to(list_at, j) + " too; expected one of its own");
      return;
    }
  }

  // Two sensors may share a device (a board with two pads), but then something must tell them apart.
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
                     .friction = std::nullopt};
    if (in.contains("friction")) s.friction = in["friction"].get<double>();
    if (in.contains("skin")) skin(in["skin"], s.setup);
    if (in.contains("profile")) {
      for (const char* key : {"layout", "skin"}) {
        if (in.contains(key))
          add(pointer_to(at, key), in[key], "the profile brings its own; expected only one of the two");
      }
    }
    stale_after(in, at, s);
    return s;
  }

  TaxelLayout layout(const json& sensor, const std::string& sensor_at) {
    const TaxelLayout usual = TaxelLayout::grid(100, 100, 0.144 / kMmPerMetre);
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
    constexpr std::size_t kMost = 1'000'000;  // 36 MB a sensor in frames alone
    if (columns * rows <= kMost) return TaxelLayout::grid(columns, rows, metres(in["pitch_mm"]));
    add(at + "/grid", in["grid"],
        "has " + std::to_string(columns * rows) + " taxels; expected up to 1000000");
    return usual;
  }

  TaxelLayout taxels(const json& in, const std::string& at, const TaxelLayout& usual) {
    std::vector<double> x_m, y_m;
    for (const auto& taxel : in["taxels"]) {
      x_m.push_back(metres(taxel[0]));
      y_m.push_back(metres(taxel[1]));
    }
    try {
      return TaxelLayout::scattered(std::move(x_m), std::move(y_m));
    } catch (const std::invalid_argument& e) {
      add(at + "/taxels", in["taxels"], e.what());
      return usual;
    }
  }

  static void skin(const json& in, SensorSetup& setup) {
    const bool flat = in["radius_mm"].is_string();
    setup.skin_radius_m = flat ? std::numeric_limits<double>::infinity() : metres(in["radius_mm"]);
    setup.skin_modulus_pa = in["modulus_mpa"].get<double>() * kPascalPerMpa;
    setup.skin_poisson = in["poisson"];
  }

  // Not a schema's default, as it follows the rate: a slow sensor must not be stale between any two of its
  // frames.
  void stale_after(const json& in, const std::string& at, SensorSettings& s) {
    const double frame_ms = 1000 / s.setup.rate_hz;
    if (!in.contains("stale_after_ms")) {
      s.stale_after =
          std::max(s.stale_after, std::chrono::milliseconds(std::llround(std::ceil(3 * frame_ms))));
      return;
    }
    s.stale_after = std::chrono::milliseconds(in["stale_after_ms"].get<int>());
    if (static_cast<double>(s.stale_after.count()) >= frame_ms) return;
    add(at + "/stale_after_ms", in["stale_after_ms"],
        "is shorter than one frame at rate_hz; expected at least " +
            std::to_string(std::llround(std::ceil(frame_ms))) + " ms");
  }

  void grasps(Settings& s) {
    const json& list = root_["grasps"];
    std::vector<std::string> known;
    if (root_.contains("sensors") && root_["sensors"].is_array()) {
      for (const auto& sensor : root_["sensors"]) {
        if (sensor.is_object() && sensor.contains("name") && sensor["name"].is_string())
          known.push_back(sensor["name"]);
      }
    }
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::string at = pointer_to("/grasps", i);
      const bool converts = clean(at);
      unique_name("/grasps", list, i);
      if (!converts) continue;
      s.grasps.push_back({list[i]["name"], list[i]["sensors"]});
      for (std::size_t j = 0; j < list[i]["sensors"].size(); ++j) {
        const std::string& name = s.grasps.back().sensors[j];
        if (std::find(known.begin(), known.end(), name) != known.end()) continue;
        add(pointer_to(at + "/sensors", j), name,
            "is no sensor of this configuration" + did_you_mean(name, known));
      }
    }
  }

  Range range(const json& in, const std::string& at) {
    const Range r{in[0].get<double>(), in[1].get<double>()};
    if (r.low > r.high) add(at, in, "falls; expected [from, to] with from not above to");
    return r;
  }

  void objects(Settings& s) {
    const json& list = root_["objects"];
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::string at = pointer_to("/objects", i);
      if (!clean(at)) continue;
      const auto ranged = [&](const char* key) { return range(list[i][key], pointer_to(at, key)); };
      const Range radius_mm = ranged("radius_mm"), modulus_mpa = ranged("modulus_mpa");
      s.objects.push_back({.weight = list[i]["weight"],
                           .normal_n = ranged("normal_n"),
                           .friction = ranged("friction"),
                           .radius_m = {radius_mm.low / kMmPerMetre, radius_mm.high / kMmPerMetre},
                           .flat_share = list[i]["flat_share"],
                           .modulus_pa = {modulus_mpa.low * kPascalPerMpa, modulus_mpa.high * kPascalPerMpa},
                           .poisson = ranged("poisson")});
    }
  }

  void estimator(Settings& s) const {
    const json& in = root_["estimator"];
    static const std::map<std::string, MethodChoice> kMethods{{"auto", MethodChoice::automatic},
                                                              {"svd-knn", MethodChoice::svd_knn},
                                                              {"registered", MethodChoice::registered},
                                                              {"moments", MethodChoice::moments},
                                                              {"fit", MethodChoice::fit}};
    s.estimator = {.method = kMethods.at(in["method"]),
                   .budget_us = in["budget_us"],
                   .rank = in["rank"],
                   .neighbours = in["neighbours"],
                   .tracking = in["tracking"],
                   .sigma_max = in["sigma_max"]};
    s.noise = in["noise"];
    s.offset_m = metres(in["offset_mm"]);
  }

  void alerts(AlertSettings& a) {
    const json& in = root_["alerts"];
    a = {.warn_below = in["warn_below"],
         .slip_below = in["slip_below"],
         .hysteresis = in["hysteresis"],
         .min_ms = in["min_ms"],
         .sigmas = in["sigmas"],
         .target_margin = in["target_margin"]};
    if (a.slip_below <= a.warn_below) return;
    add("/alerts/slip_below", in["slip_below"],
        "is above warn_below = " + in["warn_below"].dump() + "; expected slip_below <= warn_below");
  }

  void socket(SocketSettings& s) {
    const json& in = root_["socket"];
    s.path = in["path"].get<std::string>();
    s.mode = static_cast<unsigned>(std::stoul(in["mode"].get<std::string>(), nullptr, 8));
    s.max_clients = in["max_clients"];
    constexpr std::size_t kLongest =
        107;  // sockaddr_un::sun_path less its end; the schema counts characters, it bytes
    if (s.path.native().size() > kLongest) {
      add("/socket/path", in["path"],
          "has " + std::to_string(s.path.native().size()) + " bytes; expected up to 107");
    }
    if (s.path.native().find('\0') != std::string::npos) add("/socket/path", in["path"], "holds a zero byte");
  }

  void can(Settings& s) {
    const json& in = root_["can"];
    CanSettings c;
    c.interface = in["interface"];
    c.base_id = in["base_id"].is_string()
                    ? static_cast<std::uint32_t>(std::stoul(in["base_id"].get<std::string>(), nullptr, 16))
                    : in["base_id"].get<std::uint32_t>();
    c.extended = in["extended"];
    c.fd = in["fd"];
    c.period = std::chrono::milliseconds(in["period_ms"].get<int>());
    c.allow_simulated = in["allow_simulated"];
    constexpr std::uint64_t kLastOffset = 0x3F, kLargest = 0x7FF, kLargestExtended = 0x1FFFFFFF;
    if (c.base_id + kLastOffset > (c.extended ? kLargestExtended : kLargest)) {
      add("/can/base_id", in["base_id"],
          c.extended
              ? "leaves no room for slipd's 64 identifiers; expected up to 0x1FFFFFC0"
              : "leaves no room for slipd's 64 identifiers of 11 bits; expected up to 0x7C0, or extended");
    }
    s.can = std::move(c);
  }

  void recorder(RecorderSettings& r) const {
    const json& in = root_["recorder"];
    r = {.seconds = in["seconds"], .max_mb = in["max_mb"], .keep = in["keep"]};
  }

  void realtime(RealtimeSettings& r) const {
    const json& in = root_["realtime"];
    static const std::map<std::string, RealtimeMode> kModes{
        {"enforce", RealtimeMode::enforce}, {"prefer", RealtimeMode::prefer}, {"off", RealtimeMode::off}};
    r = {.mode = kModes.at(in["mode"]),
         .priority = in["priority"],
         .cpus = in["cpus"],
         .lock_memory = in["lock_memory"]};
  }

  const json& root_;
  std::vector<Problem>& problems_;
};

}  // namespace

bool is_touched(const std::vector<Problem>& problems, const std::string& pointer) {
  const auto within = [](const std::string& inner, const std::string& outer) {
    return inner == outer || inner.starts_with(outer + "/");
  };
  return std::any_of(problems.begin(), problems.end(), [&](const Problem& p) {
    return within(p.pointer, pointer) || within(pointer, p.pointer);
  });
}

Settings convert(const json& root, std::vector<Problem>& problems) {
  return Converter(root, problems).settings();
}

}  // namespace slipd
