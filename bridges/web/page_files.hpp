// The page's files, which are in the program. Any thread.
#pragma once

#include <span>
#include <string_view>

namespace slipd::web {

struct PageFile {
  // Path below "/".
  std::string_view path;
  // Of HTTP's Content-Type.
  std::string_view type;
  // Its bytes.
  std::string_view content;
};

// All of them.
std::span<const PageFile> page_files();
// Null: there is no such file.
const PageFile* page_file(std::string_view path);

}  // namespace slipd::web
