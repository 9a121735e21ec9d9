#include "bridges/support/settings_file.hpp"

#include <cerrno>
#include <fstream>
#include <system_error>
#include <utility>

#include "schema/json_text.hpp"

namespace slipd::bridges {

nlohmann::json parse_settings(std::string_view text, const std::string& name, std::string_view schema,
                              const FurtherCheck& further) {
  const nlohmann::json form = parse_json_text(schema);
  nlohmann::json settings;
  try {
    settings = parse_json_text(text);
  } catch (const JsonTextError& error) {
    throw SettingsError({error.located_in(name)});
  }
  std::vector<Problem> problems = check(form, settings);
  if (problems.empty() && further) problems = further(settings);
  if (problems.empty()) return settings;
  std::vector<std::string> lines;
  lines.reserve(problems.size());
  for (const Problem& problem : problems) lines.push_back(problem.in(name));
  throw SettingsError(std::move(lines));
}

nlohmann::json load_settings(const std::filesystem::path& file, std::string_view schema,
                             const FurtherCheck& further) {
  const std::string name = file.string();
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (error || !std::filesystem::exists(status))
    throw SettingsError(
        {name + ": cannot be read: " + (error ? error.message() : std::generic_category().message(ENOENT))});
  if (!std::filesystem::is_regular_file(status))  // a pipe might never end
    throw SettingsError({name + ": is no regular file; give the settings as one"});
  if (const auto bytes = std::filesystem::file_size(file, error); !error && bytes > kLargestSettings)
    throw SettingsError({name + ": is larger than 1 MiB, which no settings are"});
  std::ifstream in(file, std::ios::binary);
  errno = 0;
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (!in.is_open() || in.bad())
    throw SettingsError({name + ": cannot be read: " + std::generic_category().message(errno)});
  return parse_settings(text, name, schema, further);
}

}  // namespace slipd::bridges
