// Lets what this process maps be in memory at once. The pages of the segments are all used when they are
// created. A page fault for each of them takes most of the daemon's start, and on some virtual machines a
// second.
#pragma once

#include <cstddef>

namespace sft::shm {

/// While it lives, all that any thread maps is in memory from the beginning, if the system lets this process
/// lock so much memory. If not, pages are mapped when they are used, as usual. At its end nothing is locked
/// any more.
class PopulatedMappings {
 public:
  /// `bytes`: of what will be mapped.
  explicit PopulatedMappings(std::size_t bytes);
  ~PopulatedMappings();
  PopulatedMappings(const PopulatedMappings&) = delete;
  PopulatedMappings& operator=(const PopulatedMappings&) = delete;

  bool is_allowed() const { return is_allowed_; }

 private:
  bool is_allowed_ = false;
};

}  // namespace sft::shm
