// What is thrown for settings that cannot be used. Any thread that may allocate.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace slipd {

// All that is wrong with a settings file. what() is all problems, one a line.
class SettingsError : public std::runtime_error {
 public:
  // Each is one line: `FILE: /json/pointer = value: what is wrong, the range and unit`, or `FILE: what is
  // wrong` for the whole file.
  explicit SettingsError(std::vector<std::string> problems);
  const std::vector<std::string>& problems() const noexcept { return problems_; }

 private:
  std::vector<std::string> problems_;
};

}  // namespace slipd
