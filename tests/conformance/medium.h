// A medium on which the conformance suite runs. The medium carries samples between two nodes of this process.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <utility>

#include "core/seam/transport.h"

namespace sft::conformance {

/// The differences between transports that tests have to allow for (conformance.md gives the reasons).
struct Traits {
  bool projects = true;  ///< whether a reader gets only its fields; if false, it gets the whole sample
  /// True if the transport counts samples that were displaced before the reader took its first sample.
  bool counts_before_first_taken = true;
  bool reliable = false;  ///< whether readers request reliable delivery
};

/// Owns an object of shared memory or of a network, and gives access to the interface that both kinds have in
/// common.
template <class Common, class OfMemory, class OfNetwork>
class Either {
 public:
  Either() = default;
  Either(std::unique_ptr<OfMemory> given)  // NOLINT(google-explicit-constructor)
      : memory_(given.get()), common_(std::move(given)) {}
  Either(std::shared_ptr<OfMemory> given)  // NOLINT(google-explicit-constructor)
      : memory_(given.get()), common_(std::move(given)) {}
  Either(std::unique_ptr<OfNetwork> given)  // NOLINT(google-explicit-constructor)
      : network_(given.get()), common_(std::move(given)) {}

  Common& operator*() const { return *common_; }
  Common* operator->() const { return common_.get(); }
  /// Return the object; null if the object is of the other kind.
  OfMemory* memory() const { return memory_; }
  OfNetwork* network() const { return network_; }
  void reset() { *this = Either(); }

 private:
  OfMemory* memory_ = nullptr;
  OfNetwork* network_ = nullptr;
  std::shared_ptr<Common> common_;
};

using AnyTransport = Either<core::Transport, core::SharedMemory, core::Network>;
using AnyWriter = Either<core::WriterPort, core::LendingWriter, core::NetworkWriter>;
using AnyReader = Either<core::ReaderPort, core::BorrowingReader, core::NetworkReader>;

class Medium {
 public:
  virtual ~Medium() = default;
  /// Returns the reason why the medium is not available here, or "" if it is available.
  virtual std::string refusal() { return {}; }
  virtual Traits traits() const { return {}; }

  /// Opens a node's transport and waits until it is ready. REQUIRES: refusal() is empty.
  virtual AnyTransport open() = 0;
  /// Returns the address of a reader of `node` that waits at the doorbell `bell`.
  virtual core::Locator locator(const AnyTransport& node, const core::DoorbellAddress& bell) = 0;
};

struct MediumChoice {
  std::string name;
  std::function<std::unique_ptr<Medium>()> make;
};
inline std::string name_of(const testing::TestParamInfo<MediumChoice>& choice) { return choice.param.name; }
inline std::ostream& operator<<(std::ostream& out, const MediumChoice& choice) { return out << choice.name; }

}  // namespace sft::conformance
