// A valid profile is accepted unchanged; an invalid one is refused with the place.
#include "drivers/decode/profile.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "tests/drivers/driver_fixture.hpp"

namespace slipd::decode {
namespace {

using nlohmann::json;
using test::refusal_of;
using testing::HasSubstr;

json shipped(const std::string& name) {
  std::ifstream file(std::string(SLIPD_SOURCE_DIR) + "/config/profiles/" + name + ".json");
  return json::parse(file);
}

// The error about the XELA's profile after `change`.
std::string said_of(const std::function<void(json&)>& change, const std::string& name = "xela-xr1944") {
  json profile = shipped(name);
  change(profile);
  return refusal_of([&] { static_cast<void>(parse_profile(profile.dump(), "mine")); });
}

TEST(Profile, AllThatAreShippedCanWorkAndSayWhereTheyComeFrom) {
  const std::filesystem::path folder = std::string(SLIPD_SOURCE_DIR) + "/config/profiles";
  int seen = 0;
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    const std::string name = file.path().stem().string();
    EXPECT_EQ(refusal_of([&] { static_cast<void>(find_profile(name)); }), "") << name;
    EXPECT_FALSE(find_profile(name).tested.empty()) << name;
    ++seen;
  }
  EXPECT_GE(seen, 4);
}

TEST(Profile, ThatDoesNotExistIsAnErrorWithTheFoldersSearched) {
  EXPECT_THAT(refusal_of([] { static_cast<void>(find_profile("nobodys")); }),
              HasSubstr("/etc/slipd/profiles/nobodys.json"));
}

TEST(Profile, InWhichFieldsOverlapIsRefused) {
  EXPECT_THAT(said_of([](json& p) { p["scan"]["packets"][0]["fields"][1]["offset"] = 2; }),
              HasSubstr("mine.json: /scan/packets/0/fields = 2: is a byte of two fields"));
}

TEST(Profile, OfTaxelsThatDifferGivesEachItsGain) {
  json profile = shipped("xela-xr1944");
  profile["gain"] = json::array();
  for (int i = 0; i < 16; ++i) profile["gain"].push_back(1 + 0.1 * i);
  const Profile plain = find_profile("xela-xr1944"), calibrated = parse_profile(profile.dump(), "mine");
  for (std::size_t packet = 0; packet < plain.scan.size(); ++packet) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Field &before = plain.scan[packet].fields[i], &after = calibrated.scan[packet].fields[i];
      EXPECT_DOUBLE_EQ(after.gain_pa, before.gain_pa * (1 + 0.1 * static_cast<double>(before.taxel)));
    }
  }
  EXPECT_THAT(said_of([](json& p) {
                p["gain"] = {1, 1.1};
              }),
              HasSubstr("/gain = [1,1.1]: has 2 values; expected one for each of the 16 taxels"));
}

TEST(Profile, OfTaxelsWithoutPositionIsRefused) {
  EXPECT_THAT(said_of([](json& p) {
                p["layout"]["grid"] = {4, 3};
              }),
              HasSubstr("has 12 taxels, and a field speaks of taxel 12, which has no position"));
}

TEST(Profile, WithTaxelsThatNothingFillsIsRefused) {
  EXPECT_THAT(said_of([](json& p) { p["scan"]["repeat"] = 15; }), HasSubstr("taxel 15, normal, never comes"));
  EXPECT_THAT(said_of([](json& p) { p["scan"]["taxels_each"] = 0; }), HasSubstr("comes twice"));
}

TEST(Profile, ThatReadsBehindAPacketsEndIsRefused) {
  EXPECT_THAT(said_of([](json& p) { p["scan"]["packets"][0]["length"] = 6; }),
              HasSubstr("is a byte behind the packet's end"));
}

TEST(Profile, WithAmbiguousPacketsIsRefused) {
  EXPECT_THAT(said_of([](json& p) { p["scan"]["id_step"] = 0; }), HasSubstr("nothing to tell them apart"));
  EXPECT_THAT(said_of([](json& p) { p["scan"]["packets"][1].erase("match"); }, "icub-mtb"),
              HasSubstr("/scan/packets/1"));
}

TEST(Profile, WhoseTimeOutWouldLetTwoScansMixIsRefused) {
  EXPECT_THAT(said_of([](json& p) { p["scan"]["timeout_ms"] = 10; }), HasSubstr("/scan/timeout_ms = 10"));
}

