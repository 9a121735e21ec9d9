/* A plugin of QEMU's user mode (docs/devel/tcg-plugins of QEMU): how many instructions of its own processor a program executes, as one
 * number in the file that out= names. Debian packages no header of this interface: what is used of version 1 is declared here. */
#include <inttypes.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

typedef uint64_t plugin_id;
struct qemu_plugin_tb;
enum { kInlineAdd = 0 };
void qemu_plugin_register_vcpu_tb_trans_cb(plugin_id id, void (*translated)(plugin_id, struct qemu_plugin_tb*));
void qemu_plugin_register_atexit_cb(plugin_id id, void (*ended)(plugin_id, void*), void* data);
void qemu_plugin_register_vcpu_tb_exec_inline(struct qemu_plugin_tb* block, int operation, void* counter, uint64_t operand);
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb* block);

#define EXPORTED __attribute__((visibility("default")))
EXPORTED int qemu_plugin_version = 1;
EXPORTED int qemu_plugin_install(plugin_id id, const void* info, int count, char** arguments);

static uint64_t executed; /* of a program of one thread */
static char out[4096];

static void add_block(plugin_id id, struct qemu_plugin_tb* block) {
  (void)id;
  qemu_plugin_register_vcpu_tb_exec_inline(block, kInlineAdd, &executed, qemu_plugin_tb_n_insns(block));
}

static void report(plugin_id id, void* data) {
  (void)id;
  (void)data;
  FILE* const file = fopen(out, "w");
  if (file == NULL) return;
  fprintf(file, "%" PRIu64 "\n", executed);
  fclose(file);
}

int qemu_plugin_install(plugin_id id, const void* info, int count, char** arguments) {
  (void)info;
  if (count != 1 || strncmp(arguments[0], "out=", 4) != 0 || strlen(arguments[0] + 4) >= sizeof out) {
    fputs("instruction_counter: give out=FILE\n", stderr);
    return 1;
  }
  strcpy(out, arguments[0] + 4);
  qemu_plugin_register_vcpu_tb_trans_cb(id, add_block);
  qemu_plugin_register_atexit_cb(id, report, NULL);
  return 0;
}
