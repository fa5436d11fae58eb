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

/// Whether this process may lock so much memory, and as much beside it as the daemon leaves for others.
bool may_lock() {
  constexpr std::size_t all = bytes + (std::size_t{64} << 20);
  void* const mapped = ::mmap(nullptr, all, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  const bool may = ::mlock(mapped, all) == 0;
  ::munmap(mapped, all);
  return may;
}

TEST(PopulatedMappings, NeedNoPageFaultsWhereSoMuchMemoryMayBeLocked) {
  const bool may = may_lock();
  const long usual = faults_of_a_mapping();
  {
    const PopulatedMappings populated(bytes);
    EXPECT_EQ(populated.is_allowed(), may);
    const long faults = faults_of_a_mapping();
    if (may)
      EXPECT_LT(faults, usual / 10);
    else
      EXPECT_GT(faults, usual / 2) << "mappings are as usual";
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
