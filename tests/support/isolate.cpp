// isolate PROGRAM [ARGUMENT...]: runs the program on an isolated host.
#include <unistd.h>

#include <cstdio>

#include "tests/support/isolated_host.h"

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  return sft::test::run_isolated([&] {
    execv(argv[1], argv + 1);
    std::perror(argv[1]);
    return 127;
  });
}
