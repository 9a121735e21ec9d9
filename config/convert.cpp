#include "config/convert.hpp"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/advice/alert.hpp"

namespace slipd {
namespace {

using nlohmann::json;

// CAN identifiers limit the number of sensors and grasps together.
constexpr std::size_t kMostOnCan = 31;

// Converts section by section and collects problems.
class Converter {
 public:
  Converter(const json& root, const json& written, std::vector<Problem>& problems)
      : root_(root), written_(written), problems_(problems) {}

  Settings settings() {
    Settings s;
    if (root_.contains("sensors") && root_["sensors"].is_array()) sensors(s);
    if (root_["grasps"].is_array()) grasps(s);
    if (root_["objects"].is_array()) objects(s);
    if (clean("/estimator")) estimator(s);
    if (clean("/alerts")) alerts(s.alerts);
    if (clean("/socket")) socket(s.socket);
    for (SensorSettings& sensor : s.sensors)
      sensor.setup.runtime_folder = s.socket.path.parent_path().string();
    if (root_.contains("can") && clean("/can")) can(s);
    if (clean("/recorder")) recorder(s.recorder);
    if (clean("/metrics")) metrics(s.metrics);
    if (clean("/realtime")) realtime(s.realtime);
    if (clean("/log")) s.log_level = root_["log"]["level"];
    return s;
  }

 private:
  bool clean(const std::string& pointer) const { return !has_problem_at(problems_, pointer); }
  void add(const std::string& pointer, const json& value, const std::string& what) {
    problems_.push_back(problem_of(pointer, value, what));
  }

  void sensors(Settings& s) {
    const json& list = root_["sensors"];
    s.sensors = convert_sensors(list, written_["sensors"], problems_);
    if (root_.contains("can") && list.size() > kMostOnCan) {
      add("/sensors", list,
          "has " + std::to_string(list.size()) + " sensors; expected up to 31, more do not go on CAN");
    }
  }

  void grasps(Settings& s) {
    const json& list = root_["grasps"];
    if (root_.contains("can") && root_.contains("sensors") && root_["sensors"].size() <= kMostOnCan &&
        root_["sensors"].size() + list.size() > kMostOnCan) {
      add("/grasps", list,
          "sensors and grasps are " + std::to_string(root_["sensors"].size() + list.size()) +
              "; expected up to 31 together, more do not go on CAN");
    }
    const std::vector<Problem> found = problems_;
    check_names_differ(list, "/grasps", problems_);
    std::vector<std::string> known;
    if (root_.contains("sensors") && root_["sensors"].is_array()) {
      for (const auto& sensor : root_["sensors"]) {
        if (sensor.is_object() && sensor.contains("name") && sensor["name"].is_string())
          known.push_back(sensor["name"]);
      }
    }
    const bool sensors_known = !has_problem_exactly_at(found, "/sensors");
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::string at = pointer_to("/grasps", i);
      if (has_problem_at(found, at)) continue;
      if (std::find(known.begin(), known.end(), list[i]["name"]) != known.end())
        add(at + "/name", list[i]["name"],
            "is the name of a sensor; expected another, as clients ask for both by name");
      s.grasps.push_back({list[i]["name"], list[i]["sensors"], poses(list[i], at)});
      if (!sensors_known) continue;
      for (std::size_t j = 0; j < list[i]["sensors"].size(); ++j) {
        const std::string& name = s.grasps.back().sensors[j];
        if (std::find(known.begin(), known.end(), name) != known.end()) continue;
        add(pointer_to(at + "/sensors", j), name,
            "is no sensor of this configuration" + did_you_mean(name, known));
      }
    }
  }

  std::vector<FingerPose> poses(const json& grasp, const std::string& at) {
    std::vector<FingerPose> poses;
    if (!grasp.contains("poses")) return poses;
    const json& list = grasp["poses"];
    if (list.size() != grasp["sensors"].size())
      add(at + "/poses", list.size(),
          "poses; expected one for each of the " + std::to_string(grasp["sensors"].size()) + " sensors");
    for (std::size_t i = 0; i < list.size(); ++i) {
      constexpr double kMPerMm = 1e-3;
      auto at_m = list[i]["at_mm"].get<Vector3>();
      for (double& value : at_m) value *= kMPerMm;
      if (!make_pose(at_m, list[i]["normal"].get<Vector3>(), list[i]["x"].get<Vector3>(),
                     poses.emplace_back()))
        add(pointer_to(at + "/poses", i), list[i],
            "has no axes; expected a normal and an x that are not 0 and not parallel");
    }
    return poses;
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
      const auto scaled = [&](const char* key, double (*unit)(const json&)) {
        ranged(key);
        return Range{unit(list[i][key][0]), unit(list[i][key][1])};
      };
      s.objects.push_back({.weight = list[i]["weight"],
                           .normal_n = ranged("normal_n"),
                           .friction = ranged("friction"),
                           .radius_m = scaled("radius_mm", metres_of_mm),
                           .flat_share = list[i]["flat_share"],
                           .modulus_pa = scaled("modulus_mpa", pascals_of_mpa),
                           .poisson = ranged("poisson")});
    }
  }

