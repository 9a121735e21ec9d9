#include "daemon/paper_loader.hpp"

#include <dlfcn.h>

#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>

#include "daemon/pipeline/module_file.hpp"

namespace slipd {
namespace {

const PaperModule& load() {
  const std::filesystem::path file = default_module_folder() / "slipd-paper.so";
  const std::string needs = "the methods svd-knn and registered need ";
  const std::string others = "; auto, moments, fit, block-fit and closing need nothing more";
  std::error_code error;
  if (!std::filesystem::exists(file, error))
    throw std::runtime_error(needs + "the package slipd-paper, which is not installed (" + file.string() +
                             "): install it" + others);
  const ModuleFile loaded = load_module_file(file);
  if (loaded.library == nullptr)
    throw std::runtime_error(needs + file.string() + ": " + loaded.trouble + others);
  using Entry = const PaperModule* (*)();
  const auto symbol = reinterpret_cast<Entry>(dlsym(loaded.library, kPaperSymbol));
  const PaperModule* const module = symbol != nullptr ? symbol() : nullptr;
  if (module == nullptr || module->abi != kPaperAbi || module->version != std::string_view(SLIPD_VERSION))
    throw std::runtime_error(needs + file.string() + " of the same version as slipd, " SLIPD_VERSION +
                             ": install the package slipd-paper of that version" + others);
  return *module;
}

}  // namespace

const PaperModule& paper_module() {
  static const PaperModule& module = load();  // tried again after an exception
  return module;
}

}  // namespace slipd
