#include "bridges/web/request_rules.hpp"

#include <gtest/gtest.h>

namespace slipd::web {
namespace {

RequestHead asks(std::string_view target, std::string_view host = "127.0.0.1:8077") {
  RequestHead head;
  head.method = "GET";
  head.target = target;
  head.host = host;
  return head;
}

RequestRules rules(std::string token = {}) {
  return {host_names("127.0.0.1", true, 8077, {"gripper.example"}), std::move(token)};
}

Refusal judged(const RequestRules& rules, const RequestHead& head) {
  return rules.judge(head, route_of(head.target));
}

TEST(Routes, LeadToEachPart) {
  EXPECT_EQ(route_of("/").part, Part::page);
  EXPECT_EQ(route_of("/").name, "index.html");
  EXPECT_EQ(route_of("/app.js?x").name, "app.js");
  EXPECT_EQ(route_of("/live").part, Part::live);
  EXPECT_EQ(route_of("/api/recordings").part, Part::recordings);
  EXPECT_EQ(route_of("/api/method").part, Part::method);
  EXPECT_EQ(route_of("/api/counts").part, Part::counts);
  EXPECT_EQ(route_of("/recordings/a%20b.rec").name, "a b.rec");
  EXPECT_EQ(route_of("/?token=abc").token, "abc");
}

TEST(Routes, NeverLeadOutOfAFolder) {
  for (const char* target :
       {"", "x", "*", "http://x/", "/..", "/a/b", "/recordings/", "/recordings/../a", "/recordings/..%2fa",
        "/recordings/%2e%2e", "/recordings/.a", "/recordings/a%5cb", "/recordings/a%00", "/recordings/a%",
        "/recordings/a%4", "/recordings/a%zz", "/a\x7f"})
    EXPECT_EQ(route_of(target).part, Part::nothing) << target;
  EXPECT_EQ(route_of("/" + std::string(600, 'a')).part, Part::nothing);
}

TEST(Rules, ServeOwnNamesOnly) {
  for (const char* own : {"127.0.0.1:8077", "localhost:8077", "LocalHost:8077", "gripper.example"})
    EXPECT_EQ(judged(rules(), asks("/", own)), Refusal::none) << own;
  for (const char* other :
       {"", "127.0.0.1", "127.0.0.1:80", "evil.example", "gripper.example.evil", "127.0.0.1:8077 "})
    EXPECT_EQ(judged(rules(), asks("/", other)), Refusal::host) << other;
}

TEST(Rules, RefusePagesOfOtherSites) {
  RequestHead head = asks("/live");
  head.upgrade = true;
  EXPECT_EQ(judged(rules(), head), Refusal::none);
  for (const char* own : {"http://127.0.0.1:8077", "https://gripper.example"}) {
    head.origin = own;
    EXPECT_EQ(judged(rules(), head), Refusal::none) << own;
  }
  for (const char* other :
       {"", "null", "http://evil.example", "http://127.0.0.1:80", "ws://127.0.0.1:8077", "127.0.0.1:8077"}) {
    head.origin = other;
    EXPECT_EQ(judged(rules(), head), Refusal::origin) << other;
  }
}

TEST(Rules, ReadOnly) {
  for (const char* method : {"POST", "PUT", "DELETE", "OPTIONS", "get", ""}) {
    RequestHead head = asks("/");
    head.method = method;
    EXPECT_EQ(judged(rules(), head), Refusal::method) << method;
  }
}

TEST(Rules, OnlyTheWebSocketIsUpgraded) {
  EXPECT_EQ(judged(rules(), asks("/live")), Refusal::upgrade);
  RequestHead head = asks("/");
  head.upgrade = true;
  EXPECT_EQ(judged(rules(), head), Refusal::upgrade);
}

TEST(Rules, AskForTheTokenOfEverything) {
  const RequestRules closed = rules("0123456789abcdef");
  for (const char* target :
       {"/", "/live", "/api/counts", "/nothing/at/all", "/?token=0123456789abcdeF", "/?token="})
    EXPECT_EQ(judged(closed, asks(target)), Refusal::token) << target;
  EXPECT_EQ(judged(closed, asks("/?token=0123456789abcdef")), Refusal::none);
  EXPECT_EQ(closed.cookie("127.0.0.1:8077"), "slipd-token-8077=0123456789abcdef");
  for (const char* cookie :
       {"slipd-token-8077=0123456789abcdef", "a=b; slipd-token-8077=0123456789abcdef; c=d"}) {
    RequestHead head = asks("/");
    head.cookie = cookie;
    EXPECT_EQ(judged(closed, head), Refusal::none) << cookie;
  }
  for (const char* cookie : {"slipd-token-8077=0123456789abcde", "slipd-token-8077=0123456789abcdef0",
                             "x-slipd-token-8077=0123456789abcdef", ";;;", "slipd-token-8077"}) {
    RequestHead head = asks("/");
    head.cookie = cookie;
    EXPECT_EQ(judged(closed, head), Refusal::token) << cookie;
  }
  RequestHead head = asks("/");
  head.authorization = "Bearer 0123456789abcdef";
  EXPECT_EQ(judged(closed, head), Refusal::none);
}

TEST(Rules, TheCookieIsThatOfTheHostsPort) {
  const RequestRules two{host_names("::1", true, 80, {"gripper.example", "[::1]:8078"}), "0123456789abcdef"};
  const auto admits = [&](const char* host, const char* cookie) {
    RequestHead head = asks("/", host);
    head.cookie = cookie;
    return judged(two, head) == Refusal::none;
  };
  EXPECT_TRUE(admits("[::1]:8078", "slipd-token-8078=0123456789abcdef"));
  EXPECT_TRUE(admits("[::1]:8078", "slipd-token-8077=fedcba9876543210; slipd-token-8078=0123456789abcdef"));
  EXPECT_TRUE(admits("[::1]", "slipd-token=0123456789abcdef"));
  EXPECT_TRUE(admits("gripper.example", "slipd-token=0123456789abcdef"));
  EXPECT_FALSE(admits("[::1]:8078", "slipd-token-8077=0123456789abcdef"));
  EXPECT_FALSE(admits("[::1]:8078", "slipd-token=0123456789abcdef"));
  EXPECT_FALSE(admits("gripper.example", "slipd-token-8078=0123456789abcdef"));
}

TEST(Rules, AHostOfSixWordsIsInBrackets) {
  const RequestRules six{host_names("::1", true, 80, {}), {}};
  EXPECT_EQ(judged(six, asks("/", "[::1]:80")), Refusal::none);
  EXPECT_EQ(judged(six, asks("/", "[::1]")), Refusal::none);
  EXPECT_EQ(judged(six, asks("/", "localhost")), Refusal::none);
}

}  // namespace
}  // namespace slipd::web