  void estimator(Settings& s) const {
    const json& in = root_["estimator"];
    s.estimator = {
        .method = method_choices().at(in["method"]),
        .budget_us = in.contains("budget_us") ? std::optional<double>(in["budget_us"]) : std::nullopt,
        .rank = in["rank"],
        .neighbours = in["neighbours"],
        .tracking = in["tracking"],
        .sigma_max = in["sigma_max"]};
    s.noise = in["noise"];
    s.offset_m = metres_of_mm(in["offset_mm"]);
  }

  void alerts(AlertSettings& a) {
    const json& in = root_["alerts"];
    a = {.warn_below = in["warn_below"],
         .slip_below = in["slip_below"],
         .hysteresis = in["hysteresis"],
         .min_ms = in["min_ms"],
         .cost = in.contains("sigmas") ? cost_of(in["sigmas"]) : in["cost"].get<double>(),
         .target_margin = in["target_margin"],
         .false_alarms_per_hour = in["false_alarms_per_hour"],
         .use = in["use"] == "low" ? AlertUse::low : AlertUse::margin};
    if (in.contains("sigmas") && written_["alerts"].contains("cost"))
      add("/alerts/sigmas", in["sigmas"], "says again what \"cost\" says; leave one of them out");
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
        107;  // bytes in sockaddr_un::sun_path without its final 0; the schema counts characters
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
    c.sliding = in["sliding"];
    constexpr std::uint64_t kLastOffset = 0x3F, kLastOfSliding = 0x5F;
    constexpr std::uint64_t kLargest = 0x7FF, kLargestExtended = 0x1FFFFFFF;
    const std::uint64_t last = c.sliding ? kLastOfSliding : kLastOffset;
    if (c.base_id + last > (c.extended ? kLargestExtended : kLargest)) {
      const std::string room = "leaves no room for slipd's " + std::to_string(last + 1) + " identifiers";
      const bool sliding = c.sliding;
      add("/can/base_id", in["base_id"],
          c.extended
              ? room + "; expected up to " + (sliding ? "0x1FFFFFA0" : "0x1FFFFFC0")
              : room + " of 11 bits; expected up to " + (sliding ? "0x7A0" : "0x7C0") + ", or extended");
    }
    s.can = std::move(c);
  }

  void recorder(RecorderSettings& r) const {
    const json& in = root_["recorder"];
    r = {.seconds = in["seconds"], .max_mb = in["max_mb"], .keep = in["keep"]};
  }

  void metrics(MetricsSettings& m) {
    const json& in = root_["metrics"];
    const std::string file = in["file"];
    if (!file.empty() && file.front() != '/') add("/metrics/file", in["file"], "expected an absolute path");
    m = {.file = in["file"].get<std::string>(), .period = std::chrono::seconds(in["period_s"].get<int>())};
  }

  void realtime(RealtimeSettings& r) const {
    const json& in = root_["realtime"];
    static const std::map<std::string, RealtimeMode> kModes{
        {"enforce", RealtimeMode::enforce}, {"prefer", RealtimeMode::prefer}, {"off", RealtimeMode::off}};
    r = {.mode = kModes.at(in["mode"]),
         .priority = in["priority"],
         .cpus = in["cpus"],
         .estimate_threads = in["estimate_threads"],
         .lock_memory = in["lock_memory"]};
  }

  const json& root_;
  const json& written_;  // root_ before defaults were filled in
  std::vector<Problem>& problems_;
};

}  // namespace

bool has_problem_at(const std::vector<Problem>& problems, const std::string& pointer) {
  const auto within = [](const std::string& inner, const std::string& outer) {
    return inner == outer || inner.starts_with(outer + "/");
  };
  return std::any_of(problems.begin(), problems.end(), [&](const Problem& p) {
    return within(p.pointer, pointer) || within(pointer, p.pointer);
  });
}

bool has_problem_exactly_at(const std::vector<Problem>& problems, const std::string& pointer) {
  return std::any_of(problems.begin(), problems.end(),
                     [&](const Problem& p) { return p.pointer == pointer; });
}

void check_names_differ(const json& list, const std::string& at, std::vector<Problem>& problems) {
  if (has_problem_exactly_at(problems, at)) return;  // too long, say; each is compared with all
  const auto named = [](const json& one) { return one.is_object() && one.contains("name"); };
  for (std::size_t i = 0; i < list.size(); ++i) {
    for (std::size_t j = 0; j < i && named(list[i]); ++j) {
      if (!named(list[j]) || list[j]["name"] != list[i]["name"]) continue;
      problems.push_back(problem_of(pointer_to(at, i) + "/name", list[i]["name"],
                                    "is the name of " + pointer_to(at, j) + " too; expected one of its own"));
      break;
    }
  }
}

Settings convert(const json& root, const json& written, std::vector<Problem>& problems) {
  return Converter(root, written, problems).settings();
}

}  // namespace slipd
