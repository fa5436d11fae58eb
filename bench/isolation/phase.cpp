#include "bench/isolation/phase.h"

namespace sft::bench::isolation {

std::string name_of(Phase phase) {
  switch (phase) {
    case Phase::alone:
      return "alone";
    case Phase::again:
      return "again";
    case Phase::joined:
      return "joined";
    case Phase::stalled:
      return "stalled";
    case Phase::lossy:
      return "lossy";
    case Phase::narrow:
      return "narrow";
    case Phase::killed:
      break;
  }
  return "killed";
}

}  // namespace sft::bench::isolation
