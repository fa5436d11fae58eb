// Looks at what sftd needs of the system and may lack, above all in containers. iceoryx would only say that
// some condition of its own does not hold.
#pragma once

#include <string>

namespace sft::shm {

/// The directories that sftd needs.
struct Surroundings {
  std::string proc = "/proc";
  std::string shm = "/dev/shm";
  std::string tmp = "/tmp";

  /// Returns a sentence about what is missing first, and what to do; empty if all is there.
  std::string lacking() const;
};

}  // namespace sft::shm
