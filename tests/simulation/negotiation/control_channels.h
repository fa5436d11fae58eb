// The control channels between nodes, as discovery provides them. The messages about one endpoint arrive in
// order, a request after its announcement. A message that was overwritten before its arrival may arrive or
// not. If there is a random source, messages about different endpoints arrive in any order.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "core/control/control.h"
#include "tests/support/test_seed.h"

namespace sft::test {

using SentRequest = std::shared_ptr<const core::Request>;

/// A message about an endpoint: an announcement, a request, or, with neither, a withdrawal.
struct Word {
  core::EndpointId id = 0;
  std::shared_ptr<const core::Endpoint> endpoint{};
  SentRequest request{};
};

struct ControlChannel {
  bool found = false;
  std::deque<Word> words;
  Word last;
};

class ControlChannels {
 public:
  using Ends = std::pair<std::size_t, std::size_t>;  ///< the sending and the receiving node

  /// Discovery leaves some choices open. The channels choose by `random`; if `random` is null, they take the
  /// first possibility.
  explicit ControlChannels(Random* random) : random_(random) {}

  void open(std::size_t from, std::size_t to, bool found) { channels_[{from, to}].found = found; }
  /// Removes all messages under way. The receiver has to find the sender again.
  void lose(std::size_t from, std::size_t to) { channels_.at({from, to}) = {}; }
  /// Removes the channels to a node that no longer exists.
  void close_to(std::size_t to);

  const ControlChannel& between(std::size_t from, std::size_t to) const { return channels_.at({from, to}); }
  std::vector<Ends> ends() const;

  /// Sends the message to all nodes that have found the sender.
  void send(std::size_t from, const Word& word);
  /// Makes the node `to` find the node `from`. Then `from` sends all these endpoints and requests.
  void find(std::size_t from, std::size_t to, const std::map<core::EndpointId, SentRequest>& requests,
            const std::map<core::EndpointId, std::shared_ptr<const core::Endpoint>>& announced);

  Word take(std::size_t from, std::size_t to);
  /// Returns and removes all messages under way, in the order in which they were sent.
  std::deque<Word> take_all(std::size_t from, std::size_t to);

 private:
  bool coin() { return random_ != nullptr && (*random_)() % 2 == 0; }
  void post(ControlChannel& channel, Word word);

  Random* random_;
  std::map<Ends, ControlChannel> channels_;
};

}  // namespace sft::test
