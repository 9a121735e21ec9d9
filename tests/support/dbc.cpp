#include "tests/support/dbc.hpp"

#include <regex>
#include <sstream>
#include <stdexcept>

namespace slipd::testing {
namespace {

constexpr std::uint32_t kExtendedMark = 0x80000000;

class Reader {
 public:
  std::map<std::uint32_t, DbcMessage> read(const std::string& text) {
    std::istringstream in(text);
    for (line_ = 0; std::getline(in, text_);) {
      ++line_;
      statement();
    }
    return std::move(messages_);
  }

 private:
  bool matches(const char* pattern) { return std::regex_match(text_, found_, std::regex(pattern)); }
  bool begins(const char* word) const { return text_.starts_with(word); }

  DbcMessage& message() {
    const auto id = static_cast<std::uint32_t>(std::stoul(found_[1])) & ~kExtendedMark;
    const auto known = messages_.find(id);
    if (known == messages_.end()) wrong("speaks of a message that is not there");
    return known->second;
  }
  DbcSignal& signal() {
    DbcMessage& in = message();
    const auto known = in.signals.find(found_[2]);
    if (known == in.signals.end()) wrong("speaks of a signal that is not there");
    return known->second;
  }
  [[noreturn]] void wrong(const char* why) const {
    throw std::runtime_error("DBC, line " + std::to_string(line_) + " " + why + ": " + text_);
  }

  void statement() {
    if (begins("BO_ ")) {
      if (!matches(R"(BO_ (\d+) (\w+): (\d+) (\w+))")) wrong("is no message");
      const auto id = static_cast<std::uint32_t>(std::stoul(found_[1]));
      last_ = &messages_[id & ~kExtendedMark];
      if (!last_->name.empty()) wrong("has an identifier that another message has");
      last_->id = id & ~kExtendedMark;
      last_->extended = (id & kExtendedMark) != 0;
      last_->name = found_[2];
      last_->length = static_cast<unsigned>(std::stoul(found_[3]));
    } else if (begins(" SG_ ")) {
      if (!matches(
              R"re( SG_ (\w+) : (\d+)\|(\d+)@([01])([+-]) \(([^,]+),([^)]+)\) \[([^|]+)\|([^\]]+)\] "([^"]*)" \w+)re"))
        wrong("is no signal");
      const auto number = [&](std::size_t i) { return std::stod(found_[i]); };
      last_->signals[found_[1]] = {.start = static_cast<unsigned>(number(2)),
                                   .length = static_cast<unsigned>(number(3)),
                                   .little_endian = found_[4] == "1",
                                   .is_signed = found_[5] == "-",
                                   .scale = number(6),
                                   .offset = number(7),
                                   .low = number(8),
                                   .high = number(9),
                                   .unit = found_[10],
                                   .comment = {},
                                   .values = {}};
    } else if (matches(R"re(CM_ BO_ (\d+) "([^"]*)";)re")) {
      message().comment = found_[2];
    } else if (matches(R"re(CM_ SG_ (\d+) (\w+) "([^"]*)";)re")) {
      signal().comment = found_[3];
    } else if (matches(R"re(BA_ "(\w+)" BO_ (\d+) (-?\d+);)re")) {
      const std::string name = found_[1];
      const int value = std::stoi(found_[3]);
      const auto known = messages_.find(static_cast<std::uint32_t>(std::stoul(found_[2])) & ~kExtendedMark);
      if (known == messages_.end()) wrong("speaks of a message that is not there");
      known->second.attributes[name] = value;
    } else if (begins("VAL_ ")) {
      if (!matches(R"re(VAL_ (\d+) (\w+)((?: \d+ "[^"]*")+) ;)re")) wrong("is no value table");
      DbcSignal& of = signal();
      const std::string table = found_[3];
      const std::regex entry(R"re((\d+) "([^"]*)")re");
      for (std::sregex_iterator each(table.begin(), table.end(), entry), end; each != end; ++each)
        of.values[std::stoull((*each)[1])] = (*each)[2];
    } else if (begins("CM_ SG_") || begins("CM_ BO_") || begins("BA_ ")) {
      wrong("is not understood");
    }
  }

  std::map<std::uint32_t, DbcMessage> messages_;
  DbcMessage* last_ = nullptr;
  std::string text_;
  std::smatch found_;
  int line_ = 0;
};

}  // namespace

std::uint64_t DbcSignal::raw(const std::array<std::uint8_t, 8>& data) const {
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < data.size(); ++i) bits |= std::uint64_t{data[i]} << (8 * i);
  return (bits >> start) & ((std::uint64_t{1} << length) - 1);
}

std::map<std::uint32_t, DbcMessage> read_dbc(const std::string& text) {
  return Reader().read(text);
}

}  // namespace slipd::testing
