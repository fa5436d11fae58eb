// The control channels between nodes, as discovery has them: of each endpoint the words come in their order,
// a request behind its announcement. What was overwritten before it came may or may not come. Where chance
// decides, words of different endpoints come in any order.
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

/// An announcement, a request, or neither: the endpoint is withdrawn.
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
  using Ends = std::pair<std::size_t, std::size_t>;  ///< from, to

  /// Channels that choose among possibilities by `random`; without it they choose the first one.
  explicit ControlChannels(Random* random) : random_(random) {}

  void open(std::size_t from, std::size_t to, bool found) { channels_[{from, to}].found = found; }
  /// All that is under way is gone, and the receiver has to find the sender again.
  void lose(std::size_t from, std::size_t to) { channels_.at({from, to}) = {}; }
  /// Nobody is there any more to whom anything could come.
  void close_to(std::size_t to);

  const ControlChannel& between(std::size_t from, std::size_t to) const { return channels_.at({from, to}); }
  std::vector<Ends> ends() const;

  /// The word comes to all that have found the sender.
  void send(std::size_t from, const Word& word);
  /// The receiver finds the sender, which has all of this to say.
  void find(std::size_t from, std::size_t to, const std::map<core::EndpointId, SentRequest>& requests,
            const std::map<core::EndpointId, std::shared_ptr<const core::Endpoint>>& announced);

  Word take(std::size_t from, std::size_t to);
  /// Returns all that is under way, in the order in which it was sent.
  std::deque<Word> take_all(std::size_t from, std::size_t to);

 private:
  bool coin() { return random_ != nullptr && (*random_)() % 2 == 0; }
  void post(ControlChannel& channel, Word word);

  Random* random_;
  std::map<Ends, ControlChannel> channels_;
};

}  // namespace sft::test
