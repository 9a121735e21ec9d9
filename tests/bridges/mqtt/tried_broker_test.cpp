#include "bridges/mqtt/tried_broker.hpp"

#include <gtest/gtest.h>

#include "tests/support/temp_folder.hpp"

namespace slipd::mqtt {
namespace {

using testing::TempFolder;

TEST(TriedBroker, IsNoneAtFirstAndAfterAnOrderlyEnd) {
  const TempFolder folder;
  for (int start = 0; start < 2; ++start) {
    TriedBroker tried(folder.file("a.broker"));
    EXPECT_FALSE(tried.left_behind());
    tried.note("one:1883");
  }
}

TEST(TriedBroker, IsTheLastOneThatWasNotedBeforeAnEndThatWasNotMeant) {
  const TempFolder folder;
  EXPECT_EXIT(
      {
        TriedBroker tried(folder.file("a.broker"));
        tried.note("one:1883");
        tried.note("two:1883");
        std::abort();
      },
      ::testing::KilledBySignal(SIGABRT), "");
  EXPECT_EQ(TriedBroker(folder.file("a.broker")).left_behind(), "two:1883");
}

TEST(TriedBroker, IsWrittenOnceHoweverOftenItIsTried) {
  const TempFolder folder;
  const auto file = folder.file("a.broker");
  TriedBroker tried(file);
  tried.note("one:1883");
  std::filesystem::remove(file);
  tried.note("one:1883");
  EXPECT_FALSE(std::filesystem::exists(file));
  tried.note("two:1883");
  EXPECT_TRUE(std::filesystem::exists(file));
}

TEST(TriedBroker, IsNotRememberedWhereTheFileCannotBeWritten) {
  TriedBroker tried("/nowhere/a.broker");
  tried.note("one:1883");
  EXPECT_FALSE(TriedBroker("/nowhere/a.broker").left_behind());
}

}  // namespace
}  // namespace slipd::mqtt
