#include "bridges/mqtt/settings.hpp"

#include <gmock/gmock.h>
#include <stdlib.h>

#include "bridges/support/settings_file.hpp"
#include "embedded/slipd_mqtt_schema.hpp"

namespace slipd::mqtt {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

Settings settings_from(const std::string& text) {
  return settings_of(bridges::parse_settings(text, "mqtt.json", slipd_mqtt_schema, further_problems));
}

std::vector<std::string> problems_of(const std::string& text) {
  try {
    settings_from(text);
  } catch (const SettingsError& error) {
    return error.problems();
  }
  return {};
}

TEST(MqttSettings, TheShippedFileHasTheDefaults) {
  const auto shipped = settings_of(bridges::load_settings(SLIPD_SOURCE_DIR "/bridges/mqtt/mqtt.json",
                                                          slipd_mqtt_schema, further_problems));
  ASSERT_EQ(shipped.brokers.size(), 1U);
  EXPECT_EQ(shipped.brokers[0].host, "localhost");
  EXPECT_EQ(shipped.brokers[0].port, 1883);
  EXPECT_EQ(shipped.rate_hz, 10);
  EXPECT_EQ(shipped.max_alerts, 10'000);
  EXPECT_FALSE(shipped.host.empty());
}

TEST(MqttSettings, TlsChangesThePort) {
  const auto settings =
      settings_from(R"({"brokers": [{"host": "a", "tls": {}}, {"host": "b", "port": 1, "tls": {}}]})");
  EXPECT_EQ(settings.brokers[0].port, 8883);
  EXPECT_EQ(settings.brokers[1].port, 1);
  EXPECT_EQ(settings.brokers[0].tls->ca_file, "/etc/ssl/certs/ca-certificates.crt");
}

TEST(MqttSettings, APasswordIsNotSentInTheClearToAnotherHost) {
  EXPECT_THAT(problems_of(R"({"brokers": [{"host": "192.0.2.7", "user": "u", "password_file": "/p"}]})"),
              ElementsAre(HasSubstr("/brokers/0/password_file")));
  EXPECT_THAT(problems_of(R"({"brokers": [{"host": "127.0.0.1", "user": "u", "password_file": "/p"}]})"),
              ElementsAre());
  EXPECT_THAT(
      problems_of(R"({"brokers": [{"host": "192.0.2.7", "user": "u", "password_file": "/p", "tls": {}}]})"),
      ElementsAre());
}

TEST(MqttSettings, ACertificateNeedsItsKey) {
  EXPECT_THAT(problems_of(R"({"brokers": [{"host": "a", "tls": {"cert_file": "/c"}}]})"),
              ElementsAre(HasSubstr("/brokers/0/tls")));
}

TEST(MqttSettings, ANameWithoutASlashIsACredential) {
  setenv("CREDENTIALS_DIRECTORY", "/run/credentials/x", 1);
  const auto settings =
      settings_from(R"({"brokers": [{"host": "localhost", "user": "u", "password_file": "password"}]})");
  unsetenv("CREDENTIALS_DIRECTORY");
  EXPECT_EQ(settings.brokers[0].password_file, "/run/credentials/x/password");
}

TEST(MqttSettings, ATopicHasNoWildcards) {
  EXPECT_THAT(problems_of(R"({"brokers": [{"host": "a"}], "host": "a/+"})"), ElementsAre(HasSubstr("/host")));
  EXPECT_THAT(problems_of(R"({"brokers": [{"host": "a"}], "topic_prefix": "#"})"),
              ElementsAre(HasSubstr("/topic_prefix")));
}

}  // namespace
}  // namespace slipd::mqtt
