// Requests and answers as text, without a socket.
#include "daemon/rpc/protocol/rpc.hpp"

#include <gtest/gtest.h>

#include <random>

#include "daemon/rpc/protocol/plain_request.hpp"

namespace slipd::rpc {
namespace {

using nlohmann::json;

int code_of(const std::string& text) {
  return json::parse(text).at("error").at("code");
}

TEST(Rpc, ARequestIsReadWithItsParameters) {
  const Line line = parse(R"({"jsonrpc":"2.0","id":3,"method":"gamma","params":{"sensor":"left"}})");
  ASSERT_EQ(line.requests.size(), 1U);
  EXPECT_FALSE(line.batch);
  EXPECT_EQ(line.requests[0].method, "gamma");
  EXPECT_EQ(line.requests[0].id, "3");
  EXPECT_EQ(line.requests[0].params["sensor"], "left");
  EXPECT_FALSE(line.requests[0].notification);
}

TEST(Rpc, NestingIsAllowedUpToItsLimitAndBracketsInStringsDoNotCount) {
  const auto nested = [](int depth) { return std::string(depth, '[') + std::string(depth, ']'); };
  EXPECT_TRUE(parse(nested(kDeepestNesting)).error_response.empty());
  EXPECT_EQ(code_of(parse(nested(kDeepestNesting + 1)).error_response), kParseError);
  const std::string text = R"({"jsonrpc":"2.0","id":"\"[[","method":")" + std::string(1000, '[') + "\"}";
  EXPECT_TRUE(parse(text).error_response.empty());
}

TEST(Rpc, AnyBytesGetAnAnswerInJson) {
  std::mt19937 random(1);
  const std::string good =
      R"([{"jsonrpc":"2.0","id":1,"method":"gamma","params":{"sensor":"left"}},{"a":[1e5,"\u00e9"]}])";
  for (int i = 0; i < 20000; ++i) {
    std::string text = good;
    for (std::uint32_t changes = random() % 4 + 1; changes > 0; --changes) {
      text[random() % text.size()] = static_cast<char>(random());
    }
    const Line line = parse(text);
    ASSERT_TRUE(!line.error_response.empty() || !line.requests.empty());
    if (!line.error_response.empty()) {
      ASSERT_TRUE(json::accept(line.error_response)) << line.error_response;
    }
    for (const Request& request : line.requests) {
      if (request.error_response && !request.error_response->empty()) {
        ASSERT_TRUE(json::accept(*request.error_response));
      }
      ASSERT_TRUE(json::accept(error_text(request.id, 1, request.method)));
    }
  }
}

TEST(Rpc, CommonRequestsTakeTheFastParser) {
  for (const char* text : {R"({"jsonrpc":"2.0","id":1,"method":"gamma"})",
                           R"({"jsonrpc": "2.0", "id": 0, "method": "gamma", "params": {}})",
                           R"({"method":"gamma","params":{"sensor":"left"},"id":"a-7","jsonrpc":"2.0"} )"}) {
    ASSERT_TRUE(plain_request(text)) << text;
    EXPECT_EQ(plain_request(text)->method, "gamma");
  }
  EXPECT_EQ(plain_request(R"({"jsonrpc":"2.0","id":"a-7","method":"gamma"})")->id, "\"a-7\"");
}

TEST(Rpc, TheFastParserAgreesWithTheFullOne) {
  std::mt19937 random(2);
  const std::string pieces[] = {"{",
                                "}",
                                "\"",
                                ":",
                                ",",
                                "\"id\"",
                                "\"method\"",
                                "\"jsonrpc\"",
                                "\"2.0\"",
                                "1",
                                "01",
                                "1e3",
                                "-1",
                                "1.5",
                                "null",
                                "\"params\"",
                                "{\"a\":\"b\"}",
                                "\"\\u0041\"",
                                "\"\xC3\xA9\"",
                                "[]",
                                " ",
                                "\t",
                                "9999999999999999999"};
  const std::string good = R"({"jsonrpc":"2.0","id":12,"method":"gamma","params":{"sensor":"left","x":"y"}})";
  int plain = 0;
  for (int i = 0; i < 200'000; ++i) {
    std::string text = good;
    for (std::uint32_t changes = random() % 3; changes > 0; --changes) {
      const std::size_t at = random() % text.size(), length = random() % 12;
      switch (random() % 3) {
        case 0:
          text[at] = static_cast<char>(random());
          break;
        case 1:
          text.replace(at, length, pieces[random() % std::size(pieces)]);
          break;
        default:  // a member twice, or at another place
          text.insert(at, text.substr(random() % text.size(), random() % 30));
      }
    }
    const auto request = plain_request(text);
    if (!request) continue;
    ++plain;
    const Line line = parse("\n" + text);  // the same JSON, which the fast parser does not accept
    ASSERT_TRUE(line.error_response.empty()) << text;
    ASSERT_EQ(line.requests.size(), 1U) << text;
    ASSERT_FALSE(line.requests[0].error_response) << text;
    ASSERT_FALSE(line.requests[0].notification) << text;
    ASSERT_EQ(request->method, line.requests[0].method) << text;
    ASSERT_EQ(request->id, line.requests[0].id) << text;
    ASSERT_EQ(request->params, line.requests[0].params) << text;
  }
  EXPECT_GT(plain, 50'000);
}

TEST(Rpc, ABatchHasALimit) {
  const auto batch = [](std::size_t count) { return json(std::vector<int>(count, 1)).dump(); };
  EXPECT_TRUE(parse(batch(kLargestBatch)).error_response.empty());
  EXPECT_EQ(code_of(parse(batch(kLargestBatch + 1)).error_response), kInvalidRequest);
}

TEST(Rpc, ABatchIsHandedOnWhenItsLastAnswerHasCome) {
  std::string all = "not yet";
  const auto answers = std::make_shared<Responses>(true, 3, [&](std::string text) { all = std::move(text); });
  Request asked;
  asked.id = "1";
  Request notification;
  notification.notification = true;
  Reply(notification, answers).result(true);
  Reply(asked, answers).result(2);
  EXPECT_EQ(all, "not yet");
  asked.id = "2";
  Reply(asked, answers).error(kNotPossible, "no");
  EXPECT_EQ(json::parse(all).size(), 2U);
}

TEST(Rpc, ABatchOfNotificationsHasNoAnswer) {
  std::string all = "not yet";
  Responses answers(true, 2, [&](std::string text) { all = std::move(text); });
  answers.add("");
  answers.add("");
  EXPECT_EQ(all, "");
}

}  // namespace
}  // namespace slipd::rpc
