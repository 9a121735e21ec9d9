#include "schema/settings_error.hpp"

#include <utility>

#include "schema/schema_words.hpp"

namespace slipd {

SettingsError::SettingsError(std::vector<std::string> problems)
    : std::runtime_error(joined(problems, "\n")), problems_(std::move(problems)) {}

}  // namespace slipd
