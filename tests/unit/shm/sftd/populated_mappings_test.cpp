// The daemon's mappings are in memory at once while it starts, where the system lets it lock so much.
#include "shm_transport/sftd/populated_mappings.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <cstddef>
#include <cstring>

namespace sft::shm {
namespace {

constexpr std::size_t bytes = std::size_t{16} << 20;

/// The page faults of this process for writing to all pages of a new mapping that is shared, as a segment is.
long faults_of_a_mapping() {
  void* const mapped = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  rusage before{}, after{};
  ::getrusage(RUSAGE_SELF, &before);
  std::memset(mapped, 1, bytes);
  ::getrusage(RUSAGE_SELF, &after);
  ::munmap(mapped, bytes);
  return after.ru_minflt - before.ru_minflt;
}

TEST(PopulatedMappings, NeedNoPageFaults) {
  const long usual = faults_of_a_mapping();
  {
    const PopulatedMappings populated(bytes);
    if (!populated.is_allowed()) GTEST_SKIP() << "this user may not lock so much memory";
    EXPECT_LT(faults_of_a_mapping(), usual / 10);
  }
  EXPECT_GT(faults_of_a_mapping(), usual / 2) << "nothing is populated any more";
}

TEST(PopulatedMappings, PopulateNothingIfSoMuchCannotBeMapped) {
  const PopulatedMappings populated(std::size_t{1} << 50);
  EXPECT_FALSE(populated.is_allowed()) << "so much cannot be mapped";
  EXPECT_GT(faults_of_a_mapping(), 100);
}

}  // namespace
}  // namespace sft::shm
