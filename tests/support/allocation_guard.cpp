// Loaded before a program (LD_PRELOAD). Counts what its threads allocate and free, by the thread's name,
// once the test has armed it through a file that both map into memory.
#include "tests/support/allocation_guard.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);
}

namespace {

using slipd::testing::AllocationCounts;

AllocationCounts* counts = nullptr;

__attribute__((constructor)) void map_counts() {
  const char* const file = std::getenv(slipd::testing::kAllocationGuardFile);
  const int fd = file != nullptr ? open(file, O_RDWR | O_CLOEXEC) : -1;
  if (fd < 0) return;
  void* const memory = mmap(nullptr, sizeof(AllocationCounts), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  close(fd);
  if (memory != MAP_FAILED) counts = static_cast<AllocationCounts*>(memory);
}

void count() noexcept {
  if (counts == nullptr || !counts->armed.load()) return;
  char name[16] = {};
  prctl(PR_GET_NAME, name);
  if (std::strcmp(name, "estimate") == 0) {
    ++counts->estimate;
  } else if (std::strncmp(name, "acq:", 4) == 0) {
    ++counts->acquire;
  } else if (std::strcmp(name, "can") == 0) {
    ++counts->can;
  } else {
    ++counts->others;
  }
}

}  // namespace

extern "C" {

void* malloc(std::size_t size) {
  count();
  return __libc_malloc(size);
}
void* calloc(std::size_t number, std::size_t size) {
  count();
  return __libc_calloc(number, size);
}
void* realloc(void* old, std::size_t size) {
  count();
  return __libc_realloc(old, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  count();
  return __libc_memalign(alignment, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
  count();
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** result, std::size_t alignment, std::size_t size) {
  count();
  *result = __libc_memalign(alignment, size);
  return *result != nullptr ? 0 : ENOMEM;
}
void free(void* memory) {
  if (memory != nullptr) count();
  __libc_free(memory);
}

}  // extern "C"
