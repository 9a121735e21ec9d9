// From JSON to Settings: units, defaults, and what no schema can check.
#include "config/settings.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>

#include "core/advice/alert.hpp"
#include "tests/config/support.hpp"

namespace slipd::test {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

const char* const kMinimal = R"({"sensors": [{"name": "left", "driver": "sim"}]})";

// The minimal document with `value` put at `pointer`.
json with(const std::string& pointer, const json& value) {
  json document = json::parse(kMinimal);
  document[json::json_pointer(pointer)] = value;
  return document;
}

// Looking at each of so many sensors would take seconds; their number is judged first.
TEST(Settings, WithFarTooManySensorsLookAtNoneOfThem) {
  class Counting : public FakeCatalogue {
   public:
    const DriverModule* find(const std::string& name) override {
      ++asked;
      return FakeCatalogue::find(name);
    }
    int asked = 0;
  } drivers;
  json document = json::parse(kMinimal);
  for (int i = 0; i < 10'000; ++i) document["sensors"].push_back(document["sensors"][0]);
  document["grasps"] = {{{"name", "g"}, {"sensors", {"nobody"}}}};
  try {
    parse_settings(document.dump(), "t.json", drivers);
    FAIL() << "accepted";
  } catch (const SettingsError& error) {
    ASSERT_EQ(error.problems().size(), 1U);
    EXPECT_THAT(error.problems().front(), HasSubstr("/sensors"));
    EXPECT_THAT(error.problems().front(), HasSubstr("too many items"));
  }
  EXPECT_EQ(drivers.asked, 0);
}

TEST(Settings, OfAMinimalDocumentAreTheDefaultsOfTheStructs) {
  const Settings s = parse(std::string(kMinimal)), d;
  EXPECT_EQ(s.estimator, d.estimator);
  EXPECT_EQ(s.noise, d.noise);
  EXPECT_EQ(s.offset_m, d.offset_m);
  EXPECT_EQ(s.alerts, d.alerts);
  EXPECT_EQ(s.objects, paper_objects());
  EXPECT_EQ(s.socket.path, d.socket.path);
  EXPECT_EQ(s.socket.mode, d.socket.mode);
  EXPECT_EQ(s.socket.max_clients, d.socket.max_clients);
  EXPECT_FALSE(s.can);
  EXPECT_EQ(s.recorder.seconds, d.recorder.seconds);
  EXPECT_EQ(s.recorder.max_mb, d.recorder.max_mb);
  EXPECT_EQ(s.recorder.keep, d.recorder.keep);
  EXPECT_EQ(s.metrics.file, d.metrics.file);
  EXPECT_EQ(s.metrics.period, d.metrics.period);
  EXPECT_EQ(s.realtime.mode, d.realtime.mode);
  EXPECT_EQ(s.realtime.priority, d.realtime.priority);
  EXPECT_EQ(s.realtime.cpus, d.realtime.cpus);
  EXPECT_EQ(s.realtime.estimate_threads, d.realtime.estimate_threads);
  EXPECT_EQ(s.realtime.lock_memory, d.realtime.lock_memory);
  EXPECT_EQ(s.log_level, d.log_level);
  EXPECT_TRUE(s.grasps.empty());
}

TEST(Settings, OfAMinimalSensorAreTheDefaultsOfTheStructs) {
  const Settings s = parse(std::string(kMinimal));
  ASSERT_EQ(s.sensors.size(), 1U);
  const SensorSettings& sensor = s.sensors[0];
  EXPECT_EQ(sensor.driver, "sim");
  EXPECT_EQ(sensor.stale_after, std::chrono::milliseconds(20));
  EXPECT_FALSE(sensor.friction);
  EXPECT_FALSE(sensor.contact.min_normal_n);
  EXPECT_THAT(sensor.gain, ElementsAre(1));
  EXPECT_EQ(sensor.setup.name, "left");
  EXPECT_EQ(sensor.setup.rate_hz, 1000);
  EXPECT_EQ(sensor.setup.layout, TaxelLayout::grid(100, 100, 0.144 / 1000));
  EXPECT_EQ(sensor.setup.device, json::object());
  EXPECT_EQ(sensor.setup.options, json::parse(R"({"seed": 1, "noise": 0.01})"));
  EXPECT_EQ(s.scene_of(sensor), (Scene{Skin{}, paper_objects(), 0.002, 0.01}));
}

TEST(Settings, TellADriverTheFolderOfTheSocket) {
  EXPECT_EQ(parse(std::string(kMinimal)).sensors[0].setup.runtime_folder, "/run/slipd");
  EXPECT_EQ(parse(with("/socket/path", "/tmp/mine/s.sock")).sensors[0].setup.runtime_folder, "/tmp/mine");
}

TEST(Settings, FrictionIsAValueOrARangeThatDoesNotFall) {
  EXPECT_EQ(parse(with("/sensors/0/friction", {0.3, 0.8})).sensors.at(0).friction,
            KnownFriction(Range{0.3, 0.8}));
  EXPECT_THAT(problems_of(with("/sensors/0/friction", {0.8, 0.3})), ElementsAre(HasSubstr("falls")));
  EXPECT_EQ(problems_of(with("/sensors/0/friction", json::array({0.8}))).size(), 1U);
  EXPECT_EQ(problems_of(with("/sensors/0/friction", "slippery")).size(), 1U);
}

TEST(Settings, OfAMinimalCanSectionAreTheDefaultsOfTheStruct) {
  const auto can = parse(with("/can", {{"interface", "can0"}})).can.value();
  const CanSettings d;
  EXPECT_EQ(can.interface, "can0");
  EXPECT_EQ(can.base_id, d.base_id);
  EXPECT_EQ(can.extended, d.extended);
  EXPECT_EQ(can.fd, d.fd);
  EXPECT_EQ(can.period, d.period);
  EXPECT_EQ(can.allow_simulated, d.allow_simulated);
  EXPECT_EQ(can.sliding, d.sliding);
}

TEST(Settings, CarryARangeOfDepthAsItsGeometricMeanAndASixthOfItsWidth) {
  json document = whole_document();
  json& depth = document["sensors"][0]["skin"]["depth_mm"];
  EXPECT_EQ(parse(document).sensors.at(0).skin_depth_sigma, kUsualDepthSigma);
  depth = {1, 4};
  const SensorSettings range = parse(document).sensors.at(0);
  EXPECT_NEAR(range.setup.skin_depth_m, 0.002, 1e-12);
  EXPECT_NEAR(3 * range.skin_depth_sigma, std::log(2), 1e-12);
  depth = {1.5, 1.5};
  const SensorSettings exact = parse(document).sensors.at(0);
  EXPECT_EQ(exact.setup.skin_depth_m, 0.0015);
  EXPECT_EQ(exact.skin_depth_sigma, 0);
  EXPECT_EQ(parse(document).scene_of(exact).skin.depth_sigma, 0);
  depth = {2, 1};
  EXPECT_ANY_THROW(parse(document));
}

TEST(Settings, CarryTheBaseOfASkinWhichIsAHalfSpaceUnlessTold) {
  json document = whole_document();
  const Settings settings = parse(document);
  EXPECT_EQ(settings.scene_of(settings.sensors.at(0)).skin.bonded_poisson(), 0.4);
  json& skin = document["sensors"][0]["skin"];
  skin.erase("base");
  EXPECT_EQ(parse(document).sensors.at(0).setup.skin_base, SkinBase::half_space);
  skin["base"] = "soft";
  EXPECT_ANY_THROW(parse(document));
}

TEST(Settings, TakePadsOfFourToSixtyFourPillars) {
  json document = whole_document();
  json& sensor = document["sensors"][0];
  sensor.erase("gain");
  sensor["skin"]["base"] = "pillars";
  EXPECT_THAT(problems_of(document),
              ElementsAre(HasSubstr("needs 4 to 64 taxels, each a pillar; the layout has 200")));
  sensor["layout"] = {{"grid", {5, 5}}, {"pitch_mm", 2}};
  EXPECT_EQ(parse(document).sensors.at(0).setup.skin_base, SkinBase::pillars);
}

TEST(Settings, CarryEveryKeyInSIUnits) {
  const Settings s = parse(whole_document());
  const SensorSettings& left = s.sensors.at(0);
  EXPECT_EQ(left.setup.rate_hz, 500);
  EXPECT_EQ(left.stale_after, std::chrono::milliseconds(30));
  EXPECT_EQ(left.setup.layout, TaxelLayout::grid(10, 20, 0.0005));
  EXPECT_TRUE(std::isinf(left.setup.skin_radius_m));
  EXPECT_EQ(left.setup.skin_modulus_pa, 1e6);
  EXPECT_EQ(left.setup.skin_poisson, 0.4);
  EXPECT_EQ(left.setup.skin_depth_m, 0.0015);
  EXPECT_EQ(left.setup.device, json::parse(R"({"index": 1})"));
  EXPECT_EQ(left.setup.options, json::parse(R"({"seed": 3, "noise": 0.1})"));
  EXPECT_EQ(left.friction, KnownFriction(0.5));
  EXPECT_EQ(left.contact.min_normal_n, 0.2);
  EXPECT_THAT(s.sensors.at(1).gain, ElementsAre(0.5));
  EXPECT_EQ(s.sensors.at(1).setup.layout, TaxelLayout::scattered({0, 0.001, 0}, {0, 0, 0.001}));
  EXPECT_EQ(s.sensors.at(2).setup.profile, "xela-xr1944");
  EXPECT_EQ(s.grasps.at(0).name, "gripper");
  EXPECT_THAT(s.grasps.at(0).sensors, ElementsAre("left", "right"));
  ASSERT_EQ(s.grasps.at(0).poses.size(), 2U);
  EXPECT_EQ(s.grasps.at(0).poses[0].at_m, (Vector3{0, 0, -0.02}));
  EXPECT_EQ(s.grasps.at(0).poses[0].x, (Vector3{1, 0, 0}));
  EXPECT_EQ(s.grasps.at(0).poses[1].y, (Vector3{0, -1, 0}));
  EXPECT_THAT(s.objects,
              ElementsAre(ObjectFamily{2, {1, 6}, {0.2, 0.8}, {0.005, 0.05}, 0.25, {1e6, 1e7}, {0.1, 0.2}}));
  EXPECT_EQ(s.estimator, (EstimatorSettings{MethodChoice::fit, 60, 9, 6, false, 0.2}));
  EXPECT_EQ(s.noise, 0.02);
  EXPECT_EQ(s.offset_m, 0.003);
  EXPECT_EQ(s.alerts, (AlertSettings{0.5, 0.3, 0.06, 3, 20, 0.6, 2, AlertUse::low}));
  EXPECT_EQ(s.socket.path, "/tmp/s");
  EXPECT_EQ(s.socket.mode, 0600U);
  EXPECT_EQ(s.socket.max_clients, 10U);
  EXPECT_EQ(s.can->interface, "can1");
  EXPECT_EQ(s.can->base_id, 0x100U);
  EXPECT_TRUE(s.can->extended && s.can->fd && s.can->allow_simulated && s.can->sliding);
  EXPECT_EQ(s.can->period, std::chrono::milliseconds(20));
  EXPECT_EQ(s.recorder.seconds, 5);
  EXPECT_EQ(s.recorder.max_mb, 10);
  EXPECT_EQ(s.recorder.keep, 3);
  EXPECT_EQ(s.metrics.file, "/run/slipd/slipd.prom");
  EXPECT_EQ(s.metrics.period, std::chrono::seconds(30));
  EXPECT_EQ(s.realtime.mode, RealtimeMode::enforce);
  EXPECT_EQ(s.realtime.priority, 50);
  EXPECT_THAT(s.realtime.cpus, ElementsAre(1, 2));
  EXPECT_EQ(s.realtime.estimate_threads, 3);
  EXPECT_FALSE(s.realtime.lock_memory);
  EXPECT_EQ(s.log_level, "debug");
}

TEST(Settings, GiveASlowSensorThreeFramesBeforeItIsStale) {
  EXPECT_EQ(parse(with("/sensors/0/rate_hz", 60)).sensors[0].stale_after, std::chrono::milliseconds(50));
  json document = with("/sensors/0/rate_hz", 60);
  document["sensors"][0]["stale_after_ms"] = 16;
  EXPECT_THAT(problems_of(document),
              ElementsAre(HasSubstr("/sensors/0/stale_after_ms = 16: is shorter than one frame")));
}

TEST(Settings, CheckADriversOptionsByItsOwnSchema) {
  EXPECT_THAT(
      problems_of(with("/sensors/0/options", {{"noise", 2}, {"sede", 1}})),
      ElementsAre(
          "t.json: /sensors/0/options/noise = 2: is too large; expected a number from 0 to 1 of full scale",
          "t.json: /sensors/0/options/sede = 1: is an unknown key; did you mean \"seed\"?"));
}

TEST(Settings, StateWhyAnExistingDriverCannotBeUsed) {
  EXPECT_THAT(
      problems_of(with("/sensors/0/driver", "old")),
      ElementsAre("t.json: /sensors/0/driver = \"old\": is there, but cannot be used: it was built for "
                  "driver interface 1"));
}

TEST(Settings, TakeOneGainForAllTaxelsOrOneForEach) {
  json document = whole_document();
  document["sensors"][1]["gain"] = {1, 0.5, 2};
  EXPECT_THAT(parse(document).sensors.at(1).gain, ElementsAre(1, 0.5, 2));
  document["sensors"][1]["gain"] = {1, 0.5};
  EXPECT_THAT(problems_of(document),
              ElementsAre("t.json: /sensors/1/gain = [1,0.5]: has 2 values; expected one for each of the 3 "
                          "taxels, or one number"));
}

TEST(Settings, SayWhichDriversThereAre) {
  EXPECT_THAT(
      problems_of(with("/sensors/0/driver", "smi")),
      ElementsAre(
          "t.json: /sensors/0/driver = \"smi\": no such driver; did you mean \"sim\"?; found: replay, sim; "
          "looked in /nowhere"));
}

TEST(Settings, ReportAnInvalidSchemaAsTheDriversFault) {
  EXPECT_THAT(problems_of(with("/sensors/0/driver", "broken")),
              ElementsAre(HasSubstr("the driver describes its options wrongly")));
}

TEST(Settings, WantSensorsAndGraspsThatCanBeToldApart) {
  json document = whole_document();
  document["sensors"][1]["name"] = "left";
  document["grasps"].push_back({{"name", "gripper"}, {"sensors", {"real", "lfet"}}});
  EXPECT_THAT(problems_of(document),
              testing::IsSupersetOf({HasSubstr("/sensors/1/name = \"left\": is the name of /sensors/0 too"),
                                     HasSubstr("/grasps/1/name = \"gripper\": is the name of /grasps/0 too"),
                                     HasSubstr("/grasps/0/sensors/1 = \"right\": is no sensor"),
                                     HasSubstr("/grasps/1/sensors/1 = \"lfet\": is no sensor of this "
                                               "configuration; did you mean \"left\"?")}));
}

TEST(Settings, WantAGraspOfAnotherNameThanAnySensorHas) {
  json document = whole_document();
  document["grasps"][0]["name"] = document["sensors"][0]["name"];
  EXPECT_THAT(problems_of(document),
              ElementsAre(HasSubstr("/grasps/0/name = \"left\": is the name of a sensor")));
}

TEST(Settings, WantAPoseWithAxesForEachSensorOfAGrasp) {
  json document = whole_document();
  document["grasps"][0]["poses"][1]["x"] = {0, 0, 3};
  EXPECT_THAT(problems_of(document), ElementsAre(HasSubstr("/grasps/0/poses/1")));
  document["grasps"][0]["poses"].erase(1);
  EXPECT_THAT(problems_of(document), ElementsAre(HasSubstr("expected one for each of the 2 sensors")));
}

TEST(Settings, WantTwoSensorsOfOneDeviceToDiffer) {
  json document = whole_document();
  document["sensors"][1]["device"] = document["sensors"][0]["device"];
  EXPECT_THAT(problems_of(document), testing::IsEmpty());  // their options differ
  document["sensors"][1]["options"] = document["sensors"][0]["options"];
  EXPECT_THAT(problems_of(document),
              ElementsAre(HasSubstr("/sensors/1/device = {…}: is the device of /sensors/0")));
}

TEST(Settings, WantOneWayOfSayingWhereTheTaxelsAre) {
  const auto layout = [](const char* text) {
    return problems_of(with("/sensors/0/layout", json::parse(text)));
  };
  EXPECT_THAT(layout("{}"), ElementsAre(HasSubstr("/sensors/0/layout = {}: expected either grid")));
  EXPECT_THAT(layout(R"({"grid": [2, 2], "taxels": [[0, 0], [1, 0]], "pitch_mm": 1})"),
              ElementsAre(HasSubstr("expected either grid")));
  EXPECT_THAT(layout(R"({"grid": [2, 2]})"),
              ElementsAre(HasSubstr("/sensors/0/layout/pitch_mm: is missing")));
  EXPECT_THAT(layout(R"({"taxels": [[0, 0], [1, 0]], "pitch_mm": 1})"),
              ElementsAre(HasSubstr("/sensors/0/layout/pitch_mm = 1: belongs to grid")));
  EXPECT_THAT(layout(R"({"taxels": [[1, 1], [1, 1]]})"), ElementsAre(HasSubstr("are in the same place")));
  EXPECT_THAT(layout(R"({"grid": [4096, 4096], "pitch_mm": 1})"),
              ElementsAre(HasSubstr("has 16777216 taxels; expected up to")));
}

TEST(Settings, WantAProfileInsteadOfALayout) {
  json document = with("/sensors/0/profile", "xela-xr1944");
  document["sensors"][0]["layout"] = {{"grid", {2, 2}}, {"pitch_mm", 1}};
  EXPECT_THAT(problems_of(document), ElementsAre(HasSubstr("/sensors/0/layout = ")));
}

TEST(Settings, ReplaceTheSkinOfAProfileKeyByKey) {
  const SkinInfo of_profile{0.02, 1e6, 0.4, 0.003, SkinBase::rigid};
  const auto skin_with = [&](const json& written) {
    json document = with("/sensors/0/profile", "xela-xr1944");
    if (!written.is_null()) document["sensors"][0]["skin"] = written;
    const Settings settings = parse(document);
    return settings.scene_of(settings.sensors.at(0), of_profile).skin;
  };
  const Skin own{0.02, 1e6, 0.4, 0.003, kUsualDepthSigma, SkinBase::rigid};
  EXPECT_EQ(skin_with(nullptr), own);
  EXPECT_EQ(skin_with(json::object()), own);
  Skin deep = own;
  deep.depth_m = 0.0015;
  EXPECT_EQ(skin_with({{"depth_mm", 1.5}}), deep) << "the line that sliplab skin prints";
  EXPECT_EQ(skin_with({{"radius_mm", "flat"},
                       {"modulus_mpa", 0.5},
                       {"poisson", 0.45},
                       {"depth_mm", {1, 1}},
                       {"base", "half_space"}}),
            (Skin{std::numeric_limits<double>::infinity(), 0.5e6, 0.45, 0.001, 0, SkinBase::half_space}))
      << "also where a value is the default of a sensor without a profile";
}

TEST(Settings, WantRangesThatRiseAndThresholdsInOrder) {
  json document = with("/objects", {{{"normal_n", {5, 1}}, {"poisson", {0.2, 0.2}}}, {{"weight", "x"}}});
  document["alerts"] = {{"warn_below", 0.3}, {"slip_below", 0.4}};
  EXPECT_THAT(problems_of(document),
              testing::UnorderedElementsAre(
                  HasSubstr("/objects/0/normal_n = [5,1]: falls"), HasSubstr("/objects/1/weight"),
                  HasSubstr("/alerts/slip_below = 0.4: is above warn_below = 0.3")));
}

TEST(Settings, TakeTheCostOfASlipOrItsSigmasButNotBoth) {
  const auto cost_with = [](const json& alerts) { return parse(with("/alerts", alerts)).alerts.cost; };
  EXPECT_EQ(cost_with({{"cost", 20}}), 20);
  EXPECT_NEAR(sigmas_for(cost_with({{"sigmas", 1.7}})), 1.7, 1e-9);
  EXPECT_THAT(problems_of(with("/alerts/sigmas", -1)), ElementsAre(HasSubstr("/alerts/sigmas")));
  EXPECT_THAT(problems_of(with("/alerts", {{"cost", 20}, {"sigmas", 1.7}})),
              ElementsAre(HasSubstr("/alerts/sigmas = 1.7: says again what \"cost\" says")));
}

TEST(Settings, PutAtMost31SensorsOnCAN) {
  json document = json::parse(kMinimal);
  for (int i = 0; i < 31; ++i)
    document["sensors"].push_back({{"name", "s" + std::to_string(i)}, {"driver", "sim"}});
  EXPECT_THAT(problems_of(document), testing::IsEmpty());
  document["can"] = {{"interface", "can0"}};
  EXPECT_THAT(problems_of(document), ElementsAre(HasSubstr("has 32 sensors; expected up to 31")));
  document["sensors"].erase(31);
  EXPECT_THAT(problems_of(document), testing::IsEmpty());
  document["grasps"] = {{{"name", "gripper"}, {"sensors", {"s0", "s1"}}}};
  EXPECT_THAT(problems_of(document), ElementsAre(HasSubstr("sensors and grasps are 32")));
}

TEST(Settings, KeepAllOfSlipdsIdentifiersWithinCANs) {
  const auto base = [](const json& id, bool extended) {
    return problems_of(with("/can", {{"interface", "can0"}, {"base_id", id}, {"extended", extended}}));
  };
  EXPECT_THAT(base("0x7C0", false), testing::IsEmpty());
  EXPECT_THAT(base(1984, false), testing::IsEmpty());
  EXPECT_THAT(base("0x7C1", false), ElementsAre(HasSubstr("/can/base_id = \"0x7C1\": leaves no room")));
  EXPECT_THAT(base("0x7C1", true), testing::IsEmpty());
  EXPECT_THAT(base("0x1FFFFFC0", true), testing::IsEmpty());
  EXPECT_THAT(base("0xFFFFFFFF", true), ElementsAre(HasSubstr("leaves no room")));
  const auto with_sliding = [](const json& id) {
    return problems_of(with("/can", {{"interface", "can0"}, {"base_id", id}, {"sliding", true}}));
  };
  EXPECT_THAT(with_sliding("0x7A0"), testing::IsEmpty());
  EXPECT_THAT(with_sliding("0x7A1"), ElementsAre(HasSubstr("leaves no room for slipd's 96 identifiers")));
}

TEST(Settings, CountASocketsPathInBytes) {
  std::string path = "/";
  for (int i = 0; i < 60; ++i) path += "é";
  EXPECT_THAT(problems_of(with("/socket/path", path)),
              ElementsAre(HasSubstr("has 121 bytes; expected up to 107")));
  EXPECT_THAT(problems_of(with("/socket/path", std::string("/a\0b", 4))),
              ElementsAre(HasSubstr("holds a zero byte")));
}

TEST(Settings, AreAnErrorAtLineAndColumnWhenTheTextIsNoJSON) {
  EXPECT_THAT(problems_of(std::string("{\n\"sensors\": [,]\n}")),
              ElementsAre(testing::StartsWith("t.json:2:13: syntax error")));
  EXPECT_THAT(problems_of(std::string("[]")), ElementsAre("t.json: / = []: is a list; expected an object"));
}

TEST(Settings, AreAnErrorWhenThereIsNoSuchFile) {
  FakeCatalogue drivers;
  EXPECT_THROW(load_settings("/nonexistent/slipd.json", drivers), SettingsError);
  EXPECT_THROW(load_settings("/", drivers), SettingsError);
  EXPECT_THROW(load_settings("/dev/zero", drivers), SettingsError);
}

}  // namespace
}  // namespace slipd::test
