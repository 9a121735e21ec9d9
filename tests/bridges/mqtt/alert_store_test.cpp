#include "bridges/mqtt/alert_store.hpp"

#include <gmock/gmock.h>

#include <fstream>

#include "tests/support/temp_folder.hpp"

namespace slipd::mqtt {
namespace {

using testing::TempFolder;

AlertStore::MakePayload numbered() {
  return [](std::int64_t number, std::int64_t dropped) {
    return std::to_string(number) + "/" + std::to_string(dropped);
  };
}

std::vector<std::int64_t> all_of(AlertStore& store) {
  std::vector<std::int64_t> numbers;
  std::int64_t last = 0;
  while (const auto next = store.after(last)) numbers.push_back(last = next->number);
  return numbers;
}

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(AlertStore, KeepsOrderAndNumbersOverARestart) {
  const TempFolder folder;
  std::string series;
  {
    AlertStore store(folder.file("a.db"), 100);
    series = store.series();
    EXPECT_EQ(series.size(), 32U);
    for (int i = 1; i <= 3; ++i) EXPECT_EQ(store.append("t/" + std::to_string(i), numbered()), i);
    store.acknowledge(1);
  }
  AlertStore store(folder.file("a.db"), 100);
  EXPECT_EQ(store.series(), series);
  EXPECT_EQ(store.waiting(), 2);
  EXPECT_THAT(all_of(store), ElementsAre(2, 3));
  EXPECT_EQ(store.after(1)->topic, "t/2");
  EXPECT_EQ(store.append("t/4", numbered()), 4);
}

TEST(AlertStore, CountsTheAlertsOfTheLastHourOverARestart) {
  const TempFolder folder;
  constexpr std::int64_t kHour = std::int64_t{3600} * 1'000'000'000, kStart = 500 * kHour;
  {
    AlertStore store(folder.file("a.db"), 2);  // which drops, and counts all the same
    for (int i = 0; i < 6; ++i) store.append("t", numbered(), kStart + i * kHour / 4);
    store.append("t", numbered());  // an end
    for (int i = 1; i <= 7; ++i) store.acknowledge(i);
  }
  AlertStore store(folder.file("a.db"), 2);
  EXPECT_EQ(store.last_hour(kStart + 5 * kHour / 4), 4);
  EXPECT_EQ(store.last_hour(kStart + 2 * kHour), 1);
  EXPECT_EQ(store.last_hour(kStart + 3 * kHour), 0);
  EXPECT_EQ(store.last_hour(kStart), 0);  // the clock was set back; what is older was forgotten
}

TEST(AlertStore, RemembersWhichAlertOfATopicStandsOverARestart) {
  const TempFolder folder;
  {
    AlertStore store(folder.file("a.db"), 1);  // which drops, and remembers all the same
    for (const int stands : {1, 2}) store.append("left", numbered(), 1, stands);
    store.append("right", numbered(), 1, 1);
    store.append("right", numbered());  // its end
    for (int i = 1; i <= 4; ++i) store.acknowledge(i);
  }
  AlertStore store(folder.file("a.db"), 1);
  EXPECT_EQ(store.standing("left"), 2);
  EXPECT_EQ(store.standing("right"), 0);
  EXPECT_EQ(store.standing("nobody"), 0);
}

TEST(AlertStore, NeverUsesANumberTwice) {
  const TempFolder folder;
  {
    AlertStore store(folder.file("a.db"), 100);
    store.append("t", numbered());
    store.append("t", numbered());
    store.acknowledge(1);
    store.acknowledge(2);
  }
  AlertStore store(folder.file("a.db"), 100);
  EXPECT_THAT(all_of(store), IsEmpty());
  EXPECT_EQ(store.append("t", numbered()), 3);
}

TEST(AlertStore, DropsTheOldestOfAFullStoreAndCountsThem) {
  const TempFolder folder;
  {
    AlertStore store(folder.file("a.db"), 3);
    for (int i = 0; i < 5; ++i) store.append("t", numbered());
    EXPECT_THAT(all_of(store), ElementsAre(3, 4, 5));
    EXPECT_EQ(store.after(4)->payload, "5/2");
    EXPECT_EQ(store.dropped(), 2);
    EXPECT_EQ(store.waiting(), 3);
  }
  AlertStore store(folder.file("a.db"), 3);
  EXPECT_EQ(store.dropped(), 2);
}

TEST(AlertStore, AnAcknowledgedAlertMakesRoom) {
  const TempFolder folder;
  AlertStore store(folder.file("a.db"), 2);
  store.append("t", numbered());
  store.append("t", numbered());
  store.acknowledge(1);
  store.append("t", numbered());
  EXPECT_EQ(store.dropped(), 0);
  EXPECT_THAT(all_of(store), ElementsAre(2, 3));
}

TEST(AlertStore, BeginsANewSeriesIfTheFileIsDamaged) {
  const TempFolder folder;
  folder.write("a.db", "this is no database, and long enough to be looked at as one");
  AlertStore store(folder.file("a.db"), 10);
  EXPECT_TRUE(std::filesystem::exists(folder.file("a.db.damaged")));
  EXPECT_EQ(store.append("t", numbered()), 1);
}

TEST(AlertStore, SaysWhichFileItCannotUse) {
  try {
    AlertStore("/nowhere/a.db", 10);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("/nowhere/a.db"));
  }
}

// An error within the transaction stands for a disk that refuses.
TEST(AlertStore, CountsWhatTheDiskRefuses) {
  const TempFolder folder;
  AlertStore store(folder.file("a.db"), 10);
  store.append("t", numbered());
  EXPECT_EQ(store.append("t", [](auto, auto) -> std::string { throw std::runtime_error("no room"); }),
            std::nullopt);
  EXPECT_EQ(store.dropped(), 1);
  EXPECT_EQ(store.trouble(), "no room");
  EXPECT_EQ(store.append("t", numbered()), 2);
  EXPECT_THAT(all_of(store), ElementsAre(1, 2));
  EXPECT_EQ(store.trouble(), "");
}

}  // namespace
}  // namespace slipd::mqtt
