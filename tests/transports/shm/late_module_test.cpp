// Programs that load SFT at run time. The tests check if iceoryx then calls the functions that SFT replaces.
// Each case is a process of its own, because libraries stay loaded.
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <string>

namespace sft::test {
namespace {

void* load(const char* file) {
  void* const library = dlopen(file, RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) std::fprintf(stderr, "%s\n", dlerror());
  return library;
}

/// Loads SFT, and ends the process with 0 if iceoryx calls the functions of SFT. Otherwise prints SFT's
/// report about shared memory, and ends the process with 1.
[[noreturn]] void load_sft() {
  void* const module = load(LATE_MODULE);
  if (module == nullptr) std::_Exit(2);
  const auto replaced = reinterpret_cast<bool (*)()>(dlsym(module, "functions_are_replaced"));
  const auto shared_memory = reinterpret_cast<const char* (*)()>(dlsym(module, "shared_memory"));
  if (replaced()) std::_Exit(0);
  std::fprintf(stderr, "%s\n", shared_memory());
  std::_Exit(1);
}

class LateModule : public ::testing::Test {
 protected:
  LateModule() { GTEST_FLAG_SET(death_test_style, "threadsafe"); }
};

TEST_F(LateModule, ReplacesTheFunctionsIfIceoryxComesWithIt) {
  EXPECT_EXIT(load_sft(), ::testing::ExitedWithCode(0), "");
}

TEST_F(LateModule, UsesNoSharedMemoryAndSaysWhyIfIceoryxWasLoadedBefore) {
  const auto load_both = [] {
    if (load("libiceoryx_posh.so.2") == nullptr) std::_Exit(2);
    load_sft();
  };
  EXPECT_EXIT(load_both(), ::testing::ExitedWithCode(1), "has loaded iceoryx before SFT.*LD_PRELOAD");
}

}  // namespace
}  // namespace sft::test
