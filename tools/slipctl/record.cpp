// `slipctl record`: reads the recording from the daemon and writes it into a file of the user's.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <iostream>
#include <system_error>

#include "tools/slipctl/client.hpp"
#include "tools/slipctl/commands.hpp"
#include "tools/slipctl/table.hpp"

namespace slipctl {
namespace {

UniqueFd open_new(const RecordOptions& options) {
  const int how = O_WRONLY | O_CREAT | O_CLOEXEC | (options.force ? O_TRUNC : O_EXCL);
  UniqueFd file(::open(options.out.c_str(), how, 0644));
  if (file.get() >= 0) return file;
  if (errno == EEXIST) throw ClientError(options.out + " is there already; --force writes over it");
  throw ClientError("cannot write " + options.out + ": " + std::generic_category().message(errno));
}

bool empty(const UniqueFd& file) {
  struct stat status {};
  return ::fstat(file.get(), &status) == 0 && S_ISREG(status.st_mode) && status.st_size == 0;
}

}  // namespace

void record(const CommonOptions& common, const RecordOptions& options) {
  RpcClient client(common.socket);  // before the file: without a daemon none is created
  const UniqueFd file = open_new(options);
  try {
    const nlohmann::ordered_json result = client.record(options.sensor, options.seconds, file.get());
    if (common.json)
      std::cout << result.dump() << '\n';
    else
      std::cout << options.sensor << " is recorded in " << options.out << '\n' << tree(result, 2);
    if (const auto& trouble = result.value("trouble", nlohmann::ordered_json()); trouble.is_string())
      throw ClientError(options.out + " is not whole: " + trouble.get<std::string>());
  } catch (const ClientError&) {
    if (empty(file)) ::unlink(options.out.c_str());
    throw;
  }
}

}  // namespace slipctl
