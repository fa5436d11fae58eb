// What the conformance suite is run on: a way for samples to travel between two nodes of this process.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <ostream>
#include <string>

#include "core/seam/transport.h"

namespace sft::conformance {

/// Where transports may differ in the same test (conformance.md says why they do).
struct Traits {
  bool projects = true;  ///< a reader gets the fields that it asked for, or else the whole sample
  bool counts_before_first_taken = true;  ///< what a queue pushed out before anything was taken from it
  bool reliable = false;                  ///< readers ask for that
};

class Medium {
 public:
  virtual ~Medium() = default;
  /// Why it cannot be had here; empty if it can.
  virtual std::string refusal() { return {}; }
  virtual Traits traits() const { return {}; }

  /// A node's transport, ready. REQUIRES: no refusal.
  virtual std::unique_ptr<core::Transport> open() = 0;
  /// Where a reader is reached that belongs to a node and waits at a doorbell.
  virtual core::Locator locator(const core::Transport& node, const core::DoorbellAddress& bell) = 0;
};

struct MediumChoice {
  std::string name;
  std::function<std::unique_ptr<Medium>()> make;
};
/// For GoogleTest.
inline std::string name_of(const testing::TestParamInfo<MediumChoice>& choice) { return choice.param.name; }
inline std::ostream& operator<<(std::ostream& out, const MediumChoice& choice) { return out << choice.name; }

}  // namespace sft::conformance
