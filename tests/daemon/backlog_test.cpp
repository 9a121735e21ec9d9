// The queue of a client: it keeps every answer, and the newest notifications.
#include "daemon/rpc/clients/backlog.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "daemon/rpc/protocol/owed_bytes.hpp"

namespace slipd {
namespace {

std::shared_ptr<const Notification> head(int number) {
  return std::make_shared<const Notification>(
      Notification{R"({"method":"estimate","params":{"seq":)" + std::to_string(number), number});
}

nlohmann::json params(const std::optional<std::string>& line) {
  EXPECT_EQ(line->back(), '\n');
  return nlohmann::json::parse(*line).at("params");
}

TEST(Backlog, DropsTheOldestNotificationsAndTheNextOneStatesTheirNumber) {
  Backlog backlog(3);
  for (int i = 0; i < 10; ++i) backlog.push_notification(head(i), 0);
  const auto first = params(backlog.next());
  EXPECT_EQ(first["seq"], 7);
  EXPECT_EQ(first["dropped"], 7);
  EXPECT_EQ(params(backlog.next())["dropped"], 0);
  EXPECT_EQ(params(backlog.next())["seq"], 9);
  EXPECT_FALSE(backlog.next());
  EXPECT_EQ(backlog.dropped(), 7U);
}

TEST(Backlog, NeverLosesAnAnswerAndKeepsTheOrder) {
  Backlog backlog(1);
  backlog.push_response("a");
  backlog.push_notification(head(1), 0);
  backlog.push_response("b");
  backlog.push_notification(head(2), 0);
  EXPECT_EQ(backlog.next(), "a\n");
  EXPECT_EQ(backlog.next(), "b\n");
  EXPECT_EQ(params(backlog.next())["seq"], 2);
  EXPECT_TRUE(backlog.empty());
}

TEST(OwedBytes, AreOwedToOneAndToAllUntilTheyAreSettled) {
  OwedBytes all;
  {
    const auto one = std::make_shared<OwedBytes>(&all);
    OwedBytes other(&all);
    other.add(5);
    OwedPart promised(one, 100);
    promised.grow(10);
    OwedPart moved = std::move(promised);
    EXPECT_EQ(one->bytes(), 110U);
    EXPECT_EQ(all.bytes(), 115U);
    moved = {};
    EXPECT_EQ(one->bytes(), 0U);
    EXPECT_EQ(all.bytes(), 5U);
    one->add(7);
    one->settle(3);
    EXPECT_EQ(all.bytes(), 9U);
  }
  EXPECT_EQ(all.bytes(), 0U) << "of clients that are gone nothing is owed";
}

TEST(Backlog, SentPlusDroppedIsTheTotal) {
  Backlog backlog(4);
  std::uint64_t delivered = 0;
  std::uint64_t dropped = 0;
  constexpr int kAll = 1000;
  for (int i = 0; i < kAll; ++i) {
    backlog.push_notification(head(i), i % 10 == 0 ? 2 : 0);  // some were lost before the queue
    if (i % 7 == 0) {
      dropped += params(backlog.next())["dropped"].get<std::uint64_t>();
      ++delivered;
    }
  }
  while (const auto line = backlog.next()) {
    dropped += params(line)["dropped"].get<std::uint64_t>();
    ++delivered;
  }
  EXPECT_EQ(delivered + dropped, kAll + 2 * kAll / 10);
  EXPECT_EQ(dropped, backlog.dropped());
}

}  // namespace
}  // namespace slipd
