// The process of the readers. The process takes datagrams, reassembles samples, hands them to its readers,
// and answers the writer. It can crash and be started again.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/negotiation/accepted_requests.h"
#include "core/seam/buffer_pool.h"
#include "tests/simulation/udp/laws.h"
#include "tests/simulation/udp/network.h"
#include "tests/simulation/udp/scenario.h"
#include "tests/simulation/udp/topic.h"
#include "udp_transport/flow/receive_shares.h"
#include "udp_transport/receive/reassembly.h"
#include "udp_transport/receive/subscriptions.h"
#include "udp_transport/wire/datagram.h"

namespace sft::simulation {

class ReaderHost {
 public:
  /// The arguments must outlive this object.
  ReaderHost(const Scenario& scenario, Random& random, Network& network, Laws& laws)
      : scenario_(scenario), random_(random), network_(network), laws_(laws) {}

  /// Starts the process, with new readers.
  void start();
  void crash();

  /// Returns the wishes of the readers, as far as the writer knows them.
  std::map<core::EndpointId, Wish> wishes_known() const;
  /// Changes the wish of a reader. From now on the reader takes samples under both selections. The writer
  /// learns of the change later.
  void change_a_wish(Time now);
  /// Adds a reader, or removes a reader other than the first one. The writer learns of the change later.
  void come_or_go(Time now);
  /// Returns the number of times that a reader has changed its wish, joined or left.
  std::size_t changes() const { return changes_; }
  /// Fails if there is more state than the present readers may need.
  void check_kept();
  /// Makes the writer know the requests that have been under way long enough.
  void notify_writer_of_wishes(Time now);

  void receive(const Bytes& bytes, Time now);
  /// Hands over samples for which readers had no room before, and sends the answers that are due.
  void look(Time now);
  /// Returns the time at which look() or another function is due, even if no datagram arrives.
  Time next() const;
  /// Returns null while the process is down.
  udp::ArrivalWindow* arrivals() { return reassembly_ == nullptr ? nullptr : reassembly_->window(0); }

 private:
  struct Reader {
    core::EndpointId id = 0;
    /// Identifies the reader in subscriptions; no samples are queued in it.
    std::shared_ptr<udp::Inbox> inbox;
    core::AcceptedRequests requests;
    Wish asked = 0;               ///< the reader's latest wish
    std::optional<Wish> known{};  ///< the wish of the reader that the writer knows
    /// Wishes that the writer does not know yet, each with the time when the writer will know it.
    std::deque<std::pair<Time, Wish>> under_way{};
  };

  /// A reader that has left. The writer still serves the reader until the time `until`.
  struct Departed {
    core::EndpointId id = 0;
    Wish known = 0;
    Time until;
  };

  Reader& add_reader(Wish wish);
  Wish any_wish();
  void join(Time now);
  void leave(Time now);
  void announce(Reader& reader, Time now);
  void follow();
  void accept(const Bytes& bytes, Time now);
  std::set<std::uint64_t> awaited_of(const std::optional<udp::Datagram>& datagram);
  void refuse(const std::optional<udp::Datagram>& datagram, const std::set<std::uint64_t>& awaited);
  bool has_decided(const udp::ChannelMark& mark, std::uint64_t behind);
  void report(const Bytes& bytes, Time now);
  void hand_over(Time now);
  std::size_t room_now();
  void answer(Time now);

  const Scenario& scenario_;
  Random& random_;
  Network& network_;
  Laws& laws_;
  std::shared_ptr<core::BufferPool> memory_ = core::BufferPool::make(std::size_t{64} << 20);
  std::unique_ptr<udp::SubscriptionDirectory> directory_;
  std::shared_ptr<const udp::Subscriptions> subscriptions_;
  std::unique_ptr<udp::Reassembly> reassembly_;  ///< null while the process is down
  std::unique_ptr<udp::ReceiveShares> shares_;
  std::vector<Reader> readers_;
  std::vector<Departed> departed_;
  core::EndpointId last_id_ = 0;
  std::size_t changes_ = 0;
  Time look_again_at_ = Time::max();  ///< the time when readers may have room again
};

}  // namespace sft::simulation
