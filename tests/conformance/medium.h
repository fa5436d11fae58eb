// A medium, on which the conformance suite runs: a way for samples to travel between two nodes of this
// process.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <utility>

#include "core/seam/transport.h"

namespace sft::conformance {

/// The differences that transports may have in the same test (conformance.md says why they have them).
struct Traits {
  bool projects = true;  ///< a reader gets the fields that it asked for, or else the whole sample
  bool counts_before_first_taken = true;  ///< what a queue pushed out before anything was taken from it
  bool reliable = false;                  ///< readers ask for that
};

/// Something of shared memory, or of a network, used as what both have in common.
template <class Common, class OfMemory, class OfNetwork>
class Either {
 public:
  Either() = default;
  Either(std::unique_ptr<OfMemory> given)  // NOLINT(google-explicit-constructor)
      : memory_(given.get()), common_(std::move(given)) {}
  Either(std::unique_ptr<OfNetwork> given)  // NOLINT(google-explicit-constructor)
      : network_(given.get()), common_(std::move(given)) {}

  Common& operator*() const { return *common_; }
  Common* operator->() const { return common_.get(); }
  /// Null if it is the other one.
  OfMemory* memory() const { return memory_; }
  OfNetwork* network() const { return network_; }
  void reset() { *this = Either(); }

 private:
  OfMemory* memory_ = nullptr;
  OfNetwork* network_ = nullptr;
  std::unique_ptr<Common> common_;
};

using AnyTransport = Either<core::Transport, core::SharedMemory, core::Network>;
using AnyWriter = Either<core::WriterPort, core::LendingWriter, core::NetworkWriter>;
using AnyReader = Either<core::ReaderPort, core::BorrowingReader, core::NetworkReader>;

class Medium {
 public:
  virtual ~Medium() = default;
  /// The reason why the medium cannot be had here; empty if it can.
  virtual std::string refusal() { return {}; }
  virtual Traits traits() const { return {}; }

  /// A node's transport, ready. REQUIRES: no refusal.
  virtual AnyTransport open() = 0;
  /// The address of a reader that belongs to a node and waits at a doorbell.
  virtual core::Locator locator(const AnyTransport& node, const core::DoorbellAddress& bell) = 0;
};

struct MediumChoice {
  std::string name;
  std::function<std::unique_ptr<Medium>()> make;
};
/// Returns the name that GoogleTest prints.
inline std::string name_of(const testing::TestParamInfo<MediumChoice>& choice) { return choice.param.name; }
inline std::ostream& operator<<(std::ostream& out, const MediumChoice& choice) { return out << choice.name; }

}  // namespace sft::conformance
