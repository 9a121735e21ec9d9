// The files in config/: the annotated default and the scenes.
#include <gmock/gmock.h>

#include <filesystem>

#include "schema/schema.hpp"
#include "tests/config/support.hpp"
#include "tests/config/violations.hpp"

namespace slipd::test {
namespace {

using nlohmann::json;

TEST(DefaultConfiguration, HasTheDefaultValuesOnly) {
  json written = parse_json_text(text_of("config/slipd.json")),
       minimal = json::parse(R"({"sensors": [{"name": "left", "driver": "sim"}]})");
  EXPECT_THAT(check(schema(), written), testing::IsEmpty());
  EXPECT_THAT(check(schema(), minimal), testing::IsEmpty());
  written.erase("$schema");
  for (auto* document : {&written, &minimal}) (*document)["sensors"] = nullptr;  // compared as settings below
  EXPECT_EQ(written, minimal);
}

// Its simulated sensor takes a tenth of the taxels and a fifth of the rate, so that it runs on any machine.
TEST(DefaultConfiguration, HasOneSimulatedSensorAsAMinimalOneHasButSmaller) {
  const Settings written = parse(text_of("config/slipd.json"));
  const Settings minimal = parse(std::string(R"({"sensors": [{"name": "left", "driver": "sim"}]})"));
  ASSERT_EQ(written.sensors.size(), 1U);
  const SensorSettings &a = written.sensors[0], &b = minimal.sensors[0];
  EXPECT_EQ(a.driver, b.driver);
  EXPECT_LE(a.setup.rate_hz, b.setup.rate_hz / 5);
  EXPECT_EQ(a.stale_after, b.stale_after);
  EXPECT_LE(a.setup.layout.size(), b.setup.layout.size() / 9);
  EXPECT_EQ(written.scene_of(a), minimal.scene_of(b));
  EXPECT_EQ(a.setup.options, b.setup.options);
}

TEST(DefaultConfiguration, ShowsEveryKeyWithItsMeaning) {
  const std::string text = text_of("config/slipd.json");
  for (const auto& path : survey(schema(), whole_document()).all) {
    EXPECT_THAT(text, testing::HasSubstr("\"" + path.substr(path.rfind('.') + 1) + "\":"));
  }
}

// The drivers of the source tree, by the options they describe there; none of them is loaded.
class SourceCatalogue : public DriverCatalogue {
 public:
  const DriverModule* find(const std::string& name) override {
    const std::string file = "drivers/" + name + "/options.json";
    if (!std::filesystem::exists(std::string(SLIPD_SOURCE_DIR) + "/" + file)) return nullptr;
    schema_ = text_of(file);
    module_.options_schema = schema_.c_str();
    return &module_;
  }
  std::string why_not(const std::string& name) override { return "no drivers/" + name + "/options.json"; }
  std::vector<std::string> names() override { return {}; }

 private:
  std::string schema_;
  DriverModule module_{kDriverAbi, "", "", nullptr, nullptr};
};

TEST(Scenes, AreAllValid) {
  int count = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::string(SLIPD_SOURCE_DIR) + "/config/scenes")) {
    SourceCatalogue drivers;
    EXPECT_NO_THROW(load_settings(entry.path(), drivers)) << entry.path();
    ++count;
  }
  EXPECT_GE(count, 4);
}

std::vector<std::string> problems_of_device(const std::string& driver, const nlohmann::json& device) {
  const nlohmann::json document{{"sensors", {{{"name", "left"}, {"driver", driver}, {"device", device}}}}};
  SourceCatalogue drivers;
  try {
    parse_settings(document.dump(), "t.json", drivers);
  } catch (const SettingsError& error) {
    return error.problems();
  }
  return {};
}

std::vector<std::string> mistaken(const std::string& key, const std::string& value,
                                  const std::string& meant) {
  return {"t.json: /sensors/0/device/" + key + " = " + value + ": is an unknown key; did you mean \"" +
          meant + "\"?"};
}

TEST(Devices, WithAMisspeltKeyAreRefused) {
  EXPECT_EQ(problems_of_device("modbus", {{"serial_line", "/dev/ttyUSB0"}, {"unti", 9}}),
            mistaken("unti", "9", "unit"));
  EXPECT_EQ(problems_of_device("serial", {{"path", "/dev/ttyUSB0"}, {"buad", 9600}}),
            mistaken("buad", "9600", "baud"));
  EXPECT_EQ(problems_of_device("usb", {{"serail", "123"}}), mistaken("serail", "\"123\"", "serial"));
  EXPECT_EQ(problems_of_device("hid", {{"paht", "/dev/hidraw0"}}),
            mistaken("paht", "\"/dev/hidraw0\"", "path"));
  EXPECT_EQ(problems_of_device("can", {{"interface", "can0"}, {"fro", "skin"}}),
            mistaken("fro", "\"skin\"", "for"));
}

TEST(Devices, TakeEveryKeyThatTheirDriverReadsAndOneForPeople) {
  using testing::IsEmpty;
  EXPECT_THAT(problems_of_device("modbus", {{"host", "h"}, {"port", 502}, {"unit", 9}, {"for", "a"}}),
              IsEmpty());
  EXPECT_THAT(problems_of_device("modbus", {{"serial_line", "l"}, {"baud", 19200}, {"unit", 9}}), IsEmpty());
  EXPECT_THAT(problems_of_device("serial", {{"path", "p"}, {"baud", 9600}, {"for", "a"}}), IsEmpty());
  EXPECT_THAT(problems_of_device("usb", {{"serial", "1"}, {"port", "1-2"}, {"for", "a"}}), IsEmpty());
  EXPECT_THAT(problems_of_device("hid", {{"serial", "1"}, {"path", "p"}, {"for", "a"}}), IsEmpty());
  EXPECT_THAT(problems_of_device("can", {{"interface", "can0"}, {"for", "a"}}), IsEmpty());
  EXPECT_THAT(problems_of_device("sim", {{"port", "bus"}}), IsEmpty()) << "it reads none, and takes any";
}

}  // namespace
}  // namespace slipd::test
