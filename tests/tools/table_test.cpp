#include "tools/slipctl/table.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace slipctl {
namespace {

using nlohmann::json;

TEST(Table, AlignsColumnsAndPutsNumbersToTheRight) {
  EXPECT_EQ(table({{"name", "gamma"}, {"left", "0.6"}, {"r", "–"}}),
            "name  gamma\n"
            "left    0.6\n"
            "r         –\n");
}

TEST(Table, ShowsWhatIsUnknownAsADash) {
  EXPECT_EQ(table_of({{{"name", "left"}, {"gamma", nullptr}}}, {"name", "gamma", "sigma"}),
            "name  gamma  sigma\n"
            "left      –      –\n");
}

TEST(Table, PrintsANestedAnswerAsATree) {
  const json status{{"uptime_s", 12.5},
                    {"sensors", {{{"name", "left"}, {"received", 7}, {"latency_us", {{"p50", 33.0}}}}}}};
  EXPECT_EQ(tree(status),
            "uptime_s  12.5\n"
            "sensors\n"
            "  left\n"
            "    received  7\n"
            "    latency_us\n"
            "      p50  33\n");
}

}  // namespace
}  // namespace slipctl