TEST(Profile, ThatWantsMoreRegistersThanThereAreIsRefused) {
  EXPECT_THAT(said_of([](json& p) { p["modbus"]["registers"] = 280; }, "onrobot-rg2-ft"),
              HasSubstr("ends with register 282"));
}

TEST(Profile, ThatTakesOneAxisForTwoIsRefused) {
  EXPECT_THAT(said_of([](json& p) {
                p["axes"] = {{"x", "-z"}};
              }),
              HasSubstr("/axis = \"x\": is not among the axes"));
}

struct Contradiction {
  const char* profile;
  void (*change)(json&);
  const char* said;
};

TEST(Profile, ThatContradictsItselfIsRefusedWithThePlaceAndTheReason) {
  const Contradiction all[] = {
      {"xela-xr1944", [](json& p) { p["scan"]["packets"][0]["length"] = 65; }, "more than a CAN frame holds"},
      {"vendor-hid-8x8", [](json& p) { p["scan"]["packets"][0]["length"] = 256; },
       "more than a report holds"},
      {"vendor-hid-8x8", [](json& p) { p["scan"]["key_offset"] = 200; },
       "/scan/key_offset = 200: lies behind"},
      {"icub-mtb", [](json& p) { p["scan"]["packets"][0]["match"]["offset"] = 8; },
       "/match/offset = 8: lies behind"},
      {"xela-xr1944", [](json& p) { p["scan"]["packets"][0]["fields"][0]["sensor"] = 1; },
       "is no sensor of the device"},
      {"xela-xr1944", [](json& p) { p["scan"]["packets"][0]["fields"][0].erase("type"); },
       "expected offset and type, or usage"},
      {"xela-xr1944", [](json& p) { p["scan"]["packets"][0]["fields"][0]["scale_n"] = 1; },
       "expected either scale_pa or scale_n"},
      {"xela-xr1944", [](json& p) { p["layout"].erase("pitch_mm"); },
       "expected grid with pitch_mm, or taxels"},
      {"xela-xr1944",
       [](json& p) {
         p["layout"] = {{"taxels", {{0, 0}, {0, 0}}}};
       },
       "/layout"},
      {"robotiq-ft300", [](json& p) { p["layout"]["pitch_mm"] = 1; },
       "a wrench needs wrench_mm and nothing else"},
      {"onrobot-rg2-ft", [](json& p) { p.erase("modbus"); }, "/modbus: is missing"},
      {"onrobot-rg2-ft", [](json& p) { p["scan"]["packets"][0]["length"] = 53; },
       "no whole number of registers"},
      {"onrobot-rg2-ft", [](json& p) { p["scan"]["packets"][0]["length"] = 252; },
       "more than one request can have"},
      {"contactile-pts2",
       [](json& p) { p["stream"]["records"] = shipped("robotiq-tsf85")["stream"]["records"]; },
       "cannot be inside pts2"},
      {"icub-mtb", [](json& p) { p["scan"]["packets"][1]["match"]["mask"] = 127; },
       "/scan/packets/1/match/value = 128: has bits outside the mask 127, so no packet has it"},
      {"optoforce", [](json& p) { p["stream"]["checksum"]["at"] = 60; },
       "/stream/checksum = {…}: reaches out of a frame of 16 bytes"},
      {"optoforce", [](json& p) { p["stream"]["checksum"]["at"] = -1; }, "reaches out of a frame"},
      {"optoforce", [](json& p) { p["stream"]["checksum"]["from"] = -17; }, "reaches out of a frame"},
      {"anyskin",
       [](json& p) {
         p["stream"] = {{"begin", {1, 2}}, {"end", {3}}, {"length", 2}};
       },
       "/stream/length = 2: is shorter than begin and end together"},
      {"csv-force",
       [](json& p) {
         p["stream"]["end"] = {1, 2, 3};
         p["stream"]["longest"] = 2;
       },
       "/stream/longest = 2: is shorter than begin and end together"},
      {"3dconnexion", [](json& p) { p["scan"]["packets"][0]["id"] = 300; },
       "/scan/packets/0/id = 300: is the id in repetition 0; driver hid has ids up to 255"},
      {"3dconnexion",
       [](json& p) {
         p["start"] = {{{"id", 300}}};
       },
       "/start/0/id = 300: is no report id"},
      {"xela-xr1944", [](json& p) { p["scan"]["packets"][0]["id"] = "0x1FFFFFF1"; },
       "/scan/packets/0/id = 536870912: is the id in repetition 15; driver can has ids up to 536870911"},
      {"xela-xr1944", [](json& p) { p["scan"]["packets"][0]["id"] = "0xE0000001"; },
       "/scan/packets/0/id = \"0xE0000001\""},
      {"xela-xr1944", [](json& p) { p["start"][0]["id"] = "0xE0000001"; }, "/start/0/id = \"0xE0000001\""},
      {"optoforce", [](json& p) { p["usb"]["devices"][0]["vendor"] = "0x123404d8"; },
       "/usb/devices/0/vendor = \"0x123404d8\""},
      {"3dconnexion", [](json& p) { p["hid"]["product"] = 65536; }, "/hid/product = 65536"},
      {"optoforce", [](json& p) { p["usb"]["in"] = "0x181"; }, "/usb/in = \"0x181\""},
      {"optoforce", [](json& p) { p["usb"]["out"] = "0x81"; }, "/usb/out = \"0x81\""},
      {"optoforce",
       [](json& p) {
         p["usb"].erase("out");
         p["stop"] = {{{"bytes", {1}}}};
       },
       "/stop/0: has no endpoint to go to: name the device's in usb.out, or use control"},
  };
  for (const auto& [profile, change, said] : all)
    EXPECT_THAT(said_of(change, profile), HasSubstr(said)) << profile;
}

