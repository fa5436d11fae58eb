// Measures how costs grow with masks and nodes, compared with Cyclone DDS in the same run.
// Hosts are network namespaces with an MTU of 1500. Unless a group says otherwise, the system chooses the
// cores of the processes.
#include "bench/common/program.h"
#include "bench/many/many.h"
#include "tests/support/isolated_host.h"

namespace {

void shorten(sft::bench::ManyScale& scale) {
  scale = {.quick = true, .rounds = 1, .settled_s = 10, .joining_s = 9, .window_s = 9};
}

}  // namespace

int main(int argc, char** argv) {
  using namespace sft::bench;
  ManyScale scale;
  Program program("How costs grow with masks and nodes, against references of the same run",
                  {{"masks_64", [&] { return masks_64(scale); }},
                   {"join_64", [&] { return join_64(scale); }},
                   {"growth", [&] { return growth(scale); }},
                   {"idle", [&] { return idle(scale); }}});
  program.options().add_flag_callback(
      "--quick", [&] { shorten(scale); }, "one short round of each contender");
  if (const auto code = program.parse(argc, argv)) return *code;
  return sft::test::run_isolated([&] { return program.run(); });
}
