// Checks the system for what sftd needs and may lack, above all in containers. iceoryx would only report
// that some condition of its own does not hold.
#pragma once

#include <string>

namespace sft::shm {

/// The directories that sftd needs.
struct Surroundings {
  std::string proc = "/proc";
  std::string shm = "/dev/shm";
  std::string tmp = "/tmp";

  /// Returns a sentence about the first thing that is missing, and what to do; empty if nothing is missing.
  std::string lacking() const;
};

}  // namespace sft::shm
