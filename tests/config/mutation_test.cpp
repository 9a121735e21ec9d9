// Random damage to configurations: the result is always Settings, or a SettingsError of printable lines.
#include <gmock/gmock.h>

#include <random>

#include "tests/config/support.hpp"

namespace slipd::test {
namespace {

using nlohmann::json;

class Damage {
 public:
  explicit Damage(unsigned seed) : random_(seed) {}

  std::size_t below(std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random_); }

  json anything() {
    static const std::vector<json> kThings{nullptr,
                                           true,
                                           0,
                                           -1,
                                           1,
                                           0.5,
                                           1e308,
                                           -1e308,
                                           5e-324,
                                           9223372036854775807,
                                           18446744073709551615U,
                                           "",
                                           "flat",
                                           "sim",
                                           "0x1FFFFFFF",
                                           "a\nb",
                                           "\x1b[2J",
                                           std::string(10000, 'x'),
                                           json::array(),
                                           json::object(),
                                           {1, 2},
                                           {5, 1},
                                           {{"grid", 1}},
                                           json::parse(std::string(60, '[') + std::string(60, ']')),
                                           json::array_t(2000, 1)};
    return kThings[below(kThings.size())];
  }

  void to(json& document) {
    const json flat = document.flatten();
    auto it = flat.begin();
    std::advance(it, static_cast<std::ptrdiff_t>(below(flat.size())));
    json::json_pointer at(it.key());
    for (std::size_t up = below(4); up > 0 && !at.empty() && !at.parent_pointer().empty(); --up)
      at.pop_back();
    if (at.empty()) return;
    json& parent = document[at.parent_pointer()];
    const json whole = document;
    switch (below(5)) {
      case 0:
        document[at] = anything();
        break;
      case 1:
        document[at] = whole;
        break;
      case 2:
        document[at] = whole[at.parent_pointer()];
        break;
      case 3:
        if (parent.is_object()) parent[at.back() + "s"] = anything();
        if (parent.is_array()) parent.push_back(anything());
        break;
      default:
        if (parent.is_object()) parent.erase(at.back());
        if (parent.is_array()) parent.erase(parent.size() - 1);
        break;
    }
  }

  void to(std::string& text) {
    const std::size_t at = below(text.size());
    switch (below(4)) {
      case 0:
        text[at] = static_cast<char>(below(256));
        break;
      case 1:
        text.erase(at, 1 + below(20));
        break;
      case 2:
        text.insert(at, text.substr(below(text.size()), 1 + below(40)));
        break;
      default:
        text.resize(at + 1);
        break;
    }
  }

 private:
  std::mt19937 random_;
};

void expect_plain_answer(const std::string& text, unsigned seed) {
  try {
    parse(text);
  } catch (const SettingsError& e) {
    ASSERT_FALSE(e.problems().empty()) << seed;
    for (const auto& line : e.problems()) {
      EXPECT_TRUE(line.starts_with("t.json:")) << seed << ": " << line;
      EXPECT_EQ(line.find_first_of("\n\r\x1b"), std::string::npos) << seed << ": " << line;
      EXPECT_LT(line.size(), 2000U) << seed;
    }
  } catch (const std::exception& e) {
    FAIL() << seed << ": " << e.what() << "\n" << text.substr(0, 2000);
  }
}

TEST(Mutations, OfTheDocumentEndInSettingsOrInErrorsThatNameAPlace) {
  for (unsigned seed = 0; seed < 500; ++seed) {
    Damage damage(seed);
    json document = whole_document();
    for (std::size_t n = 1 + damage.below(5); n > 0; --n) damage.to(document);
    expect_plain_answer(document.dump(), seed);
  }
}

TEST(Mutations, OfTheTextEndInSettingsOrInErrorsThatNameAPlace) {
  const std::string whole = text_of("config/slipd.json");
  for (unsigned seed = 0; seed < 500; ++seed) {
    Damage damage(seed);
    std::string text = whole;
    for (std::size_t n = 1 + damage.below(5); n > 0; --n) damage.to(text);
    expect_plain_answer(text, seed);
  }
}

}  // namespace
}  // namespace slipd::test