TEST(Profile, WithAKeyThatNobodyKnowsIsRefused) {
  EXPECT_THAT(said_of([](json& p) { p["rate_hz"] = "fast"; }), HasSubstr("/rate_hz"));
  EXPECT_THAT(said_of([](json& p) { p["scan"]["repeats"] = 3; }), HasSubstr("did you mean \"repeat\""));
}

TEST(Profile, ThatIsNoJsonIsRefusedWithItsLine) {
  EXPECT_THAT(refusal_of([] { static_cast<void>(parse_profile("{\n \"a\": }", "mine")); }),
              HasSubstr("mine.json:2:"));
}

TEST(Profile, MustBeOfTheDriverThatIsToUseIt) {
  SensorSetup setup = test::setup_of(TaxelLayout::wrench(0.01), json::object());
  setup.profile = "xela-xr1944";
  EXPECT_THAT(refusal_of([&] { static_cast<void>(profile_of({setup}, "modbus")); }),
              HasSubstr("is for driver can"));
  SensorSetup other = setup;
  other.profile = "icub-mtb";
  EXPECT_THAT(refusal_of([&] {
                static_cast<void>(profile_of({setup, other}, "can"));
              }),
              HasSubstr("give all of one device the same"));
  other.profile = "";
  EXPECT_THAT(refusal_of([&] { static_cast<void>(profile_of({other}, "can")); }),
              HasSubstr("needs a \"profile\""));
}

TEST(Profile, WhoseStreamDoesNotBringItsPacketsIsRefused) {
  EXPECT_THAT(said_of([](json& p) { p["scan"]["packets"][0]["length"] = 443; }, "contactile-pts2"),
              HasSubstr("is not what the stream brings: 444 bytes"));
  EXPECT_THAT(said_of([](json& p) { p["scan"]["packets"][0]["id"] = 80; }, "robotiq-tsf85"),
              HasSubstr("/scan/packets/0/length = 56: is of a packet that is no record"));
  EXPECT_THAT(said_of([](json& p) { p["stream"]["begin"] = json::array(); }, "robotiq-tsf85"),
              HasSubstr("/stream/begin"));
  EXPECT_THAT(said_of([](json& p) { p["stream"].erase("length_byte"); }, "robotiq-tsf85"),
              HasSubstr("expected length, or length_byte, or an end marker"));
  EXPECT_THAT(said_of([](json& p) {
                p["stream"] = {{"begin", {1}}, {"length", 7}};
              }),
              HasSubstr("is for drivers usb and serial"));
  EXPECT_THAT(said_of([](json& p) { p.erase("usb"); }, "robotiq-tsf85"), HasSubstr("/usb"));
}

TEST(Profile, WhoseClockReachesBehindItsPacketIsRefused) {
  EXPECT_THAT(said_of(
                  [](json& p) {
                    p["scan"]["packets"][0]["clock"] = {{"offset", 10}, {"type", "u32le"}};
                  },
                  "robotiq-ft300"),
              HasSubstr("reaches behind the packet's end"));
}

}  // namespace
}  // namespace slipd::decode
